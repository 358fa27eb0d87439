"""The window: it arranges the views and passes on what the window system says."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent, QKeyEvent
from PySide6.QtWidgets import (
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QMainWindow,
    QMenu,
    QScrollArea,
    QToolBar,
    QToolButton,
    QUndoView,
    QVBoxLayout,
    QWidget,
)

from .. import actions
from ..i18n import tr
from ..layers import layers
from ..menus import overlay_action, tool_action
from ..panels.controls import column_of
from ..panels.faces import FacesPanel
from ..panels.manual import ManualPanel
from ..panels.overlays import OverlaysPanel
from ..panels.protect import ProtectPanel
from ..panels.readings import ReadingsPanel
from ..panels.recipe import RecipePanel
from ..panels.strip import FilmStrip
from ..scene import Scene
from ..theme import GRID_PX, Theme
from ..tools import tools
from .bar import MessageBar
from .canvas import PhotoCanvas
from .docks import Docks
from .empty import EmptyState
from .status import StatusLine
from .twin import Twin

_SIDE_PX = 296


class Window(QMainWindow):
    """The editor's window.

    Signals
    -------
    dropped(list of Path)
        Files or folders were dropped.
    original_held(bool)
        The key for the original goes down or up.
    activated(bool)
        The window has the focus, or another one.
    asked_to_close
        The user wants to close; `really_close` does.
    """

    dropped = Signal(object)
    original_held = Signal(bool)
    activated = Signal(bool)
    asked_to_close = Signal()

    def __init__(self, scene: Scene) -> None:
        super().__init__()
        self.setAcceptDrops(True)
        self.actions_by_name = actions.build(self)
        self.canvas, self.bar = PhotoCanvas(scene), MessageBar()
        self.twin = Twin(self.canvas)
        self.recipe, self.faces = RecipePanel(), FacesPanel()
        self.readings, self.status = ReadingsPanel(), StatusLine()
        overlays = {
            layer.name: self.actions_by_name[overlay_action(layer.name)] for layer in layers()
        }
        self.overlays = OverlaysPanel(overlays)
        named = {tool.name: self.actions_by_name[tool_action(tool.name)] for tool in tools()}
        self.protect = ProtectPanel(
            named, self.actions_by_name["hard"], self.actions_by_name["unprotect"]
        )
        self.manual = ManualPanel(
            [self.actions_by_name[name] for name in ("mark", "mirror", "mirror-side", "snap")],
            self.actions_by_name["apply"],
            self.actions_by_name["compare-modes"],
        )
        self.history, self.strip = QUndoView(), FilmStrip()
        self.history.setEmptyLabel(tr("As it was opened"))
        self.history.setAccessibleName(tr("History"))
        named_actions = self.actions_by_name
        self.empty = EmptyState([named_actions["open"], named_actions["sample"]])
        self.docks = Docks(self)
        self.recent, self.presets = QMenu(tr("Open &recent")), QMenu(tr("Prese&ts"))
        self.recent.setToolTipsVisible(True)
        self.panels = QMenu(tr("&Panels"))
        self._closing = False
        menus = {"recent": self.recent, "presets": self.presets, "panels": self.panels}
        actions.fill_menus(self.menuBar(), self.actions_by_name, menus)
        self._add_toolbar()
        self.setCentralWidget(self._stage())
        self._add_docks()
        self.setStatusBar(self.status)
        self.canvas.setFocus()

    def dress(self, theme: Theme) -> None:
        """Take the canvas grey of a theme."""
        self.canvas.setBackground(theme.canvas)
        self.twin.setBackground(theme.canvas)

    def show_title(self, name: str, *, dirty: bool) -> None:
        """Name the photo, with a star while there are unsaved changes."""
        self.setWindowTitle(f"{name}[*] – Kogao" if name else "Kogao[*]")  # noqa: RUF001
        self.setWindowModified(dirty)

    def really_close(self) -> None:
        """Close without asking again."""
        self._closing = True
        self.close()

    def _add_toolbar(self) -> None:
        bar = QToolBar(tr("Tools"))
        bar.setObjectName("tools")
        bar.setMovable(False)
        bar.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        actions.fill_toolbar(bar, self.actions_by_name)
        bar.addWidget(self._hold_button())
        self.addToolBar(bar)

    def _hold_button(self) -> QToolButton:
        hold = QToolButton()
        hold.setText(tr("Hold: before"))
        hold.setToolTip(tr("Show the photo as it was while the button is held (\\)"))
        hold.setAccessibleName(tr("Show the photo as it was"))
        hold.pressed.connect(lambda: self.original_held.emit(True))
        hold.released.connect(lambda: self.original_held.emit(False))
        return hold

    def _stage(self) -> QWidget:
        stage = QWidget()
        grid = QGridLayout(stage)
        grid.setContentsMargins(0, 0, 0, 0)
        views = QHBoxLayout()
        views.setSpacing(GRID_PX // 2)
        # Equal shares: the same zoom shows the same piece of the photo in both.
        for view in (self.twin, self.canvas):
            views.addWidget(view, 1)
        grid.addLayout(views, 0, 0)
        over = QVBoxLayout()
        over.setContentsMargins(3 * GRID_PX, 3 * GRID_PX, 3 * GRID_PX, 0)
        over.addWidget(self.bar)
        self.bar.left.connect(self.canvas.setFocus)
        grid.addWidget(self.empty, 0, 0, Qt.AlignmentFlag.AlignCenter)
        grid.addLayout(over, 0, 0, Qt.AlignmentFlag.AlignTop)
        return stage

    def _side(self) -> QWidget:
        content = QWidget()
        column = column_of(content, margin=3 * GRID_PX, spacing=4 * GRID_PX)
        column.addWidget(self.manual)
        column.addWidget(self.recipe)
        column.addWidget(self.protect)
        column.addWidget(self.overlays)
        column.addStretch()
        scroll = QScrollArea()
        scroll.setWidgetResizable(True)
        scroll.setFrameShape(QFrame.Shape.NoFrame)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        scroll.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        scroll.setWidget(content)
        scroll.setFixedWidth(_SIDE_PX)
        return scroll

    def _add_docks(self) -> None:
        area, docks = Qt.DockWidgetArea, self.docks
        docks.add("faces", tr("Faces panel"), self.faces, area.LeftDockWidgetArea)
        docks.add("settings", tr("Settings"), self._side(), area.RightDockWidgetArea)
        bottom = area.BottomDockWidgetArea
        docks.add("readings", tr("Readings"), self.readings, bottom)
        docks.add("history", tr("History"), self.history, bottom, beside="readings")
        docks.add("strip", tr("Film strip"), self.strip, bottom, beside="readings", shown=False)
        self.panels.addActions(docks.toggles())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Hold the original with the backslash, panning with Space."""
        if not self._hold(event, True):
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Let both go."""
        if not self._hold(event, False):
            super().keyReleaseEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        """Let held keys go when another window takes over."""
        if event.type() == QEvent.Type.ActivationChange:
            self.activated.emit(self.isActiveWindow())
            if not self.isActiveWindow():
                self.original_held.emit(False)
                self.canvas.hold_space(False)
        super().changeEvent(event)

    def _hold(self, event: QKeyEvent, down: bool) -> bool:
        if event.isAutoRepeat():
            return False
        if event.key() == Qt.Key.Key_Backslash:
            self.original_held.emit(down)
            return True
        if event.key() == Qt.Key.Key_Space:
            self.canvas.hold_space(down)
            return True
        return False

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Accept files."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Pass files and folders on."""
        urls = [url for url in event.mimeData().urls() if url.isLocalFile()]
        if urls:
            event.acceptProposedAction()
            self.dropped.emit([Path(url.toLocalFile()) for url in urls])

    def closeEvent(self, event: QCloseEvent) -> None:
        """Leave the decision to whoever knows about unsaved changes."""
        if not self._closing:
            self.asked_to_close.emit()
        # The answer may have come at once, or it comes later and closes again.
        event.setAccepted(self._closing)
