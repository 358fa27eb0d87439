"""The editor with a made-up photo and a source that knows its face; no screen, no networks."""

from __future__ import annotations

import gc
import os
import threading

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import cache, partial, reduce
from operator import or_
from pathlib import Path

import cv2
import numpy as np
import pytest
from kogao_app.__main__ import main
from kogao_app.canvas.handles import position
from kogao_app.editor import Editor
from kogao_app.features.experiments.dialog import ExperimentDialog, Findings
from kogao_app.features.files.saver import Saver
from kogao_app.features.together import TogetherDialog
from kogao_app.render.live import REST_MS
from kogao_app.storage import Storage
from kogao_app.view_state import Following, Handle, RenderedFrame
from kogao_app.widgets import messages
from kogao_app.widgets.controls import Fold
from kogao_app.window import Window
from kogao_app.workspaces import WORKSPACES
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt, QTimer
from PySide6.QtGui import QFont, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QMessageBox, QWidget
from pytestqt.qtbot import QtBot
from scenes import KnownFaces, oval_face, textured_photo
from timeouts import LONGEST_S, held_back

from kogao_core.background import find as background
from kogao_core.background.people import PersonFinder, PersonMask
from kogao_core.base.geometry import Image
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks.pixels import Pyramid
from kogao_core.lab.reports.report import Table
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe

SIZE = 1100, 760  # of a window, px


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

    def rendered(self, pixels: Image) -> Image:
        """What the core makes of the photo's pixels and the state."""
        edits = self.state.done
        strokes = {"protection": edits.protection, "brushwork": edits.brushwork}
        return render(pixels, edits.faces, edits.recipe, **strokes).pixels

    def panel(self, feature: str) -> QWidget:
        """The panel that a feature adds to the window."""
        return getattr(self.editor, feature).panel

    def settle(self) -> None:
        self.qtbot.waitUntil(lambda: not self.editor.busy)

    def open(self, path: Path) -> None:
        self.editor.files.open(path)
        self.settle()

    def leave(self) -> None:
        """Close the window as its user does, and wait until it has closed."""
        self.window.close()
        self.qtbot.waitUntil(lambda: not self.window.isVisible())

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

    def workspaces(self) -> Iterator[str]:
        """Show each workspace in turn, and yield its name."""
        for name in WORKSPACES:
            self.window.actions_by_name[f"workspace-{name}"].trigger()
            yield name

    def unfold(self) -> None:
        """Open every group that opens and closes under its title."""
        for fold in self.window.findChildren(Fold):
            fold.button.setChecked(True)

    def drawn(self) -> list[RenderedFrame]:
        """The frames that are drawn from now on; the list grows."""
        view, frames = self.editor.view, []
        view.watch(lambda: frames.extend([view.frame] if view.frame else []), "frame")
        frames.clear()
        return frames

    def pause_never(self) -> None:
        """Let no pause of a gesture bring the whole photo, which may be there before its preview.

        A gesture goes on until it is committed.
        """
        self.editor.live._rest.setInterval(round(2000 * LONGEST_S))

    def set(self, field: str, value: object) -> None:
        """Set a field of the recipe as one undo step."""
        self.editor.recipe.set_field(field, value)
        self.editor.document.commit()

    def show(self, field: str, value: object) -> None:
        """Set a field of the recipe as one undo step, and wait until it is shown and kept."""
        self.set(field, value)
        self.settle()

    def edit(self, percent: float) -> None:
        """Set the warp distance as one undo step, and wait until the edit is kept."""
        self.show("percent", percent)

    def save(self, path: Path) -> None:
        """Save a copy, and wait until it is written."""
        self.editor.files.save(path)
        self.settle()

    def to_front(self) -> None:
        self.window.activateWindow()
        self.qtbot.waitUntil(self.window.isActiveWindow)

    def choose(self, menu: str, words: str) -> None:
        """Open a menu and choose the entry that says `words`."""
        self.window.menus[menu].aboutToShow.emit()
        action = next(one for one in self.window.menus[menu].actions() if words in one.text())
        assert action.isEnabled()
        action.trigger()

    def align(self) -> QPoint:
        """Pan the photo's pixels onto the screen's, and return where its corner lies."""
        corner = self.canvas.to_screen(np.array([-0.5, -0.5]))
        at = corner.toPoint()
        self.canvas.start_pan(corner)
        self.canvas.pan_to(at.toPointF())
        self.canvas.end_pan()
        return at

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
        return bar.accessibleDescription() if bar.isVisible() else ""

    def take_step(self, words: str) -> None:
        """Press the button of the message bar that says `words`."""
        button = next(b for b in self.window.bar.buttons if words in b.text())
        QTest.mouseClick(button, Qt.MouseButton.LeftButton)


class LastingDriver(Driver):
    """The hands in a window that the tests of a module have one after the other."""

    def __init__(self, editor: Editor, qtbot: QtBot, source: KnownFaces) -> None:
        super().__init__(editor, qtbot)
        self.source = source
        self._checked = {
            action: action.isChecked()
            for name, action in self.window.actions_by_name.items()
            if action.isCheckable() and not name.startswith(("workspace-", "overlay-"))
        }

    def tidy(self, workspace: str) -> None:
        """Put back what a photo doesn't bring along, as it was at first."""
        self.editor.document.abort()
        # Nobody is asked about work half done.
        self.editor.document.begin_with(self.editor.document.base)
        for widget in QApplication.topLevelWidgets():
            if widget is not self.window and widget.isVisible():
                widget.close()
        while self.window.bar.dismiss():
            pass
        self.window.resize(*SIZE)
        self.window.activateWindow()
        self.editor.recipe.choose(None)
        self.editor.workspaces.show(workspace)
        self.editor.workspaces.reset()
        # Of those that exclude each other the one that is wanted takes the place of the other.
        for wanted in (True, False):
            for action, checked in self._checked.items():
                if checked is wanted and action.isChecked() is not wanted:
                    action.trigger()
        self.editor.view.set(following=Following())
        self.editor.recipe.settings.clear()
        self.editor.preferences.changed.emit()


def _combined(modifiers: tuple[Qt.KeyboardModifier, ...]) -> Qt.KeyboardModifier:
    return reduce(or_, modifiers, Qt.KeyboardModifier.NoModifier)


@pytest.fixture
def qtbot(qtbot: QtBot) -> QtBot:
    """The same hands, patient with a busy machine."""
    for wait in ("waitUntil", "waitExposed", "waitActive"):
        setattr(qtbot, wait, partial(getattr(qtbot, wait), timeout=round(1000 * LONGEST_S)))
    return qtbot


@pytest.fixture
def source(request: pytest.FixtureRequest) -> KnownFaces:
    if LASTING and "one_window" in request.fixturenames:
        vars(LASTING[0].source).clear()
        LASTING[0].source.faces = [oval_face()]
        return LASTING[0].source
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
def other(tmp_path: Path) -> Path:
    """Another photo beside the first."""
    path = tmp_path / "other.png"
    assert cv2.imwrite(str(path), textured_photo(seed=5))
    return path


@pytest.fixture
def storage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Storage:
    """Where the editor keeps its things; `main` finds the same places."""
    for name in ("CONFIG", "DATA"):
        monkeypatch.setenv(f"XDG_{name}_HOME", str(tmp_path / "home" / name.lower()))
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "home" / "data"))
    return Storage.of_user()


# What `one_window` holds.
LASTING: list[LastingDriver] = []


@pytest.fixture(scope="session", autouse=True)
def nobody_in_noise() -> Iterator[None]:
    """Look for no people in the photo of most tests, where none are, and for its lines once.

    These looks are most of what showing a photo takes.
    """
    people, lines, noise = PersonFinder.find, background.straight_lines, textured_photo()

    def told(finder: PersonFinder, photo: Image | Pyramid, faces: Sequence[Face]) -> PersonMask:
        image = photo.image if isinstance(photo, Pyramid) else photo
        in_vain = np.array_equal(image, noise)
        return PersonMask(missed=len(faces)) if in_vain else people(finder, photo, faces)

    def found(photo: Pyramid, mask: PersonMask | None = None) -> np.ndarray:
        once = mask is None and np.array_equal(photo.image, noise)
        return in_noise() if once else lines(photo, mask)

    in_noise = cache(lambda: lines(Pyramid(noise)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PersonFinder, "find", told)
        patch.setattr(background, "straight_lines", found)
        yield


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
            if isinstance(widget, Window) and all(widget is not one.window for one in LASTING):
                widget.deleteLater()
        app.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        if not LASTING:
            app.setStyleSheet("")


@contextmanager
def _collected() -> Iterator[None]:
    """Collect garbage of what is made here only.

    What was there before stays out of the collector's sight, which takes longer to look through
    than many tests; what is made here doesn't, however many editors are started.
    """
    gc.collect()
    gc.freeze()
    with pytest.MonkeyPatch.context() as patch:
        for name in ("freeze", "unfreeze"):
            patch.setattr(gc, name, lambda: None)
        # What merely informs is there until a test has seen it.
        patch.setattr(messages, "LINGER_MS", round(2000 * LONGEST_S))
        yield
    # Here, not on a worker of the next test.
    gc.collect()


def _shown(driver: Driver) -> Driver:
    driver.window.resize(*SIZE)
    with driver.qtbot.waitExposed(driver.window):
        driver.window.show()
    return driver


def _closed(driver: Driver) -> None:
    """Close an editor; nothing is left of it."""
    driver.editor.close()
    driver.window.deleteLater()
    # Pytest keeps what fixtures returned.
    vars(driver).clear()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


@pytest.fixture(scope="module")
def one_window() -> Iterator[list[LastingDriver]]:
    """Let the tests of a module have one window, each with a photo of its own.

    For those that change nothing but the photo and how it is seen.
    """
    with _collected():
        yield LASTING
        while LASTING:
            _closed(LASTING.pop())


@pytest.fixture
def start(
    request: pytest.FixtureRequest,
    qapp: QApplication,
    qtbot: QtBot,
    source: KnownFaces,
    storage: Storage,
) -> Iterator[Callable[..., Driver]]:
    """Start an editor; it is closed, and nothing is left of it, at the end of the test."""
    drivers: list[Driver] = []
    lasts = "one_window" in request.fixturenames

    def take(workspace: str) -> LastingDriver:
        if LASTING:
            LASTING[0].qtbot = qtbot
            LASTING[0].tidy(workspace)
        else:
            editor = Editor(qapp, source, storage, workspace=workspace)
            LASTING.append(_shown(LastingDriver(editor, qtbot, source)))
        return LASTING[0]

    # Whatever a test looks at is there; what else workspaces show, their own tests tell.
    def make(photo: Path | None = None, *, workspace: str | None = "inspect") -> Driver:
        if lasts and photo is not None and not drivers:
            driver = take(workspace)
        else:
            if not drivers and LASTING:
                # A window is built faster while none wears the style sheet.
                _closed(LASTING.pop())
                qapp.setStyleSheet("")
            driver = _shown(Driver(Editor(qapp, source, storage, workspace=workspace), qtbot))
        drivers.append(driver)
        # Tests state their figures for 4 %, whatever the default is.
        if driver.editor.document.first_recipe == Recipe():
            driver.editor.recipe.begin_with(Recipe(percent=4.0))
        # The question of the first save has been answered.
        settings = driver.editor.save_options.settings
        if driver in LASTING or not settings.contains("saving/record"):
            settings.setValue("saving/record", False)
        # A double click of the last test leaves the button down.
        QTest.mouseRelease(driver.window, Qt.MouseButton.LeftButton, pos=QPoint(1, 1))
        # Elsewhere than where the last test left the mouse: Qt tells of no move to the same place.
        QTest.mouseMove(driver.window, QPoint(1, 1))
        if photo is not None:
            driver.open(photo)
        return driver

    with nullcontext() if lasts else _collected():
        yield make
        for driver in drivers:
            # What two windows did to one photo would have to be asked about.
            if driver in LASTING and driver.window.isVisible() and len(drivers) == 1:
                driver.editor.live._rest.setInterval(REST_MS)
                driver.settle()
            else:
                _closed(driver)
        LASTING[:] = [one for one in LASTING if vars(one)]


@pytest.fixture
def run_main(qapp: QApplication, source: KnownFaces) -> Callable[..., int]:
    """Run `main` and call `act(window)` every 50 ms until it returns True.

    The window of other tests is closed first. If `act` fails or takes too long, the program ends.
    """
    while LASTING:
        _closed(LASTING.pop())

    def run(words: Sequence[str], act: Callable[[Window], bool]) -> int:
        problems: list[Exception] = []

        def poll(patience: float) -> None:
            windows = (w for w in qapp.topLevelWidgets() if isinstance(w, Window) and w.isVisible())
            try:
                window = next(windows, None)
                if window is not None and act(window):
                    return
                assert patience > 0, "the window didn't come to the expected state"
            except Exception as problem:
                problems.append(problem)
                qapp.exit(-1)
                return
            QTimer.singleShot(50, lambda: poll(patience - 0.05))

        QTimer.singleShot(100, lambda: poll(LONGEST_S))
        code = main(words, source)
        for problem in problems:
            raise problem
        return code

    return run


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
def searched(
    start: Callable[[], Driver], source: KnownFaces, photo: Path
) -> Iterator[tuple[Driver, threading.Event]]:
    """An editor whose search for the photo's faces is slow, and what lets the search end."""
    gate, source.find = held_back(source.find)
    driver = start()
    driver.editor.files.read(photo)
    driver.qtbot.waitUntil(lambda: driver.editor.document.photo is not None)
    yield driver, gate
    gate.set()


@pytest.fixture
def empty(start: Callable[[], Driver]) -> Driver:
    return start()


@pytest.fixture
def hands(qtbot: QtBot) -> Iterator[Driver]:
    """The hands at a window that holds nothing, for dialogs that need no editor."""
    driver = Driver.__new__(Driver)
    driver.window, driver.qtbot = QWidget(), qtbot
    driver.window.show()
    yield driver
    driver.window.deleteLater()


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
    experiment = ExperimentDialog("An experiment", two.window, "the paper's settings")
    caption = "How long each of the methods takes for this photo, median of ten runs, ms"
    experiment.show_findings(Findings("timing", "What it asks", [Table(caption, ["a"], [["1"]])]))
    together = TogetherDialog(two.window, 2 * [two.editor.document.path])
    for dialog in (experiment, together):
        dialog.open()
    together.resize(together.minimumSizeHint())
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
