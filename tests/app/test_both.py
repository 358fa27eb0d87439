"""In Compare both modes lie side by side, with their times and what to do next."""

import re

import numpy as np
import pytest
from kogao_app.document import State
from kogao_app.features.both import _as_text
from PySide6.QtCore import Qt
from scenes import oval_face

pytestmark = pytest.mark.usefixtures("one_window")

KEYS, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier
NONE = "–"  # noqa: RUF001


@pytest.fixture
def comparing(start, photo):
    return start(photo, workspace="compare")


def marked_by_hand(driver):
    """A face of manual mode, as if every point had been set."""
    driver.key(KEYS.Key_F3)
    face = oval_face().with_outline_point(10, oval_face().outline[10] + 6.0)
    state = driver.state.in_mode("manual")
    driver.editor.document.step(State(faces=(face,), mode="manual", kept=state.kept), "Mark")
    driver.settle()


def pixels(view):
    image = view.grab().toImage()
    return np.frombuffer(image.constBits(), np.uint8).copy()


def test_the_other_mode_lies_beside_this_one_and_only_here(comparing):
    beside = comparing.editor.both.beside
    assert beside.isVisible()
    comparing.qtbot.waitUntil(lambda: abs(beside.width() - comparing.canvas.width()) <= 1)
    assert beside.shown.state.mode == "manual"
    assert beside.shown.frame.done.faces == []
    marked_by_hand(comparing)
    assert comparing.editor.both.here.text() == "Manual"
    assert beside.plate.text() == "Automatic: hidden until Apply"
    assert beside.shown.state.faces == comparing.state.sheet("automatic").faces
    found = beside.shown.frame.rendering.pixels
    comparing.key(KEYS.Key_F2)
    comparing.settle()
    np.testing.assert_array_equal(found, comparing.shown)
    assert beside.backgroundBrush() == comparing.canvas.backgroundBrush()
    over = comparing.window.stage.children()
    assert over.index(comparing.editor.both.guide) > over.index(beside)
    comparing.window.actions_by_name["workspace-retouch"].trigger()
    assert not beside.isVisible()


def test_both_views_stay_at_the_same_place(comparing):
    beside = comparing.editor.both.beside
    comparing.canvas.zoom_to(2.0)
    assert beside.zoom == pytest.approx(comparing.canvas.zoom)
    beside.zoom_to(3.0)
    assert comparing.canvas.zoom == pytest.approx(3.0)


def test_a_hand_that_marked_nothing_has_no_time(comparing):
    def times():
        rows = comparing.panel("both").times.items()
        return {mode: [cell.text() for cell in row] for mode, row in rows}

    comparing.key(KEYS.Key_F3)
    comparing.edit(6.0)
    assert comparing.editor.manual.clock.elapsed_s > 0.0
    assert times()["manual"] == [NONE] * 3
    assert NONE not in times()["automatic"]
    marked_by_hand(comparing)
    assert NONE not in times()["manual"]
    assert all(re.fullmatch(r"[\d,]+ ms(, (cold|warm))?", time) for time in times()["manual"])


def test_the_automatic_time_is_measured_where_faces_came_from_saved_edits(comparing, photo, other):
    comparing.edit(6.0)
    comparing.open(other)
    comparing.open(photo)
    comparing.settle()
    assert NONE not in [cell.text() for cell in comparing.panel("both").times["automatic"]]


def test_the_modes_keep_their_sides(comparing):
    def is_left(view):
        return view.mapTo(comparing.window, view.rect().topLeft()).x() < 300

    for key, left in ((KEYS.Key_F3, True), (KEYS.Key_F2, False), (KEYS.Key_F3, True)):
        comparing.key(key)
        comparing.qtbot.waitUntil(lambda left=left: is_left(comparing.editor.both.beside) is left)


def test_times_by_hand_are_shown_in_seconds():
    assert _as_text(146.4054, 0.022, None) == ["146.4 s", "22 ms", "146.4 s"]


def test_how_far_the_points_lie_apart_is_said(comparing):
    apart = comparing.panel("both").apart
    assert "No face marked by hand" in apart.text()
    marked_by_hand(comparing)
    comparing.key(KEYS.Key_Return, CONTROL)
    assert apart.text().startswith("face 1: landmarks ")


def test_whoever_marks_against_the_clock_sees_no_answer(comparing):
    view, apart = comparing.editor.both.beside.shown, comparing.panel("both").apart
    comparing.key(KEYS.Key_F3)
    comparing.settle()
    for _ in range(2):
        assert "landmarks" not in view.visible
        assert view.original, "the automatic result would show where its points are"
        assert "px" not in apart.text()
        marked_by_hand(comparing)
    comparing.key(KEYS.Key_Return, CONTROL)
    assert "landmarks" in view.visible
    assert not view.original
    assert "px" in apart.text()


def test_the_canvas_says_what_to_do_next_from_the_start_to_the_end(comparing):
    guide = comparing.editor.both.guide
    assert guide.isVisible()
    steps = [guide.text()]
    comparing.key(KEYS.Key_F3)
    comparing.settle()
    steps.append(guide.text())
    marked_by_hand(comparing)
    steps.append(guide.text())
    comparing.key(KEYS.Key_Return, CONTROL)
    steps.append(guide.text())
    comparing.key(KEYS.Key_F2)
    comparing.settle()
    steps.append(guide.text())
    words = ("1 of 3: .*F3", "left eye, outer corner .1 of 6", r"Ctrl\+Return", "3 of 3", "3 of 3")
    for step, word in zip(steps, words, strict=True):
        assert re.search(word, step), step
    comparing.window.actions_by_name["workspace-inspect"].trigger()
    assert not guide.isVisible()
