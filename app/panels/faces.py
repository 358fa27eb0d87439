"""The faces of the photo: which ones are made smaller."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QIcon, QImage, QPixmap
from PySide6.QtWidgets import QListWidget, QListWidgetItem, QWidget

from kogao_core.face import Face
from kogao_core.geometry import Box

from ..document import State
from ..i18n import tr
from ..pyramid import Pyramid
from .controls import column_of, heading

_THUMBNAIL_PX = 48


class FacesPanel(QWidget):
    """A list with a check box, a thumbnail and the score of each face.

    Signals
    -------
    switched(int, bool)
        A face is switched on or off.
    """

    switched = Signal(int, bool)

    def __init__(self) -> None:
        super().__init__()
        self._pyramid: Pyramid | None = None
        self.list = QListWidget()
        self.list.setAccessibleName(tr("Faces"))
        self.list.setIconSize(QSize(_THUMBNAIL_PX, _THUMBNAIL_PX))
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.itemChanged.connect(self._tell)
        title = heading(tr("Face&s"))
        title.setBuddy(self.list)
        column = column_of(self, margin=8)
        column.addWidget(title)
        column.addWidget(self.list)
        self.setFixedWidth(160)

    def open(self, photo: Pyramid) -> None:
        """Take thumbnails from another photo."""
        self._pyramid = photo
        self.list.clear()

    def show_state(self, state: State) -> None:
        """Show the faces; thumbnails stay while points are dragged."""
        with QSignalBlocker(self.list):
            if self.list.count() != len(state.faces):
                self._fill(state.faces)
            for index in range(len(state.faces)):
                off = index in state.off
                check = Qt.CheckState.Unchecked if off else Qt.CheckState.Checked
                self.list.item(index).setCheckState(check)

    def _fill(self, faces: tuple[Face, ...]) -> None:
        self.list.clear()
        for number, face in enumerate(faces, 1):
            by_hand = face.source == "manual"
            score = tr("by hand") if by_hand else tr("{n:.0f} %", n=100 * face.score)
            item = QListWidgetItem(self._thumbnail(face), f"{number}\n{score}")
            item.setToolTip(tr("Face {n}: uncheck to leave it as it is", n=number))
            self.list.addItem(item)

    def _thumbnail(self, face: Face) -> QIcon:
        if self._pyramid is None:
            return QIcon()
        left, top, width, height = face.box
        side = max(width, height)
        level = self._pyramid.level_for(_THUMBNAIL_PX / max(side, 1.0))
        pixels = self._pyramid.levels[level]
        corner = np.array([left + (width - side) / 2, top + (height - side) / 2]) / 2**level
        x, y = np.round(corner).astype(int).tolist()
        length = max(1, round(side / 2**level))
        box = Box(x, y, x + length, y + length).clipped(Box.of(pixels))
        if not box.area:
            return QIcon()
        rows, columns = box.slices
        part = np.ascontiguousarray(pixels[rows, columns])
        image = QImage(
            part.data, box.width, box.height, part.strides[0], QImage.Format.Format_RGB888
        )
        smooth = Qt.TransformationMode.SmoothTransformation
        keep = Qt.AspectRatioMode.KeepAspectRatio
        size = round(_THUMBNAIL_PX * self.devicePixelRatioF())
        return QIcon(QPixmap.fromImage(image.copy()).scaled(size, size, keep, smooth))

    def _tell(self, item: QListWidgetItem) -> None:
        self.switched.emit(self.list.row(item), item.checkState() == Qt.CheckState.Checked)
