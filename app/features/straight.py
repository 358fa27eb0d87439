"""Looks for straight lines near the faces and measures their bend, off the GUI thread."""

from __future__ import annotations

from PySide6.QtCore import Signal

from kogao_core.bend import BentLine, bends, beside, straight_lines
from kogao_core.geometry import Array, Box
from kogao_core.pipeline import Rendering

from ..i18n import reason, tr
from ..render.pyramid import Rgb8
from .feature import Context, Feature


class StraightLines(Feature):
    """Keeps `ViewState.lines` up with the newest whole photo while the overlay is on.

    Signals
    -------
    measured
        `ViewState.lines` is new.
    """

    measured = Signal()

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._rendering: Rendering | None = None
        self._found: tuple[Rgb8, Box, Array] | None = None
        self._lane = self.lane(self._show, self._not_measured)
        self.live.measured.connect(self.follow)
        self.document.opened.connect(self._forget)
        self.actions["overlay-straight"].toggled.connect(self.refresh)

    def follow(self, rendering: Rendering) -> None:
        """Measure the bends of another result, if anyone looks."""
        self._rendering = rendering
        self.refresh()

    def refresh(self) -> None:
        """Measure if the overlay is on."""
        rendering, photo = self._rendering, self.document.pyramid
        if rendering is None or photo is None or "straight" not in self.view.visible:
            return
        pixels, found = photo.levels[0], self._found

        def job() -> tuple[tuple[Rgb8, Box, Array], list[BentLine]]:
            near = rendering.domain.bounds
            kept = found if found is not None and found[1] == near else None
            kept = kept or (pixels, near, straight_lines(pixels, near))
            background = beside(kept[2], [pairs.source_px for pairs in rendering.pairs])
            return kept, bends(rendering.field, background)

        self._lane.submit(job)

    def _show(self, result: tuple[tuple[Rgb8, Box, Array], list[BentLine]]) -> None:
        self._found, lines = result
        self.view.lines = tuple(lines)
        self.window.canvas.redraw()
        self.measured.emit()

    def _not_measured(self, problem: Exception) -> None:
        text = tr("Straight lines can't be measured ({why}).", why=reason(problem))
        self.say(text)

    def _forget(self) -> None:
        self._lane.drop()
        self._rendering = self._found = None
        self.view.lines = ()
