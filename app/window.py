"""The main window: arranges the widgets of features and emits window events as signals."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

import numpy as np
from PySide6.QtCore import QCoreApplication, QEvent, QRectF, QSize, QSizeF, Qt, Signal
from PySide6.QtGui import (
    QAction,
    QCloseEvent,
    QDragEnterEvent,
    QDragLeaveEvent,
    QDropEvent,
    QKeyEvent,
    QResizeEvent,
)
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

from kogao_core.base.language import looked_up

from .accessibility import tell_choices
from .actions import MENUS, Names
from .canvas.photo_canvas import PhotoCanvas
from .canvas.viewport import OriginalView, Viewport
from .i18n import tr
from .theme import GRID_PX, Theme
from .view_state import ViewState
from .widgets.controls import column_of, name_buttons, segmented
from .widgets.dialogs import files_in
from .widgets.docks import ColumnArea, Dock, Docks, RowArea
from .widgets.icons import SIZE, icon
from .widgets.messages import MessageBar, StatusLine
from .workspaces import WORKSPACES, Workspace

_SIDE_PX = 296
# Name of the dock in the column next to the photo.
_SIDE: Final = "settings"
# Panels of tools, below the settings: the settings stay where they are while tools change.
_TOOL_PANELS: Final = ("manual", "push", "protect")
# Panels that depend on the opened photos.
_BY_PHOTO: Final = ("strip",)
# Tools with an icon that needs no text.
_KNOWN: Final = ("undo", "redo", "fit", "actual")
_WORD: Final = Qt.ToolButtonStyle.ToolButtonTextBesideIcon
_ALONE: Final = Qt.ToolButtonStyle.ToolButtonIconOnly
# Height of the hair above the eyes, as a multiple of the height from eyes to chin.
_FOREHEAD: Final = 0.8
_MARGIN_PX: Final = 3 * GRID_PX
# Letters of the US layout by key code of Linux; keys beyond Latin 1, without keys such as F1.
_US: Final = {
    first + place: letter
    for first, row in ((24, "QWERTYUIOP[]"), (38, "ASDFGHJKL"), (52, "ZXCVBNM,."))
    for place, letter in enumerate(row)
}
_LATIN, _NAMED = 0xFF, 0x01000000


class Window(QMainWindow):
    """The editor's window."""

    # (files: list of Path): files and folders dropped on the window.
    dropped = Signal(object)
    # (over: bool): files are dragged over the window, or no longer.
    dragged = Signal(bool)
    # (wanted: bool): the key or button for the original is pressed or released.
    original_wanted = Signal(bool)
    # (active: bool): the window becomes active or inactive.
    activated = Signal(bool)
    # (): the user closes the window, which stays open until `really_close`.
    asked_to_close = Signal()
    # (workspace: Workspace): another workspace is shown.
    arranged = Signal(object)

    def __init__(self, view: ViewState) -> None:
        super().__init__()
        self.setAcceptDrops(True)
        self.actions_by_name: dict[str, QAction] = {}
        self.menus: dict[str, QMenu] = {}
        self._special: list[tuple[QAction, tuple[str, ...]]] = []  # commands of some workspaces
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
        """Lay out menus, tool bar and panels, after all features have added actions."""
        first = [name for menu in MENUS for name in menu.names(list(self.actions_by_name))]
        ordered = dict.fromkeys((*first, *self.actions_by_name))
        there = self.actions_by_name
        self.actions_by_name = {name: there[name] for name in ordered if name in there}
        self._fill_menus()
        tell_choices()
        self._add_toolbar()
        self.setCentralWidget(self.stage)
        side, tools, below = QWidget(), QWidget(), []
        columns = [column_of(one, margin=3 * GRID_PX, spacing=4 * GRID_PX) for one in (side, tools)]
        for name, (panel, dock) in panels.items():
            if dock is None:
                self._beside[name] = panel
                columns[name in _TOOL_PANELS].addWidget(panel)
            elif dock.area == Qt.DockWidgetArea.LeftDockWidgetArea:
                self.docks.add(name, dock, panel)
            else:
                below.append((name, dock, panel))
        columns[0].addStretch()
        right, both = Dock(tr("Settings"), Qt.DockWidgetArea.RightDockWidgetArea), QWidget()
        self._tools = ColumnArea(tools, _SIDE_PX, whole=True)
        column_of(both, ColumnArea(side, _SIDE_PX), self._tools, spacing=0)
        self.docks.add(_SIDE, right, both)
        self._side = both
        for name, dock, panel in below:
            self.docks.add(name, dock, panel if dock.scrolls else RowArea(panel))
        for name in _BY_PHOTO:
            self.docks.offer(name, False)
        self.setStatusBar(self.status)
        name_buttons(self)
        self.canvas.setFocus()

    def arrange(self, workspace: Workspace, docks: str = "") -> None:
        self._workspace = workspace
        there = {**self.actions_by_name, "hold-original": self._before_action}
        self._bar.fill(workspace.tools, there)
        self.docks.arrange({_SIDE, *workspace.panels}, _BY_PHOTO, docks)
        self._show_beside()
        for action, names in self._special:
            action.setVisible(workspace.name in names)  # keys of invisible actions are off
        self.arranged.emit(workspace)

    def need(self, panel: str, needed: bool) -> None:
        """Show a panel next to the photo while needed, in any workspace."""
        (self._needed.add if needed else self._needed.discard)(panel)
        self._show_beside()

    def _show_beside(self) -> None:
        if self._workspace is not None:
            for name, panel in self._beside.items():
                panel.setVisible(name in self._needed or name in self._workspace.panels)
            tools = (self._beside[name] for name in _TOOL_PANELS)
            self._tools.setHidden(all(panel.isHidden() for panel in tools))

    def dress(self, theme: Theme) -> None:
        """Apply the canvas grey and the icons of a theme."""
        for view in self.findChildren(Viewport):
            view.setBackground(theme.canvas)
        tools = {name for one in WORKSPACES.values() for name in one.tools if name is not None}
        for name in tools & self.actions_by_name.keys():
            self.actions_by_name[name].setIcon(icon(name, theme))
        self._before.setIcon(icon("hold-original", theme))
        self._bar.dress(theme)

    def show_title(self, name: str) -> None:
        """Show the photo's name in the title, with a place for a star."""
        self.setWindowTitle(f"{name}[*] – Kogao" if name else "Kogao[*]")  # noqa: RUF001

    def really_close(self) -> None:
        self._closing = True
        self.close()

    def _fill_menus(self) -> None:
        for declared in MENUS:
            menu = self.menuBar().addMenu(looked_up(declared.title))
            for name in declared.names(list(self.actions_by_name)):
                if name is None:
                    menu.addSeparator()
                elif name in self.menus:
                    menu.addMenu(self.menus[name])
                elif name in self.actions_by_name:  # missing without the lab package
                    menu.addAction(self.actions_by_name[name])
            if declared.only:
                # The manual panel leads back to automatic mode in each workspace.
                stays = self.actions_by_name["mode-automatic"]
                special = [it for it in (menu.menuAction(), *menu.actions()) if it is not stays]
                self._special += [(it, declared.only) for it in special]

    def _add_toolbar(self) -> None:
        switch = [self.actions_by_name[f"workspace-{name}"] for name in WORKSPACES]
        self._bar = ToolBar(tr("Tools"), segmented(tr("Workspace"), switch))
        self._before_action.setDefaultWidget(self._hold_button())
        self.addToolBar(self._bar)

    def _hold_button(self) -> QToolButton:
        button = self._before
        button.setText(tr("Hold: before"))
        button.setIconSize(self._bar.iconSize())
        button.setToolTip(tr("Show the original while the button is held (\\ or F4)"))
        button.setAccessibleName(tr("Show the original"))
        follows = self.actions_by_name["compare-wipe"]
        button.setEnabled(follows.isEnabled())
        follows.changed.connect(lambda: button.setEnabled(follows.isEnabled()))
        button.pressed.connect(lambda: self.original_wanted.emit(True))
        button.released.connect(lambda: self.original_wanted.emit(False))
        return button

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Show the original while backslash or F4 is held; pan while Space is held.

        A key of a Russian or Greek layout counts as the letter of the US layout in its place, which
        Qt does only with a Latin layout beside it, and elsewhere than on Linux always.
        """
        is_foreign = sys.platform == "linux" and _LATIN < event.key() < _NAMED
        if is_foreign and (letter := _US.get(event.nativeScanCode())):
            latin = QKeyEvent(event.type(), ord(letter), event.modifiers())
            QCoreApplication.sendEvent(self.focusWidget() or self, latin)
        elif not self._hold(event):
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """End the original view and panning: with AltGr, the key is another one by now."""
        if not event.isAutoRepeat():
            self._let_go()
        super().keyReleaseEvent(event)

    def event(self, event: QEvent) -> bool:
        """Release held keys when a dialog opens."""
        if event.type() == QEvent.Type.WindowBlocked:
            self._let_go()
        return super().event(event)

    def changeEvent(self, event: QEvent) -> None:
        """Release held keys when another window becomes active."""
        if event.type() == QEvent.Type.ActivationChange:
            self.activated.emit(self.isActiveWindow())
            if not self.isActiveWindow():
                self._let_go()
        super().changeEvent(event)

    def _let_go(self) -> None:
        self.original_wanted.emit(False)
        self.canvas.set_space_down(False)

    def _hold(self, event: QKeyEvent) -> bool:
        if event.isAutoRepeat():
            return False
        # On German and French keyboards the backslash needs AltGr.
        if event.key() in (Qt.Key.Key_Backslash, Qt.Key.Key_F4):
            self.original_wanted.emit(True)
            return True
        if event.key() == Qt.Key.Key_Space:
            self.canvas.set_space_down(True)
            return True
        return False

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if event.mimeData().hasUrls():
            event.acceptProposedAction()
            self.dragged.emit(True)

    def dragLeaveEvent(self, event: QDragLeaveEvent) -> None:
        """End the drag."""
        super().dragLeaveEvent(event)
        self.dragged.emit(False)

    def dropEvent(self, event: QDropEvent) -> None:
        event.acceptProposedAction()
        self.dragged.emit(False)
        self.dropped.emit(files_in(event.mimeData()))

    def closeEvent(self, event: QCloseEvent) -> None:
        """Emit `asked_to_close`; a feature handles unsaved changes."""
        if not self._closing:
            self.asked_to_close.emit()
        # A listener may have closed at once; otherwise a later close follows.
        event.setAccepted(self._closing)


class ToolBar(QToolBar):
    """Tool buttons in groups, after a fixed first widget."""

    def __init__(self, title: str, first: QWidget) -> None:
        super().__init__(title)
        self.setObjectName("tools")
        self.setMovable(False)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        self._named: list[QToolButton] = []
        grown = max(1.0, self.fontMetrics().height() / SIZE[1])
        self.setIconSize(QSize(*SIZE) * grown)
        self.addWidget(first)

    def fill(self, names: Names, actions: Mapping[str, QAction]) -> None:
        """Replace the tools after the first widget."""
        # Keep the first widget: a click on this widget may have caused the call.
        for action in self.actions()[1:]:
            self.removeAction(action)
        self._named = []
        for name in (None, *names):
            if name is None:
                self.addSeparator()
                continue
            self.addAction(actions[name])
            button = self.widgetForAction(actions[name])
            if isinstance(button, QToolButton):
                button.setAccessibleName(button.accessibleName() or actions[name].iconText())
                button.setToolButtonStyle(_ALONE)
                if name not in _KNOWN:
                    self._named.append(button)
        self._give_words()

    def dress(self, theme: Theme) -> None:
        """Set icon and name of the button for tools that don't fit."""
        for more in self.findChildren(QToolButton, "qt_toolbar_ext_button"):
            more.setIcon(icon("more", theme))
            more.setToolTip(tr("More tools"))
            more.setAccessibleName(tr("More tools"))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show as many button texts as fit."""
        super().resizeEvent(event)
        self._give_words()

    def _give_words(self) -> None:
        """Show all texts, then hide texts one by one from the last, until the bar fits."""
        for button in self._named:
            button.setToolButtonStyle(_WORD)
        for button in reversed(self._named):
            if self._asked_px() <= self.width():
                break
            button.setToolButtonStyle(_ALONE)

    def _asked_px(self) -> int:
        """Return the width of all tools; `sizeHint` leaves out tools that Qt has hidden."""
        widths = [self.widgetForAction(one).sizeHint().width() for one in self.actions()]
        layout = self.layout()
        assert layout is not None
        sides = layout.contentsMargins()
        return sum(widths) + layout.spacing() * (len(widths) - 1) + sides.left() + sides.right()


class Stage(QWidget):
    """Contains the views side by side, and overlays messages without hiding faces."""

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
        """Add a view of the photo to the right of the others."""
        self._views.append(view)
        # Equal widths: at the same zoom all views show the same part of the photo.
        self._row.addWidget(view, 1)
        # Messages stay on top of a view that is added later.
        view.lower()

    def put_last(self, view: Viewport) -> None:
        """Move a view to the right of the others."""
        if self._row.indexOf(view) < self._row.count() - 1:
            self._row.addWidget(view, 1)

    def show_below(self, widget: QWidget) -> None:
        """Overlay a widget on the lower edge of the views; messages don't cover the widget."""
        self._below.append(widget)
        edge = QVBoxLayout()
        edge.setContentsMargins(_MARGIN_PX, 0, _MARGIN_PX, _MARGIN_PX)
        edge.addWidget(widget)
        self._grid.addLayout(edge, 0, 0, Qt.AlignmentFlag.AlignBottom)
        self._bar.raise_()

    def show_in_middle(self, widget: QWidget) -> None:
        self._grid.addWidget(widget, 0, 0, Qt.AlignmentFlag.AlignCenter)

    def place_bar(self) -> None:
        """Move the message to the position that hides the least of all heads."""
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
        super().resizeEvent(event)
        self.place_bar()

    def _heads(self) -> Iterator[QRectF]:
        """Yield the bounding boxes of heads, px of the stage."""
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
    """Return the position for `size` in `area` that covers the least of `kept`; prefer `now`."""
    places = list(_places(size, area))
    if now is not None and now in places:
        places.insert(0, now)
    return min(places, key=lambda place: sum(_common(place, one) for one in kept))


def _places(size: QSizeF, area: QRectF) -> Iterable[QRectF]:
    right, below = area.width() - size.width(), area.height() - size.height()
    # At the bottom first: heads are in the upper half of most photos.
    for y in (below, 0.0):
        for x in (right / 2, 0.0, right):
            yield QRectF(area.left() + x, area.top() + y, size.width(), size.height())


def _common(one: QRectF, other: QRectF) -> float:
    both = one.intersected(other)
    return both.width() * both.height()
