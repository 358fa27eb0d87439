"""Match a retouch: the open photo follows a retouched copy, and matches become a style."""

import dataclasses

import pytest
from kogao_app.features.retouch import matched
from PIL import Image
from scenes import oval_face

from kogao_core.pipeline import render
from kogao_core.reading.flow import NotRead
from kogao_core.recipe import presets
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


def test_a_retouched_copy_becomes_targets_a_wipe_and_a_style(start, photo, copy):
    driver = start(photo)
    match(driver, copy)
    (face,) = driver.state.faces
    assert face.targets is not None
    assert face.recipe.percent == pytest.approx(6.0, abs=1.0)
    assert driver.editor.view.compare == "wipe"
    assert driver.editor.view.retouched is not None
    assert "the outline moved by" in driver.say().casefold().replace("face 1: ", "")
    driver.editor.match._save("Hers")
    (recipe,) = presets.listed(driver.editor.match.storage.presets).values()
    assert recipe.percent == face.recipe.percent
    driver.window.actions_by_name["compare-wipe"].setChecked(False)
    assert driver.editor.view.retouched is None


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
