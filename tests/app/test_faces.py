"""Each face with settings of its own, and settings carried from face to face and photo to photo."""

import dataclasses
import io

import numpy as np
import pytest
from kogao_app.view_state import Handle
from named import HEAD, head_of, mwg
from PIL import Image
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from scenes import oval_face

from kogao_core.additions import fit
from kogao_core.base.geometry import Affine
from kogao_core.projects import interchange
from kogao_core.recipe.recipe import Recipe

pytestmark = pytest.mark.usefixtures("one_window")

CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
KEYS = Qt.Key


def choose(driver, row):
    rows = driver.panel("faces").list
    QTest.mouseClick(
        rows.viewport(),
        Qt.MouseButton.LeftButton,
        pos=rows.visualItemRect(rows.item(row)).center() + QPoint(20, 0),
    )


def percent(driver):
    return driver.panel("recipe").percent.slider


def test_only_the_selected_face_is_marked_in_the_list(two):
    rows = two.panel("faces").list
    for face in (1, None, 0, 1):
        two.editor.recipe.choose(face)
        two.settle()
        marked = [index.row() for index in rows.selectedIndexes()]
        assert marked == [0 if face is None else face + 1]


def test_a_word_that_asks_for_a_look_stands_below_the_name_in_the_warning_colour(opened):
    """The word stood before the name, in its colour."""
    face = dataclasses.replace(opened.state.faces[0], score=0.5, source="mesh")
    opened.editor.document.step(opened.state.with_face(0, face), "")
    opened.settle()
    rows = opened.panel("faces").list
    place = rows.visualItemRect(rows.item(1))
    image = rows.viewport().grab(place).toImage()
    names = image.copy(image.rect().adjusted(60, 0, -40, 0))
    pixels = [(y, names.pixelColor(x, y)) for y in range(names.height())
              for x in range(names.width())]  # fmt: skip
    inked = [y for y, colour in pixels if colour.red() > 2 * colour.blue()]
    assert len(inked) > 20
    assert min(inked) >= image.height() / 2 - 1


def test_a_face_chosen_in_the_list_comes_into_view(two):
    canvas, zoom = two.canvas, 8.0
    canvas.zoom_to(zoom, canvas.to_screen(two.state.faces[0].middle))
    rows = two.panel("faces").list
    for face in (0, 1):
        at = rows.visualItemRect(two.panel("faces").item(face)).center()
        QTest.mouseClick(rows.viewport(), Qt.MouseButton.LeftButton, pos=at)
        middle = canvas.to_screen(two.state.faces[face].middle).toPoint()
        assert canvas.viewport().rect().contains(middle)
        assert (canvas.zoom == pytest.approx(zoom)) == (face == 0), "what is in view stays"


def test_a_selected_face_gets_settings_of_its_own(two, pixels):
    choose(two, 2)
    assert two.panel("recipe").owner.title.text() == "Face 2"
    two.press_key(percent(two), KEYS.Key_End)
    two.settle()
    first, second = two.state.faces
    assert first.recipe is None
    assert second.recipe.percent == 15.0
    assert two.state.recipe.percent == 4.0
    tips = [two.panel("faces").item(row).toolTip() for row in (0, 1)]
    assert ["own settings, 15 %" in tip for tip in tips] == [False, True]
    spoken = two.panel("faces").item(1).data(Qt.ItemDataRole.AccessibleTextRole)
    assert spoken == "Face 2, by hand, own settings, 15 %"
    rows = two.panel("faces").list
    assert rows.sizeHintForColumn(0) <= rows.viewport().width(), "no row is cut"
    np.testing.assert_array_equal(two.shown, two.rendered(pixels))
    assert two.editor.document.undo.count() == 1


def test_the_panel_shows_and_sets_the_selected_faces_values(two):
    choose(two, 1)
    two.press_key(percent(two), KEYS.Key_End)
    two.settle()
    choose(two, 2)
    assert percent(two).value() == 40
    assert two.panel("recipe").owner.note.text() == "photo settings"
    choose(two, 1)
    assert percent(two).value() == 150
    assert two.panel("recipe").owner.note.text() == "own settings"
    choose(two, 0)
    assert percent(two).value() == 40
    assert two.panel("recipe").owner.note.text() == "except 1"
    two.press_key(percent(two), KEYS.Key_Home)
    two.settle()
    assert [two.state.recipe_of(face).percent for face in (0, 1)] == [15.0, 0.0]


def test_settings_that_are_there_already_are_no_step(two):
    two.key(KEYS.Key_C, CONTROL, SHIFT)
    two.key(KEYS.Key_V, CONTROL, SHIFT)
    assert two.editor.document.undo.count() == 0
    two.editor.recipe.choose(0)
    two.key(KEYS.Key_V, CONTROL, SHIFT)
    two.key(KEYS.Key_V, CONTROL, SHIFT)
    assert two.editor.document.undo.count() == 1, "but they become its own"


def test_the_way_back_to_the_photos_settings(two):
    choose(two, 1)
    two.press_key(percent(two), KEYS.Key_End)
    two.settle()
    button = two.panel("recipe").owner.button
    for row in (0, 1):
        choose(two, row)
        assert button.isVisible()
        QTest.mouseClick(button, Qt.MouseButton.LeftButton)
        two.settle()
        assert two.state.faces[0].recipe is None
        assert not button.isVisible()
        two.key(KEYS.Key_Z, CONTROL)
        assert two.state.faces[0].recipe.percent == 15.0


def test_what_only_the_photo_can_choose_stays_the_photos(two):
    choose(two, 2)
    panel = two.panel("recipe")
    QTest.mouseClick(panel.fold.button, Qt.MouseButton.LeftButton)
    panel.switches["guard"].click()
    assert two.state.recipe.guard is False
    assert two.state.faces[1].recipe is None


def test_a_clicked_centre_is_that_of_the_selected_face_alone(two):
    choose(two, 2)
    two.key(KEYS.Key_L)
    two.key(KEYS.Key_T)
    two.click(two.on_screen(Handle("centre", 1, 2)))
    assert two.state.faces[1].recipe.center == 3
    assert two.state.recipe == Recipe(percent=4.0)
    assert two.state.faces[0].recipe is None


def test_settings_are_copied_from_face_to_face_and_to_another_photo(two, start, photo):
    choose(two, 1)
    two.press_key(percent(two), KEYS.Key_End)
    two.settle()
    two.key(KEYS.Key_C, CONTROL, SHIFT)
    choose(two, 2)
    two.key(KEYS.Key_V, CONTROL, SHIFT)
    assert two.state.faces[1].recipe.percent == 15.0
    other = start(photo)
    steps = other.editor.document.undo.count()
    other.key(KEYS.Key_V, CONTROL, SHIFT)
    assert other.state.recipe == Recipe(percent=15.0)
    assert other.editor.document.undo.count() == steps + 1


STRANGE = (
    *("", "hello", "[" * 9000, '{"percent": 99}', "[1]", "\x00", "NaN"),
    '{"percent": 1' + "0" * 400 + "}",
)


def test_a_strange_clipboard_is_said_and_changes_nothing(two):
    before = two.state
    for text in STRANGE:
        two.window.bar.dismiss()
        assert two.say() == ""
        QGuiApplication.clipboard().setText(text)
        two.key(KEYS.Key_V, CONTROL, SHIFT)
        assert "no settings" in two.say(), text[:20]
        assert two.state is before, text[:20]


def test_settings_that_ask_for_too_much_are_said_and_undone(start, photo, pixels, monkeypatch):
    with monkeypatch.context() as narrow:
        narrow.setattr(fit, "MOST_CONTROL_POINTS", 100)
        driver = start(photo)
    assert "choose fewer faces" in driver.say()
    assert driver.say().count("\n") == 0

    driver.key(KEYS.Key_F, CONTROL)
    driver.settle()
    np.testing.assert_array_equal(driver.shown, driver.rendered(pixels))


def test_settings_of_nothing_to_warp_show_the_photo(two, pixels):
    QGuiApplication.clipboard().setText('{"percent": 0, "lattice_unit": "warp"}')
    two.key(KEYS.Key_V, CONTROL, SHIFT)
    two.settle()
    assert two.state.recipe.lattice_unit == "warp"
    np.testing.assert_array_equal(two.shown, pixels)


def test_a_face_that_goes_gives_the_panel_back_to_the_photo(two, source):
    choose(two, 2)
    source.faces = source.faces[:1]
    two.press_key(percent(two), KEYS.Key_End)
    two.settle()
    two.key(KEYS.Key_F, CONTROL)
    two.settle()
    assert two.editor.view.face is None
    assert two.panel("recipe").owner.title.text() == "All faces"


def test_arrows_walk_through_the_faces(two):
    choose(two, 0)
    two.press_key(two.panel("faces").list, KEYS.Key_Down)
    assert two.editor.view.face == 0
    QTest.keyClick(two.panel("faces").list, KEYS.Key_Space)
    assert two.state.off == {0}


def test_the_wheel_moves_a_slider_with_the_focus_in_one_step(two, qtbot):
    slider = percent(two)
    slider.setFocus()
    for _ in range(3):
        two.turn_wheel(slider, 1)
    qtbot.waitUntil(lambda: not two.editor.document.in_gesture)
    assert two.state.recipe.percent > 4.0
    assert two.editor.document.undo.count() == 1


def test_a_photo_without_faces_has_the_row_of_the_photo(start, source, photo):
    source.faces = []
    driver = start()
    driver.open(photo)
    rows = driver.panel("faces").list
    assert [rows.item(row).text() for row in range(rows.count())] == ["All faces"]


def test_names_from_the_photos_metadata_stand_beside_the_faces(start, source, tmp_path, encoded):
    file, picture = tmp_path / "named.jpg", Image.open(io.BytesIO(encoded)).convert("RGB")
    place = head_of(source.faces[0], picture.size)
    picture.save(file, xmp=HEAD.format(mwg([("Zoë Ann", place)], picture.size)).encode())
    driver = start(file)
    item = driver.panel("faces").item(0)
    assert item.text() == "Zoë Ann"
    assert item.data(Qt.ItemDataRole.AccessibleTextRole).startswith("Zoë Ann, ")


def test_a_landmark_file_replaces_the_faces_in_one_undo_step(opened, tmp_path):
    before, path = opened.state, tmp_path / "points.csv"
    moved = oval_face().mapped(Affine(np.eye(2), np.array([7.0, -4.0])))
    refused = Affine(np.eye(2), np.array([4000.0, 0.0]))
    for face, words in ((moved.mapped(refused), "another photo"), (moved, "")):
        interchange.write([face], path)
        opened.window.actions_by_name["import-landmarks"].trigger()
        opened.choose_path(path)
        opened.settle()
        assert words in opened.say()
        assert (opened.state is before) == bool(words)
    np.testing.assert_allclose(opened.state.faces[0].points, moved.points, atol=0.001)
    opened.to_front()
    opened.key(KEYS.Key_Z, CONTROL)
    assert opened.state.faces == before.faces
