"""What stands in the middle of the window while no photo is open: what to do."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFrame, QLabel, QPushButton, QVBoxLayout

from .. import recent
from ..i18n import tr
from ..panels.controls import heading, muted_label
from ..theme import GRID_PX

_MOST_RECENT: Final = 5


class EmptyState(QFrame):
    """Buttons to begin with.

    Parameters
    ----------
    begin : sequence of QAction
        Open a photo, open the sample.

    Signals
    -------
    wanted(Path)
        A photo opened lately is wanted again.
    """

    wanted = Signal(object)

    def __init__(self, begin: Sequence[QAction]) -> None:
        super().__init__()
        self.setProperty("bar", "hint")
        self.setAccessibleName(tr("No photo is open"))
        column = QVBoxLayout(self)
        column.setContentsMargins(*(6 * GRID_PX,) * 4)
        column.setSpacing(2 * GRID_PX)
        column.addWidget(heading(tr("Make a face a little smaller")))
        drop = muted_label(tr("Drop photos or a folder here, or"))
        column.addWidget(drop)
        self.buttons = [_button(action) for action in begin]
        for button in self.buttons:
            column.addWidget(button)
        self._title = muted_label(tr("Opened lately"))
        column.addSpacing(2 * GRID_PX)
        column.addWidget(self._title)
        self._links: list[QLabel] = []
        self._recent = QVBoxLayout()
        self._recent.setSpacing(GRID_PX)
        column.addLayout(self._recent)
        self.show_recent([])

    def show_recent(self, paths: Sequence[Path]) -> None:
        """Offer the photos opened lately."""
        for link in self._links:
            link.deleteLater()
        shown = paths[:_MOST_RECENT]
        titles = recent.titles(shown)
        self._links = [self._link(*one) for one in zip(shown, titles, strict=True)]
        for link in self._links:
            self._recent.addWidget(link)
        self._title.setVisible(bool(paths))

    def _link(self, path: Path, title: str) -> QLabel:
        link = QLabel(f'<a href="#">{_escaped(title)}</a>')
        link.setToolTip(str(path))
        link.setAccessibleName(tr("Open {name}", name=title))
        link.setTextInteractionFlags(
            Qt.TextInteractionFlag.LinksAccessibleByMouse
            | Qt.TextInteractionFlag.LinksAccessibleByKeyboard
        )
        link.linkActivated.connect(lambda _: self.wanted.emit(path))
        return link


def _button(action: QAction) -> QPushButton:
    button = QPushButton(action.text().replace("&", ""))
    button.setToolTip(action.toolTip())
    button.clicked.connect(action.trigger)
    return button


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
