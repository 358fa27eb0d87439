"""The window: it arranges the views and passes on what the window system says."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent, QKeyEvent
from PySide6.QtWidgets import (
    QDockWidget,
    QFrame,
    QGridLayout,
    QMainWindow,
    QScrollArea,
    QToolBar,
    QVBoxLayout,
    QWidget,
)

from .. import actions
from ..i18n import tr
from ..layers import layers
from ..panels.controls import column_of
from ..panels.faces import FacesPanel
from ..panels.overlays import OverlaysPanel
from ..panels.readings import ReadingsPanel
from ..panels.recipe import RecipePanel
from ..scene import Scene
from ..theme import GRID_PX, Theme
from .bar import MessageBar
from .canvas import PhotoCanvas
from .status import StatusLine

_SIDE_PX = 296


class Window(QMainWindow):
    """The editor's window.

    Signals
    -------
    dropped(Path)
        A file was dropped.
    original_held(bool)
        The key for the original goes down or up.
    asked_to_close
        The user wants to close; `really_close` does.
    """

    dropped = Signal(object)
    original_held = Signal(bool)
    asked_to_close = Signal()

    def __init__(self, scene: Scene) -> None:
        super().__init__()
        self.setAcceptDrops(True)
        self.actions_by_name = actions.build(self)
        self.canvas, self.bar = PhotoCanvas(scene), MessageBar()
        self.recipe, self.faces = RecipePanel(), FacesPanel()
        self.readings, self.status = ReadingsPanel(), StatusLine()
        overlays = {
            layer.name: self.actions_by_name[actions.overlay_action(layer.name)]
            for layer in layers()
        }
        self.overlays = OverlaysPanel(overlays)
        self._closing = False
        actions.fill_menus(self.menuBar(), self.actions_by_name)
        self._add_toolbar()
        self.setCentralWidget(self._stage())
        self._dock(tr("Faces panel"), self.faces, Qt.DockWidgetArea.LeftDockWidgetArea)
        self._dock(tr("Settings"), self._side(), Qt.DockWidgetArea.RightDockWidgetArea)
        self._dock(tr("Readings"), self.readings, Qt.DockWidgetArea.BottomDockWidgetArea)
        self.setCorner(Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.RightDockWidgetArea)
        self.setCorner(Qt.Corner.BottomLeftCorner, Qt.DockWidgetArea.LeftDockWidgetArea)
        self.setStatusBar(self.status)
        self.canvas.setFocus()

    def dress(self, theme: Theme) -> None:
        """Take the canvas grey of a theme."""
        self.canvas.setBackground(theme.canvas)

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
        bar.setMovable(False)
        bar.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        actions.fill_toolbar(bar, self.actions_by_name)
        self.addToolBar(bar)

    def _stage(self) -> QWidget:
        stage = QWidget()
        grid = QGridLayout(stage)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.addWidget(self.canvas, 0, 0)
        over = QVBoxLayout()
        over.setContentsMargins(3 * GRID_PX, 3 * GRID_PX, 3 * GRID_PX, 0)
        over.addWidget(self.bar)
        grid.addLayout(over, 0, 0, Qt.AlignmentFlag.AlignTop)
        return stage

    def _side(self) -> QWidget:
        content = QWidget()
        column = column_of(content, margin=3 * GRID_PX, spacing=4 * GRID_PX)
        column.addWidget(self.recipe)
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

    def _dock(self, title: str, content: QWidget, area: Qt.DockWidgetArea) -> None:
        dock = QDockWidget(title)
        dock.setObjectName(title)
        dock.setTitleBarWidget(QWidget())
        dock.setFeatures(QDockWidget.DockWidgetFeature.NoDockWidgetFeatures)
        dock.setWidget(content)
        self.addDockWidget(area, dock)

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
        if event.type() == QEvent.Type.ActivationChange and not self.isActiveWindow():
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
        """Open the first file."""
        files = [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]
        if files:
            event.acceptProposedAction()
            self.dropped.emit(Path(files[0]))

    def closeEvent(self, event: QCloseEvent) -> None:
        """Leave the decision to whoever knows about unsaved changes."""
        if not self._closing:
            self.asked_to_close.emit()
        # The answer may have come at once, or it comes later and closes again.
        event.setAccepted(self._closing)
