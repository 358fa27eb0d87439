"""The window: it arranges what features add to it and passes on what the window system says."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

import numpy as np
from PySide6.QtCore import QByteArray, QEvent, QRectF, QSize, QSizeF, Qt, Signal
from PySide6.QtGui import QAction, QCloseEvent, QDragEnterEvent, QDropEvent, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QMainWindow,
    QMenu,
    QToolBar,
    QToolButton,
    QVBoxLayout,
    QWidget,
    QWidgetAction,
)

from . import actions
from .accessibility import tell_choices
from .canvas.photo_canvas import PhotoCanvas
from .canvas.viewport import OriginalView, Viewport
from .i18n import tr
from .theme import GRID_PX, Theme
from .view_state import ViewState
from .widgets.controls import column_of, segmented
from .widgets.dialogs import files_in
from .widgets.docks import ColumnArea, Dock, Docks, RowArea
from .widgets.icons import DRAWN, SIZE, WORDLESS, icon
from .widgets.messages import MessageBar, StatusLine
from .workspaces import WORKSPACES, Workspace

_SIDE_PX = 296
# The dock of the column beside the photo.
_SIDE: Final = "settings"
# What is there or not with the photos that were opened.
_BY_PHOTO: Final = ("strip",)
_WORD: Final = Qt.ToolButtonStyle.ToolButtonTextBesideIcon
_ALONE: Final = Qt.ToolButtonStyle.ToolButtonIconOnly
# Of the height from the eyes to the chin: the hair ends about so far above the eyes.
_FOREHEAD: Final = 0.8
_MARGIN_PX: Final = 3 * GRID_PX


class Window(QMainWindow):
    """The editor's window."""

    dropped = Signal(object)
    original_wanted = Signal(bool)
    activated = Signal(bool)
    asked_to_close = Signal()
    arranged = Signal(object)

    def __init__(self, view: ViewState) -> None:
        super().__init__()
        self.setAcceptDrops(True)
        self.actions_by_name: dict[str, QAction] = {}
        self.menus = {"panels": QMenu(tr("&Panels"), self)}
        self.canvas, self.bar, self.status = PhotoCanvas(view), MessageBar(), StatusLine()
        self.original = OriginalView(self.canvas)
        self.docks = Docks(self)
        self._closing = False
        self._before_action, self._before = QWidgetAction(self), QToolButton()
        self._beside: dict[str, QWidget] = {}
        self._needed: set[str] = set()
        self._workspace: Workspace | None = None
        self.stage = Stage(self.canvas, self.original, self.bar)

    def lay_out(self, panels: Mapping[str, tuple[QWidget, Dock | None]]) -> None:
        """Put everything in its place, once all features have added their actions."""
        menus = actions.layout(list(self.actions_by_name))
        first = [name for names in menus.values() for name in names if name in self.actions_by_name]
        there = (*first, *self.actions_by_name)
        self.actions_by_name = {name: self.actions_by_name[name] for name in there}
        self._fill_menus(menus)
        tell_choices()
        self._add_toolbar()
        self.setCentralWidget(self.stage)
        side, below = QWidget(), []
        column = column_of(side, margin=3 * GRID_PX, spacing=4 * GRID_PX)
        for name, (panel, dock) in panels.items():
            if dock is None:
                self._beside[name] = panel
                column.addWidget(panel)
            elif dock.area == Qt.DockWidgetArea.LeftDockWidgetArea:
                self.docks.add(name, dock, panel)
            else:
                below.append((name, dock, panel))
        column.addStretch()
        right = Dock(tr("Settings"), Qt.DockWidgetArea.RightDockWidgetArea)
        self.docks.add(_SIDE, right, ColumnArea(side, _SIDE_PX))
        for name, dock, panel in below:
            self.docks.add(name, dock, panel if dock.scrolls else RowArea(panel))
        for name in _BY_PHOTO:
            self.docks.offer(name, False)
        self.menus["panels"].addActions(self.docks.toggles())
        self.setStatusBar(self.status)
        self.canvas.setFocus()

    def arrange(self, workspace: Workspace, docks: QByteArray | None = None) -> None:
        """Show a workspace."""
        self._workspace = workspace
        there = {**self.actions_by_name, "hold-original": self._before_action}
        self._bar.fill(workspace.tools, there)
        self.docks.arrange({_SIDE, *workspace.panels}, _BY_PHOTO, docks)
        self._show_beside()
        self.arranged.emit(workspace)

    def need(self, panel: str, needed: bool) -> None:
        """Show a panel beside the photo while it is needed, whatever the workspace."""
        (self._needed.add if needed else self._needed.discard)(panel)
        self._show_beside()

    def _show_beside(self) -> None:
        if self._workspace is not None:
            for name, panel in self._beside.items():
                panel.setVisible(name in self._needed or name in self._workspace.panels)

    def dress(self, theme: Theme) -> None:
        """Take the canvas grey of a theme."""
        for view in self.findChildren(Viewport):
            view.setBackground(theme.canvas)
        for name in DRAWN.keys() & self.actions_by_name.keys():
            self.actions_by_name[name].setIcon(icon(name, theme))
        self._before.setIcon(icon("hold-original", theme))
        self._bar.dress(theme)

    def show_title(self, name: str, *, dirty: bool) -> None:
        """Name the photo, with a star while there are unsaved changes."""
        self.setWindowTitle(f"{name}[*] – Kogao" if name else "Kogao[*]")  # noqa: RUF001
        self.setWindowModified(dirty)

    def really_close(self) -> None:
        """Close without asking again."""
        self._closing = True
        self.close()

    def _fill_menus(self, menus: Mapping[str, actions.Names]) -> None:
        for title, names in menus.items():
            if not any(names):
                continue  # the laboratory isn't here
            menu = self.menuBar().addMenu(title)
            for name in names:
                if name is None:
                    menu.addSeparator()
                elif name in self.menus:
                    menu.addMenu(self.menus[name])
                else:
                    menu.addAction(self.actions_by_name[name])

    def _add_toolbar(self) -> None:
        switch = [self.actions_by_name[f"workspace-{name}"] for name in WORKSPACES]
        self._bar = ToolBar(tr("Tools"), segmented(tr("Workspace"), switch))
        self._before_action.setDefaultWidget(self._hold_button())
        self.addToolBar(self._bar)

    def _hold_button(self) -> QToolButton:
        button = self._before
        button.setText(tr("Hold: before"))
        button.setIconSize(self._bar.iconSize())
        button.setToolTip(tr("Show the photo as it was while the button is held (\\)"))
        button.setAccessibleName(tr("Show the photo as it was"))
        button.pressed.connect(lambda: self.original_wanted.emit(True))
        button.released.connect(lambda: self.original_wanted.emit(False))
        return button

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
                self.original_wanted.emit(False)
                self.canvas.set_space_down(False)
        super().changeEvent(event)

    def _hold(self, event: QKeyEvent, down: bool) -> bool:
        if event.isAutoRepeat():
            return False
        if event.key() == Qt.Key.Key_Backslash:
            self.original_wanted.emit(down)
            return True
        if event.key() == Qt.Key.Key_Space:
            self.canvas.set_space_down(down)
            return True
        return False

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Accept files."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Pass files and folders on."""
        event.acceptProposedAction()
        self.dropped.emit(files_in(event.mimeData()))

    def closeEvent(self, event: QCloseEvent) -> None:
        """Leave the decision to whoever knows about unsaved changes."""
        if not self._closing:
            self.asked_to_close.emit()
        # The answer may have come at once, or it comes later and closes again.
        event.setAccepted(self._closing)


class ToolBar(QToolBar):
    """Tools in groups, behind what always stands first, whatever the tools are."""

    def __init__(self, title: str, first: QWidget) -> None:
        super().__init__(title)
        self.setObjectName("tools")
        self.setMovable(False)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        self._groups: list[list[QToolButton]] = []
        grown = max(1.0, self.fontMetrics().height() / SIZE[1])
        self.setIconSize(QSize(*SIZE) * grown)
        self.addWidget(first)

    def fill(self, names: actions.Names, actions: Mapping[str, QAction]) -> None:
        """Lay tools out in place of those that are there."""
        # What stands first stays: it may be what was pressed.
        for action in self.actions()[1:]:
            self.removeAction(action)
        self._groups = []
        for name in (None, *names):
            if name is None:
                self.addSeparator()
                self._groups.append([])
                continue
            self.addAction(actions[name])
            button = self.widgetForAction(actions[name])
            if isinstance(button, QToolButton):
                button.setAccessibleName(button.accessibleName() or actions[name].iconText())
                button.setToolButtonStyle(_ALONE)
                if name not in WORDLESS:
                    self._groups[-1].append(button)
        self._give_words()

    def dress(self, theme: Theme) -> None:
        """Give the way to tools that find no room its icon and its name."""
        for more in self.findChildren(QToolButton, "qt_toolbar_ext_button"):
            more.setIcon(icon("more", theme))
            more.setToolTip(tr("More tools"))
            more.setAccessibleName(tr("More tools"))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show as many words as there is room for."""
        super().resizeEvent(event)
        self._give_words()

    def _give_words(self) -> None:
        """Show all words, then take them away by the group, from the last one, until all fits."""
        for group in self._groups:
            self._style(group, _WORD)
        for group in reversed(self._groups):
            if self.sizeHint().width() <= self.width():
                break
            self._style(group, _ALONE)

    def _style(self, group: list[QToolButton], style: Qt.ToolButtonStyle) -> None:
        for button in group:
            button.setToolButtonStyle(style)
        # Buttons that aren't shown yet tell it nothing of their size.
        if (layout := self.layout()) is not None:
            layout.invalidate()


class Stage(QWidget):
    """Holds the views of the photo side by side, and lays messages where they hide no face."""

    def __init__(self, canvas: PhotoCanvas, original: OriginalView, bar: MessageBar) -> None:
        super().__init__()
        self._view, self._bar = canvas.shown, bar
        self._views: list[Viewport] = []
        self._below: list[QWidget] = []
        self._place: QRectF | None = None
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._row = QHBoxLayout()
        self._row.setSpacing(GRID_PX // 2)
        self._grid.addLayout(self._row, 0, 0)
        for one in (original, canvas):
            self.add_view(one)
        bar.setParent(self)
        bar.left.connect(canvas.setFocus)
        bar.appeared.connect(self.place_bar)
        canvas.view_changed.connect(self.place_bar)

    def add_view(self, view: Viewport) -> None:
        """Put a view of the photo to the right of the others."""
        self._views.append(view)
        # Equal shares: the same zoom shows the same piece of the photo in all of them.
        self._row.addWidget(view, 1)
        # Whenever it comes, what is said lies over it.
        view.lower()

    def show_below(self, widget: QWidget) -> None:
        """Lay a widget over the lower edge of the views; messages leave it in sight."""
        self._below.append(widget)
        edge = QVBoxLayout()
        edge.setContentsMargins(_MARGIN_PX, 0, _MARGIN_PX, _MARGIN_PX)
        edge.addWidget(widget)
        self._grid.addLayout(edge, 0, 0, Qt.AlignmentFlag.AlignBottom)
        self._bar.raise_()

    def show_in_middle(self, widget: QWidget) -> None:
        """Lay a widget over the middle of the views."""
        self._grid.addWidget(widget, 0, 0, Qt.AlignmentFlag.AlignCenter)

    def place_bar(self) -> None:
        """Lay the message where it hides no head, as far as there is room beside them."""
        if self._bar.isHidden():
            self._place = None
            return
        area = self.rect().toRectF().adjusted(_MARGIN_PX, _MARGIN_PX, -_MARGIN_PX, -_MARGIN_PX)
        size = self._bar.size_in(round(area.width())).toSizeF()
        for one in self._below:
            if one.isVisible():
                area.setBottom(min(area.bottom(), one.y() - _MARGIN_PX))
        self._place = clear_place(size, area, list(self._heads()), self._place)
        self._bar.setGeometry(self._place.toRect())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Find the message another place."""
        super().resizeEvent(event)
        self.place_bar()

    def _heads(self) -> Iterator[QRectF]:
        """Yield where heads are seen, px of the stage."""
        for seen in (view for view in self._views if view.isVisible()):
            for face in self._view.state.faces:
                left, top, width, height = face.box
                corners = np.array([(left, top - _FOREHEAD * height), (left + width, top + height)])
                low, high = (
                    seen.viewport().mapTo(self, seen.to_screen(corner).toPoint()).toPointF()
                    for corner in corners
                )
                yield QRectF(low, high)


def clear_place(
    size: QSizeF, area: QRectF, kept: Sequence[QRectF], now: QRectF | None = None
) -> QRectF:
    """Return the place of `size` in `area` that covers least of what is to be `kept` in sight."""
    places = list(_places(size, area))
    if now is not None and now in places:
        places.insert(0, now)
    return min(places, key=lambda place: sum(_common(place, one) for one in kept))


def _places(size: QSizeF, area: QRectF) -> Iterable[QRectF]:
    right, below = area.width() - size.width(), area.height() - size.height()
    for y in (0.0, below):
        for x in (right / 2, 0.0, right):
            yield QRectF(area.left() + x, area.top() + y, size.width(), size.height())


def _common(one: QRectF, other: QRectF) -> float:
    both = one.intersected(other)
    return both.width() * both.height()
