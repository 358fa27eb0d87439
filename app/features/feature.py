"""Base class of features: actions, an optional panel, and background jobs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

from PySide6.QtCore import QObject, QSettings, QThreadPool, Signal
from PySide6.QtGui import QAction, QActionGroup
from PySide6.QtWidgets import QWidget

from ..actions import TABLE, Item
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
    """Shared objects for features.

    Parameters
    ----------
    document : Document
        The open photo and edits.
    view : ViewState
        Display settings.
    live : Live
        Renders the document to the canvas.
    window : Window
        The main window.
    pool : QThreadPool
        Threads for background jobs.
    storage : Storage
        The user's folders.
    settings : QSettings
        Persistent settings.
    features : list of Feature
        All features built with this context, in order; each feature adds itself.
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
    """A user-visible feature of the editor.

    Parameters
    ----------
    context : Context
        Shared objects, also available as attributes of the feature.

    Signals
    -------
    message(Message)
        A message for the bar over the canvas.
    working(str)
        The running activity; empty when finished.
    did(str)
        A completed action; shown until the next edit.
    """

    message = Signal(object)
    working = Signal(str)
    did = Signal(str)
    # The panel of the feature, in the side column or in a separate dock. Workspaces refer to the
    # panel by this name.
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
        """True while a job runs or waits."""
        return any(map(attrgetter("busy"), self._lanes))

    def stop(self) -> None:
        """Discard queued jobs and ignore the results of running jobs."""
        for lane in self._lanes:
            lane.drop()

    def finish(self) -> None:
        """Finish work that must not be lost, after the window is closed."""

    @property
    def actions(self) -> Mapping[str, QAction]:
        """All actions of the window by name."""
        return self.window.actions_by_name

    def lane(
        self,
        done: Callable[[Any], object],
        failed: Callable[[Exception], object],
        pool: QThreadPool | None = None,
    ) -> Lane:
        """Return a job lane that `busy` and `stop` include."""
        lane = Lane(pool or self.pool, failed, self)
        lane.done.connect(done)
        self._lanes.append(lane)
        return lane

    def bind(
        self,
        command: Item | str,
        slot: Callable[[], object] | None = None,
        *,
        toggled: Callable[[bool], object] | None = None,
        checked: bool | None = None,
    ) -> QAction:
        """Connect a command to a slot, add its action to the window, and return the action.

        Other features read `actions` only after all features are built.

        Parameters
        ----------
        command : Item or str
            The command, or its name in `app.actions.TABLE`.
        slot : callable, optional
            Called when the user triggers the action.
        toggled : callable, optional
            Called with the new state each time a checkable action changes.
        checked : bool, optional
            Initial state of a checkable action; None: not checkable unless `toggled` is given.
        """
        command = TABLE[command] if isinstance(command, str) else command
        action = self.window.actions_by_name[command.name] = command.action(self.window)
        action.setCheckable(checked is not None or toggled is not None)
        action.setChecked(bool(checked))
        if slot is not None:
            action.triggered.connect(lambda: slot())
        if toggled is not None:
            action.toggled.connect(toggled)
        if command.photo:
            self.enable_with_photo(action.setEnabled)
        self.window.addAction(action)
        return action

    def enable_with_photo(self, enable: Callable[[bool], object]) -> None:
        """Disable a control until a photo is open."""
        enable(False)
        self.document.opened.connect(lambda: enable(True))

    def one_of(self, *names: str) -> QActionGroup:
        """Make these actions exclusive."""
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
        """Show a message in the bar over the canvas, see `Message`."""
        self.message.emit(Message(text, steps, wrong, applies))
