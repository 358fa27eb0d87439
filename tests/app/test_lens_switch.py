"""The window says how far a lens stretched a face, and takes it out."""

import numpy as np
import pytest
from PIL import Image
from PIL.ExifTags import Base as Tag
from PySide6.QtCore import Qt
from scenes import textured_photo
from test_view import picture

import kogao_core as kogao
from kogao_core.warp.lens import stretch_percent

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


def test_list_and_overlay_tell_how_far_and_which_way_a_face_is_stretched(start, wide):
    edge, middle = kogao.template_face((520, 60), 90), kogao.template_face((300, 200), 90)
    driver, _ = opened_with(start, wide, edge, middle)
    rows = driver.panel("faces")
    assert "lens: " in rows.item(0).text()
    assert "lens: " not in rows.item(1).text()
    assert "from the camera" in rows.item(0).toolTip()
    bare = picture(driver)
    driver.key(Qt.Key.Key_L, Qt.KeyboardModifier.ShiftModifier)
    drawn = picture(driver)
    radius = 6.0 * edge.anchor.spacing_px
    origin = np.array(edge.anchor.origin_px)
    way = (origin - (299.5, 199.5)) / np.hypot(*(origin - (299.5, 199.5)))
    longer = 1.0 + stretch_percent(edge, 26.0, driver.editor.document.state.image) / 100.0
    for end in (origin - longer * radius * way, origin + radius * way[::-1] * (1.0, -1.0)):
        column, row = driver.canvas.to_screen(end).toPoint().toTuple()
        near = np.s_[row - 2 : row + 3, 3 * (column - 2) : 3 * (column + 3)]
        assert (drawn[near] != bare[near]).any()


def test_a_photo_that_tells_nothing_has_no_such_overlay(start, photo):
    driver, lens = opened_with(start, photo, kogao.template_face((60, 60), 60))
    bare = picture(driver)
    driver.key(Qt.Key.Key_L, Qt.KeyboardModifier.ShiftModifier)
    np.testing.assert_array_equal(picture(driver), bare)
    lens.focal.setValue(24)
    driver.settle()
    assert "lens: " in driver.panel("faces").item(0).text()
