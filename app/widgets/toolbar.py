"""The toolbar: where room is short, tools give up their words before any of them goes behind »."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import QToolBar, QToolButton, QWidget

from ..actions import Names
from ..i18n import tr
from ..theme import Theme
from .icons import SIZE, WORDLESS, icon

_WORD: Final = Qt.ToolButtonStyle.ToolButtonTextBesideIcon
_ALONE: Final = Qt.ToolButtonStyle.ToolButtonIconOnly


class ToolBar(QToolBar):
    """Tools in groups, behind what always stands first.

    Parameters
    ----------
    title : str
        What the bar is called.
    """

    def __init__(self, title: str) -> None:
        super().__init__(title)
        self.setObjectName("tools")
        self.setMovable(False)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        self._groups: list[list[QToolButton]] = []

    def begin(self, first: QWidget) -> None:
        """Put what stays whatever the tools are at the beginning."""
        grown = max(1.0, self.fontMetrics().height() / SIZE[1])
        self.setIconSize(QSize(*SIZE) * grown)
        self.addWidget(first)

    def fill(self, names: Names, actions: Mapping[str, QAction]) -> None:
        """Lay tools out in place of those that are there.

        Parameters
        ----------
        names : tuple of str or None
            The most important first; None is a line between two groups.
        actions : mapping of str to QAction
            By name.
        """
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
