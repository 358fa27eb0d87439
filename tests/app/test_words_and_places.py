"""What lies where a retoucher looks for it: keys, palette, groups, what is held back."""

import dataclasses
from functools import partial

import pytest
from kogao_app.canvas.overlays.overlay import Place, affine
from kogao_app.canvas.overlays.unlisted import badges
from kogao_app.features.commands import Palette
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialog

from kogao_core.additions.guard import Limit
from kogao_core.pipeline import render

pytestmark = pytest.mark.usefixtures("one_window")

KEYS, LEFT = Qt.Key, Qt.MouseButton.LeftButton
CTRL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


def test_keys_of_other_programs_zoom(opened):
    went = []
    keys = {"fit": KEYS.Key_0, "actual": KEYS.Key_1}
    keys |= {"closer": KEYS.Key_Plus, "farther": KEYS.Key_Minus}
    for name, key in keys.items():
        opened.window.actions_by_name[name].triggered.connect(lambda *_, n=name: went.append(n))
        opened.key(key, CTRL)
    assert went == list(keys)


def test_a_double_click_shows_the_place_1_to_1_and_another_one_all(opened):
    at = QPoint(90, 70)
    there = opened.canvas.to_photo(at.toPointF())
    fitted = opened.canvas.zoom
    for zoom in (1.0, fitted):
        QTest.mouseDClick(opened.canvas.viewport(), LEFT, pos=at)
        QTest.mouseRelease(opened.canvas.viewport(), LEFT, pos=at)
        assert opened.canvas.zoom == pytest.approx(zoom, rel=0.02)
        if zoom == 1.0:
            assert abs(opened.canvas.to_photo(at.toPointF()) - there).max() < 1.0
    assert not opened.editor.document.undo.canUndo()


def test_the_palette_knows_what_others_call_it(opened):
    opened.key(KEYS.Key_P, CTRL, SHIFT)
    palette = opened.dialog(Palette)
    words = {"before": "Wipe", "history": "History", "freeze": "Protect", "resize": "Export"}
    for typed, found in words.items():
        palette.words.setText(typed)
        rows = [palette.list.item(row) for row in range(palette.list.count())]
        assert found in [one.text().partition("   ")[0] for one in rows if not one.isHidden()]
        assert not palette.nothing.isVisible()
    palette.words.setText("face")
    said = palette.words.accessibleDescription()
    assert said.endswith(" commands"), "told as a change of the focused field"
    QTest.keyClick(palette.words, Qt.Key.Key_Down)
    row = palette.list.currentItem().text()
    assert palette.words.accessibleDescription().startswith(f"{row}, ")
    assert row not in said
    palette.words.setText("xylophone")
    assert palette.nothing.isVisible()
    assert palette.words.accessibleDescription() == palette.nothing.text()
    palette.close()


def test_several_faces_are_set_at_once_and_rows_tell_their_amounts(two):
    rows = two.panel("faces").list
    one, other = (rows.visualItemRect(rows.item(row)).center() for row in (1, 2))
    QTest.mouseClick(rows.viewport(), LEFT, pos=one)
    QTest.mouseClick(rows.viewport(), LEFT, CTRL, pos=other)
    assert (two.editor.view.face, two.editor.view.also) == (1, frozenset({0}))
    assert two.panel("recipe").owner.title.text() == "Faces 1, 2"
    two.panel("recipe").percent.edited.emit(7.5)
    two.panel("recipe").percent.rested.emit()
    assert [face.recipe.percent for face in two.state.faces] == [7.5, 7.5]
    assert all("own settings, 7.5 %" in rows.item(row).toolTip() for row in (1, 2))
    assert two.editor.document.undo.count() == 1
    QTest.mouseClick(rows.viewport(), LEFT, pos=one)
    assert (two.editor.view.face, two.editor.view.also) == (0, frozenset())
    two.editor.recipe.choose(0, [0, 1])
    two.editor.recipe.follow_photo()
    assert [face.recipe for face in two.state.faces] == [None, None]


def test_who_is_held_back_is_named_on_the_canvas(two, pixels):
    rendering = render(pixels, two.state.faces, two.state.recipe)
    held = dataclasses.replace(rendering, limits=(Limit(), Limit(0.7, (0.0, 0.0))))
    view, area = two.editor.view, two.canvas.viewport().rect().toRectF()
    view.set(frame=dataclasses.replace(view.frame, rendering=held))
    place = Place(affine(two.canvas._to_screen()), area)
    texts = [badge.text for badge in badges(view, place, two.canvas.font())]
    assert [text for text in texts if "⚠" in text] == ["2 ⚠ 70 %"]


# Tools that show a panel below the settings.
SHOWN = {"tool-push": "push", "tool-brush": "protect", "mode-manual": "manual"}


def whole(panel):
    """Whether a panel is visible without scrolling."""
    return panel.visibleRegion().boundingRect() == panel.rect()


@pytest.mark.parametrize("workspace", ["retouch", "compare"])
def test_settings_stay_in_place_when_a_tool_shows_its_panel(start, photo, workspace):
    driver = start(photo, workspace=workspace)
    slider = driver.panel("recipe").percent.slider

    def place():
        return slider.mapTo(driver.window, QPoint()), slider.size()

    before = place()
    for name in (*SHOWN, "mode-automatic"):
        driver.window.actions_by_name[name].trigger()
        driver.settle()
        assert (name, *place()) == (name, *before)
        if name != "mode-automatic":
            driver.qtbot.waitUntil(partial(whole, driver.panel(SHOWN[name])))
    driver.unfold()
    driver.settle()
    assert place() == before, "a scroll bar takes no room of the settings"


def test_lens_correction_moves_no_other_setting(start, photo):
    driver = start(photo, workspace="retouch")
    panel = driver.panel("recipe")
    before = panel.shape.mapTo(panel, QPoint()), panel.more.mapTo(panel, QPoint())
    for lens in (24.0, "off"):
        driver.editor.recipe.set_field("lens", lens)
        driver.settle()
        assert (panel.shape.mapTo(panel, QPoint()), panel.more.mapTo(panel, QPoint())) == before


def test_keys_of_menus_that_a_workspace_does_not_show_do_nothing(start, photo):
    driver = start(photo, workspace="retouch")
    driver.key(KEYS.Key_F3)
    driver.key(KEYS.Key_1, CTRL, Qt.KeyboardModifier.AltModifier)
    driver.settle()
    assert driver.state.mode == "automatic"
    assert not driver.window.findChildren(QDialog)
    driver.window.actions_by_name["workspace-compare"].trigger()
    assert driver.window.actions_by_name["experiment-methods"].isEnabled(), "a button there"
    driver.key(KEYS.Key_F3)
    assert driver.state.mode == "manual"
    driver.window.actions_by_name["workspace-retouch"].trigger()
    driver.key(KEYS.Key_F2)
    assert driver.state.mode == "automatic", "there is a way back everywhere"
