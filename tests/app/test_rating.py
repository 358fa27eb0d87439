"""A rating session in the editor, by its keys; killed in the middle, it goes on where it was."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from kogao_app.controllers.rating import Rating
from kogao_app.views.rating import RatingWindow
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtQml import QJSEngine
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QPushButton
from scenes import oval_face, textured_photo

from kogao_core.experiments.study import making, page, plan, results
from kogao_core.experiments.study.plan import Study, order
from kogao_core.experiments.study.session import Session
from kogao_core.experiments.study.tally import tally
from kogao_core.experiments.study.variants import Variant
from kogao_core.experiments.subjects import Subject

KINDS = (
    *(Variant("table1", float(percent), 2, 1.0) for percent in (2, 4, 6, 8, 10)),
    *(Variant("figure11", 4.0, 2, size) for size in (0.25, 1.0)),
    Variant("satisfaction", 4.0, 2, 1.0),
)
NAMES = tuple(f"{number:016x}.jpg" for number in range(30))

# A program of its own: rates as many pictures as it is told to, then waits to be killed.
VICTIM = """
    import sys
    from pathlib import Path
    from PySide6.QtCore import Qt, QTimer
    from PySide6.QtTest import QTest
    from PySide6.QtWidgets import QApplication
    from kogao_app.editor import Editor
    from kogao_app.storage import Storage

    class Nobody:
        name = "nobody"
        def find(self, rgb):
            return []

    app = QApplication([])
    editor = Editor(app, Nobody(), Storage.of_user())
    editor.window.show()
    rating = editor.rating.open(Path(sys.argv[1]))
    rating.welcome.code.setText("victim")
    QTest.mouseClick(rating.welcome.button, Qt.MouseButton.LeftButton)
    for number in range(int(sys.argv[2])):
        while rating.judging.picture._fresh:
            app.processEvents()
        QTest.keyClick(rating, Qt.Key.Key_J if number % 2 else Qt.Key.Key_F)
    print("rated", flush=True)
    app.exec()
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of two made-up faces."""
    folder = tmp_path_factory.mktemp("studies") / "faces"
    people = [
        Subject(f"{seed}.png", textured_photo(240, 320, seed=seed), (oval_face(240, 320),))
        for seed in (1, 2)
    ]
    making.make(people, folder, making.Choices(variants=KINDS, seed="s"))
    return folder


@pytest.fixture
def study(folder, tmp_path):
    """A copy of it to write into."""
    copy = tmp_path / "faces"
    copy.mkdir()
    for path in folder.iterdir():
        if path.is_file():
            (copy / path.name).hardlink_to(path)
    plan.key_path(copy).hardlink_to(plan.key_path(folder))
    return copy


def open_session(driver, study, code="synthetic"):
    window = driver.editor.rating.open(study)
    driver.qtbot.waitExposed(window)
    window.welcome.code.setText(code)
    QTest.mouseClick(window.welcome.button, Qt.MouseButton.LeftButton)
    return window


def press(window, *keys):
    """Press keys, each when the picture is on the screen."""
    for key in keys:
        while window.judging.picture._fresh:
            QApplication.processEvents()
        QTest.keyClick(window, key)


def log(study, code="synthetic"):
    return results.load(study / plan.RATINGS_FOLDER / f"{code}.jsonl")


def standing(study, code="synthetic"):
    return Session(plan.load_study(study), code, list(log(study, code).records)).answered


def count(study):
    return tally([(study, plan.key_path(study))])


F, J, S = Qt.Key.Key_F, Qt.Key.Key_J, Qt.Key.Key_S
BACK, ENTER, RIGHT = Qt.Key.Key_Backspace, Qt.Key.Key_Return, Qt.Key.Key_Right


def test_a_session_by_keys_from_the_menu_to_the_report(empty, study):
    shown = []
    empty.key(Qt.Key.Key_R, Qt.KeyboardModifier.ControlModifier)
    dialog = empty.window.findChild(QFileDialog)
    dialog.fileSelected.emit(str(study))
    dialog.close()
    window = empty.window.findChild(RatingWindow)
    window.welcome.code.setText("synthetic")
    QTest.mouseClick(window.welcome.button, Qt.MouseButton.LeftButton)
    session = window._rating.session
    while not session.grading:
        shown.append(session.current)
        press(window, J if len(shown) % 3 == 0 else F)
    assert sorted(shown) == sorted(session.study.ratings)
    assert window.judging.progress.value() == len(shown)
    press(window, F, J, ENTER)  # none of them grades, and an untouched slider is no grade
    assert len(session.answered) == len(shown)
    window.judging.slider.setFocus()
    for _ in range(7):
        QTest.keyClick(window.judging.slider, RIGHT)
    assert window.judging.value.text() == "57"
    press(window, ENTER, S)
    assert window.pages.currentWidget() is window.ending
    assert "16 answers" in window.ending.said.text()
    answers = {record.picture: record.answer for record in standing(study)}
    assert [answers[name] for name in shown] == [
        "unnatural" if place % 3 == 2 else "natural" for place in range(len(shown))
    ]
    found = count(study)
    assert sum(share.hits for share in found.shares.values()) == len(shown) // 3
    assert (found.grades, found.skipped) == ([57], 1)


def test_backspace_takes_answers_back_and_keeps_every_line(empty, study):
    window = open_session(empty, study)
    press(window, F, J)
    judged = window._rating.session.answered[-1].picture
    press(window, BACK)
    assert window._rating.session.current == judged
    press(window, F)
    assert [(r.answer, r.back) for r in log(study).records] == [
        ("natural", False),
        ("unnatural", False),
        (None, True),
        ("natural", False),
    ]
    press(window, *[BACK] * 5)
    assert window._rating.session.answered == []
    assert not window.judging.take_back.isEnabled()
    assert len(log(study).records) == 6


def test_from_the_end_one_can_go_back(empty, study):
    window = open_session(empty, study)
    press(window, *[F] * 14, S, S)
    assert window.pages.currentWidget() is window.ending
    press(window, BACK)
    assert window.pages.currentWidget() is window.judging
    assert window._rating.session.grading


def blindly(window, *keys):
    """Press keys without letting anything be painted."""
    for key in keys:
        pressed = QKeyEvent(QKeyEvent.Type.KeyPress, key, Qt.KeyboardModifier.NoModifier)
        QApplication.sendEvent(window, pressed)


def test_pictures_that_nobody_has_seen_cant_be_judged(empty, study):
    window = open_session(empty, study)
    press(window, F)
    blindly(window, F, J, F)
    assert len(standing(study)) == 1
    press(window, J)
    blindly(window, BACK, J)
    assert len(standing(study)) == 1, "what was taken back is to be seen again, too"
    press(window, *[F] * 13)
    assert window._rating.session.grading
    blindly(window, S)
    assert len(standing(study)) == 14
    press(window, S)
    assert len(standing(study)) == 15


def test_a_held_key_answers_once_and_shortcuts_answer_nothing(empty, study):
    window = open_session(empty, study)
    press(window, F)
    held = QKeyEvent(QKeyEvent.Type.KeyPress, F, Qt.KeyboardModifier.NoModifier, "f", True)
    QApplication.sendEvent(window, held)
    QTest.keyClick(window, F, Qt.KeyboardModifier.ControlModifier)
    assert len(standing(study)) == 1


def test_the_window_hints_at_nothing(empty, study):
    window = open_session(empty, study)
    key = plan.load_key(plan.key_path(study))
    said = " ".join(
        str(text)
        for widget in window.findChildren(object)
        for text in (
            getattr(widget, name)()
            for name in (
                "text",
                "toolTip",
                "accessibleName",
                "accessibleDescription",
                "windowTitle",
            )
            if hasattr(widget, name)
        )
    )
    names = [face.name for face in key.subjects]
    for name in (*key.pictures, *names, "%", "lattice", "centre", "warp"):
        assert name not in said
    assert window.focusWidget() is window.judging.picture
    for button in window.findChildren(QPushButton):
        assert button.text()


def test_a_closed_session_is_offered_again_and_another_stays_apart(empty, study):
    window = open_session(empty, study)
    press(window, F, F, F)
    window.close()
    again = empty.editor.rating.open(study)
    assert again.welcome.sessions.itemText(1) == "synthetic: 3 of 16"
    again.welcome.sessions.setCurrentIndex(1)
    assert not again.welcome.code.isEnabled()
    QTest.keyClick(again.welcome.code, ENTER)
    QTest.mouseClick(again.welcome.button, Qt.MouseButton.LeftButton)
    assert len(again._rating.session.answered) == 3
    again.close()
    other = open_session(empty, study, "someone-else")
    assert other._rating.session.answered == []


def test_a_session_open_elsewhere_is_refused(empty, study, qapp):  # noqa: ARG001
    first = Rating(study)
    first.start("synthetic")
    window = open_session(empty, study)
    assert "open in another window" in window.problem.text()
    assert window.pages.currentWidget() is window.welcome
    first.stop()
    QTest.mouseClick(window.welcome.button, Qt.MouseButton.LeftButton)
    assert window.pages.currentWidget() is window.judging
    assert not window.problem.isVisible()


def test_a_code_that_could_be_a_path_is_refused(empty, study):
    window = open_session(empty, study, "../../etc")
    assert "a to z" in window.problem.text()
    assert not list(study.rglob("*.jsonl"))


def test_a_folder_without_a_study_is_said(empty, tmp_path):
    assert empty.editor.rating.open(tmp_path) is None
    assert "holds no study" in empty.say()


def test_a_missing_picture_is_said_and_cant_be_judged(empty, study):
    first = order(plan.load_study(study).ratings, "synthetic")[0]
    (study / first).unlink()
    window = open_session(empty, study)
    assert first in window.judging.trouble.text()
    for key in (F, J):
        QTest.keyClick(window, key)
    assert standing(study) == []


def test_a_full_disk_is_said_and_the_answer_can_be_given_again(empty, study, monkeypatch):
    window = open_session(empty, study)
    press(window, F)

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(results.os, "fsync", full)
    shown = window._rating.session.current
    press(window, J)
    assert "No space left" in window.judging.trouble.text()
    assert window._rating.session.current == shown
    monkeypatch.undo()
    press(window, J)
    assert [record.answer for record in standing(study)] == ["natural", "unnatural"]


def killed(study, rated):
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    program = [sys.executable, "-c", textwrap.dedent(VICTIM), str(study), str(rated)]
    victim = subprocess.Popen(program, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        assert victim.stdout.readline() == "rated\n"
    finally:
        victim.send_signal(signal.SIGKILL)
        assert victim.wait(10) == -signal.SIGKILL
        victim.stdout.close()


def test_a_killed_session_goes_on_without_losing_or_doubling_an_answer(empty, study, storage):
    del storage  # the victim must not find the user's own
    killed(study, 6)
    before = [(record.picture, record.answer) for record in standing(study, "victim")]
    assert [answer for _, answer in before] == ["natural", "unnatural"] * 3
    # As if it had died in the middle of the next line.
    path = study / plan.RATINGS_FOLDER / "victim.jsonl"
    with path.open("ab") as file:
        file.write(b'{"n": 7, "picture": "00')
    window = empty.editor.rating.open(study)
    assert window.welcome.sessions.itemText(1) == "victim: 6 of 16"
    window.welcome.sessions.setCurrentIndex(1)
    QTest.mouseClick(window.welcome.button, Qt.MouseButton.LeftButton)
    while not window._rating.session.grading:
        press(window, F)
    press(window, S, S)
    after = [(record.picture, record.answer) for record in standing(study, "victim")]
    assert after[:6] == before
    names = [picture for picture, _ in after]
    assert sorted(names) == sorted(window._rating.session._todo)
    assert len(set(names)) == 16
    found = count(study)
    assert sum(share.answers for share in found.shares.values()) == 14
    assert sum(share.hits for share in found.shares.values()) == 3
    assert found.torn == 1


def test_the_page_of_the_browser_has_the_same_order_and_replays_alike(qapp):  # noqa: ARG001
    made = Study("a-study", NAMES[:25], NAMES[25:])
    script = re.search(r"<script>(.*)</script>", page.page(made), re.DOTALL)[1]
    engine = QJSEngine()

    def js(expression):
        value = engine.evaluate(
            f"(function () {{{script}\nreturn JSON.stringify({expression});}})()"
        )
        assert not value.isError(), value.toString()
        return json.loads(value.toString())

    for rater in ("7f3a91c2", "a", "rater-22"):
        wanted = [*order(made.ratings, rater), *order(made.satisfaction, rater)]
        assert js(f"todo('{rater}')") == wanted
    session = Session(made, "r1")
    for _ in range(5):
        session.take(session.answer("natural", 5.0))
    session.take(session.back())
    lines = json.dumps([record.to_dict() for record in session.records])
    assert js(f"standing({lines}).length") == 4


def test_what_the_page_saves_is_read_like_the_editors(qapp, tmp_path):  # noqa: ARG001
    made = Study("a-study", NAMES[:25], NAMES[25:])
    script = re.search(r"<script>(.*)</script>", page.page(made), re.DOTALL)[1]
    session = Session(made, "r1")
    for _ in range(26):
        said = session.grade(70, 5.0) if session.grading else session.answer("unnatural", 5.0)
        session.take(said)
    lines = json.dumps([record.to_dict() for record in session.records])
    engine = QJSEngine()
    saved = engine.evaluate(f"(function () {{{script}\nreturn file('r1', {lines});}})()")
    (tmp_path / "ratings-r1.jsonl").write_text(saved.toString())
    held = results.load(tmp_path / "ratings-r1.jsonl")
    assert (held.study, held.rater, held.torn) == ("a-study", "r1", 0)
    assert held.records == tuple(session.records)
