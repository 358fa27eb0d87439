"""Manual and automatic side by side: both results, their points' differences, their times."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QImage, QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QGridLayout,
    QHeaderView,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ..controllers.modes import Comparison, Side
from ..i18n import tr
from ..panels.controls import heading, muted_label
from ..points import Handle, name
from ..theme import GRID_PX

_PICTURE_PX = 320
_HEIGHT_PX = 800
_FRAME_PX = 60  # what a title bar and a task bar take
_NONE = "–"  # noqa: RUF001


class ModesDialog(QDialog):
    """Two pictures above the times of table 2 and a table of points.

    Parameters
    ----------
    comparison : Comparison
        What to show.
    parent : QWidget
        The window.
    """

    def __init__(self, comparison: Comparison, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Manual and automatic"))
        self.times = _times_table(comparison.sides)
        self.points = _points_table(comparison)
        grid = QGridLayout()
        grid.setSpacing(3 * GRID_PX)
        for column, side in enumerate(comparison.sides):
            grid.addWidget(heading(_title(side)), 0, column)
            grid.addWidget(_picture(side, self.devicePixelRatioF()), 1, column)
        column_layout = QVBoxLayout(self)
        column_layout.setContentsMargins(4 * GRID_PX, 4 * GRID_PX, 4 * GRID_PX, 4 * GRID_PX)
        column_layout.setSpacing(3 * GRID_PX)
        column_layout.addLayout(grid)
        column_layout.addWidget(self.times)
        column_layout.addWidget(heading(tr("How far the points lie apart")))
        column_layout.addWidget(muted_label(summary(comparison)))
        column_layout.addWidget(self.points, 1)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        column_layout.addWidget(buttons)
        self.resize(2 * _PICTURE_PX + 12 * GRID_PX, min(_HEIGHT_PX, _room_px(parent)))


def _room_px(window: QWidget) -> int:
    return window.screen().availableGeometry().height() - _FRAME_PX


def summary(comparison: Comparison) -> str:
    """Return mean and largest difference of landmarks and targets over all faces."""
    if not comparison.faces:
        return tr("No face is marked by hand where one was found.")
    return "\n".join(
        tr(
            "face {n}: landmarks {mean:.1f} px on average, up to {most:.1f} px; "
            "targets {t_mean:.1f} px, up to {t_most:.1f} px",
            n=index + 1,
            mean=apart.landmarks_px.mean(),
            most=apart.landmarks_px.max(),
            t_mean=apart.targets_px.mean(),
            t_most=apart.targets_px.max(),
        )
        for index, _, apart in comparison.faces
    )


def _title(side: Side) -> str:
    mode = tr("Manual") if side.mode == "manual" else tr("Automatic")
    return tr("{mode}, faces: {n}", mode=mode, n=side.faces)


def _picture(side: Side, ratio: float) -> QLabel:
    height, width = side.pixels.shape[:2]
    image = QImage(
        side.pixels.data, width, height, side.pixels.strides[0], QImage.Format.Format_RGB888
    )
    length = round(_PICTURE_PX * ratio)
    picture = QPixmap.fromImage(image.copy()).scaled(
        length,
        length,
        Qt.AspectRatioMode.KeepAspectRatio,
        Qt.TransformationMode.SmoothTransformation,
    )
    picture.setDevicePixelRatio(ratio)
    label = QLabel()
    label.setPixmap(picture)
    label.setAccessibleName(_title(side))
    return label


def _times_table(sides: tuple[Side, Side]) -> QTableWidget:
    head = [tr("Time"), tr("Setting"), tr("Computing"), tr("Total")]
    rows = []
    for side in sides:
        mode = tr("Manual") if side.mode == "manual" else tr("Automatic")
        total = None if side.setting_s is None else side.setting_s + side.computing_s
        seconds = (side.setting_s, side.computing_s, total)
        rows.append([mode, *(_NONE if s is None else tr("{s:.2f} s", s=s) for s in seconds)])
    table = _table(tr("Times"), head, rows)
    table.setFixedHeight(
        table.horizontalHeader().sizeHint().height() + len(rows) * table.rowHeight(0) + 4
    )
    return table


def _points_table(comparison: Comparison) -> QTableWidget:
    head = [tr("Face"), tr("Point by hand"), tr("Found"), tr("Landmark"), tr("Target")]
    rows = []
    for index, _, apart in comparison.faces:
        for point, partner in enumerate(apart.partners.tolist()):
            label = name(Handle("outline", index, point), len(apart.partners))
            px = (apart.landmarks_px[point], apart.targets_px[point])
            far = (tr("{px:.1f} px", px=value) for value in px)
            rows.append([str(index + 1), label, str(partner + 1), *far])
    return _table(tr("Points"), head, rows)


def _table(title: str, head: list[str], rows: list[list[str]]) -> QTableWidget:
    table = QTableWidget(len(rows), len(head))
    table.setAccessibleName(title)
    table.setHorizontalHeaderLabels(head)
    table.verticalHeader().hide()
    table.setEditTriggers(QTableWidget.EditTrigger.NoEditTriggers)
    table.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
    for row, cells in enumerate(rows):
        for column, text in enumerate(cells):
            item = QTableWidgetItem(text)
            if column:
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            table.setItem(row, column, item)
    return table
