"""Amounts that are typed, and the wheel that passes over controls."""

import pytest
from kogao_app.features.recipe import fields
from kogao_app.widgets.docks import ColumnArea
from kogao_app.widgets.sliders import ValueSlider
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractSlider, QAbstractSpinBox, QComboBox, QScrollBar, QSlider

from kogao_core.recipe.recipe import SHAPE

pytestmark = pytest.mark.usefixtures("one_window")

KEYS, LEFT = Qt.Key, Qt.MouseButton.LeftButton


def type_in(field, text, key=KEYS.Key_Return):
    QTest.mouseClick(field, LEFT)
    QTest.keyClicks(field, text)
    QTest.keyClick(field, key)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *(("6", 6.0), ("6,5", 6.5), ("6.25 %", 6.25), ("7 % of D", 7.0), (" 8% ", 8.0)),
        *(("0", 0.0), ("15", 15.0), (",5", 0.5), ("3.", 3.0), ("\u22120", 0.0)),
        *(("15.1", None), ("-16", None), ("", None), ("six", None), ("6 7", None), ("6 px", None)),
        *(("6;", None), ("%", None), ("1e1", None), ("1 000", None), ("nan", None)),
    ],
)
def test_an_amount_is_read_with_or_without_its_unit(text, value):
    assert fields.percent().read(text) == value


def test_other_scales_read_their_own_units():
    assert fields.lattice().read("R 1,5") == 1.5
    assert fields.lattice().read("5") is None
    assert fields.threshold().read("0.5 px") == 0.5
    assert fields.threshold().read("0 px, lossless") == 0.0


def test_a_typed_amount_is_one_step_and_stands_there_exactly(opened):
    slider = opened.panel("recipe").percent
    type_in(slider.field, "6,25")
    opened.settle()
    assert opened.state.recipe.percent == 6.25
    assert slider.field.text() == "6.25 % of D"
    assert opened.editor.document.undo.undoText() == "Amount 4.0 → 6.25 % of D"
    assert opened.editor.document.undo.count() == 1
    assert slider.slider.hasFocus(), "the arrows go on from there"
    opened.key(KEYS.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert slider.field.text() == "4.0 % of D"


def test_a_field_that_is_left_takes_what_was_typed(opened):
    panel = opened.panel("recipe")
    QTest.mouseClick(panel.percent.field, LEFT)
    QTest.keyClicks(panel.percent.field, "7")
    opened.set("percent", 5.0)
    assert panel.percent.field.text() == "7", "it outlives another state"
    QTest.mouseClick(opened.canvas.viewport(), LEFT, pos=QPoint(3, 3))
    assert opened.state.recipe.percent == 7.0


def test_a_field_that_is_looked_at_changes_nothing(opened):
    fold = opened.panel("recipe").fold.button
    QTest.mouseClick(fold, LEFT)
    field = opened.panel("recipe").sliders["threshold_px"].field
    before = opened.state.recipe
    type_in(field, "")
    assert opened.state.recipe == before, "what it shows is rounded"
    assert opened.editor.document.undo.count() == 0


@pytest.mark.parametrize("text", ["40", "a lot"])
def test_what_is_no_amount_is_said_once_and_the_last_one_stays(opened, text):
    field = opened.panel("recipe").percent.field
    type_in(field, text)
    assert opened.say() == "Amount goes from -15.0 % of D to 15.0 % of D."
    assert field.text() == "4.0 % of D"
    assert opened.editor.document.undo.count() == 0


def test_escape_gives_up_what_was_typed_and_nothing_else(two):
    two.editor.recipe.choose(0)
    field = two.panel("recipe").percent.field
    for typed in ("9", "x.,o"):
        type_in(field, typed, KEYS.Key_Escape)
        assert field.text() == "4.0 % of D"
        assert two.state.recipe_of(0).percent == 4.0
        assert two.editor.view.face == 0
    assert two.editor.view.compare == "off", "letters typed in a field are no shortcuts"
    assert not two.window.actions_by_name["hide-overlays"].isChecked()
    two.key(KEYS.Key_Escape)
    assert two.editor.view.face is None, "the next one steps back as ever"


def test_enter_leads_from_a_slider_to_its_field_and_back(opened):
    slider = opened.panel("recipe").lattice
    slider.slider.setFocus()
    QTest.keyClick(opened.window.focusWidget(), KEYS.Key_Return)
    assert slider.field.hasFocus()
    assert slider.field.selectedText() == slider.field.text()
    QTest.keyClicks(opened.window.focusWidget(), "2")
    QTest.keyClick(opened.window.focusWidget(), KEYS.Key_Return)
    assert opened.state.recipe.lattice == 2.0
    assert slider.slider.hasFocus()


def test_a_brush_is_typed_in_px_across(opened):
    opened.key(KEYS.Key_B)
    slider = opened.panel("protect").size_px
    type_in(slider.field, "33")
    assert opened.editor.view.brush.radius_px == 16.5
    assert slider.field.text() == "33 px"
    type_in(slider.field, "0")
    assert opened.say() == "Size goes from 2 px to 1024 px."


def test_every_slider_has_a_field_whose_longest_value_is_seen_whole(opened):
    panel = opened.panel("recipe")
    for fold in (panel.shape, panel.fold):
        QTest.mouseClick(fold.button, LEFT)
    opened.key(KEYS.Key_B)
    sliders = opened.window.findChildren(QSlider)
    fields_ = [one.field for one in opened.window.findChildren(ValueSlider)]
    assert len(fields_) == len(sliders) == 8 + len(SHAPE)
    for field in fields_:
        for text in field._scale.ends:
            field.show_text(text)
            assert field.fontMetrics().horizontalAdvance(text) + 4 <= field.width()
        assert field.accessibleName().endswith(", in figures")
        assert not field.acceptDrops(), "photos are for the window"


# -- the wheel -------------------------------------------------------------------------------------


def turned_by_wheels(root):
    """Everything below a widget that a wheel could set to another value."""
    kinds = (QAbstractSlider, QAbstractSpinBox, QComboBox)
    found = [widget for kind in kinds for widget in root.findChildren(kind)]
    return [widget for widget in found if not isinstance(widget, QScrollBar)]


def value(widget):
    return widget.currentIndex() if isinstance(widget, QComboBox) else widget.value()


def test_the_wheel_sets_nothing_that_has_not_the_focus(opened):
    """In the window and in every dialog that has anything to set: what is found is tried."""
    QTest.mouseClick(opened.panel("recipe").fold.button, LEFT)
    opened.key(KEYS.Key_B)
    for name in ("export", "preferences"):
        opened.window.actions_by_name[name].trigger()
    controls = turned_by_wheels(opened.window)
    for kind in (QAbstractSlider, QAbstractSpinBox, QComboBox):
        assert any(isinstance(control, kind) for control in controls)
    opened.canvas.setFocus()
    before = [value(one) for one in controls]
    for control in controls:
        assert control.focusPolicy() != Qt.FocusPolicy.WheelFocus, "the wheel would bring it"
        opened.turn_wheel(control, -1)
    assert [value(one) for one in controls] == before
    assert not opened.editor.document.in_gesture


@pytest.mark.parametrize("notch", [-120, 120])
def test_the_wheel_over_what_has_not_the_focus_moves_the_panel(opened, notch):
    panel = opened.panel("recipe")
    for fold in (panel.fold, panel.shape):
        QTest.mouseClick(fold.button, LEFT)
    area = opened.window.findChild(ColumnArea)
    control = panel.percent.slider if notch < 0 else panel.choices["interpolation"]

    def seen():
        area.ensureWidgetVisible(control)
        return area.verticalScrollBar().maximum() > 0 and not control.visibleRegion().isEmpty()

    opened.qtbot.waitUntil(seen)
    before = area.verticalScrollBar().value()
    at = control.mapTo(opened.window, control.rect().center())
    QTest.wheelEvent(opened.window.windowHandle(), at, QPoint(0, notch))
    assert (area.verticalScrollBar().value() - before) * notch < 0


def test_the_wheel_turns_what_has_the_focus(opened):
    QTest.mouseClick(opened.panel("recipe").fold.button, LEFT)
    box = opened.panel("recipe").choices["interpolation"]
    box.setFocus()
    before = box.currentIndex()
    opened.turn_wheel(box, -1)
    assert box.currentIndex() == before + 1
