"""What a screen reader is told, asked for as one asks: through QAccessible."""

import gc
import re
import sys

import numpy as np
import pytest
from kogao_app.accessibility import tell_choices
from kogao_app.canvas import photo_canvas
from kogao_app.canvas.spoken import Part
from kogao_app.features import speech
from kogao_app.features.recipe import fields
from kogao_app.features.recipe.fields import CenterChoice
from kogao_app.view_state import Handle
from kogao_app.widgets.messages import BarAction
from kogao_app.widgets.sliders import ValueSlider
from PySide6.QtCore import QCoreApplication, QEvent, Qt, QTimer
from PySide6.QtGui import QAccessible
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolButton
from scenes import oval_face
from systems import needs_own_names

pytestmark = pytest.mark.usefixtures("one_window")

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
    assert value.maximumValue() == 15.0
    assert value.minimumValue() == (15.0 if sys.platform == "linux" else 0.0), "Orca's percentage"
    assert of(slider).text(TEXT.Name) == slider.accessibleName()
    assert of(slider).role() == QAccessible.Role.Slider


def test_a_description_begins_with_the_value_and_a_step_by_key_tells_only_the_value(
    opened, monkeypatch
):
    opened.to_front()
    opened.canvas.setFocus()
    sliders = [one.slider for one in opened.window.findChildren(ValueSlider)]
    for slider in sliders:
        said = of(slider).text(TEXT.Description)
        assert said == f"{slider.amount_text()}\n{slider.accessibleDescription()}"
        assert re.search(r"[^\d\s.,+-]", slider.amount_text()), "a unit"
    slider, told = opened.panel("recipe").percent.slider, []
    event = QAccessible.Event.DescriptionChanged
    with monkeypatch.context() as patch:
        patch.setattr(QAccessible, "updateAccessibility", lambda one: told.append(one.type()))
        opened.press_key(slider, KEYS.Key_Right)
    assert of(slider).text(TEXT.Description) == slider.amount_text() == "4.1 % of D"
    assert told.count(event) == 1
    opened.canvas.setFocus()
    assert of(slider).text(TEXT.Description) == f"4.1 % of D\n{slider.accessibleDescription()}"


def test_every_scale_is_told_in_its_own_figures(opened):
    recipe = opened.panel("recipe").sliders
    recipe["percent"].field.typed.emit(6.25)
    for slider in (*map(recipe.get, ("percent", "lattice", "threshold_px")),
                   opened.panel("protect").size_px):  # fmt: skip
        text, number = spoken(slider.slider)
        assert text == slider.field.text()
        assert f"{number:.3g}" in text


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


@needs_own_names
def test_controls_come_and_go_while_they_are_asked(qtbot):
    tell_choices()
    for _ in range(10):
        choice, slider = CenterChoice(), ValueSlider("Amount", fields.percent(), "", 0)
        for one in (choice, slider):
            qtbot.addWidget(one)
        slider.show_value(3.0)
        assert spoken(slider.slider) == ("3.0 % of D", 3.0)
        assert of(choice.group.button(1)).role() == QAccessible.Role.RadioButton
        for one in (choice, slider):
            one.deleteLater()
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    gc.collect()


@needs_own_names
def test_what_excludes_each_other_is_told_as_radio_buttons(opened):
    opened.window.actions_by_name["workspace-inspect"].trigger()
    opened.editor.recipe.set_field("scope", "face")  # with which the centre counts
    centre = opened.panel("recipe").centre.group.buttons()
    tools = opened.window.actions_by_name
    named = ("workspace-retouch", "workspace-inspect", "mode-manual", "tool-brush", "loupe")
    buttons = {
        name: next(one for one in tools[name].associatedObjects() if isinstance(one, QToolButton))
        for name in named
    }
    radio = QAccessible.Role.RadioButton
    assert {of(one).role() for one in centre} == {radio}
    assert len(centre) == 4
    assert [of(buttons[name]).role() == radio for name in named] == [True] * 4 + [False]
    assert [of(one).state().checked for one in centre] == [False, True, False, False]
    assert of(centre[2]).text(TEXT.Name) == "Centre 3"
    of(centre[2]).actionInterface().doAction("Press")
    assert [of(one).state().checked for one in centre] == [False, False, True, False]
    assert opened.state.recipe.center == 3
    of(centre[0]).actionInterface().doAction("SetFocus")
    assert of(centre[0]).state().focused
    assert of(centre[0]).state().checkable
    assert of(buttons["workspace-inspect"]).state().checked


@pytest.fixture
def heard(monkeypatch):
    said = []
    monkeypatch.setattr(speech, "announce", lambda _, text, **__: said.append(text))
    return said


@pytest.fixture
def unheard(monkeypatch):
    """What is told of parts of the canvas while nobody listens."""
    events = []

    def take(event):
        if isinstance(event.object(), Part):
            events.append((event.type().name, event.object().name))

    monkeypatch.setattr(QAccessible, "updateAccessibility", take)
    monkeypatch.setattr(QAccessible, "isActive", lambda: False)
    return events


@pytest.fixture
def told(unheard, monkeypatch):
    """What a screen reader is told of them: which event, and the part's name."""
    monkeypatch.setattr(QAccessible, "isActive", lambda: True)
    return unheard


def test_a_move_is_told_once_it_is_known_whether_it_folds(opened, heard):
    for _ in range(2):
        opened.key(KEYS.Key_Period, CONTROL)
    opened.press_key(opened.canvas, KEYS.Key_Left, times=3)
    opened.settle()
    assert heard == ["outline 2, left cheek, 3 px left, no folds"]
    opened.key(KEYS.Key_Z, CONTROL)
    opened.settle()
    assert heard[1:] == [
        "Undone: outline 2, left cheek 1.0 px",
        "outline 2, left cheek, 1 px right, no folds",
    ]


def test_a_point_taken_while_the_keys_go_elsewhere_is_named(opened, heard):
    opened.panel("recipe").percent.slider.setFocus()
    at = np.zeros(2)
    opened.canvas.begin("points", Handle("mouth", 0, 1), at)
    opened.canvas.end(at)
    assert heard == ["right mouth corner"]


def test_what_stands_over_the_photo_is_said_with_its_buttons(opened, heard):
    opened.editor.points.say("The clipboard holds no settings.")
    opened.editor.points.say("It is gone.", BarAction("Open…", print))
    assert heard == ["The clipboard holds no settings.", "It is gone. Buttons: Open…"]


def test_the_choice_of_a_face_is_said(two, heard):
    two.panel("faces").list.setFocus()
    two.editor.recipe.choose(1)
    two.editor.recipe.choose(None)
    assert heard == ["Face 2 of 2, selected, 4 %", "All faces"]


def test_what_a_key_switches_and_what_was_found_is_said(opened, heard):
    opened.key(KEYS.Key_H)
    opened.key(KEYS.Key_H)
    opened.key(KEYS.Key_F, CONTROL)
    opened.settle()
    assert heard == ["Heat map of the move: on", "Heat map of the move: off", "Faces found: 1"]


def test_what_keys_do_to_photo_brush_strokes_and_points_is_said(opened, heard, monkeypatch):
    monkeypatch.setattr(photo_canvas, "announce", speech.announce)
    QTest.keyPress(opened.window, KEYS.Key_F4)
    QTest.keyRelease(opened.window, KEYS.Key_F4)
    assert heard == ["before", "after"]
    opened.window.actions_by_name["tool-push"].trigger()
    heard.clear()
    opened.key(KEYS.Key_BracketRight)
    assert heard == [opened.panel("push").size_px.field.text()]
    heard.clear()
    for key in (KEYS.Key_Return, KEYS.Key_Right, KEYS.Key_Return):
        opened.press_key(opened.canvas, key)
    began, moved, ended = heard[:3]
    assert (began, ended) == (f"Stroke begins, {began[15:]}", f"Stroke ends, {moved}")
    assert moved.startswith("x ")
    assert moved != began[15:]
    opened.window.actions_by_name["tool-points"].trigger()
    opened.editor.view.set(selected=Handle("target", 0, 3))
    opened.press_key(opened.canvas, KEYS.Key_Left)
    opened.settle()
    heard.clear()
    opened.key(KEYS.Key_Delete)
    assert heard[0] == "Automatic target"


def test_a_warning_is_said_when_it_comes_and_when_it_goes(opened, heard):
    opened.show("scope", "face")
    slider = opened.panel("recipe").percent.slider
    heard.clear()
    opened.press_key(slider, KEYS.Key_PageUp, times=5)
    opened.settle()
    assert heard == ["⚠ 49.7 % of answers: unnatural"]
    opened.press_key(slider, KEYS.Key_PageDown, times=5)
    opened.settle()
    assert heard[1:] == ["0.0 % of answers: unnatural"]


def parts(interface):
    return [interface.child(place) for place in range(interface.childCount())]


def test_the_canvas_holds_faces_and_the_selected_one_its_points(two):
    canvas = of(two.canvas)
    assert [face.text(TEXT.Name) for face in parts(canvas)] == [
        "Face 1 of 2, 4 %",
        "Face 2 of 2, 4 %",
    ]
    assert [face.childCount() for face in parts(canvas)] == [0, 0]
    canvas.child(1).actionInterface().doAction("Press")
    assert two.editor.view.face == 1
    assert canvas.child(1).text(TEXT.Name) == "Face 2 of 2, selected, 4 %"
    assert [face.state().selected for face in parts(canvas)] == [False, True]
    points = parts(canvas.child(1))
    assert len(points) == 27 + 21
    assert points[10].text(TEXT.Name) == "outline 11, chin"
    assert points[10].parent().object() is canvas.child(1).object()
    assert canvas.child(1).parent().object() is two.canvas
    assert [canvas.child(1).indexOfChild(point) for point in points] == list(range(48))
    assert [canvas.indexOfChild(face) for face in parts(canvas)] == [0, 1]
    two.key(KEYS.Key_I)
    two.settle()
    assert canvas.child(1).text(TEXT.Name) == "Face 2 of 2, selected, unchanged"
    assert canvas.child(1).childCount() == 0


def test_a_point_tells_where_it_is_and_where_it_was_at_first(opened):
    chin = of(opened.canvas).child(0).child(10)
    x, y = opened.state.faces[0].outline[10]
    assert chin.text(TEXT.Description) == f"x {x:.0f}, y {y:.0f}"
    chin.actionInterface().doAction("Press")
    assert opened.editor.view.selected == Handle("outline", 0, 10)
    opened.press_key(opened.canvas, KEYS.Key_Left, times=3)
    opened.press_key(opened.canvas, KEYS.Key_Down)
    opened.settle()
    assert chin.text(TEXT.Description) == (
        f"x {x - 3:.0f}, y {y + 1:.0f}, 3 px left, 1 px down of the first position"
    )
    assert chin.state().selected
    target = of(opened.canvas).child(0).child(37)
    assert target.text(TEXT.Name) == "target 11, chin"
    target.actionInterface().doAction("Press")
    opened.press_key(opened.canvas, KEYS.Key_Up)
    assert target.text(TEXT.Description).endswith("set by hand")


def test_a_part_lies_where_it_is_seen(opened):
    canvas = opened.canvas
    face = of(canvas).child(0)
    mouth = face.child(25)
    at = canvas.viewport().mapToGlobal(opened.on_screen(Handle("mouth", 0, 0)))
    assert mouth.rect().adjusted(4, 4, -4, -4).contains(at)
    assert face.rect().contains(mouth.rect())
    assert of(canvas).childAt(at.x(), at.y()).object() is face.object()
    assert face.childAt(at.x(), at.y()).object() is mouth.object()
    assert not mouth.state().offscreen
    canvas.zoom_to(30.0)
    assert mouth.state().offscreen


def test_the_focus_goes_to_the_point_that_keys_walk_to(opened, told):
    opened.to_front()
    opened.canvas.setFocus()
    opened.key(KEYS.Key_Period, CONTROL)
    assert told[-1] == ("Focus", "outline 1, left temple")
    first = of(opened.canvas).child(0).child(0)
    assert first.state().focused
    assert not of(opened.canvas).state().focused
    assert of(opened.canvas).focusChild().object() is first.object()
    opened.panel("recipe").percent.slider.setFocus()
    assert not first.state().focused
    told.clear()
    opened.canvas.setFocus()
    opened.qtbot.waitUntil(lambda: ("Focus", "outline 1, left temple") in told)
    opened.panel("recipe").percent.slider.setFocus()
    told.clear()
    opened.key(KEYS.Key_Period, CONTROL)
    later = []
    QTimer.singleShot(0, lambda: later.append(True))
    opened.qtbot.waitUntil(lambda: bool(later))
    assert told.count(("Focus", "outline 2, left cheek")) == 1, "told once"


def test_a_face_and_a_place_that_change_are_told_once_the_gesture_is_over(two, told):
    two.to_front()
    two.canvas.setFocus()
    two.editor.recipe.choose(0)
    assert told[-1] == ("Focus", "Face 1 of 2, selected, 4 %")
    two.key(KEYS.Key_Period, CONTROL)
    told.clear()
    QTest.keyPress(two.canvas, KEYS.Key_Left)
    assert told == []
    QTest.keyRelease(two.canvas, KEYS.Key_Left)
    assert told == [("DescriptionChanged", "outline 1, left temple")]
    told.clear()
    two.press_key(two.panel("recipe").percent.slider, KEYS.Key_Right)
    assert ("NameChanged", "Face 1 of 2, selected, 4.1 %") in told


def test_nothing_is_made_ready_for_nobody(two, unheard, monkeypatch):
    asked = []
    monkeypatch.setattr(Part, "name", property(lambda part: asked.append(part) or ""))
    two.to_front()
    two.canvas.setFocus()
    two.editor.recipe.choose(1)
    two.key(KEYS.Key_Period, CONTROL)
    two.press_key(two.canvas, KEYS.Key_Left)
    assert (asked, unheard) == ([], [])
    assert len(parts(of(two.canvas).child(1))) == 27 + 21, "and yet who asks is answered"


def test_parts_come_and_go_while_they_are_asked(two, source):
    canvas = of(two.canvas)
    for count in (3, 1, 2, 4):
        old = parts(canvas)
        source.faces = [oval_face(center=(60 + 90 * n, 170), size=0.3) for n in range(count)]
        two.key(KEYS.Key_F, CONTROL)
        two.settle()
        two.editor.recipe.choose(count - 1)
        assert len(parts(canvas)) == count
        assert parts(canvas.child(count - 1))[10].text(TEXT.Name) == "outline 11, chin"
        del old
        gc.collect()
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


def test_an_announcement_is_an_event_of_the_canvas(opened, monkeypatch):
    events = []
    monkeypatch.setattr(QAccessible, "updateAccessibility", events.append)
    opened.editor.points.say("Something.")
    (event,) = [e for e in events if e.type() == QAccessible.Event.Announcement]
    assert event.message() == "Something."
    assert event.object() is opened.canvas
