"""The silhouette: order, spacing, and that it moves with the mesh."""

import numpy as np
import pytest

from kogao_core.base.geometry import Affine, Array, degrees_of
from kogao_core.faces.landmarks import outline, template_face
from kogao_core.faces.landmarks.mesh import EYES
from kogao_core.faces.landmarks.outline import forehead, joined, silhouette

LEFT_EAR, RIGHT_EAR = 234, 454  # points of the mesh


def oval_mesh() -> Array:
    """A mesh whose rim lies on an ellipse of 200 x 260; the other points crowd its middle."""
    rng = np.random.default_rng(3)
    mesh = rng.normal(0.0, 10.0, (478, 2))
    angles = np.linspace(0.0, 2.0 * np.pi, len(outline._OVAL), endpoint=False)
    mesh[list(outline._OVAL)] = np.column_stack([100.0 * np.sin(angles), -130.0 * np.cos(angles)])
    mesh[list(EYES)] = [(-48.0, -22.0), (-20.0, -20.0), (20.0, -20.0), (48.0, -18.0)]
    return mesh + 300.0


def outline_of(mesh: Array) -> Array:
    return silhouette(mesh, mesh[list(EYES)])


def below_eyes(points: Array, eyes: Array) -> Array:
    """How far points lie below the line through the outer eye corners, in their distance."""
    upright = Affine.similarity(1.0, -degrees_of(eyes[3] - eyes[0]), (0.0, 0.0))
    return (upright(points) - upright(eyes[0]))[:, 1] / np.linalg.norm(eyes[3] - eyes[0])


def test_runs_from_the_left_of_the_eye_line_round_the_chin_to_its_right() -> None:
    mesh = oval_mesh()
    points = outline_of(mesh)
    assert points.shape == (21, 2)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    np.testing.assert_allclose(steps, steps.mean(), rtol=0.06)
    assert points[0, 0] < points[10, 0] < points[20, 0]
    assert points[10, 1] > points[[0, 20], 1].max() + 100.0
    assert (np.diff(points[:, 0])[4:16] > 0.0).all()
    ends = below_eyes(points[[0, 20]], mesh[list(EYES)])
    np.testing.assert_allclose(ends, outline.END_BELOW_EYES, atol=0.005)


def test_lies_on_the_mesh_edge_and_a_little_outside() -> None:
    points = (outline_of(oval_mesh()) - 300.0) / (100.0, 130.0)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, atol=0.03)
    assert np.linalg.norm(points[10]) > 1.0


@pytest.mark.parametrize("degrees", [37.0, 180.0])
@pytest.mark.parametrize("scale", [0.1, 1.0, 12.0])
def test_moves_with_the_mesh(degrees: float, scale: float) -> None:
    move = Affine.similarity(scale, degrees, (40.0, -7.0))
    moved = outline_of(move(oval_mesh()))
    np.testing.assert_allclose(moved, move(outline_of(oval_mesh())), atol=2e-3 * scale)


def test_a_mirrored_mesh_gives_the_mirrored_outline() -> None:
    mirror = Affine(np.diag([-1.0, 1.0]), np.array([600.0, 0.0]))
    mesh = mirror(oval_mesh())
    np.testing.assert_allclose(
        silhouette(mesh, mesh[list(EYES)][::-1]), mirror(outline_of(oval_mesh()))[::-1], atol=1e-3
    )


def test_a_turned_head_keeps_its_cheek() -> None:
    mesh = oval_mesh()
    mesh[435] = mesh[RIGHT_EAR] + (15.0, 60.0)
    assert outline_of(mesh)[:, 0].max() > mesh[435, 0] - 5.0


def test_a_nose_never_becomes_the_outline() -> None:
    mesh = oval_mesh()
    mesh[[1, 4, 5]] = mesh[LEFT_EAR] + (-80.0, 40.0)
    np.testing.assert_array_equal(outline_of(mesh), outline_of(oval_mesh()))


def test_a_collapsed_mesh_is_refused() -> None:
    with pytest.raises(ValueError, match="collapsed"):
        outline_of(np.zeros((478, 2)))


def test_a_line_is_cut_where_it_passes_the_eyes_and_prolonged_where_it_ends_below() -> None:
    eyes = np.array([(-3.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (3.0, 0.0)])
    line = np.array([(-5.0, -4.0), (-5.0, 4.0), (0.0, 8.0), (5.0, 4.0), (4.5, 1.0)])
    turn = Affine.similarity(7.0, 160.0, (30.0, 40.0))
    wanted = np.array([(-5.0, 0.0), (-5.0, 4.0), (0.0, 8.0), (5.0, 4.0), (4.5, 1.0), (13 / 3, 0.0)])
    np.testing.assert_allclose(outline.ended(line, eyes), wanted)
    np.testing.assert_allclose(outline.ended(turn(line), turn(eyes)), turn(wanted))


def test_a_line_that_points_away_from_the_eyes_cannot_end_there() -> None:
    eyes = np.array([(-3.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (3.0, 0.0)])
    with pytest.raises(ValueError, match="doesn't reach the eyes"):
        outline.ended(np.array([(-5.0, -1.0), (0.0, 8.0), (5.0, 8.0)]), eyes)


def test_template_has_the_order_of_every_other_face() -> None:
    face = template_face((100.0, 80.0), 60.0)
    assert (face.score, face.source, len(face.points)) == (1.0, "manual", 27)
    assert face.outline[20, 0] - face.outline[0, 0] == pytest.approx(60.0)
    assert (np.diff(face.eyes[:, 0]) > 0.0).all()
    assert face.outline[10, 1] > face.mouth_center[1] > face.eye_center[1]
    left, top, width, height = face.box
    assert (left + width / 2.0, top + height / 2.0) == pytest.approx((100.0, 80.0), abs=0.1)


@pytest.mark.parametrize("width", [0.0, -3.0, float("nan")])
def test_template_refuses_a_width_of_nothing(width: float) -> None:
    with pytest.raises(ValueError, match="width_px"):
        template_face((0.0, 0.0), width)


def test_a_face_placed_by_hand_ends_where_a_found_one_does() -> None:
    face = template_face((300.0, 200.0), 160.0, 20.0)
    ends = below_eyes(face.outline[[0, 20]], face.eyes)
    np.testing.assert_allclose(ends, outline.END_BELOW_EYES, atol=0.01)


@pytest.mark.parametrize("degrees", [0.0, 37.0, 180.0])
def test_the_forehead_is_the_rest_of_the_silhouette_from_left_to_right(degrees: float) -> None:
    move = Affine.similarity(1.0, degrees, (0.0, 0.0))
    mesh = oval_mesh()
    upright = forehead(mesh, mesh[list(EYES)])
    assert upright.shape == (15, 2)
    assert (np.diff(upright[:, 0])[1:-1] > 0.0).all()
    assert (below_eyes(upright[1:-1], mesh[list(EYES)]) < 0.0).all()
    on_rim = np.linalg.norm((upright - 300.0) / (100.0, 130.0), axis=1)
    np.testing.assert_allclose(on_rim, 1.0, atol=0.03)
    steps = np.linalg.norm(np.diff(upright, axis=0), axis=1)
    np.testing.assert_allclose(steps, steps.mean(), rtol=0.06)
    turned = move(mesh)
    np.testing.assert_allclose(forehead(turned, turned[list(EYES)]), move(upright), atol=2e-3)


def test_the_forehead_joins_an_outline_that_was_moved() -> None:
    mesh = oval_mesh()
    rim, line = forehead(mesh, mesh[list(EYES)]), outline_of(mesh)
    line[0] -= (6.0, 0.0)
    line[-1] += (3.0, 2.0)
    between = joined(rim, line)
    assert between.shape == (13, 2)
    steps = np.linalg.norm(np.diff(np.vstack([line[0], between, line[-1]]), axis=0), axis=1)
    np.testing.assert_allclose(steps, steps.mean(), rtol=0.15)
