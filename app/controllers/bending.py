"""Looks for straight lines near the faces and measures their bend, off the GUI thread."""

from __future__ import annotations

from PySide6.QtCore import QObject, QThreadPool, Signal

from kogao_core.bend import BentLine, bends, beside, straight_lines
from kogao_core.geometry import Array, Box
from kogao_core.pipeline import Rendering

from ..document import Document
from ..i18n import reason, tr
from ..pyramid import Rgb8
from ..scene import Scene
from ..views.bar import Message
from ..workers import Lane


class Bending(QObject):
    """Keeps `Scene.lines` up with the newest whole photo while the overlay is on.

    Signals
    -------
    measured
        `Scene.lines` is new.
    said(Message)
        For the bar over the canvas.
    """

    measured = Signal()
    said = Signal(object)

    def __init__(
        self, document: Document, scene: Scene, pool: QThreadPool, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._document, self._scene = document, scene
        self._rendering: Rendering | None = None
        self._found: tuple[Rgb8, Box, Array] | None = None
        self._lane = Lane(pool, self._not_measured, self)
        self._lane.done.connect(self._show)
        document.opened.connect(self._forget)

    @property
    def busy(self) -> bool:
        """True while lines are being looked for."""
        return self._lane.busy

    def stop(self) -> None:
        """Start nothing more."""
        self._lane.drop()

    def follow(self, rendering: Rendering) -> None:
        """Measure the bends of another result, if anyone looks."""
        self._rendering = rendering
        self.refresh()

    def refresh(self) -> None:
        """Measure if the overlay is on."""
        rendering, photo = self._rendering, self._document.pyramid
        if rendering is None or photo is None or "straight" not in self._scene.visible:
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
        self._scene.lines = tuple(lines)
        self.measured.emit()

    def _not_measured(self, problem: Exception) -> None:
        text = tr("Straight lines can't be measured ({why}).", why=reason(problem))
        self.said.emit(Message(text))

    def _forget(self) -> None:
        self._lane.drop()
        self._rendering = self._found = None
        self._scene.lines = ()
