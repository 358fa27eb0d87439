"""Overlays that follow the state at once: landmarks, targets, the centre line, placement."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF
from PySide6.QtGui import QPainter, QPainterPath

from kogao_core.base.geometry import Array
from kogao_core.base.language import Text
from kogao_core.faces.doubt import SEEN, SURE
from kogao_core.faces.face import Face
from kogao_core.faces.targets import center_candidates
from kogao_core.warp.frame import edges_px
from kogao_core.warp.lens import stretch_percent
from kogao_core.warp.surround import forehead_pairs

from ...i18n import tr
from ...view_state import ViewState
from ..handles import apart
from . import glyphs
from .overlay import Overlay, Place

_TICK_PX: Final = 6.0
# Landmarks at least this far apart on screen have marks of full size.
_ROOM_PX: Final = 16.0
_TURNS: Final = np.linspace(0.0, 2.0 * np.pi, 73)
_ROUND: Final = np.column_stack([np.cos(_TURNS), np.sin(_TURNS)])
_BALL: Final = 6.0  # in landmark spacings: the radius of a ball that a head is
_FOLLOWER: Final = 0.5  # of a target's mark: the size of one that follows


class Landmarks(Overlay):
    """Outline dots, and diamonds at the corners of eyes and mouth; a line for a small face.

    The selected face's outline is a bright line.
    """

    name = "landmarks"
    title = Text("Landmarks")
    height = 110
    key = "L"
    handles = frozenset({"outline", "eye", "mouth"})

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        """Draw its mark."""
        glyphs.dot(painter, box.center(), glyphs.LANDMARK)

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw off faces and unsure ones hollow, or dotted."""
        for index, face in enumerate(self.shown.state.faces):
            if not self.shown.marks(index):
                continue
            chosen, seen = index == self.shown.face, apart(face, place.zoom)
            off = index in self.shown.state.off or face.score < SURE
            if chosen or not seen:
                colour, width = (glyphs.HALO, 2.2) if chosen else (glyphs.OUTLINE, 1.6)
                glyphs.polyline(painter, place.points(face.outline), colour, width, dotted=off)
            if seen:
                unsure = np.full(len(face.points), off)
                if face.confidence is not None:
                    unsure |= face.confidence < SEEN
                size = _size(place, face)
                for number, at in enumerate(place.points(face.points)):
                    sure = glyphs.dot if number < len(face.outline) else glyphs.diamond
                    mark = glyphs.hollow if unsure[number] else sure
                    mark(painter, at, glyphs.LANDMARK, size)


def _large(view: ViewState, place: Place) -> Iterator[tuple[int, Face]]:
    """Yield the active faces whose marks are shown and can be told apart."""
    for index, face in enumerate(view.state.faces):
        if index not in view.state.off and view.marks(index) and apart(face, place.zoom):
            yield index, face


def _size(place: Place, face: Face) -> float:
    """Return how large a face's marks are: smaller where they would hide its outline."""
    return min(1.0, face.anchor.spacing_px * place.zoom / _ROOM_PX)


class Targets(Overlay):
    """Rings where the landmarks go, and the way there; smaller ones on a forehead that follows."""

    name = "targets"
    title = Text("Targets")
    height = 100
    key = "T"
    handles = frozenset({"target"})

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        """Draw its mark."""
        glyphs.ring(painter, box.center(), glyphs.TARGET)

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the targets of every active face that is large enough."""
        for index, face in _large(self.shown, place):
            pairs, size = self.shown.state.pairs[index], _size(place, face)
            _draw_ways(painter, place, pairs.source_px, pairs.target_px, size)
            recipe = self.shown.state.recipe.of_face(face.recipe)
            follow = forehead_pairs(self.shown.state.seen[index], recipe, pairs.started)
            _draw_ways(painter, place, *follow, _FOLLOWER * size)


def _draw_ways(
    painter: QPainter, place: Place, sources_px: Array, targets_px: Array, size: float
) -> None:
    ways = np.stack([sources_px, targets_px], axis=1)
    glyphs.lines(painter, place.to_screen(ways), glyphs.WAY)
    for at in place.points(targets_px):
        glyphs.ring(painter, at, glyphs.TARGET, size)


class Centre(Overlay):
    """The line from the eyes to the mouth with its four candidates, and the chosen one."""

    name = "centre"
    title = Text("Centre and its candidates")
    height = 90
    key = "C"
    handles = frozenset({"centre"})

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        """Draw its mark."""
        glyphs.cross(painter, box.center(), glyphs.CENTRE, 0.9)

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the line of every active face that is large enough."""
        for _, face in _large(self.shown, place):
            self._draw_line(painter, place, face)

    def _draw_line(self, painter: QPainter, place: Place, face: Face) -> None:
        line = place.to_screen([face.eye_center, face.mouth_center])
        places = place.points(center_candidates(face))
        size = _size(place, face)
        ticks = glyphs.ticks(line, [at.toTuple() for at in places], _TICK_PX * size)
        glyphs.lines(painter, [line, *ticks], glyphs.CENTRE)
        chosen = int(self.shown.state.recipe.of_face(face.recipe).center) - 1
        glyphs.cross(painter, places[chosen], glyphs.CENTRE, size)
        if QLineF(places[0], places[3]).length() > 5 * _TICK_PX:
            # Neighbours are closer than a label is high: odd ones stand right, even ones left.
            for number, at in enumerate(places, 1):
                beside = QPointF(12.0 if number % 2 else -28.0, 0.0)
                glyphs.label(painter, at + beside, str(number), bold=number == chosen + 1)


class LensStretch(Overlay):
    """A ball where each head is as the lens draws it, dotted as it is; its long axis, and the %."""

    name = "stretch"
    title = Text("Lens stretch")
    height = 95
    key = "Shift+L"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        """Draw its mark."""
        ball = QPainterPath()
        ball.addEllipse(box.center(), 7.0, 4.5)
        glyphs.outlined(painter, ball, glyphs.DISPLACEMENT)

    @classmethod
    def is_there(cls, view: ViewState) -> bool:
        """Return whether the focal length is known."""
        return view.state.focal_mm is not None

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw it for every face, once the focal length is known."""
        state, colour, width = self.shown.state, glyphs.DISPLACEMENT, glyphs.WIDTH_PX
        if (focal_mm := state.focal_mm) is None:
            return
        for face in state.faces:
            origin, radius = np.array(face.anchor.origin_px), _BALL * face.anchor.spacing_px
            off = origin - edges_px(state.image).mean(axis=0)
            way = radius * off / max(float(np.hypot(*off)), 1e-9)
            aside, percent = way[::-1] * (-1.0, 1.0), stretch_percent(face, focal_mm, state.image)
            longer = (1.0 + percent / 100.0) * way
            glyphs.lines(painter, [place.to_screen([origin - longer, origin + longer])], colour)
            for axis, dotted in ((way, True), (longer, False)):
                ball = place.points(origin + _ROUND @ np.stack([axis, aside]))
                glyphs.polyline(painter, ball, colour, width, dotted=dotted)
            middle, end = place.points([origin, origin + longer])
            text = tr("{n:.1f} %", n=percent)
            plate = glyphs.outward_plate(painter.font(), end, middle, text, place.viewport)
            glyphs.on_plate(painter, plate, text)
