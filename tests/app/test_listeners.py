"""A change calls few functions: only listeners of the changed fields, only their controls."""

import dataclasses
import sys
from pathlib import Path

import kogao_app
import pytest
from kogao_app.document import Document
from kogao_app.watching import Watched
from kogao_app.widgets.sliders import ValueSlider
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

import kogao_core

MOST_CALLS, MOST_RECEIVERS = 400, 8
OURS = tuple(str(Path(next(iter(one.__path__)))) for one in (kogao_app, kogao_core))


@pytest.fixture(params=["retouch", "inspect"])
def notch(request, start, photo):
    """Move the slider of the amount by one key press; return (caller, function, caller's self)."""
    driver = start(photo, workspace=request.param)
    driver.settle()
    slider, calls = driver.editor.recipe.panel.percent.slider, []
    slider.setFocus()
    QTest.keyClick(slider, Qt.Key.Key_Right)
    driver.settle()

    def note(frame, event, _):
        file = frame.f_code.co_filename
        if event == "call" and file.startswith(OURS):
            back = frame.f_back
            calls.append((back.f_code, frame.f_code, back.f_locals.get("self")))

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        QTest.keyClick(slider, Qt.Key.Key_Right)
    finally:
        sys.setprofile(before)
    driver.settle()
    return calls


def test_a_notch_calls_few_functions_and_receivers_and_shows_only_the_moved_slider(notch):
    assert len(notch) <= MOST_CALLS
    assert sum(function is ValueSlider.show_value.__code__ for _, function, _ in notch) == 1
    tell, call = Document._tell.__code__, Watched._call_watchers.__code__
    rounds = []
    for caller, function, watched in notch:
        if function is tell:
            rounds.append([])
        elif caller is call and isinstance(watched, Document) and "<" not in function.co_name:
            rounds[-1].append(function.co_qualname)
    assert len(rounds) == 2, "the preview, and the end of the gesture"
    for receivers in rounds:
        assert 0 < len(receivers) <= MOST_RECEIVERS, receivers


def test_a_listener_is_called_for_its_fields_and_only_if_its_value_differs(opened):
    document, shown = opened.editor.document, []
    document.watch(lambda: shown.append("recipe"), "recipe")
    document.watch(lambda: shown.append("loose"), "loose")
    document.watch(lambda: shown.append("count"), "faces", value=lambda: len(document.state.faces))
    assert shown == ["recipe", "loose", "count"], "each shows the present state"
    shown.clear()
    document.step(document.state.with_choices(None, percent=9.0), "Amount")
    face = document.state.faces[0]
    document.step(document.state.with_face(0, face.with_target(10, (240.0, 300.0))), "Point")
    assert shown == ["recipe"]
    document.step(document.state.without_face(0), "Remove")
    assert shown == ["recipe", "count"]


def test_a_watcher_of_the_view_is_called_for_its_fields_and_only_if_a_value_differs(opened):
    view, shown = opened.editor.view, []
    view.watch(lambda: shown.append((view.compare, view.loupe)), "compare", "loupe")
    view.watch(lambda: shown.append("any"))
    shown.clear()
    view.set(compare="wipe", loupe=True)
    view.set(compare="wipe", wipe=view.wipe)
    view.set(marking=view.marking, cursor=(3.0, 4.0))
    assert shown == [("wipe", True), "any", "any"], "all fields of a call are set before the first"
    with pytest.raises(AttributeError, match="wype"):
        view.set(wype=0.3)
    with pytest.raises(dataclasses.FrozenInstanceError):
        view.wipe = 0.3
