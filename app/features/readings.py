"""Timings, domains, values under the cursor, and export of the canvas as a figure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np
from PySide6.QtCore import QPoint, QRect, QRectF, Qt
from PySide6.QtGui import QAction, QPainter, QPaintEvent, QPixmap
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QSizePolicy, QWidget

from kogao_core.base.atomic import atomic_write
from kogao_core.base.geometry import Box
from kogao_core.paper.domain import mask_of
from kogao_core.pipeline import STAGES
from kogao_core.recipe.recipe import PAPER, SETTINGS, Recipe
from kogao_core.recipe.settings import DOMAINS, DomainName

from ..canvas.overlays import glyphs
from ..canvas.viewport import plate_on
from ..i18n import tr, translated, unwritten
from ..render.colour import in_srgb
from ..render.pictures import encoded
from ..theme import GRID_PX
from ..view_state import RenderedFrame
from ..widgets.controls import Elided, action_button, column_of, heading, muted_label, row_of
from ..widgets.dialogs import ask_path
from ..widgets.docks import Dock
from ..workspaces import Workspace
from .feature import Context, Feature
from .recipe import fields

_BAR_PX: Final = 8
_TITLE_PX: Final = 72
_NONE: Final = "–"  # noqa: RUF001
_LEGEND: Final = "legend"
_IN_CAPTION: Final = ("percent", "center", "lattice", "fit")
_CAPTION_PX: Final = 3 * GRID_PX


class ReadingsPanel(QWidget):
    """Timings and domains of the newest full-size result; whether the paper's settings are used."""

    def __init__(self, paper: QAction) -> None:
        super().__init__()
        self.timings, self.domains = _Timings(), _Domains()
        self.settings = Elided()
        right = QWidget()
        self.settings.setMinimumWidth(_TITLE_PX)
        below = row_of(self.settings, action_button(paper), spacing=GRID_PX)
        below.setStretchFactor(self.settings, 1)
        column_of(right, self.domains, below, None)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 8, 12, 8)
        row.setSpacing(4 * GRID_PX)
        row.addWidget(self.timings, 2)
        row.addWidget(right, 3)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)


class _Timings(QWidget):
    def __init__(self) -> None:
        super().__init__()
        self.total = muted_label()
        grid = _table(self, tr("Timings"), self.total)
        self.rows: dict[str, tuple[_Bar, QLabel]] = {}
        for row, (stage, title) in enumerate(STAGES.items()):
            bar, value = _Bar(), _number()
            for column, cell in enumerate((_title(translated(title)), bar, value)):
                grid.addWidget(cell, row, column)
            self.rows[stage] = (bar, value)
        grid.setColumnStretch(1, 1)
        grid.setColumnMinimumWidth(2, 64)

    def show_laps(self, laps_ms: Mapping[str, float]) -> None:
        """Show the time of each stage, in ms; dashes without times."""
        total = sum(laps_ms.values())
        self.total.setText(tr("full photo {ms:.0f} ms", ms=total) if laps_ms else "")
        for stage, (bar, value) in self.rows.items():
            lap = laps_ms.get(stage, 0.0)
            bar.show_share(lap / total if total else 0.0)
            value.setText(tr("{ms:.1f} ms", ms=lap) if laps_ms else _NONE)


class _Domains(QWidget):
    def __init__(self) -> None:
        super().__init__()
        self.saving = muted_label()
        grid = _table(self, tr("Domains"), self.saving)
        self.rows: dict[DomainName, tuple[QLabel, QLabel]] = {}
        for row, domain in enumerate(DOMAINS):
            mark = QLabel()
            draw = glyphs.domain_mark(domain.name)
            mark.setPixmap(glyphs.swatch(draw, self.devicePixelRatioF()))
            title = _title(translated(domain.title), fields.help_of(domain))
            pixels, share = _number(), _number()
            for column, cell in enumerate((mark, title, pixels, share)):
                grid.addWidget(cell, row, column)
            self.rows[domain.name] = (pixels, share)
        grid.setColumnStretch(1, 1)
        grid.setColumnMinimumWidth(3, 64)
        grid.setRowStretch(len(DOMAINS), 1)

    def show_counts(self, counts: Mapping[DomainName, int], computed: DomainName) -> None:
        """Show the pixels of each domain and their share of the photo; dashes without counts.

        Also show how much less the computed domain is than the photo.
        """
        whole, part = max(1, counts.get("image", 0)), counts.get(computed, 0)
        told = tr("{n:.1f} % computed, {times:.1f} × less",  # noqa: RUF001
                  n=100 * part / whole, times=whole / max(1, part))  # fmt: skip
        self.saving.setText(told if part else "")
        for name, (pixels, share) in self.rows.items():
            count = counts.get(name, 0)
            pixels.setText(tr("{n:,} px", n=count) if counts else _NONE)
            share.setText(tr("{n:.1f} %", n=100 * count / whole) if counts else _NONE)


class _Bar(QWidget):
    """A horizontal bar for a fraction, 0 to 1."""

    def __init__(self) -> None:
        super().__init__()
        self._share = 0.0
        self.setMinimumSize(24, _BAR_PX)

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


def _title(text: str, tip: str = "") -> QLabel:
    """Return a label that is elided before the number next to the label is cut."""
    label = Elided(tip)
    label.setText(text)
    label.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)
    label.setMinimumWidth(_TITLE_PX)
    label.setProperty("muted", "true")
    return label


def _number() -> QLabel:
    label = QLabel()
    label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    return label


class Readings(Feature):
    """Shows times and domains of the newest full-size result, and values under the cursor."""

    name = "readings"

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        paper = self.bind("paper-settings", self._use_paper)
        self.panel: ReadingsPanel = ReadingsPanel(paper)
        self._on = False
        self.plate = plate_on(self.window.canvas)
        self.plate.setAccessibleName(tr("Values under the cursor"))
        self.plate.hide()
        self.view.watch(self._show_values, "cursor", "loupe")
        self.window.arranged.connect(self._arrange)
        self.view.watch(self._show_frame, "frame")
        self.dock = Dock(tr("Readings"))
        self.document.opened.connect(self._show_settings)
        self.view.watch(self._show, "full")

    def _arrange(self, workspace: Workspace) -> None:
        self._on = self.name in workspace.panels
        self._show_frame()

    def _show_frame(self) -> None:
        self._show_values()
        if self._on:
            self._show_settings()

    def _show_values(self) -> None:
        frame, image, (x, y) = (
            self.view.frame,
            self.document.image,
            self.view.cursor or (-1.0, -1.0),
        )
        inside = 0 <= round(x) < image.width and 0 <= round(y) < image.height
        shown = self._on and inside and not self.view.loupe
        self.plate.setVisible(shown and frame is not None)
        if shown and frame is not None:
            self.plate.setText("\n".join(values_at(frame, x, y)))
            self.plate.adjustSize()

    def _show_settings(self) -> None:
        differing = differing_from_paper(self.document.state.recipe)
        self.panel.settings.setText(settings_text(self.document.state.recipe))
        self.actions["paper-settings"].setEnabled(bool(differing) and bool(self.document.photo))

    def _use_paper(self) -> None:
        state = self.document.state
        changes = {name: getattr(PAPER, name) for name in differing_from_paper(state.recipe)}
        self.document.step(state.with_choices(None, **changes), tr("Use the paper's settings"))

    def _show(self) -> None:
        full = self.view.full
        laps_ms = full.rendering.timings_ms if full is not None and full.rendering.pairs else {}
        self.panel.timings.show_laps(laps_ms)
        name: DomainName = "image" if full is None else full.rendering.domain.name
        self.panel.domains.show_counts(self.view.counts, name)


def settings_text(recipe: Recipe) -> str:
    """Return whether the settings are the paper's, or which fields differ."""
    if differing := differing_from_paper(recipe):
        names = ", ".join(translated(SETTINGS[name].title) for name in differing)
        return tr("Not the paper's: {names}", names=names)
    return tr("Settings: the paper's")


def differing_from_paper(recipe: Recipe) -> list[str]:
    """Return the fields that differ from the paper's settings, without amount and centre."""
    names = (name for name in SETTINGS if name not in ("percent", "center"))
    return [name for name in names if getattr(recipe, name) != getattr(PAPER, name)]


def values_at(frame: RenderedFrame, x: float, y: float) -> list[str]:
    """Return lines with the displacement, det J, lattice cells and domain at (x, y), px."""
    rendering, at = frame.rendering, frame.to_photo.inverse(np.array([[x, y]]))
    field, threshold_px = rendering.field, rendering.recipe.threshold_px
    dx, dy = (field.at(at)[0] * frame.scale).tolist()
    det = float(field.det_jacobian(at[:, 0], at[:, 1])[0, 0])
    lines = [
        tr("pixel {x}, {y}", x=round(x), y=round(y)),
        tr("displacement {n:.2f} px ({dx:+.2f}, {dy:+.2f})", n=math.hypot(dx, dy), dx=dx, dy=dy),
        tr("det J {n:.3f}", n=det),
    ]
    for number, lattice in enumerate(field.lattices[: len(rendering.pairs)], 1):
        if lattice.reaches(at).any():
            i, j = (int(lattice.grid.locate(at[:, axis], axis)[0][0]) for axis in (0, 1))
            lines.append(tr("face {n}: cell ({i}, {j})", n=number, i=i, j=j))
    left, top = np.round(at[0]).astype(int).tolist()
    box = Box(left, top, left + 1, top + 1)
    lattices = field.lattices
    smallest = [one for one in DOMAINS if mask_of(lattices, box, one.name, threshold_px).any()][-1]
    lines.append(tr("domain: {name}", name=translated(smallest.title)))
    lines.append(tr("threshold T {n:.4g} px", n=threshold_px * frame.scale))
    return lines


class Figure(Feature):
    """Exports the canvas as a figure for a report."""

    def __init__(self, context: Context, readings: Readings) -> None:
        super().__init__(context)
        self._readings: QWidget = readings.panel
        self.bind("export-figure", self.ask)

    def ask(self) -> None:
        """Request a path for the figure."""
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
        """Write the figure; show a message if writing fails."""
        self.window.bar.clear()
        try:
            atomic_write(encoded(self.picture(), path.suffix), path)
        except OSError as problem:
            self.say(unwritten(path, problem))
        else:
            self.did.emit(tr("Figure written to {name}", name=path.name))

    def picture(self) -> QPixmap:
        """Return canvas, caption and readings in one picture, one below the other."""
        canvas, figures = self._canvas(), self._readings.grab()
        ratio = canvas.devicePixelRatio()
        line = self.window.fontMetrics().height() + 2 * _CAPTION_PX
        width = max(canvas.width(), figures.width())
        whole = QPixmap(width, round(canvas.height() + line * ratio + figures.height()))
        whole.setDevicePixelRatio(ratio)
        whole.fill(self.window.palette().window().color())
        painter = QPainter(whole)
        painter.setFont(self.window.font())
        painter.setPen(self.window.palette().windowText().color())
        below = round(canvas.height() / ratio)
        painter.drawPixmap(QPoint(round((width - canvas.width()) / ratio / 2), 0), canvas)
        area = whole.deviceIndependentSize().toSize()
        place = QRect(_CAPTION_PX, below, area.width() - 2 * _CAPTION_PX, line)
        painter.drawText(place, Qt.AlignmentFlag.AlignVCenter, self.caption())
        painter.drawPixmap(QPoint(0, below + line), figures)
        painter.end()
        return whole

    def caption(self) -> str:
        """Return the caption: file name and main settings."""
        recipe = self.document.state.recipe_of(self.view.face)
        path = self.document.path
        settings = [fields.stated(name, getattr(recipe, name)) for name in _IN_CAPTION]
        return " · ".join([*([path.name] if path else []), *settings])

    def _canvas(self) -> QPixmap:
        """Return a screenshot of the canvas with the legend, even if the legend is hidden."""
        switched = self.view.switched
        self.view.set(switched=switched | {_LEGEND})
        try:
            grabbed: QPixmap = self.window.canvas.grab()
        finally:
            self.view.set(switched=switched)
        return QPixmap.fromImage(in_srgb(grabbed.toImage()))
