"""What nobody expected: said in the bar, written down, and the work goes on."""

import sys
import threading

import pytest
from kogao_app.faults import Faults
from PySide6.QtCore import Qt, QTimer


@pytest.fixture
def faults(opened, storage, qtbot):
    """As `main` does it, with pytest-qt in the place of stderr."""
    faults = Faults(storage.log)
    faults.caught.connect(opened.editor.admit, Qt.ConnectionType.QueuedConnection)
    with qtbot.captureExceptions() as printed, faults.heard():
        faults.printed = printed
        yield faults


def stumble():
    raise LookupError("a stone")


def in_a_slot():
    QTimer.singleShot(0, stumble)


def in_a_thread():
    threading.Thread(target=stumble).start()


@pytest.mark.parametrize("where", [in_a_slot, in_a_thread])
@pytest.mark.usefixtures("faults")
def test_an_unexpected_exception_is_said_and_written_down(opened, storage, where):
    where()
    opened.qtbot.waitUntil(lambda: "a stone" in opened.say())
    assert str(storage.log) in opened.say()
    written = storage.log.read_text()
    assert "Traceback" in written
    assert "in stumble" in written


@pytest.mark.usefixtures("faults")
def test_the_work_can_be_saved_afterwards(opened, photo):
    opened.editor.recipe.set_field("percent", 7.0)
    in_a_slot()
    opened.qtbot.waitUntil(lambda: "a stone" in opened.say())
    opened.take_step("Save the project")
    opened.choose_path(photo.with_name("portrait.png.kogao.json"))
    opened.settle()
    assert photo.with_name("portrait.png.kogao.json").is_file()
    assert opened.window.isVisible()


def test_what_fails_again_and_again_is_said_once(opened, faults):
    """As painting would, with every picture; that of the message, too."""
    stumbled = []
    timer = QTimer(interval=0)
    timer.timeout.connect(lambda: stumbled.append(1) or stumble())
    timer.start()
    opened.qtbot.waitUntil(lambda: "a stone" in opened.say())
    opened.take_step("Dismiss")
    before = len(stumbled)
    opened.qtbot.waitUntil(lambda: len(stumbled) > before + 10)
    timer.stop()
    assert opened.say() == ""
    assert len(faults.printed) == 1


@pytest.mark.usefixtures("faults")
def test_what_a_worker_raises_is_written_down(opened, storage, monkeypatch):
    monkeypatch.setattr("kogao_app.render.live.render", stumble_over)
    opened.editor.recipe.set_field("percent", 7.0)
    opened.qtbot.waitUntil(lambda: "a stone" in opened.say())
    assert "in stumble_over" in storage.log.read_text()


def stumble_over(*_, **__):
    raise LookupError("a stone")


def test_the_hooks_are_those_from_before_afterwards(tmp_path):
    before = sys.excepthook, threading.excepthook
    with Faults(tmp_path / "kogao.log").heard():
        assert sys.excepthook != before[0]
    assert (sys.excepthook, threading.excepthook) == before


def test_without_a_place_for_the_log_stderr_has_to_do(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sys, "excepthook", sys.__excepthook__)
    (tmp_path / "file").write_text("no folder")
    with Faults(tmp_path / "file" / "kogao.log").heard():
        sys.excepthook(LookupError, LookupError("a stone"), None)
    assert "a stone" in capsys.readouterr().err
