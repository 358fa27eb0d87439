"""Width, length, jaw and the like in Retouch: one slider each, signed, at any amount."""

import pytest
from kogao_app.widgets.docks import ColumnArea
from kogao_app.workspaces import RETOUCH
from PySide6.QtCore import QEvent, QPoint, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDockWidget

from kogao_core.recipe.recipe import SHAPE

pytestmark = pytest.mark.usefixtures("one_window")

KEYS, ALT = Qt.Key, Qt.KeyboardModifier.AltModifier
LEFT, CTRL = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def retouch(start, photo):
    return start(photo, workspace=RETOUCH.name)


def sliders(driver):
    return driver.panel("recipe").sliders


def dragged(slider, by, modifier=Qt.KeyboardModifier.NoModifier):
    """Drag a slider that stands in its middle."""
    at = QPoint(slider.width() // 2, slider.height() // 2)
    there = at + QPoint(by, 0)
    QTest.mousePress(slider, LEFT, pos=at)
    place, kind = there.toPointF(), QEvent.Type.MouseMove
    event = QMouseEvent(kind, place, slider.mapToGlobal(place), LEFT, LEFT, modifier)
    QApplication.sendEvent(slider, event)
    QTest.mouseRelease(slider, LEFT, pos=there)


def test_the_jaw_alone_is_slimmed_by_two_actions(retouch):
    QTest.mouseDClick(sliders(retouch)["percent"].field, LEFT)
    QTest.keyClicks(sliders(retouch)["percent"].field, "0\r")
    dragged(sliders(retouch)["jaw_width"].slider, -40)
    retouch.settle()
    recipe = retouch.state.recipe
    assert (recipe.percent, recipe.jaw_width < 0.0) == (0.0, True)
    moved = retouch.state.pairs[0].displacement_px
    assert abs(moved[[0, 10, 20]]).max() < 0.2 < 1.0 < abs(moved).max()
    retouch.window.actions_by_name["undo"].trigger()
    assert retouch.state.recipe.jaw_width == 0.0


def test_each_is_in_sight_goes_both_ways_and_comes_back_by_a_double_click(retouch):
    panel = retouch.panel("recipe")
    at_first = [one for one in panel.sliders.values() if one.isVisible()]
    assert len(at_first) == 6, "Amount, and the parts of a face that are changed most"
    panel.sides.button.setChecked(True)
    for name in (name for name in SHAPE if name != "even_out"):
        slider = sliders(retouch)[name]
        assert slider.isVisible()
        ends = {}
        for key in (KEYS.Key_Home, KEYS.Key_End):
            retouch.press_key(slider.slider, key)
            ends[key] = getattr(retouch.state.recipe, name), slider.field.text()
        assert list(ends.values()) == [(-15.0, "-15.0 %"), (15.0, "+15.0 %")], name
        QTest.mouseDClick(slider.slider, LEFT)
        assert getattr(retouch.state.recipe, name) == 0.0


def test_a_drag_with_ctrl_is_ten_times_as_fine(retouch):
    jaw = sliders(retouch)["jaw_width"].slider
    found = []
    for modifier in (Qt.KeyboardModifier.NoModifier, CTRL, Qt.KeyboardModifier.ShiftModifier):
        dragged(jaw, 30, modifier)
        found.append(retouch.state.recipe.jaw_width)
        QTest.mouseDClick(jaw, LEFT)
    assert found[0] > 5.0
    assert found[1:] == [pytest.approx(found[0] / 10, abs=0.15)] * 2


def test_alt_j_leads_to_the_jaw_where_one_starts(retouch):
    retouch.key(KEYS.Key_J, ALT)
    assert sliders(retouch)["jaw_width"].slider.hasFocus()


def test_the_panel_can_be_widened_and_sliders_are_as_wide(retouch):
    jaw = sliders(retouch)["jaw_width"].slider
    area = next(one for one in retouch.window.findChildren(ColumnArea) if one.isAncestorOf(jaw))
    docks = retouch.window.findChildren(QDockWidget)
    dock, before = next(one for one in docks if one.isAncestorOf(jaw)), jaw.width()
    assert before > 0.3 * area.viewport().width()
    retouch.window.resizeDocks([dock], [area.width() + 120], Qt.Orientation.Horizontal)
    retouch.qtbot.waitUntil(lambda: jaw.width() > before + 80)
    wide = jaw.width()
    for name in ("workspace-inspect", "workspace-retouch"):
        retouch.window.actions_by_name[name].trigger()
    retouch.qtbot.waitUntil(lambda: jaw.width() == wide)
    retouch.window.actions_by_name["reset-workspace"].trigger()

    retouch.qtbot.waitUntil(lambda: jaw.width() == before)


def test_a_letter_leads_to_the_direction_and_changes_nothing(retouch):
    panel = retouch.panel("recipe")
    panel.more.button.setChecked(True)
    retouch.set("scope", "face")
    before = retouch.editor.document.undo.count()
    retouch.key(KEYS.Key_C, ALT)
    retouch.settle()
    assert panel.centre.group.button(2).hasFocus()
    assert retouch.state.recipe.center == 2
    assert retouch.editor.document.undo.count() == before
    assert [one.text() for one in panel.centre.group.buttons()] == ["1", "2", "3", "4"]


def test_undo_speaks_the_words_of_the_panel(retouch):
    said = []
    for workspace in ("retouch", "inspect"):
        retouch.window.actions_by_name[f"workspace-{workspace}"].trigger()
        retouch.press_key(sliders(retouch)["percent"].slider, KEYS.Key_Right)
        said.append(retouch.editor.document.undo.undoText().partition(" 4")[0])
    assert said == ["Amount", "Amount"]
