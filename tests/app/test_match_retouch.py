"""Match a retouch: the open photo follows a retouched copy, and matches become a style."""

import dataclasses

import numpy as np
import pytest
from kogao_app.features.retouch import matched
from PIL import Image
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QInputDialog, QLineEdit
from scenes import oval_face
from test_overlays import at, pixels_of

from kogao_core.pipeline import render
from kogao_core.reading.flow import NotRead
from kogao_core.recipe.recipe import Recipe

pytestmark = pytest.mark.usefixtures("one_window")


@pytest.fixture
def copy(tmp_path, pixels):
    path = tmp_path / "copy.png"
    recipe = Recipe(percent=6.0, hold_background=False)
    Image.fromarray(render(pixels, [oval_face()], recipe).pixels).save(path)
    return path


def match(driver, path):
    driver.window.actions_by_name["match-retouch"].trigger()
    driver.choose_path(path)
    driver.settle()


def test_a_retouched_copy_becomes_targets_and_a_wipe_with_its_outline(start, photo, copy):
    driver = start(photo)
    match(driver, copy)
    (face,) = driver.state.faces
    assert face.targets is not None
    assert face.recipe.percent == pytest.approx(6.0, abs=1.0)
    assert driver.editor.view.compare == "wipe"
    (outline,) = driver.editor.view.retouched.outlines
    np.testing.assert_array_equal(outline, face.targets)
    assert "the outline moved by" in driver.say().casefold().replace("face 1: ", "")
    drawn = pixels_of(driver)
    driver.window.actions_by_name["overlay-read"].trigger()
    hidden = (pixels_of(driver) != drawn).any(axis=2)
    assert sum(hidden[at(driver, *point)] for point in outline) > 18, "the divider hides some"
    assert hidden.mean() < 0.05
    driver.window.actions_by_name["compare-wipe"].setChecked(False)
    assert driver.editor.view.retouched is None


@pytest.mark.parametrize(
    "percents", [(6.0,), pytest.param((4.0, 5.0, 6.0, 7.0, 12.0), marks=pytest.mark.slow)]
)
def test_pairs_become_a_style_for_another_photo(start, tmp_path, pixels, percents):
    driver = start()
    for number, percent in enumerate(percents):
        photo = np.roll(pixels, number, axis=2)
        recipe = Recipe(percent=percent, hold_background=False)
        Image.fromarray(photo).save(tmp_path / f"{number}.png")
        copy = render(photo, [oval_face()], recipe).pixels
        Image.fromarray(copy).save(tmp_path / f"{number}-copy.png")
        driver.open(tmp_path / f"{number}.png")
        match(driver, tmp_path / f"{number}-copy.png")
    driver.take_step(f"from {len(percents)} photo")
    line = driver.dialog(QInputDialog).findChild(QLineEdit)
    QTest.keyClicks(line, "Hers")
    QTest.keyClick(line, Qt.Key.Key_Return)
    Image.fromarray(pixels[..., ::-1]).save(tmp_path / "last.png")
    driver.open(tmp_path / "last.png")
    driver.choose("presets", "Hers")
    driver.settle()
    assert driver.state.recipe.percent == pytest.approx(6.0, abs=0.7)
    if len(percents) > 1:
        match(driver, tmp_path / "last.png")
        assert "from 1 photo" in driver.window.bar.buttons[0].text(), "a style begins anew"


def test_a_picture_of_something_else_is_refused(start, photo, tmp_path):
    driver = start(photo)
    Image.effect_noise((480, 360), 80.0).convert("RGB").save(tmp_path / "other.png")
    before = driver.state
    match(driver, tmp_path / "other.png")
    assert "can't be read" in driver.say()
    assert driver.state is before


def test_a_face_that_is_off_is_not_read(start, photo, copy):
    driver = start(photo)
    state = dataclasses.replace(driver.state, off=frozenset({0}))
    with pytest.raises(NotRead, match="no face"):
        matched(driver.editor.document.photo, state, copy)
