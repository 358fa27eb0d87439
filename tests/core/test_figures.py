"""Figures show what was computed, where it is."""

import numpy as np
import pytest
from scenes import oval_face, textured_photo

from kogao_core.faces import targets
from kogao_core.faces.targets import center_candidates
from kogao_core.lab.experiments.figures import CENTER, LANDMARK, TARGET, figures, pictured
from kogao_core.lab.reports.drawing import Dots, Strokes, Word
from kogao_core.lab.subjects import Subject
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER
from kogao_core.recipe.settings import PAPER_CENTERS, Center

WIDTH = 640


@pytest.fixture(scope="module")
def subject():
    return Subject("made-up.png", textured_photo(), (oval_face(),))


@pytest.fixture(scope="module")
def drawn(subject):
    return {drawing.name: drawing for drawing in figures(subject, PAPER, WIDTH)}


@pytest.fixture(scope="module")
def shown(subject):
    return pictured(subject, WIDTH)


def test_every_figure_is_there_at_the_width_asked_for(drawn):
    assert list(drawn) == [
        *("landmarks", "centers", "lattice", "domains", "before-after", "directions"),
    ]
    for drawing in drawn.values():
        assert abs(drawing.painted().shape[1] - WIDTH) <= 3


def test_figure_7_shows_the_papers_centres_and_no_other(subject, monkeypatch):
    monkeypatch.setattr(targets, "CENTERS", (*PAPER_CENTERS, Center(0.3)))
    drawing = next(d for d in figures(subject, PAPER, 240) if d.name == "centers")
    words = [mark.text for mark in drawing.marks if isinstance(mark, Word)]
    assert words == ["1", "2", "3", "4"]


def test_landmarks_are_painted_where_they_are(drawn, shown):
    painted = drawn["landmarks"].painted()
    wanted = np.array(list(bytes.fromhex(LANDMARK[1:])))
    (face,) = shown.faces
    x, y = face.outline[10]
    assert (painted[round(y), round(x)] == wanted).all()
    targets, outline, corners = (
        mark.points for mark in drawn["landmarks"].marks if isinstance(mark, Dots)
    )
    np.testing.assert_array_equal(outline, face.outline)
    np.testing.assert_array_equal(corners, np.vstack([face.eyes, face.mouth]))
    moved = render(shown.pixels, shown.faces, PAPER).pairs[0].target_px
    np.testing.assert_array_equal(targets, moved)


def test_centres_are_on_their_line(drawn, shown):
    (found,) = dots(drawn["centers"], CENTER)
    candidates = center_candidates(shown.faces[0])[: len(PAPER_CENTERS)]
    np.testing.assert_array_equal(found, candidates)


def test_masks_are_as_large_as_the_domains(drawn, shown):
    counts = render(shown.pixels, shown.faces, PAPER).pixel_counts
    painted = drawn["domains"].pixels[..., 0]
    gap = round(0.0125 * WIDTH)
    each = (WIDTH - 2 * gap) // 3
    for place, name in enumerate(("image", "control-points", "threshold")):
        panel = painted[2:-2, place * (each + gap) + 2 : place * (each + gap) + each - 2]
        if name == "image":
            assert (panel == 150).all()
        else:
            share = (255.0 - panel).sum() / 105.0 / (each * len(painted))
            assert abs(share - counts[name] / counts["image"]) < 0.01


def test_before_and_after_differ_in_the_face_alone(drawn, shown):
    both = drawn["before-after"].pixels.astype(int)
    gap = round(0.0125 * WIDTH)
    each = (WIDTH - gap) // 2
    before, after = both[:, :each], both[:, each + gap :]
    x, y, width, height = np.array(shown.faces[0].box) * each / WIDTH
    changed = np.abs(before - after).max(axis=2)
    inside = changed[round(y) : round(y + height), round(x) : round(x + width)]
    assert inside.max() > 20
    assert not changed[:, : max(0, round(x - 0.4 * width))].any()


def dots(drawing, colour):
    return [
        mark.points for mark in drawing.marks if isinstance(mark, Dots) and mark.colour == colour
    ]


def test_targets_lie_on_the_lines_to_the_centre(drawn, shown):
    (rays,) = [m.segments for m in drawn["directions"].marks
               if isinstance(m, Strokes) and m.colour == TARGET]  # fmt: skip
    pairs = render(shown.pixels, shown.faces, PAPER).pairs[0]
    np.testing.assert_allclose(rays[:, 1], np.tile(pairs.center_px, (21, 1)))
    along, way = rays[:, 1] - rays[:, 0], pairs.target_px - rays[:, 0]
    assert np.abs(along[:, 0] * way[:, 1] - along[:, 1] * way[:, 0]).max() < 1e-6


@pytest.mark.parametrize("dtype", [np.uint16, np.float32])
def test_deep_and_grey_photos_are_drawn(dtype):
    grey = Subject("deep.png", textured_photo(channels=1, dtype=dtype), (oval_face(),))
    made = figures(grey, PAPER, 240)
    assert all(drawing.pixels.dtype == np.uint8 for drawing in made)
    assert made[0].pixels.std() > 5
