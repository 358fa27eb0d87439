"""The faces of the photo: which ones are made smaller, and whose settings are edited."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QListWidget, QListWidgetItem, QWidget

from kogao_core.face import Face

from ..document import State
from ..i18n import tr
from ..pyramid import Pyramid
from .controls import column_of, heading
from .thumbnails import face_icon

_THUMBNAIL_PX = 48
_ALL_ROWS = 1  # the row of all faces comes before those of single ones


class FacesPanel(QWidget):
    """All faces in the first row, then each with a check box, a thumbnail and its score.

    Signals
    -------
    switched(int, bool)
        A face is switched on or off.
    chosen(object)
        The face whose settings are to be edited; None for those of the photo.
    """

    switched = Signal(int, bool)
    chosen = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self._pyramid: Pyramid | None = None
        self._known: tuple[Face, ...] = ()
        self.list = QListWidget()
        self.list.setAccessibleName(tr("Faces"))
        self.list.setIconSize(QSize(_THUMBNAIL_PX, _THUMBNAIL_PX))
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.itemChanged.connect(self._tell_switch)
        self.list.currentRowChanged.connect(self._tell_choice)
        title = heading(tr("Face&s"))
        title.setBuddy(self.list)
        column = column_of(self, margin=8)
        column.addWidget(title)
        column.addWidget(self.list)
        self.setFixedWidth(160)

    def open(self, photo: Pyramid) -> None:
        """Take thumbnails from another photo."""
        self._pyramid, self._known = photo, ()
        with QSignalBlocker(self.list):
            self.list.clear()

    def item(self, face: int) -> QListWidgetItem:
        """Return the row of a face."""
        return self.list.item(face + _ALL_ROWS)

    def show_state(self, state: State, chosen: int | None = None) -> None:
        """Show the faces; thumbnails stay while points are dragged."""
        with QSignalBlocker(self.list):
            if len(self._known) != len(state.faces) or not self.list.count():
                self._fill(state.faces)
            self._known = state.faces
            for index, face in enumerate(state.faces):
                off = index in state.off
                check = Qt.CheckState.Unchecked if off else Qt.CheckState.Checked
                item = self.item(index)
                item.setCheckState(check)
                item.setText("\n".join(_caption(index, face)))
                item.setData(Qt.ItemDataRole.AccessibleTextRole, _spoken(index, face))
            self.list.setCurrentRow(0 if chosen is None else chosen + _ALL_ROWS)

    def _fill(self, faces: tuple[Face, ...]) -> None:
        self.list.clear()
        everyone = QListWidgetItem(tr("All faces"))
        everyone.setToolTip(tr("The settings of the photo"))
        self.list.addItem(everyone)
        for number, face in enumerate(faces, 1):
            icon = QIcon()
            if self._pyramid is not None:
                icon = face_icon(self._pyramid, face, _THUMBNAIL_PX, self.devicePixelRatioF())
            item = QListWidgetItem(icon, "")
            item.setToolTip(
                tr("Face {n}: select it for settings of its own, uncheck to leave it", n=number)
            )
            self.list.addItem(item)

    def _tell_switch(self, item: QListWidgetItem) -> None:
        on = item.checkState() == Qt.CheckState.Checked
        self.switched.emit(self.list.row(item) - _ALL_ROWS, on)

    def _tell_choice(self, row: int) -> None:
        if row >= 0:
            self.chosen.emit(None if row < _ALL_ROWS else row - _ALL_ROWS)


def _caption(index: int, face: Face) -> list[str]:
    """Return the lines beside the thumbnail: number, score, and whose settings the face goes by."""
    by_hand = face.source == "manual"
    score = tr("by hand") if by_hand else tr("{n:.0f} %", n=100 * face.score)
    return [str(index + 1), score, *([] if face.recipe is None else [tr("own")])]


def _spoken(index: int, face: Face) -> str:
    _, score, *own = _caption(index, face)
    what = [tr("Face {n}", n=index + 1), score, *(tr("settings of its own") for _ in own)]
    return ", ".join(what)
