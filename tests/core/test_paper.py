"""The paper stands alone: it loads nothing of the additions, and gives what `PAPER` renders."""

import doctest
from pathlib import Path

import numpy as np
from programs import ran
from scenes import oval_face, textured_photo

from kogao_core.base.geometry import Box
from kogao_core.paper import domain, fit, targets, walk
from kogao_core.paper.lattice import Grid, quantised
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER
from kogao_core.steps import STEPS

PAPER_MODULES = sorted(Path(walk.__file__).parent.glob("*.py"))
LOADED = (
    "import sys, kogao_core.paper.walk, kogao_core.paper.fit, kogao_core.paper.table1; print(*(\
 m for m in sys.modules if m.startswith('kogao_core.') or m in ('cv2', 'PIL')))"
)


def test_the_walk_from_landmarks_to_figure_15_is_true():
    found = doctest.testmod(walk)
    assert found.attempted
    assert not found.failed


def test_the_paper_loads_numpy_and_rectangles_only():
    loaded = ran(LOADED).stdout.split()
    rooms = {name.split(".")[1] if "." in name else name for name in loaded}
    assert rooms == {"base", "paper"}


def test_the_paper_by_itself_gives_the_lattice_and_domain_of_its_recipe():
    face, photo = oval_face(), textured_photo()
    rendering = render(photo, [face], PAPER)
    center = targets.center_candidates(face.eye_center, face.mouth_center)[PAPER.center - 1]
    pairs = targets.aim(face.outline, center, PAPER.percent / 100.0)
    grid = Grid(face.anchor.origin_px, fit.spacing_px(PAPER.lattice, face.anchor.spacing_px))
    problem = fit.Problem(grid, pairs.target_px, pairs.displacement_px)
    lattice = quantised(fit.approximate(problem))
    np.testing.assert_array_equal(lattice.phi, rendering.field.lattices[0].phi)
    (cells,) = domain.reduce([lattice], Box.of(photo), "threshold").cells
    np.testing.assert_array_equal(cells.active, rendering.domain.cells[0].active)


def test_the_recipe_of_the_paper_skips_the_additions(monkeypatch):
    whole = render(textured_photo(), [oval_face()], PAPER)
    paper = tuple(step for step in STEPS if step.section)
    assert [step.apply.__name__ for step in paper] == ["targets", "lattice", "domain"]
    monkeypatch.setattr("kogao_core.pipeline.STEPS", paper)
    alone = render(textured_photo(), [oval_face()], PAPER)
    assert alone.pixels.tobytes() == whole.pixels.tobytes()
    assert (alone.note, alone.limits) == (whole.note, whole.limits)


def test_the_paper_can_be_read_in_an_hour():
    lines = [len(path.read_text("utf-8").splitlines()) for path in PAPER_MODULES]
    assert sum(lines) <= 1000
