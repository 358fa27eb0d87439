"""What is on the canvas, its legend and the figures below it, as one picture."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QPainter, QPixmap
from PySide6.QtWidgets import QWidget

from kogao_core.atomic import put

from ..actions import Spec
from ..i18n import tr, unwritten
from ..theme import GRID_PX
from ..widgets.dialogs import ask_path
from ..widgets.pictures import encoded
from .feature import Context, Feature
from .readings import Readings
from .recipe import fields

_LEGEND: Final = "legend"
_IN_CAPTION: Final = ("percent", "center", "lattice", "fit")
_CAPTION_PX: Final = 3 * GRID_PX


class Figure(Feature):
    """Saves the canvas as a figure of a report."""

    def __init__(self, context: Context, readings: Readings) -> None:
        super().__init__(context)
        self._readings: QWidget = readings.panel
        self.add_actions(
            Spec(
                "export-figure",
                tr("Export a fi&gure…"),
                "Shift+F12",
                tr("The canvas with its overlays and legend, and the figures, as one picture"),
                self.ask,
            )
        )
        self.watch(lambda: self.document.photo is None, self._enable)

    def ask(self) -> None:
        """Ask where to write it."""
        path = self.document.path
        ask_path(
            self.window,
            tr("Export a figure"),
            self.export,
            "new",
            filters=[tr("Pictures (*.png)")],
            endings=[".png"],
            at=None if path is None else path.with_name(f"{path.stem}-figure.png"),
        )

    def export(self, path: Path) -> None:
        """Write it; a file that can't be written is said."""
        self.window.bar.clear()
        try:
            put(encoded(self.picture(), path.suffix), path)
        except OSError as problem:
            self.say(unwritten(path, problem))
        else:
            self.working.emit(tr("Figure written to {name}", name=path.name))

    def picture(self) -> QPixmap:
        """Return canvas, caption and figures below each other."""
        canvas, figures = self._canvas(), self._readings.grab()
        ratio = canvas.devicePixelRatio()
        font = self.window.font()
        line = self.window.fontMetrics().height() + 2 * _CAPTION_PX
        width = max(canvas.width(), figures.width())
        whole = QPixmap(width, round(canvas.height() + line * ratio + figures.height()))
        whole.setDevicePixelRatio(ratio)
        whole.fill(self.window.palette().window().color())
        painter = QPainter(whole)
        painter.setFont(font)
        painter.setPen(self.window.palette().windowText().color())
        below = round(canvas.height() / ratio)
        painter.drawPixmap(QPoint(round((width - canvas.width()) / ratio / 2), 0), canvas)
        area = whole.deviceIndependentSize().toSize()
        painter.drawText(
            _CAPTION_PX,
            below,
            area.width() - 2 * _CAPTION_PX,
            line,
            Qt.AlignmentFlag.AlignVCenter,
            self.caption(),
        )
        painter.drawPixmap(QPoint(0, below + line), figures)
        painter.end()
        return whole

    def caption(self) -> str:
        """Return what the figure shows: the photo, and the settings it was made with."""
        recipe = self.document.state.recipe_of(self.view.face)
        path = self.document.path
        settings = [fields.stated(name, getattr(recipe, name)) for name in _IN_CAPTION]
        return " · ".join([*([path.name] if path else []), *settings])

    def _canvas(self) -> QPixmap:
        """Return the canvas; a figure has its legend, whether that is on or not."""
        switched = self.view.switched
        self.view.switched = switched | {_LEGEND}
        try:
            grabbed: QPixmap = self.window.canvas.grab()
        finally:
            self.view.switched = switched
        return grabbed

    def _enable(self) -> None:
        self.actions["export-figure"].setEnabled(self.document.photo is not None)
