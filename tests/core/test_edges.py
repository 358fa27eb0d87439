"""Finer outlines: the network's arithmetic, the chain, and how faces are learnt."""

import os
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from kogao_resources.training.edges import learn as training
from kogao_resources.training.edges import report
from kogao_resources.training.edges.learn import backward, forward
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
from programs import ran
from systems import needs_stored_decimals

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import edges as network
from kogao_core.faces.landmarks import template_face
from kogao_core.faces.landmarks.edges import ACROSS, MOVES, Cut, EdgeNetwork, lines_of, planes
from kogao_core.faces.landmarks.pixels import Pyramid

MODEL = Path(__file__).parents[2] / "resources" / "models" / "edges.npz"


def drawn_face(grown: float = 0.0) -> tuple[np.ndarray, Face, Array]:
    """A skin-coloured face on blue, its landmarks, and its true outline, `grown` steps outside."""
    face = template_face((200.0, 200.0), 160.0)
    face = Face(face.outline, face.eyes, face.mouth)
    unit = face.interocular_px / 100.0
    outline = lines_of(face.outline)
    edge = outline.points + grown * unit * outline.normals
    image = np.full((420, 400, 3), (60, 90, 160), np.uint8)
    cv2.fillPoly(image, [np.vstack([edge, [[280, 60], [120, 60]]]).astype(int)], (205, 160, 130))
    return cv2.GaussianBlur(image, (0, 0), 1.0), face, edge


def some_parameters() -> list[np.ndarray]:
    rng = np.random.default_rng(0)
    return [rng.normal(0.0, 0.2, shape).astype(np.float32) for shape in network.shapes()]


@pytest.fixture(scope="module")
def edges() -> EdgeNetwork:
    return EdgeNetwork.read(MODEL)


def test_gradients_are_those_of_differences() -> None:
    parameters = [one.astype(np.float64) for one in some_parameters()]
    rng = np.random.default_rng(1)
    strips, weights = rng.normal(size=(2, 5, 7, 11)), rng.normal(size=(2, 2, 7, 11))

    def loss() -> float:
        return float((network.forward(parameters, strips) * weights).sum())

    steps = forward(parameters, strips)
    np.testing.assert_array_equal(steps[-1].output, network.forward(parameters, strips))
    assert steps[-1].output.shape == (2, 2, 7, 11)
    gradients = backward(parameters, steps, weights)
    for one, gradient in zip(parameters, gradients, strict=True):
        place = tuple(int(rng.integers(size)) for size in one.shape)
        kept = one[place]
        one[place] = kept + 1e-6
        above = loss()
        one[place] = kept - 1e-6
        below = loss()
        one[place] = kept
        assert gradient[place] == pytest.approx((above - below) / 2e-6, rel=1e-3, abs=1e-4)


def test_a_mirrored_strip_gets_the_mirrored_answer() -> None:
    strips = np.random.default_rng(2).normal(size=(1, 5, 41, len(ACROSS))).astype(np.float32)
    there = network.forward(some_parameters(), strips)
    back = network.forward(some_parameters(), np.ascontiguousarray(strips[:, :, ::-1]))
    np.testing.assert_allclose(back[:, :, ::-1], there, atol=1e-4)


def test_a_clear_edge_is_believed_and_nothing_to_see_moves_nothing() -> None:
    clear = np.where(MOVES == 2, 9.0, 0.0) * np.ones((41, 1))
    moves, confidence = network.settle(clear, np.full(41, -9.0))
    np.testing.assert_allclose(moves, 2.0, atol=0.1)
    assert (confidence > 0.95).all()
    moves, confidence = network.settle(np.zeros((41, len(MOVES))), np.full(41, 9.0))
    np.testing.assert_allclose(moves, 0.0, atol=0.05)
    assert (confidence < 0.01).all()


def test_hidden_lines_follow_their_neighbours() -> None:
    seen = np.where(MOVES == 3, 9.0, 0.0) * np.ones((41, 1))
    unseen = np.full(41, -9.0)
    seen[18:22], unseen[18:22] = 0.0, 9.0
    moves, confidence = network.settle(seen, unseen)
    np.testing.assert_allclose(moves[18:22], 3.0, atol=0.7)
    assert confidence[19:21].max() < 0.5 < confidence[[5, 35]].min()


@pytest.mark.parametrize("longest", [24.0, 38.0])
def test_a_long_beard_is_within_reach_and_the_cheeks_stay(longest: float) -> None:
    beard = np.round(longest / 2 * (1.0 + np.cos(np.linspace(-np.pi, np.pi, 41))))
    seen = np.where(beard[:, None] == MOVES, 9.0, 0.0)
    moves, _ = network.settle(seen, np.full(41, -9.0))
    np.testing.assert_allclose(moves, beard, atol=1.5)


def test_the_cheek_of_a_turned_head_is_believed_before_a_wall_behind_it() -> None:
    """Photographed: the cheek is seen 8 steps inside the silhouette, a wall's edge 7 outside."""
    cheek, wall = (np.exp(-0.5 * ((MOVES - at) / 1.5) ** 2) for at in (-8.0, 7.0))
    seen = np.where(np.arange(41)[:, None] < 8, 6.0 * cheek + 2.5 * wall, 6.0 * (MOVES == 0.0))
    moves, _ = network.settle(seen, np.full(41, -3.0))
    np.testing.assert_allclose(moves[:5], -8.0, atol=2.0)
    np.testing.assert_allclose(moves[12:], 0.0, atol=1.0)


def test_of_a_chin_a_beard_is_no_edge_and_what_is_near_by_is() -> None:
    beard = np.round(12.0 + 12.0 * np.cos(np.linspace(-np.pi, np.pi, 41)))
    seen = np.where(beard[:, None] == MOVES, 9.0, 0.0)
    moves, confidence = network.settle(seen, np.full(41, -9.0), beards=False)
    assert np.abs(moves).max() < 5.0
    assert confidence[12:29].max() < 0.1 < 0.9 < confidence[[3, 37]].min()
    clear = np.where(MOVES == 2, 9.0, 0.0) * np.ones((41, 1))
    moves, _ = network.settle(clear, np.full(41, -9.0), beards=False)
    np.testing.assert_allclose(moves, 2.0, atol=0.1)


@pytest.mark.parametrize("grown", [-2.0, 0.0, 3.0])
def test_an_outline_moves_onto_the_edge(edges: EdgeNetwork, grown: float) -> None:
    image, face, edge = drawn_face(grown)
    outline, confidence = edges.refined(Pyramid(image), face.eyes, face.outline)
    assert outline.shape == (21, 2)
    assert ((confidence >= 0.0) & (confidence <= 1.0)).all()
    unit = face.interocular_px / 100.0
    apart = np.linalg.norm(outline[4:17, None] - edge, axis=-1).min(axis=1) / unit
    start = np.linalg.norm(face.outline[4:17, None] - edge, axis=-1).min(axis=1) / unit
    assert apart.mean() < max(1.5, 0.6 * start.mean())
    steps = np.linalg.norm(np.diff(outline, axis=0), axis=1)
    np.testing.assert_allclose(steps, steps.mean(), rtol=0.05)


def test_a_hand_before_the_edge_lowers_its_confidence(edges: EdgeNetwork) -> None:
    image, face, _ = drawn_face()
    _, clear = edges.refined(Pyramid(image), face.eyes, face.outline)
    x, y = face.outline[5].astype(int)
    cv2.ellipse(image, ((float(x), float(y)), (70.0, 110.0), 20.0), (200, 155, 128), -1)
    _, covered = edges.refined(Pyramid(image), face.eyes, face.outline)
    assert covered[4:7].mean() < clear[4:7].mean() - 0.1
    assert abs(covered[14:].mean() - clear[14:].mean()) < 0.1


@pytest.mark.parametrize("degrees", [0.0, 63.0, 180.0])
def test_a_cut_is_upright_and_of_one_size(degrees: float) -> None:
    image, face, _ = drawn_face()
    turn = Affine.similarity(1.0, degrees, (0.0, 0.0))
    turn = Affine(turn.matrix, np.array([400.0, 400.0]) - turn((200.0, 200.0)))
    turned = cv2.warpAffine(image, turn.opencv, (800, 800))
    cut = Cut.of(Pyramid(turned), turn(face.eyes), turn(face.outline))
    eyes = cut.to_image.inverse(turn(face.eyes))
    np.testing.assert_allclose(eyes[3] - eyes[0], (100.0, 0.0), atol=1e-6)
    strip = cut.strip(lines_of(cut.to_image.inverse(turn(face.outline))))
    assert strip.shape == (41, len(ACROSS), 3)
    assert strip[8:-8, 4, 0].min() > 190
    assert strip[8:-8, -4, 0].max() < 90
    assert planes(strip).shape == (5, 41, len(ACROSS))


def test_a_beard_stands_out_against_the_skin_of_the_cheeks() -> None:
    strip = np.full((41, len(ACROSS), 3), (205, 160, 130), np.uint8)
    strip[13:28] = 40
    skin = planes(strip)[:3, [2, 9, 31, 38]]
    np.testing.assert_allclose(skin, 0.0, atol=0.05)


def test_labels_of_long_beards_are_learnt_from() -> None:
    image, face, edge = drawn_face(30.0)
    one = training.labelled_cut("face", Pyramid(image), face, edge, (), 1.0)
    np.testing.assert_allclose(one.moves[14:27], 30.0, atol=0.5)


def test_a_beard_drawn_out_has_its_label_where_its_edge_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(training, "_COVERED", 0.0)
    monkeypatch.setattr(training, "_SPREADS", np.zeros(9))
    image, face, edge = drawn_face(12.0)
    one = training.labelled_cut("face", Pyramid(image), face, edge, (), 1.0)
    chin = slice(15, 26)
    longest = []
    for seed in range(12):
        strip, moves, _ = training._drawn(one, [one], np.random.default_rng(seed))
        change = np.abs(cv2.blur(strip[2, chin, 2:] - strip[2, chin, :-2], (1, 5)))
        shown = ACROSS[1:-1][change.argmax(axis=1)]
        assert np.median(np.abs(shown - moves[chin])) < 1.0
        longest.append(moves[chin].max())
    assert min(longest) < 10.0 < 16.0 < max(longest)


def test_a_report_tells_how_far_off_unseen_faces_are_and_whether_it_was_known() -> None:
    apart, sure = np.array([1.0, 1.0, 9.0, 1.0]), np.array([0.95, 0.95, 0.1, 0.1])
    seen = np.array([True, True, True, False])
    face = report.Unseen(("wild",), 2.0, 1.0, apart, sure, seen)
    assert list(report.errors([face])) == ["wild           1   2.00 ->  1.00 % (p95 1.00)"]
    assert list(report.reliability([face], "wild")) == [
        "wild 0.0 to 0.2: 2 say 0.10, 0.00 are",
        "wild 0.9 to 1.0: 2 say 0.95, 1.00 are",
        "wild: off by 0.075 on average; area under the curve 0.83 for hidden",
    ]


@pytest.fixture
def examples(monkeypatch: pytest.MonkeyPatch) -> list[training.LabelledCut]:
    monkeypatch.setattr(training, "_BATCH", 4)
    examples = []
    for number, grown in enumerate((-3.0, 0.0, 4.0)):
        image, face, edge = drawn_face(grown)
        examples.append(training.labelled_cut(str(number), Pyramid(image), face, edge, (), 1.0))
        np.testing.assert_allclose(np.nanmean(examples[-1].moves), grown, atol=0.2)
    return examples


def test_learning_is_repeatable(
    examples: list[training.LabelledCut], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(training, "_STEPS", 2)
    learnt, again = training.learn(examples), training.learn(examples)
    for one, other in zip(learnt, again, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
def test_learning_lowers_the_error(
    examples: list[training.LabelledCut], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(training, "_STEPS", 25)

    def errors(parameters: list[np.ndarray]) -> float:
        apart = []
        for one in examples:
            outputs = network.forward(parameters, planes(one.cut.strip(one.lines))[None])
            moves, _ = network.settle(*network.split(outputs[0]))
            apart.append(np.nanmean(np.abs(moves - one.moves)))
        return float(np.mean(apart))

    learnt = training.learn(examples)
    still = np.mean([np.nanmean(np.abs(one.moves)) for one in examples])
    assert errors(learnt) < 0.8 * still


def test_what_is_hidden_in_a_label_is_not_learnt_as_an_edge() -> None:
    image, face, edge = drawn_face()
    one = training.labelled_cut("face", Pyramid(image), face, edge, range(18, 23), 1.0)
    assert 4 <= one.unseen.sum() <= 6
    assert one.unseen[20]


@needs_stored_decimals
@pytest.mark.parametrize("step", [3, pytest.param(1, marks=pytest.mark.slow)])
def test_cielab_equals_the_conversion_of_opencv(step):
    levels = np.append(np.arange(0, 256, step), 254).astype(np.uint8)
    for red in levels:
        colours = np.stack(np.meshgrid(red, levels, levels), axis=-1).reshape(-1, 1, 3)
        assert (network.cielab(colours) == cv2.cvtColor(colours, cv2.COLOR_RGB2LAB)).all(), red


@needs_stored_decimals
def test_cielab_is_the_same_on_processors_with_fewer_instructions():
    program = (
        "import zlib, numpy as np; from kogao_core.faces.landmarks import edges;"
        "levels = np.append(np.arange(0, 256, 3), 254).astype(np.uint8);"
        "colours = np.stack(np.meshgrid(levels, levels, levels), axis=-1);"
        "print(zlib.crc32(edges.cielab(colours)))"
    )
    levels = np.append(np.arange(0, 256, 3), 254).astype(np.uint8)
    colours = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 87, 3)
    wanted = zlib.crc32(cv2.cvtColor(colours, cv2.COLOR_RGB2LAB))
    found = [name for name in __cpu_dispatch__ if __cpu_features__[name]]
    for some in dict.fromkeys([*found, " ".join(found)]):
        environment = {**os.environ, "NPY_DISABLE_CPU_FEATURES": some}
        done = ran(program, flags=("-W", "ignore"), env=environment)
        assert int(done.stdout) == wanted, some
