"""The window says how far a lens stretched a face, and takes it out."""

import numpy as np
import pytest
from PIL import Image
from PIL.ExifTags import Base as Tag
from scenes import textured_photo

import kogao_core as kogao

pytestmark = pytest.mark.usefixtures("one_window")


@pytest.fixture
def wide(tmp_path):
    """A whole photo of 26 mm."""
    exif, path = Image.Exif(), tmp_path / "wide.jpg"
    exif.get_ifd(Tag.ExifOffset)[Tag.FocalLengthIn35mmFilm] = 26
    Image.fromarray(textured_photo(600, 400, 3)).save(path, exif=exif)
    return path


def opened_with(start, path, *faces):
    driver = start(path)
    driver.editor.document.start_with(faces)
    driver.settle()
    return driver, driver.panel("recipe").lens


def test_the_switch_comes_with_its_reason_where_a_face_is_stretched(start, wide):
    edge, middle = kogao.template_face((520, 60), 90), kogao.template_face((300, 200), 90)
    driver, lens = opened_with(start, wide, edge, middle)
    panel = driver.panel("recipe")
    panel.show_words(plain=True)
    panel.show_state(driver.editor.document.state)
    assert lens.isVisibleTo(panel)
    assert "26 mm" in lens.note.text()
    panel.show_state(driver.editor.document.state, 1)
    assert not lens.isVisibleTo(panel)
    panel.more.button.setChecked(True)
    assert lens.isVisibleTo(panel)


def test_the_switch_takes_it_out_and_undo_brings_it_back(start, wide):
    face = kogao.template_face((520, 60), 90)
    driver, lens = opened_with(start, wide, face)
    before = driver.editor.document.state
    lens.switch.click()
    driver.settle()
    state = driver.editor.document.state
    assert (state.recipe.lens, state.done.recipe.lens) == ("auto", 26.0)
    assert not lens.focal.isHidden()
    assert lens.focal.text() == "26 mm"
    drawn = driver.editor.view.frame.rendering
    wanted = kogao.render(driver.editor.document.photo.pixels, state.active, state.done.recipe)
    assert np.abs(drawn.field.at(face.points) - wanted.field.at(face.points)).max() < 0.1
    np.testing.assert_allclose(state.pairs[0].target_px, wanted.pairs[0].target_px, atol=1e-6)
    lens.focal.setValue(35)
    assert driver.editor.document.state.done.recipe.lens == 35.0
    driver.editor.document.undo.undo()
    driver.editor.document.undo.undo()
    assert driver.editor.document.state.recipe == before.recipe
    assert not lens.switch.isChecked()


def test_a_photo_that_tells_nothing_is_asked_for_the_number(start, photo):
    driver, lens = opened_with(start, photo, kogao.template_face((60, 60), 60))
    lens.switch.click()
    driver.settle()
    assert driver.editor.document.state.done.recipe.lens == "off"
    assert "focal length" in lens.note.text()
    lens.focal.setValue(24)
    driver.settle()
    assert driver.editor.document.state.done.recipe.lens == 24.0
    assert "24 mm" in lens.note.text()


def test_the_list_tells_how_far_a_face_is_stretched(start, wide):
    edge, middle = kogao.template_face((520, 60), 90), kogao.template_face((300, 200), 90)
    driver, _ = opened_with(start, wide, edge, middle)
    rows = driver.panel("faces")
    assert "lens: " in rows.item(0).toolTip()
    assert "lens: " not in rows.item(1).toolTip()
    assert "from the camera" in rows.item(0).toolTip()
