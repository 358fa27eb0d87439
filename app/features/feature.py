"""What all features of the editor are: actions, perhaps a panel, and work that can be ended."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from PySide6.QtCore import QObject, QSettings, QThreadPool, Signal
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QWidget

from ..actions import FIRST_KEY, call
from ..document import Document
from ..render.live import Live
from ..storage import Storage
from ..view_state import ViewState
from ..widgets.docks import Dock
from ..widgets.messages import BarAction, Message
from ..window import Window
from ..workers import Lane


@dataclass(frozen=True, eq=False)
class Context:
    """What features work with.

    Parameters
    ----------
    document : Document
        The open photo and what is done to it.
    view : ViewState
        What is on screen.
    live : Live
        Keeps the picture up with the document.
    window : Window
        The editor's.
    pool : QThreadPool
        For work off the GUI thread.
    storage : Storage
        The user's folders.
    settings : QSettings
        What outlives the program.
    features : list of Feature
        Those built with it, in turn; each enters itself.
    """

    document: Document
    view: ViewState
    live: Live
    window: Window
    pool: QThreadPool
    storage: Storage
    settings: QSettings
    features: list[Feature] = field(default_factory=list)


class Feature(QObject):
    """One thing that a user can name.

    Parameters
    ----------
    context : Context
        What it works with; its parts are the feature's own attributes.

    Signals
    -------
    message(Message)
        For the bar over the canvas.
    working(str)
        What is under way; empty for nothing.
    did(str)
        What has just been done; it is said until the next step.
    """

    message = Signal(object)
    working = Signal(str)
    did = Signal(str)
    # What it adds to the window: a panel in the column at the side, or in a dock of its own. By
    # this name workspaces know it.
    name: str = ""
    panel: QWidget | None = None
    dock: Dock | None = None

    def __init__(self, context: Context) -> None:
        super().__init__(context.document)
        context.features.append(self)
        self.document, self.view, self.live = context.document, context.view, context.live
        self.window, self.pool = context.window, context.pool
        self.storage, self.settings = context.storage, context.settings
        self._lanes: list[Lane] = []

    @property
    def busy(self) -> bool:
        """True while work is under way."""
        return any(lane.busy for lane in self._lanes)

    def stop(self) -> None:
        """Start nothing more, and forget what is under way."""
        for lane in self._lanes:
            lane.drop()

    def finish(self) -> None:
        """Bring to an end what must not be lost; the window is closed."""

    @property
    def actions(self) -> Mapping[str, QAction]:
        """The actions of the whole window by name."""
        return self.window.actions_by_name

    def lane(
        self,
        done: Callable[[Any], object],
        failed: Callable[[Exception], object],
        pool: QThreadPool | None = None,
    ) -> Lane:
        """Return a lane for work that `busy` and `stop` know of."""
        lane = Lane(pool or self.pool, failed, self)
        lane.done.connect(done)
        self._lanes.append(lane)
        return lane

    def add_action(
        self,
        name: str,
        text: str,
        key: str,
        tip: str,
        slot: Callable[[], object] | None = None,
        *,
        toggled: Callable[[bool], object] | None = None,
        checked: bool | None = None,
        needs_photo: bool = False,
        also: Sequence[str] = (),
    ) -> QAction:
        """Add an action to the window, in all of which its key holds, and return it.

        A feature that needs another's takes it from there; by names they are looked up once all
        are built.

        Parameters
        ----------
        name : str
            By which menus, toolbar and settings know it.
        text, key, tip : str
            What it is called, its shortcut and what it does.
        slot : callable, optional
            What happens when the user takes it.
        toggled : callable, optional
            What happens when it is switched on or off, by whomever; it takes which.
        checked : bool, optional
            Initial state of an action that toggles; None for one that doesn't, or is off at first.
        needs_photo : bool
            Whether it is disabled until a photo is open.
        also : sequence of str
            Keys that do the same, as other programs have them.
        """
        action = self.window.actions_by_name[name] = QAction(self.window)
        call(action, text)
        action.setShortcuts([QKeySequence(one) for one in (key, *also) if one])
        action.setProperty(FIRST_KEY, key)
        action.setToolTip(f"{tip} ({key})" if key else tip)
        action.setStatusTip(tip)
        action.setCheckable(checked is not None or toggled is not None)
        action.setChecked(bool(checked))
        if slot is not None:
            action.triggered.connect(lambda: slot())
        if toggled is not None:
            action.toggled.connect(toggled)
        if needs_photo:
            self.enable_with_photo(action.setEnabled)
        self.window.addAction(action)
        return action

    def enable_with_photo(self, enable: Callable[[bool], object]) -> None:
        """Disable something until a photo is open."""
        enable(False)
        self.document.opened.connect(lambda: enable(True))

    def one_of(self, *names: str) -> QActionGroup:
        """Let only one of these actions be checked at a time."""
        group = QActionGroup(self)
        for name in names:
            group.addAction(self.actions[name])
        return group

    def say(
        self,
        text: str,
        *steps: BarAction,
        wrong: bool = True,
        applies: Callable[[], bool] | None = None,
    ) -> None:
        """Say something in the bar over the canvas, see `Message`."""
        self.message.emit(Message(text, steps, wrong, applies))

    def watch(self, value: Callable[[], object], show: Callable[[], object]) -> None:
        """Call `show` now, and after each change of the document that makes `value` another."""
        self.document.watch(value, show)
