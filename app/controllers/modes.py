"""Renders what was set by hand and what the machine found, in a worker, for the comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from PySide6.QtCore import QObject, QThreadPool, Signal

from kogao_core.differences import Differences, differences, matching
from kogao_core.geometry import Box
from kogao_core.pipeline import render
from kogao_core.project import Mode, Sheet

from ..clock import SettingClock
from ..document import Document, State
from ..i18n import reason, tr
from ..pyramid import Pyramid, Rgb8
from ..views.bar import Message
from ..workers import Lane
from .files import Files

_MARGIN: Final = 0.25  # of the faces' larger side
_LONGEST_SIDE_PX: Final = 1024


@dataclass(frozen=True, eq=False)
class Side:
    """One mode's result: the part of it round the faces, and the two times of table 2, s."""

    mode: Mode
    faces: int
    pixels: Rgb8
    setting_s: float | None
    computing_s: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """Both modes, and how far each face's points lie apart; pairs of face indices first."""

    sides: tuple[Side, Side]
    faces: tuple[tuple[int, int, Differences], ...]


class Modes(QObject):
    """Compares the two modes of the document.

    Signals
    -------
    compared(Comparison)
        Both are rendered.
    said(Message)
        For the bar over the canvas.
    """

    compared = Signal(object)
    said = Signal(object)

    def __init__(
        self,
        document: Document,
        files: Files,
        clock: SettingClock,
        pool: QThreadPool,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._document, self._files, self._clock = document, files, clock
        self._lane = Lane(pool, self._not_compared, self)
        self._lane.done.connect(self.compared)

    @property
    def busy(self) -> bool:
        """True while it renders."""
        return self._lane.busy

    def stop(self) -> None:
        """Start nothing more."""
        self._lane.drop()

    def compare(self) -> None:
        """Render both modes as they are now."""
        pyramid, state = self._document.pyramid, self._document.state
        if pyramid is None:
            return
        times = self._clock.elapsed_s or None, self._files.finding_s
        self._lane.submit(lambda: compared(pyramid, state, times))

    def _not_compared(self, problem: Exception) -> None:
        text = tr("The two modes can't be compared ({why}).", why=reason(problem))
        self.said.emit(Message(text))


def compared(photo: Pyramid, state: State, times: tuple[float | None, float | None]) -> Comparison:
    """Render both modes of `state`; `times` are the setting times, manual first, s."""
    manual, automatic = state.sheet("manual"), state.sheet("automatic")
    box = _round_faces(manual, automatic, Box.of(photo.levels[0]))
    sides = (
        _side("manual", manual, state, photo, box, times[0]),
        _side("automatic", automatic, state, photo, box, times[1]),
    )
    faces = []
    for index, face in enumerate(manual.faces):
        other = matching(face, automatic.faces)
        if other is not None:
            found = automatic.faces[other]
            apart = differences(face, found, (manual.recipe, automatic.recipe))
            faces.append((index, other, apart))
    return Comparison(sides, tuple(faces))


def _side(
    mode: Mode, sheet: Sheet, state: State, photo: Pyramid, box: Box, setting_s: float | None
) -> Side:
    rendering = render(photo.levels[0], sheet.active, sheet.recipe, protection=state.protection)
    rows, columns = box.slices
    seen = Pyramid(_reduced(rendering.pixels[rows, columns]), photo.show).shown[0]
    computing_s = sum(rendering.timings_ms.values()) / 1e3
    return Side(mode, len(sheet.active), seen, setting_s, computing_s)


def _reduced(pixels: Rgb8) -> Rgb8:
    # Here, off the GUI thread: a face of a large photo has many times a dialog's pixels.
    shrink = max(1.0, max(pixels.shape[:2]) / _LONGEST_SIDE_PX)
    size = [max(1, round(side / shrink)) for side in pixels.shape[1::-1]]
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)


def _round_faces(first: Sheet, second: Sheet, image: Box) -> Box:
    faces = (*first.faces, *second.faces)
    if not faces:
        return image
    points = np.vstack([face.points for face in faces])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = _MARGIN * float((high - low).max())
    left, top = np.floor(low - margin).astype(int).tolist()
    right, bottom = np.ceil(high + margin).astype(int).tolist()
    return Box(left, top, right, bottom).clipped(image)
