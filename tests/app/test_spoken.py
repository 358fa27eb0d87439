"""What a screen reader is told, asked for as one asks: through QAccessible."""

from __future__ import annotations

import gc

import pytest
from kogao_app.features import speech
from kogao_app.features.recipe import fields
from kogao_app.widgets.controls import ValueSlider
from PySide6.QtCore import QCoreApplication, QEvent, Qt
from PySide6.QtGui import QAccessible
from PySide6.QtTest import QTest

KEYS, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier
TEXT = QAccessible.Text


def of(widget):
    return QAccessible.queryAccessibleInterface(widget)


def spoken(widget):
    found = of(widget)
    return found.text(TEXT.Value), found.valueInterface().currentValue()


def test_a_slider_tells_its_value_as_it_is_shown(opened):
    slider = opened.panel("recipe").percent.slider
    assert spoken(slider) == ("4.0 % of D", 4.0)
    opened.press_key(slider, KEYS.Key_Right)
    assert spoken(slider) == ("4.1 % of D", 4.1)
    value = of(slider).valueInterface()
    assert (value.minimumValue(), value.maximumValue()) == (0.0, 15.0)
    assert of(slider).text(TEXT.Name) == slider.accessibleName()
    assert of(slider).role() == QAccessible.Role.Slider


def test_a_typed_value_between_two_steps_is_told_exactly(opened):
    percent = opened.panel("recipe").percent
    QTest.mouseClick(percent.field, Qt.MouseButton.LeftButton)
    QTest.keyClicks(percent.field, "6.25")
    QTest.keyClick(percent.field, KEYS.Key_Return)
    assert spoken(percent.slider) == ("6.25 % of D", 6.25)


@pytest.mark.parametrize("field", ["lattice", "threshold_px"])
def test_every_scale_is_told_in_its_own_figures(opened, field):
    slider = opened.panel("recipe").sliders[field]
    text, number = spoken(slider.slider)
    assert text == slider.field.text()
    assert f"{number:.2f}" in text


def test_the_width_of_the_brush_is_told_across_as_it_is_shown(opened):
    size = opened.panel("protect").size_px
    text, number = spoken(size.slider)
    assert text == size.field.text() == f"{number:.0f} px across"


def test_assistive_technology_sets_a_value_as_one_undo_step(opened):
    slider = opened.panel("recipe").percent.slider
    of(slider).valueInterface().setCurrentValue(6.5)
    opened.settle()
    assert opened.state.recipe.percent == 6.5
    assert opened.editor.document.undo.count() == 1
    of(slider).valueInterface().setCurrentValue(99.0)
    assert opened.state.recipe.percent == 15.0, "the nearest that there is"
    of(slider).actionInterface().doAction("Decrease")
    assert opened.state.recipe.percent == 14.9
    of(slider).actionInterface().doAction("SetFocus")
    assert slider.hasFocus()
    assert of(slider).state().focused


def test_a_slider_is_asked_for_everything_that_a_screen_reader_asks(opened):
    slider = of(opened.panel("recipe").percent.slider)
    asked = ("text", "editableText", "selection", "tableCell", "attributes")
    assert [getattr(slider, f"{kind}Interface")() for kind in asked] == [None] * len(asked)
    assert slider.parent().object() is opened.panel("recipe").percent
    assert slider.childCount() == 0
    assert slider.state().focusable
    assert slider.rect().size() == slider.object().size()


def test_sliders_come_and_go_while_they_are_asked(qtbot):
    for _ in range(50):
        slider = ValueSlider("Amount", fields.percent(), "", 0)
        qtbot.addWidget(slider)
        slider.show_value(3.0)
        assert spoken(slider.slider) == ("3.0 % of D", 3.0)
        slider.deleteLater()
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    gc.collect()


@pytest.fixture
def heard(monkeypatch):
    said = []
    monkeypatch.setattr(speech, "announce", lambda _, text: said.append(text))
    return said


def test_a_point_is_named_and_its_move_told_once_it_is_known_whether_it_folds(opened, heard):
    for _ in range(2):
        opened.key(KEYS.Key_Period, CONTROL)
    assert heard == ["outline 1, left temple", "outline 2, left cheek"]
    opened.press_key(opened.canvas, KEYS.Key_Left, times=3)
    opened.settle()
    assert heard[2:] == ["outline 2, left cheek, 3 px left, no folds"]
    opened.key(KEYS.Key_Z, CONTROL)
    opened.settle()
    assert heard[3:] == ["outline 2, left cheek, 1 px right, no folds"]


def test_what_stands_over_the_photo_is_said(opened, heard):
    opened.editor.points.say("The clipboard holds no settings.")
    assert heard == ["The clipboard holds no settings."]


def test_the_choice_of_a_face_is_said(two, heard):
    two.editor.recipe.choose(1)
    two.editor.recipe.choose(None)
    assert heard == ["Face 2 of 2", "All faces"]


def test_an_announcement_is_an_event_of_the_canvas(opened, monkeypatch):
    events = []
    monkeypatch.setattr(QAccessible, "updateAccessibility", events.append)
    opened.editor.points.say("Something.")
    (event,) = [e for e in events if e.type() == QAccessible.Event.Announcement]
    assert event.message() == "Something."
    assert event.object() is opened.canvas
