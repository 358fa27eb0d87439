"""The paper stands alone: it loads nothing of the additions, and gives what `PAPER` renders."""

import doctest
import subprocess
import sys

import numpy as np
from scenes import oval_face, textured_photo

from kogao_core.base.geometry import Box
from kogao_core.paper import domain, fit, targets, walk
from kogao_core.paper.lattice import Grid, quantised
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER
from kogao_core.steps import STEPS

LOADED = (
    "import sys, kogao_core.paper.walk, kogao_core.paper.fit, kogao_core.paper.table1; print(*(\
 m for m in sys.modules if m.startswith('kogao_core.') or m in ('cv2', 'PIL')))"
)


def test_the_walk_from_landmarks_to_figure_15_is_true():
    found = doctest.testmod(walk)
    assert found.attempted
    assert not found.failed


def test_the_paper_loads_numpy_and_rectangles_only():
    run = subprocess.run([sys.executable, "-c", LOADED], capture_output=True, text=True, check=True)
    rooms = {name.split(".")[1] if "." in name else name for name in run.stdout.split()}
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


def test_without_the_additions_the_recipe_of_the_paper_gives_the_same_pixels(monkeypatch):
    whole = render(textured_photo(), [oval_face()], PAPER).pixels
    printed = tuple(each for each in STEPS if each[1].__name__ in ("targets", "lattice", "domain"))
    monkeypatch.setattr("kogao_core.pipeline.STEPS", printed)
    alone = render(textured_photo(), [oval_face()], PAPER).pixels
    assert alone.tobytes() == whole.tobytes()
