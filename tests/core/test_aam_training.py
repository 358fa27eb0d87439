"""Training the appearance model, on drawn faces; accuracy on photographs it hasn't seen."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from kogao_resources.training.aam.detected import Networks
from kogao_resources.training.aam.detected import read as read_picture
from kogao_resources.training.aam.examples import Example, lit
from kogao_resources.training.aam.learn import Plan, ScalePlan, error_percent, learn
from kogao_resources.training.aam.modes import shape_model
from kogao_resources.training.aam.report import hand_labelled, results, table
from kogao_resources.training.aam.turned import FaceCrop, turned
from kogao_resources.training.aam.writing import write

from kogao_core.base import assets
from kogao_core.base.geometry import Affine
from kogao_core.faces.landmarks import search
from kogao_core.faces.landmarks.aam.fitting import Crop, fit
from kogao_core.faces.landmarks.aam.model import Model, read
from kogao_core.faces.landmarks.aam.points import EYES, MIRROR, MOUTH, similarity
from kogao_core.faces.landmarks.aam.source import MODEL
from kogao_core.faces.landmarks.blazeface import Detection
from kogao_core.faces.landmarks.pixels import Pyramid

SIDE = 309
PLAN = Plan(
    scales=(ScalePlan(14.0, 3.0, 2), ScalePlan(28.0, 5.0, 1)), turns=0, starts=3, most_appearance=8
)
SAMPLES = Path(__file__).parents[2] / "resources" / "samples"
LABELS = Path(__file__).parents[1] / "labels" / "faces.json"


def drawn(rng: np.random.Generator) -> Example:
    """A line drawing of the mean face, bent and moved at random."""
    mean = read(assets.path(MODEL)).shape.mean
    bend = np.sin(mean @ rng.normal(size=(2, 2)) + rng.uniform(0.0, 6.0, 2))
    shape = 64.0 * (mean + 0.04 * bend) + SIDE / 2.0 + rng.normal(0.0, 6.0, 2)
    grey = np.full((SIDE, SIDE), 90, np.uint8)
    parts = [(0, 21), (21, 29), (29, 37), (37, 45), (45, 53), (53, 68), (68, 80)]
    for (begin, end), tone in zip(parts, (180, 20, 20, 60, 60, 150, 110), strict=True):
        cv2.fillPoly(grey, [np.round(shape[begin:end] * 16).astype(int)], tone, cv2.LINE_AA, 4)
    keypoints = np.array([*shape[EYES].reshape(2, 2, 2).mean(axis=1), *shape[[63, 74, 0, 20]]])
    box = Detection(shape.mean(axis=0), 150.0, 0.0, 0.9, keypoints + rng.normal(0.0, 3.0, (6, 2)))
    return Example(Crop(grey), shape, box, 1.0)


@pytest.fixture(scope="module")
def drawings() -> list[Example]:
    rng = np.random.default_rng(7)
    faces = [drawn(rng) for _ in range(20)]
    return [one for face in faces for one in (face, face.mirrored)]


@pytest.fixture(scope="module")
def learnt(drawings: list[Example]) -> Model:
    return learn(drawings[:30], PLAN, lambda _: None)


@pytest.mark.slow
def test_training_again_gives_the_same_bytes(
    drawings: list[Example], learnt: Model, tmp_path: Path
) -> None:
    write(learnt, tmp_path / "one.npz")
    write(learn(drawings[:30], PLAN, lambda _: None), tmp_path / "two.npz")
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()


def test_fits_of_unseen_drawings_are_much_better_than_their_starts(
    drawings: list[Example], learnt: Model
) -> None:
    unseen = drawings[30:]
    starts = [learnt.start.points(one.box) for one in unseen]
    before = [error_percent(one, at) for one, at in zip(unseen, starts, strict=True)]
    after = [
        error_percent(one, fit(learnt, one.crop, at).points)
        for one, at in zip(unseen, starts, strict=True)
    ]
    assert np.mean(after) < 0.6 * np.mean(before)


def test_shape_modes_are_orthonormal_and_hold_every_placing(drawings: list[Example]) -> None:
    shape = shape_model([one.shape for one in drawings], 0.98)
    np.testing.assert_allclose(shape.modes.T @ shape.modes, np.eye(shape.modes.shape[1]), atol=1e-9)
    placed = Affine.similarity(1.3, 25.0, (0.4, -0.2))(shape.mean)
    np.testing.assert_allclose(shape.points(shape.parameters(placed)), placed, atol=1e-9)
    far = shape.parameters(shape.points(np.full(shape.modes.shape[1], 9.0)))
    assert (np.abs(far[4:]) <= 3.0 * shape.deviations + 1e-12).all()


def test_a_mirrored_example_shows_the_mirrored_face(drawings: list[Example]) -> None:
    face, mirrored = drawings[:2]
    flip = similarity(mirrored.shape, face.crop.mirrored_points(face.shape)[MIRROR])
    np.testing.assert_allclose(flip.matrix, np.eye(2), atol=1e-9)
    x, y = np.round(mirrored.shape[MOUTH].mean(axis=0)).astype(int)
    assert mirrored.crop.levels[0][y, x] == face.crop.levels[0][y, SIDE - 1 - x]


def test_light_changes_the_picture_but_not_its_shape() -> None:
    grey = np.tile(np.linspace(0, 255, 80).astype(np.uint8), (60, 1))
    pictures = [lit(grey, np.random.default_rng(seed)) for seed in range(8)]
    assert all(one.shape == grey.shape and one.dtype == np.uint8 for one in pictures)
    assert len({one.tobytes() for one in pictures}) == len(pictures)


def bowl() -> FaceCrop:
    """A round face with its nose towards us, on a ramp of grey."""
    rng = np.random.default_rng(3)
    xy = rng.uniform(-1.0, 1.0, (478, 2)) * 60.0
    xy[[33, 263, 234, 454, 152]] = [(-32, -20), (32, -20), (-58, 0), (58, 0), (0, 60)]
    z = 0.01 * (xy**2).sum(axis=1)
    mesh = np.column_stack([xy + SIDE / 2.0, z])
    ramp = np.tile(np.linspace(0, 255, SIDE).astype(np.uint8), (SIDE, 1))
    return FaceCrop(ramp, mesh, mesh[:6, :2])


def test_a_turn_by_nothing_is_the_same_view_and_a_turn_moves_the_near_parts_most() -> None:
    view = bowl()
    same = turned(view, 0.0, 0.0)
    np.testing.assert_allclose(same.mesh, view.mesh, atol=1e-9)
    assert np.abs(same.grey.astype(int) - view.grey.astype(int)).max() <= 2
    aside = turned(view, 20.0, 0.0)
    x, y = np.round(view.mesh[:468, :2].mean(axis=0)).astype(int)
    nearest = int(view.mesh[:468, 2].argmin())
    shift = aside.mesh[nearest, 0] - view.mesh[nearest, 0]
    assert shift < -2.0
    # On a ramp the grey level tells where a pixel comes from.
    assert float(aside.grey[y, x]) - float(view.grey[y, x]) == pytest.approx(
        -shift * 255.0 / SIDE, abs=4.0
    )


@pytest.mark.usefixtures("weights")
def test_faces_to_learn_from_do_not_depend_on_the_number_of_threads(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    heads = [cv2.resize(read_picture(path), (300, 300)) for path in sorted(SAMPLES.glob("*.jpg"))]
    crowd = Pyramid(np.hstack(heads))
    found = []
    for threads in (1, 4):
        monkeypatch.setattr(search, "default_threads", lambda threads=threads: threads)
        faces = Networks().faces(crowd)
        found.append(sorted((face.mesh for face in faces), key=lambda mesh: tuple(mesh[0])))
    assert len(found[0]) == 3
    np.testing.assert_array_equal(found[0], found[1])


@pytest.mark.usefixtures("weights")
def test_hand_labelled_faces_it_has_not_seen_are_fitted(shared_data: Path) -> None:
    known = list(hand_labelled(LABELS, shared_data))[::5]
    found = results(assets.path(MODEL), known)
    errors = np.array([one.errors for one in found])
    assert np.isfinite(errors).all()
    assert (errors[:, 3] < 8.0).mean() >= 0.9
    assert errors[:, 2].mean() < 4.5
    assert any("labelled by hand" in line for line in table(found))
