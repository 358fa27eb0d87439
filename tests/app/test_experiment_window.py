"""The Experiments menu: keys to windows with tables, pictures and a report."""

from __future__ import annotations

import pytest
from kogao_app.features import experiments
from kogao_app.features.experiments import TRIALS
from kogao_app.features.experiments.dialog import ExperimentDialog
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from scenes import oval_face
from test_manual import manual, mark, mark_face  # noqa: F401

import kogao_core as kogao
from kogao_core.faces.face import ignored
from kogao_core.lab.experiments import EXPERIMENTS, trials

in_one_window = pytest.mark.usefixtures("one_window")


class KnownFace:
    """Finds the made-up face at every size of its photo."""

    name = "known"

    def find(self, rgb, on_face=ignored):  # noqa: ARG002
        return [oval_face(rgb.shape[1], rgb.shape[0])]


@pytest.fixture(autouse=True)
def _known_face_at_once(monkeypatch):
    """Find the made-up face automatically, too, and measure in as few rounds as there can be."""
    monkeypatch.setattr("kogao_app.features.experiments.source", lambda _: KnownFace())
    chosen = experiments.chosen

    def least(option, data):
        return option.least if isinstance(option.default, int) else chosen(option, data)

    monkeypatch.setattr(experiments, "chosen", least)


KEYS, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier
ALT = Qt.KeyboardModifier.AltModifier


def window_of(driver) -> ExperimentDialog:
    return next(d for d in driver.window.findChildren(ExperimentDialog) if d.isVisible())


def finish(driver):
    """Wait for an experiment: some import large libraries first."""
    driver.qtbot.waitUntil(lambda: not driver.editor.busy)


def text(table, row, column):
    return table.item(row, column).text()


def test_every_experiment_stands_in_the_menu(empty):
    for one in EXPERIMENTS:
        assert not empty.window.actions_by_name[f"experiment-{one.name}"].shortcut().isEmpty()


@in_one_window
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
    assert len(rows) == 10, "four ways at two sizes, and one of them again"


@in_one_window
def test_the_window_names_the_settings_and_repeats_with_the_papers(opened):
    """On a fresh start they are not the paper's."""
    opened.key(KEYS.Key_2, CONTROL, ALT)
    finish(opened)
    shown = window_of(opened)
    assert shown.settings.text().startswith("Not the paper's: ")
    shown.paper.click()
    finish(opened)
    again = window_of(opened)
    assert again.settings.text() == "Settings: the paper's"
    assert not again.paper.isEnabled()
    assert opened.state.recipe.fit == "approximation"


@in_one_window
def test_closing_the_window_stops_the_experiment(opened):
    opened.key(KEYS.Key_3, CONTROL, ALT)
    shown = window_of(opened)
    QTest.keyClick(shown, KEYS.Key_Escape)
    finish(opened)
    assert not [d for d in opened.window.findChildren(ExperimentDialog) if d.isVisible()]
    opened.window.actions_by_name["experiment-domains"].trigger()
    finish(opened)
    assert text(window_of(opened).tables[0], 0, 0) == "portrait.png", "another can begin"


def test_a_failure_is_told_in_its_window(opened, storage):
    storage.data.mkdir(parents=True, exist_ok=True)
    (storage.data / TRIALS).write_text('{"version": 9}\n')
    opened.key(KEYS.Key_1, CONTROL, ALT)
    shown = window_of(opened)
    finish(opened)
    assert "Line 1" in shown.state.text()
    assert not shown.to_file.isEnabled()


@pytest.fixture
def wait_ms(monkeypatch):
    """Let time pass on the setting clock when the test says so, and only then."""
    now = [0]

    class Timer:
        start_ms = None

        def start(self):
            self.start_ms = now[0]

        def elapsed(self):
            return now[0] - self.start_ms

        def isValid(self):  # noqa: N802
            return self.start_ms is not None

        def invalidate(self):
            self.start_ms = None

    monkeypatch.setattr("kogao_app.features.manual.QElapsedTimer", Timer)

    def wait(ms):
        now[0] += ms

    return wait


def test_one_photo_is_one_trial_from_when_it_is_seen_with_its_corrections(
    wait_ms, start, photo, storage
):
    driver = start(photo)
    driver.key(KEYS.Key_F3)
    driver.settle()
    wait_ms(6200)  # looking
    mark_face(driver)
    wait_ms(16_600)
    driver.key(KEYS.Key_Return, CONTROL)
    driver.key(KEYS.Key_Return, CONTROL)
    for seconds in (2.2, 1.2):
        wait_ms(60_000)  # looking at what came of it
        index = len(driver.state.faces[0].outline) - 1
        face = driver.state.faces[0].with_outline_point(index, (100.0 + seconds, 100.0))
        driver.editor.document.step(driver.state.with_face(0, face), "Drag")
        wait_ms(round(1000 * seconds))
        driver.key(KEYS.Key_Return, CONTROL)
    by_hand, automatic = trials.read(storage.data / TRIALS)
    assert (by_hand.photo, by_hand.mode, by_hand.landmarks) == ("portrait.png", "manual", 5)
    assert by_hand.looking_s == pytest.approx(6.2)
    assert by_hand.setting_s == pytest.approx(22.8)
    assert by_hand.corrections_s == pytest.approx((2.2, 1.2))
    assert (automatic.mode, automatic.landmarks, automatic.cold) == ("automatic", 21, True)
    assert automatic.setting_s == driver.editor.faces.finding_s


def test_points_of_an_earlier_day_are_no_trial(manual, storage):  # noqa: F811
    mark_face(manual)
    manual.settle()
    manual.open(manual.editor.document.path)
    manual.key(KEYS.Key_F3)
    assert manual.state.faces
    mark(manual, (90, 90), (95, 95))
    manual.key(KEYS.Key_Return, CONTROL)
    assert not (storage.data / TRIALS).exists()


@in_one_window
def test_an_entry_writes_the_evidence_of_the_result(opened, tmp_path):
    def write(path):
        opened.window.actions_by_name["experiment-evidence"].trigger()
        opened.choose_path(path)
        opened.settle()

    write(tmp_path / "e.npz")
    found = kogao.load_evidence(tmp_path / "e.npz")
    image = opened.editor.document.image
    assert found.size == (image.width, image.height)
    assert found.recipe == opened.state.recipe
    assert len(found.made["photo_sha256"]) == 64
    write(tmp_path / "none" / "e.npz")
    assert "can't be written" in opened.say()
