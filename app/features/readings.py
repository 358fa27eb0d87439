"""Measured: the time of each stage and the pixels of each domain; a figure with both below it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from PySide6.QtCore import QPoint, QRectF, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPixmap
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QSizePolicy, QWidget

from kogao_core.base.atomic import put
from kogao_core.pipeline import STAGES, Rendering
from kogao_core.recipe.settings import DOMAINS, DomainName

from ..canvas.overlays import glyphs
from ..i18n import tr, translated, unwritten
from ..render.colour import in_srgb
from ..render.pictures import encoded
from ..theme import GRID_PX
from ..widgets.controls import column_of, heading, muted_label, row_of
from ..widgets.dialogs import ask_path
from ..widgets.docks import Dock
from .feature import Context, Feature
from .recipe import fields

_BAR_PX: Final = 8
_NONE: Final = "–"  # noqa: RUF001
_LEGEND: Final = "legend"
_IN_CAPTION: Final = ("percent", "center", "lattice", "fit")
_CAPTION_PX: Final = 3 * GRID_PX


class ReadingsPanel(QWidget):
    """Timings and domains of the newest whole result, side by side."""

    def __init__(self) -> None:
        super().__init__()
        self.timings, self.domains = _Timings(), _Domains()
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 8, 12, 8)
        row.setSpacing(8 * GRID_PX)
        row.addWidget(self.timings, 1)
        row.addWidget(self.domains, 1)
        self.forget()
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)

    def show_rendering(self, rendering: Rendering) -> None:
        """Show what a whole result took and changed; dashes where no face was to be moved."""
        if rendering.pairs:
            self.timings.show_laps(rendering.timings_ms)
            self.domains.show_counts(rendering.pixel_counts)
        else:
            self.forget()

    def forget(self) -> None:
        """Show dashes: nothing is measured yet."""
        self.timings.forget()
        self.domains.forget()


class _Timings(QWidget):
    def __init__(self) -> None:
        super().__init__()
        self.total = muted_label()
        grid = _table(self, tr("Timings"), self.total)
        self.rows: dict[str, tuple[_Bar, QLabel]] = {}
        for row, (stage, title) in enumerate(STAGES.items()):
            bar, value = _Bar(), _number()
            for column, cell in enumerate((muted_label(translated(title)), bar, value)):
                grid.addWidget(cell, row, column)
            self.rows[stage] = (bar, value)
        grid.setColumnStretch(1, 1)
        grid.setColumnMinimumWidth(2, 64)

    def show_laps(self, laps_ms: Mapping[str, float]) -> None:
        """Show the time of each stage, in ms."""
        total = sum(laps_ms.values())
        self.total.setText(tr("full photo {ms:.0f} ms", ms=total))
        for stage, (bar, value) in self.rows.items():
            lap = laps_ms.get(stage, 0.0)
            bar.show_share(lap / total if total else 0.0)
            value.setText(tr("{ms:.1f} ms", ms=lap))

    def forget(self) -> None:
        """Show a dash for each stage."""
        self.total.clear()
        for bar, value in self.rows.values():
            bar.show_share(0.0)
            value.setText(_NONE)


class _Domains(QWidget):
    def __init__(self) -> None:
        super().__init__()
        grid = _table(self, tr("Domains"), muted_label())
        self.rows: dict[DomainName, tuple[QLabel, QLabel, QLabel]] = {}
        for row, domain in enumerate(DOMAINS):
            mark = QLabel()
            draw = glyphs.hatch_mark(domain.name)
            mark.setPixmap(glyphs.swatch(draw, self.devicePixelRatioF()))
            title = muted_label(translated(domain.title))
            title.setToolTip(fields.help_of(domain))
            pixels, share, saved = _number(), _number(), _number()
            saved.setProperty("muted", "true")
            for column, cell in enumerate((mark, title, pixels, share, saved)):
                grid.addWidget(cell, row, column)
            self.rows[domain.name] = (pixels, share, saved)
        grid.setColumnStretch(1, 1)
        grid.setColumnMinimumWidth(3, 64)
        grid.setColumnMinimumWidth(4, 88)
        grid.setRowStretch(len(DOMAINS), 1)

    def show_counts(self, counts: Mapping[DomainName, int]) -> None:
        """Show how many pixels each domain has, and how much of the whole it saves."""
        whole = max(1, counts.get("image", 0))
        for name, (pixels, share, saved) in self.rows.items():
            count = counts.get(name, 0)
            pixels.setText(tr("{n:,} px", n=count))
            share.setText(tr("{n:.1f} %", n=100 * count / whole))
            saved.setText(tr("{n:.1f} % saved", n=100 * (1 - count / whole)))

    def forget(self) -> None:
        """Show a dash for each domain."""
        for row in self.rows.values():
            for cell in row:
                cell.setText(_NONE)


class _Bar(QWidget):
    """A horizontal bar for a share of one."""

    def __init__(self) -> None:
        super().__init__()
        self._share = 0.0
        self.setMinimumSize(48, _BAR_PX)

    def show_share(self, share: float) -> None:
        self._share = share
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: ARG002
        painter = QPainter(self)
        top = (self.height() - _BAR_PX) / 2
        painter.fillRect(
            QRectF(0, top, self.width() * self._share, _BAR_PX), self.palette().accent()
        )


def _table(widget: QWidget, title: str, note: QLabel) -> QGridLayout:
    grid = QGridLayout()
    grid.setHorizontalSpacing(2 * GRID_PX)
    grid.setVerticalSpacing(GRID_PX // 2)
    column_of(widget, row_of(heading(title), None, note), grid, None)
    return grid


def _number() -> QLabel:
    label = QLabel()
    label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    return label


class Readings(Feature):
    """Shows what the newest whole result took and changed."""

    name = "readings"

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.panel: ReadingsPanel = ReadingsPanel()
        self.dock = Dock(tr("Readings"))
        self.document.opened.connect(self._forget)
        self.live.measured.connect(self._show)

    def _forget(self) -> None:
        self.panel.forget()
        self.view.counts = {}

    def _show(self, rendering: Rendering) -> None:
        self.panel.show_rendering(rendering)
        self.view.counts = rendering.pixel_counts if rendering.pairs else {}
        if "legend" in self.view.visible:
            self.window.canvas.redraw()


class Figure(Feature):
    """Saves the canvas as a figure of a report."""

    def __init__(self, context: Context, readings: Readings) -> None:
        super().__init__(context)
        self._readings: QWidget = readings.panel
        self.add_action(
            "export-figure",
            tr("Export a fi&gure…"),
            "Shift+F12",
            tr("The canvas with its overlays and legend, and the figures, as one picture"),
            self.ask,
            needs_photo=True,
        )

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
            self.did.emit(tr("Figure written to {name}", name=path.name))

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
        return QPixmap.fromImage(in_srgb(grabbed.toImage()))
