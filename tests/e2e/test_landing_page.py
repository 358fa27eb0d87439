"""The landing page in a real browser: its slider shows what the program renders."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from kogao_core.faces.landmarks import MeshSource
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe

ROOT = Path(__file__).parents[2]
SITE = ROOT / "docs" / "site" / "landing"
PERCENTS = (2, 6, 10)
# Rounding positions to 1/32 px differs in few pixels, and there by few grey levels.
LARGEST_DIFFERENCE = 3
PIXELS = "(() => { const c = document.querySelector('canvas'); return Array.from(c.getContext('2d')"
PIXELS += ".getImageData(0, 0, c.width, c.height).data).join(','); })()"


@pytest.fixture(scope="module")
def page(chromium, tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    (folder / "_static").mkdir()
    shutil.copy(SITE / "index.html", folder)
    for name in ("landing.js", "landing.css", "faces.js"):
        shutil.copy(SITE / name, folder / "_static")
    for name in ("landing-before.jpg", "landing-after.jpg"):
        shutil.copy(ROOT / "docs" / "pictures" / name, folder / "_static")
    chromium.afresh()
    chromium.open((folder / "index.html").as_uri())
    return chromium


def shown(page, name, percent):
    """Return the canvas once it shows a face at an Amount, RGB."""
    page.ask(
        f"var s = document.querySelector('.try input'); s.value = {percent};"
        "s.dispatchEvent(new Event('input'));"
    )
    page.until(f"document.querySelector('canvas').dataset.shown === '{name} {percent}'")
    values = np.array(page.ask(PIXELS).split(","), np.uint8)
    side = round((len(values) / 4) ** 0.5)
    return values.reshape(side, side, 4)[..., :3]


@pytest.mark.slow
@pytest.mark.parametrize("face", range(4))
def test_the_slider_shows_what_the_program_renders(page, face):
    name = page.ask(f"document.querySelectorAll('.choices img')[{face}].alt")
    page.ask(f"document.querySelectorAll('.choices button')[{face}].click()")
    photo = np.ascontiguousarray(shown(page, name, 0))
    faces = MeshSource().find(photo)
    for percent in PERCENTS:
        expected = render(photo, faces, Recipe(percent=percent)).pixels
        difference = np.abs(shown(page, name, percent).astype(int) - expected).max(axis=2)
        assert np.any(expected != photo)
        assert difference.max() <= LARGEST_DIFFERENCE, np.bincount(difference.ravel())


@pytest.mark.slow
def test_the_divider_moves_by_keys(page):
    page.ask("document.querySelector('.wipe input').focus()")
    for _ in range(3):
        page.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowRight", code="ArrowRight",
                  windowsVirtualKeyCode=39)  # fmt: skip
        page.call("Input.dispatchKeyEvent", type="keyUp", key="ArrowRight", code="ArrowRight",
                  windowsVirtualKeyCode=39)  # fmt: skip
    cut = page.ask("document.querySelector('.wipe').style.getPropertyValue('--cut')")
    assert cut == "53%"
