"""The Experiments menu: keys to windows with tables, pictures and a report."""

from __future__ import annotations

import pytest
from kogao_app.features.experiments import SETTING_TIMES
from kogao_app.features.experiments.dialog import ExperimentDialog
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel
from scenes import oval_face
from test_manual import manual, mark_face  # noqa: F401

from kogao_core.cli.commands import program
from kogao_core.faces.face import ignored
from kogao_core.lab.experiments import setting_times
from kogao_core.lab.methods import METHODS


class KnownFace:
    """Finds the made-up face at every size of its photo."""

    name = "known"

    def find(self, rgb, on_face=ignored):  # noqa: ARG002
        return [oval_face(rgb.shape[1], rgb.shape[0])]


@pytest.fixture(autouse=True)
def _known_face(monkeypatch):
    """Find the made-up face automatically, too."""
    monkeypatch.setattr("kogao_app.features.experiments.source", lambda _: KnownFace())


KEYS, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier
ALT = Qt.KeyboardModifier.AltModifier


def window_of(driver) -> ExperimentDialog:
    return next(d for d in driver.window.findChildren(ExperimentDialog) if d.isVisible())


def finish(driver):
    """Wait for an experiment: some import large libraries first."""
    driver.qtbot.waitUntil(lambda: not driver.editor.busy)


def text(table, row, column):
    return table.item(row, column).text()


def test_every_experiment_of_the_command_line_stands_in_the_menu(empty):
    for name, command in program.every["experiment"].every.items():
        if any("--html" in param.opts for param in command.params):
            assert not empty.window.actions_by_name[f"experiment-{name}"].shortcut().isEmpty()


def test_a_photo_is_needed(empty):
    empty.key(KEYS.Key_1, CONTROL, ALT)
    assert "needs a photo" in empty.say()


def test_table_2_is_measured_and_its_report_saved(opened, tmp_path):
    opened.key(KEYS.Key_1, CONTROL, ALT)
    shown = window_of(opened)
    assert not shown.to_file.isEnabled()
    finish(opened)
    times = shown.tables[0]
    assert text(times, 0, 0) == "Conventional method"
    assert len(shown.tables[0].findItems("Dual method", Qt.MatchFlag.MatchStartsWith)) == 1
    QTest.mouseClick(shown.to_file, Qt.MouseButton.LeftButton)
    opened.choose_path(tmp_path / "times.html")
    page = (tmp_path / "times.html").read_text(encoding="utf-8")
    assert "Table 2" in page
    assert "portrait.png" in page
    QTest.mouseClick(shown.to_file, Qt.MouseButton.LeftButton)
    opened.choose_path(tmp_path / "times.csv")
    head, *rows = (tmp_path / "times.csv").read_text(encoding="utf-8").splitlines()
    assert head.startswith("photo,")
    assert len(rows) == 8, "four ways at two sizes"


def test_closing_the_window_stops_the_experiment(opened):
    opened.key(KEYS.Key_3, CONTROL, ALT)
    shown = window_of(opened)
    QTest.keyClick(shown, KEYS.Key_Escape)
    finish(opened)
    assert not [d for d in opened.window.findChildren(ExperimentDialog) if d.isVisible()]
    opened.window.actions_by_name["experiment-domains"].trigger()
    finish(opened)
    assert text(window_of(opened).tables[0], 0, 0) == "portrait.png", "another can begin"


def test_methods_hang_side_by_side(opened):
    opened.key(KEYS.Key_4, CONTROL, ALT)
    shown = window_of(opened)
    finish(opened)
    hung = [method.title for method in METHODS if method.title not in shown.state.text()]
    labels = (label for label in shown.findChildren(QLabel) if not label.pixmap().isNull())
    pictures = {label.accessibleName() for label in labels}
    assert {f"Result: {name}" for name in hung} < pictures
    shown.kinds.setCurrentIndex(1)
    assert shown.kinds.currentText().startswith("Difference")


def test_a_failure_is_told_in_its_window(opened, storage):
    storage.data.mkdir(parents=True, exist_ok=True)
    (storage.data / SETTING_TIMES).write_text('{"version": 9}\n')
    opened.key(KEYS.Key_1, CONTROL, ALT)
    shown = window_of(opened)
    finish(opened)
    assert "Line 1" in shown.state.text()
    assert not shown.to_file.isEnabled()


def test_applied_work_is_a_session_once(manual, storage):  # noqa: F811
    mark_face(manual)
    manual.key(KEYS.Key_Return, CONTROL)
    manual.key(KEYS.Key_Return, CONTROL)
    (session,) = setting_times.read(storage.data / SETTING_TIMES)
    assert session.photo == "portrait.png"
    assert (session.faces, session.landmarks) == (1, 11)
    assert session.setting_s == pytest.approx(manual.editor.manual.clock.elapsed_s)
