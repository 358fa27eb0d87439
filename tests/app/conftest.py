"""The editor with a made-up photo and a source that knows its face; no screen, no networks."""

from __future__ import annotations

import gc
import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from collections.abc import Callable, Iterator
from functools import partial, reduce
from operator import or_
from pathlib import Path

import cv2
import numpy as np
import pytest
from kogao_app.canvas.handles import position
from kogao_app.editor import Editor
from kogao_app.features.experiments.dialog import ExperimentDialog, Findings
from kogao_app.features.files.saver import Saver
from kogao_app.storage import Storage
from kogao_app.view_state import Handle
from kogao_app.widgets import messages
from kogao_app.widgets.controls import Fold
from kogao_app.window import Window
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QFont, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QMessageBox, QWidget
from pytestqt.qtbot import QtBot
from scenes import KnownFaces, oval_face, textured_photo
from timeouts import LONGEST_S

from kogao_core.lab.reports.report import Table


class Driver:
    """An editor and the hands of its user."""

    def __init__(self, editor: Editor, qtbot: QtBot) -> None:
        self.editor, self.qtbot = editor, qtbot
        self.canvas, self.window = editor.window.canvas, editor.window

    @property
    def state(self):
        return self.editor.document.state

    @property
    def shown(self) -> np.ndarray:
        """The pixels on screen, at full resolution."""
        return self.editor.view.frame.rendering.pixels

    def panel(self, feature: str) -> QWidget:
        """The panel that a feature adds to the window."""
        return getattr(self.editor, feature).panel

    def settle(self) -> None:
        self.qtbot.waitUntil(lambda: not self.editor.busy)

    def open(self, path: Path) -> None:
        self.editor.files.open(path)
        self.settle()

    def key(self, key: Qt.Key, *modifiers: Qt.KeyboardModifier) -> None:
        """Press a key that holds in the whole window."""
        QTest.keyClick(self.window, key, _combined(modifiers))

    def press_key(
        self, widget: QWidget, key: Qt.Key, *modifiers: Qt.KeyboardModifier, times: int = 1
    ) -> None:
        """Give a widget the focus, and press a key there."""
        widget.setFocus()
        for _ in range(times):
            QTest.keyClick(widget, key, _combined(modifiers))

    def on_screen(self, handle: Handle) -> QPoint:
        return self.canvas.to_screen(position(self.state, handle)).toPoint()

    def press(self, at: QPoint) -> None:
        QTest.mousePress(self.canvas.viewport(), Qt.MouseButton.LeftButton, pos=at)

    def move(self, to: QPoint) -> None:
        QTest.mouseMove(self.canvas.viewport(), to)

    def release(self, at: QPoint) -> None:
        QTest.mouseRelease(self.canvas.viewport(), Qt.MouseButton.LeftButton, pos=at)

    def click(self, at: QPoint) -> None:
        self.press(at)
        self.release(at)

    def drag(self, start: QPoint, by: QPoint) -> None:
        self.press(start)
        for part in (by / 3, by / 2, by):
            self.move(start + part)
        self.release(start + by)

    def turn_wheel(self, over: QWidget, notches: int, at: QPoint | None = None) -> None:
        """Turn the wheel over a place of a widget, its middle if none is given."""
        place = QPointF(over.rect().center() if at is None else at)
        wheel = QWheelEvent(
            place,
            over.mapToGlobal(place),
            QPoint(),
            QPoint(0, 120 * notches),
            Qt.MouseButton.NoButton,
            Qt.KeyboardModifier.NoModifier,
            Qt.ScrollPhase.NoScrollPhase,
            False,
        )
        QApplication.sendEvent(over, wheel)

    def unfold(self) -> None:
        """Open every group that opens and closes under its title."""
        for fold in self.window.findChildren(Fold):
            fold.button.setChecked(True)

    def pause_never(self) -> None:
        """Let no pause of a gesture bring the whole photo, which may be there before its preview.

        A gesture goes on until it is committed.
        """
        self.editor.live._rest.setInterval(round(2000 * LONGEST_S))

    def change_something(self) -> None:
        """Make the warp distance larger by a key; it is one undo step."""
        self.press_key(self.panel("recipe").percent.slider, Qt.Key.Key_PageUp)

    def dialog(self, kind: type[QWidget]) -> QWidget:
        """Wait for a dialog of a kind."""
        found = self.window.findChildren
        self.qtbot.waitUntil(lambda: any(one.isVisible() for one in found(kind)))
        return next(one for one in found(kind) if one.isVisible())

    def answer(self, words: str) -> None:
        """Wait for a question, and press its button that says `words`."""
        buttons = self.dialog(QMessageBox).buttons()
        button = next(one for one in buttons if words in one.text().replace("&", ""))
        QTest.mouseClick(button, Qt.MouseButton.LeftButton)

    def choose_path(self, path: Path | str) -> None:
        """Answer the dialog that asks for a path, be it the desktop's or Qt's own."""
        asked = self.dialog(QFileDialog)
        asked.filesSelected.emit([str(path)])
        asked.reject()

    def say(self) -> str:
        """What the message bar says; empty when it is hidden."""
        bar = self.window.bar
        return bar.text.text() if bar.isVisible() else ""

    def take_step(self, words: str) -> None:
        """Press the button of the message bar that says `words`."""
        button = next(b for b in self.window.bar.buttons if words in b.text())
        QTest.mouseClick(button, Qt.MouseButton.LeftButton)


def _combined(modifiers: tuple[Qt.KeyboardModifier, ...]) -> Qt.KeyboardModifier:
    return reduce(or_, modifiers, Qt.KeyboardModifier.NoModifier)


@pytest.fixture
def qtbot(qtbot: QtBot) -> QtBot:
    """The same hands, patient with a busy machine."""
    for wait in ("waitUntil", "waitExposed", "waitActive"):
        setattr(qtbot, wait, partial(getattr(qtbot, wait), timeout=round(1000 * LONGEST_S)))
    return qtbot


@pytest.fixture
def source() -> KnownFaces:
    return KnownFaces(oval_face())


@pytest.fixture
def pixels() -> np.ndarray:
    return textured_photo()


@pytest.fixture(scope="session")
def encoded() -> bytes:
    """The photo as a PNG file."""
    return cv2.imencode(".png", textured_photo()[..., ::-1])[1].tobytes()


@pytest.fixture
def photo(tmp_path: Path, encoded: bytes) -> Path:
    path = tmp_path / "portrait.png"
    path.write_bytes(encoded)
    return path


@pytest.fixture
def storage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Storage:
    """Where the editor keeps its things; `main` finds the same places."""
    for name in ("CONFIG", "DATA"):
        monkeypatch.setenv(f"XDG_{name}_HOME", str(tmp_path / "home" / name.lower()))
    return Storage.of_user()


@pytest.fixture(autouse=True)
def swept() -> Iterator[None]:
    """Leave no window behind: whatever changes style or font goes through the widgets of all.

    Nor the application dressed: the next editor dresses its window once, when it is built, as the
    first of a program does, and not with each layout that takes widgets in.
    """
    yield
    app = QApplication.instance()
    if isinstance(app, QApplication):
        for widget in app.topLevelWidgets():
            if isinstance(widget, Window):
                widget.deleteLater()
        app.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        app.setStyleSheet("")


@pytest.fixture
def start(
    qapp: QApplication,
    qtbot: QtBot,
    source: KnownFaces,
    storage: Storage,
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[Callable[..., Driver]]:
    """Start an editor; it is closed, and nothing is left of it, at the end of the test."""
    # What was there before the test stays out of the collector's sight, which takes longer to look
    # through than many tests; what the test makes doesn't, however many editors it starts.
    gc.collect()
    gc.freeze()
    for name in ("freeze", "unfreeze"):
        monkeypatch.setattr(gc, name, lambda: None)
    # What merely informs is there until a test has seen it.
    monkeypatch.setattr(messages, "LINGER_MS", round(2000 * LONGEST_S))
    drivers = []

    # Whatever a test looks at is there; what else workspaces show, their own tests tell.
    def make(photo: Path | None = None, *, workspace: str | None = "inspect") -> Driver:
        driver = Driver(Editor(qapp, source, storage, workspace=workspace), qtbot)
        drivers.append(driver)
        driver.window.resize(1100, 760)
        with qtbot.waitExposed(driver.window):
            driver.window.show()
        # Elsewhere than where the last test left the mouse: Qt tells of no move to the same place.
        QTest.mouseMove(driver.window, QPoint(1, 1))
        if photo is not None:
            driver.open(photo)
        return driver

    yield make
    for driver in drivers:
        driver.editor.close()
        driver.window.deleteLater()
        # Pytest keeps what fixtures returned.
        vars(driver).clear()
    qapp.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    # Here, not on a worker of the next test.
    gc.collect()


@pytest.fixture
def text_size(qapp: QApplication) -> Iterator[Callable[[float], None]]:
    """Set the size of all text, in shares of what it is; it is as before at the end."""
    before = QFont(qapp.font())

    def scale(share: float) -> None:
        font = QFont(before)
        font.setPointSizeF(share * before.pointSizeF())
        qapp.setFont(font)

    yield scale
    qapp.setFont(before)


@pytest.fixture
def empty(start: Callable[[], Driver]) -> Driver:
    return start()


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever acts has read what stands in the bar."""
    monkeypatch.setattr(messages, "UNREAD_MS", 0)


@pytest.fixture
def unkept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Edits aren't kept by themselves, as those of another program's photo."""
    monkeypatch.setattr(Saver, "keeps", False)


@pytest.fixture
def opened(start: Callable[[], Driver], photo: Path) -> Driver:
    driver = start(photo)
    without_legend(driver)
    return driver


def without_legend(driver: Driver) -> None:
    """Uncover the corner of the canvas, where tests look at pixels, too."""
    driver.window.actions_by_name["overlay-legend"].setChecked(False)


@pytest.fixture
def two(start: Callable[[], Driver], source: KnownFaces, photo: Path) -> Driver:
    """A photo with two faces."""
    source.faces = [oval_face(center=(x, 170), size=0.45) for x in (120, 350)]
    return start(photo)


@pytest.fixture
def dialogs(two: Driver) -> Iterator[list[QWidget]]:
    """Every dialog, opened as its entry in the menus does; those that ask before work is lost."""
    two.change_something()
    for name, action in two.window.actions_by_name.items():
        # An experiment runs for a while: its window is filled below.
        asks = action.text().endswith("…") and not name.startswith("experiment-")
        if asks or name == "about":
            action.trigger()
    experiment = ExperimentDialog("An experiment", two.window)
    caption = "How long each of the methods takes for this photo, median of ten runs, ms"
    experiment.show_findings(Findings("timing", "What it asks", [Table(caption, ["a"], [["1"]])]))
    experiment.open()
    two.editor.saver.guard(lambda: None)
    two.settle()
    found = [one for one in QApplication.topLevelWidgets() if one.isVisible()]
    yield [one for one in found if one is not two.window and not isinstance(one, QFileDialog)]
    for one in found:
        if one is not two.window:
            one.close()


@pytest.fixture
def door(tmp_path: Path, source: KnownFaces) -> tuple[Path, int]:
    """A face beside a door frame, and where that stands."""
    face = oval_face(960, 720, size=0.5)
    x = round(face.outline[:, 0].max() + 0.75 * face.anchor.spacing_px)
    photo = cv2.GaussianBlur(textured_photo(960, 720), (0, 0), 12)
    photo[60:660, x - 3 : x + 4] = 250
    path = tmp_path / "door.png"
    assert cv2.imwrite(str(path), photo[..., ::-1])
    source.faces = [face]
    return path, x
