"""Flat docks around the canvas.

Oversized content scrolls, so that small windows cut nothing off.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, QSize, Qt, QTimer
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QDockWidget,
    QFrame,
    QMainWindow,
    QScrollArea,
    QScroller,
    QSizePolicy,
    QTabBar,
    QTabWidget,
    QWidget,
)

from ..i18n import tr


@dataclass(frozen=True, slots=True)
class Dock:
    """Title and side of a dock."""

    title: str
    area: Qt.DockWidgetArea = Qt.DockWidgetArea.BottomDockWidgetArea
    scrolls: bool = False  # whether the panel scrolls by itself


class Docks(QObject):
    """Adds and shows docks, and saves the layout."""

    def __init__(self, window: QMainWindow) -> None:
        super().__init__(window)
        self._window = window
        self._docks: dict[str, QDockWidget] = {}
        self._layout = ""
        window.setCorner(Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.RightDockWidgetArea)
        window.setCorner(Qt.Corner.BottomLeftCorner, Qt.DockWidgetArea.LeftDockWidgetArea)
        window.setTabPosition(Qt.DockWidgetArea.BottomDockWidgetArea, QTabWidget.TabPosition.North)

    def add(self, name: str, dock: Dock, content: QWidget) -> None:
        """Add a dock; docks at the bottom become tabs, with the first tab in front."""
        widget = QDockWidget(dock.title)
        widget.setObjectName(name)
        widget.installEventFilter(self)
        widget.setWidget(content)
        # An empty title bar widget makes the dock flat; the menu still closes the dock.
        widget.setTitleBarWidget(QWidget())
        widget.setFeatures(QDockWidget.DockWidgetFeature.DockWidgetClosable)
        bottom, area_of = Qt.DockWidgetArea.BottomDockWidgetArea, self._window.dockWidgetArea
        front = next((d for d in self._docks.values() if area_of(d) == bottom), None)
        self._docks[name] = widget
        self._window.addDockWidget(dock.area, widget)
        if front is not None and dock.area == bottom:
            self._window.tabifyDockWidget(front, widget)
            front.raise_()

    def show(self, name: str) -> None:
        """Show a dock in front of the other tabs."""
        self._docks[name].show()
        self._docks[name].raise_()

    def offer(self, name: str, offered: bool) -> None:
        """Enable a dock's menu entry, or hide the dock until there is content."""
        self._docks[name].toggleViewAction().setVisible(offered)
        if not offered:
            self._docks[name].hide()

    def toggles(self) -> list[QAction]:
        """Return the show and hide actions of all docks."""
        return [dock.toggleViewAction() for dock in self._docks.values()]

    def hide_all(self, hidden: bool) -> None:
        """Hide all docks, or show the hidden docks again."""
        if hidden:
            self._layout = self.state()
            for dock in self._docks.values():
                dock.hide()
        else:
            opened = [name for name, dock in self._docks.items() if not dock.isHidden()]
            self.arrange((), opened, self._layout)

    def state(self) -> str:
        """Return names and sizes of the visible docks, front tabs first, for `arrange`."""
        shown = [(name, dock) for name, dock in self._docks.items() if not dock.isHidden()]
        shown.sort(key=lambda one: one[1].visibleRegion().isEmpty())
        return ",".join(f"{name} {dock.width()} {dock.height()}" for name, dock in shown)

    def arrange(self, shown: Collection[str], staying: Collection[str], state: str = "") -> None:
        """Restore a layout; without a valid layout, show the docks in `shown`.

        `QMainWindow.restoreState` would leave tab bars on the canvas.
        """
        stored = {name: size for name, size in _sizes(state).items() if name in self._docks}
        names = list(stored) or [name for name in self._docks if name in shown]
        for name in self._docks.keys() - set(staying):
            self._docks[name].setVisible(name in names)
        # A dock without a tool panel has no height of its own.
        least = QSize(0, 1)
        hints = {name: self._docks[name].sizeHint().expandedTo(least).toTuple() for name in names}
        # A dock that was never laid out has no size.
        sizes = {name: size for name, size in (hints | stored).items() if min(size) > 0}
        docks = [self._docks[name] for name in sizes]
        for side, way in enumerate((Qt.Orientation.Horizontal, Qt.Orientation.Vertical)):
            self._window.resizeDocks(docks, [size[side] for size in sizes.values()], way)
        for name in reversed(names):
            self._docks[name].raise_()
        for tabs in self._window.findChildren(QTabBar):
            _follow_place(tabs)
            tabs.installEventFilter(self)
            tabs.setAccessibleName(tr("Panels"))
            tabs.setToolTip(tr("Select the panel to show here"))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Disable widgets outside the window, so that the focus skips them."""
        if event.type() == QEvent.Type.Move and isinstance(watched, QWidget):
            _follow_place(watched)
        return False


def _sizes(state: str) -> dict[str, tuple[int, int]]:
    """Return width and height by name of a stored layout; empty for damaged text."""
    try:
        return {name: (int(w), int(h)) for name, w, h in map(str.split, state.split(","))}
    except ValueError:
        return {}


def _follow_place(widget: QWidget) -> None:
    """Disable docks and tab bars that Qt moved off screen. Tab would still reach these."""
    widget.setEnabled(widget.isWindow() or widget.geometry().right() >= 0)


class ColumnArea(QScrollArea):
    """A vertically scrolling column, at least as wide as the content.

    A `whole` column is as high as the content while there is room.
    """

    def __init__(self, content: QWidget, least_px: int, *, whole: bool = False) -> None:
        super().__init__()
        self._least_px, self._content, self._whole = least_px, content, whole
        _bare(self, content)
        QScroller.grabGesture(self.viewport(), QScroller.ScrollerGestureType.TouchGesture)
        self.setProperty("whole", whole)
        # Margins set inside a layout would request the next layout, without end.
        self._later = QTimer(self, singleShot=True, interval=0)
        self._later.timeout.connect(self._keep_width)
        self.verticalScrollBar().rangeChanged.connect(self._later.start)
        vertical = QSizePolicy.Policy.Maximum if whole else QSizePolicy.Policy.Ignored
        self.setSizePolicy(QSizePolicy.Policy.Preferred, vertical)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        content.installEventFilter(self)
        self.setMinimumWidth(least_px)

    def sizeHint(self) -> QSize:
        """Return the minimum width; users can drag the edge to widen the column."""
        if not self._whole:
            return QSize(self.minimumWidth(), super().sizeHint().height())
        content, width = self._content, self.viewport().width()
        wraps = content.hasHeightForWidth()
        height = content.heightForWidth(width) if wraps else content.sizeHint().height()
        return QSize(self.minimumWidth(), height + 2)  # for the line above

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Follow the content's minimum width, and the height of a `whole` column."""
        if watched is self._content and event.type() == QEvent.Type.LayoutRequest:
            asked = self._content.minimumSizeHint().width() + self._bar_px
            self.setMinimumWidth(max(self._least_px, asked))
            self._later.start()
            self.updateGeometry()
        return super().eventFilter(watched, event)

    @property
    def _bar_px(self) -> int:
        return self.verticalScrollBar().sizeHint().width()

    def _keep_width(self) -> None:
        """Reserve the place of the scroll bar, so that content stays where it is."""
        right = 0 if self.verticalScrollBar().maximum() else self._bar_px
        if self.viewportMargins().right() != right:
            self.setViewportMargins(0, 0, right, 0)


class RowArea(QScrollArea):
    """A strip as high as the content, with horizontal scrolling in narrow windows."""

    def __init__(self, content: QWidget) -> None:
        super().__init__()
        self._content = content
        _bare(self, content)
        content.installEventFilter(self)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        """Return the content's size plus the height of the scroll bar."""
        return self._content.sizeHint() + QSize(0, self._bar_px)

    def minimumSizeHint(self) -> QSize:
        """Return the content's height plus the height of the scroll bar."""
        return QSize(0, self._content.minimumSizeHint().height() + self._bar_px)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Keep the content at least at the minimum width."""
        if watched is self._content and event.type() == QEvent.Type.LayoutRequest:
            self._content.setMinimumWidth(self._content.minimumSizeHint().width())
        return super().eventFilter(watched, event)

    @property
    def _bar_px(self) -> int:
        return self.horizontalScrollBar().sizeHint().height()


def _bare(area: QScrollArea, content: QWidget) -> None:
    area.setWidgetResizable(True)
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    area.setWidget(content)
