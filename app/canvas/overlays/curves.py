"""Curves on the parts of a face that sliders shape: a drag moves the slider."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import Final

import numpy as np
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QPainter

from kogao_core.additions.head import forehead_pairs
from kogao_core.base.geometry import Array
from kogao_core.base.language import Text
from kogao_core.faces.reshape import across
from kogao_core.faces.targets import shape_center
from kogao_core.faces.zones import weights
from kogao_core.recipe.recipe import SETTINGS

from ...document import State
from ...i18n import tr, translated
from ...view_state import ViewState
from ..handles import apart
from . import glyphs
from .overlay import Overlay, Place

_REACH_PX: Final = 6.0
_BESIDE: Final = 0.18  # distance of the curves for the width, as a fraction of the radius
_PER_STEP: Final = 8  # points between two landmarks
_MARGIN_PX: Final = 12.0


@dataclass(frozen=True, slots=True, eq=False)
class ShapeCurve:
    """A curve on the warped face, for a shape field."""

    field: str
    points_px: Array  # (N, 2): px of the photo
    steps_px: Array  # (N, 2): move of each point for 1 % of the field


def curves(state: State, index: int) -> Iterator[ShapeCurve]:
    """Yield the curves of a face."""
    face, pairs, recipe = state.seen[index], state.pairs[index], state.recipe_of(index)
    middle, right = shape_center(face, recipe), across(face)
    away, ends = face.outline - middle, (slice(0, 3), slice(-3, None))
    for field, weight in zip(
        ("chin_length", "jaw_width", "cheeks_width"), weights(face)[:3], strict=True
    ):
        rows = np.flatnonzero(weight > 0.5)
        for run in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1):
            if len(run) > 1:
                yield _dense(field, pairs.target_px[run], weight[run, None] * away[run])
    for end in ends:
        beside = pairs.target_px[end] + _BESIDE * away[end]
        yield _dense("width", beside, np.outer(away[end] @ right, right))
    rim, there = forehead_pairs(face, recipe, pairs.started)
    if len(rim):
        down = np.array([-right[1], right[0]])
        yield _dense("forehead_height", there, np.outer((rim - middle) @ down, down))


def _dense(field: str, points_px: Array, moves_px: Array) -> ShapeCurve:
    knots = np.arange(len(points_px))
    at = np.linspace(0, len(points_px) - 1, _PER_STEP * (len(points_px) - 1) + 1)
    columns = [np.interp(at, knots, column) for column in np.hstack([points_px, moves_px / 100]).T]
    return ShapeCurve(field, np.stack(columns[:2], axis=1), np.stack(columns[2:], axis=1))


def nearest(view: ViewState, place: Place, at_px: Array) -> tuple[ShapeCurve, int] | None:
    """Return the visible curve within reach of a point (2,), px of the photo, and its row."""
    found, least = None, _REACH_PX / place.zoom
    for curve in _shown(view, place):
        away = np.hypot(*(curve.points_px - at_px).T)
        if away.min() < least:
            found, least = (curve, int(away.argmin())), float(away.min())
    return found


def _shown(view: ViewState, place: Place) -> Iterator[ShapeCurve]:
    """Yield the curves of the selected or only face, if the whole face is in view."""
    face, state = view.face_in_hand, view.state
    if face is None or face in state.off or state.mode == "manual":
        return
    left, top, width, height = state.faces[face].box
    inside = place.viewport.contains(place.rect(left, top, left + width, top + height))
    rests = "shape" not in view.visible or not view.marks(face)
    if inside and apart(state.faces[face], place.zoom):
        yield from (it for it in curves(state, face) if not rests or it.field == view.shaping)


class ShapeCurves(Overlay):
    """Thin curves on jaw, chin, cheeks, width and forehead; the curve at the cursor has a name."""

    name = "shape"
    title = Text("Shape curves")
    height = 112
    key = "U"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        low = box.bottom() - 3
        arc = [
            box.topLeft() + QPointF(2, 5),
            QPointF(box.center().x(), low),
            box.topRight() + QPointF(-2, 5),
        ]
        glyphs.polyline(painter, arc, glyphs.HALO, 1.2, dotted=False)

    @classmethod
    def is_there(cls, view: ViewState) -> bool:  # noqa: ARG003
        """Return False: the legend needs no entry, since each curve shows its name."""
        return False

    def wanted(self, visible: AbstractSet[str]) -> bool:
        """Return True also for a curve that is dragged, while all marks step back."""
        return super().wanted(visible) or self.shown.shaping is not None

    def draw(self, painter: QPainter, place: Place) -> None:
        """Draw the curves; they rest while a point is dragged."""
        view = self.shown
        if view.document.in_gesture and view.shaping is None:
            return
        for curve in _shown(view, place):
            chosen = curve.field == view.shaping
            points = place.points(curve.points_px)
            glyphs.polyline(painter, points, glyphs.HALO, 2.4 if chosen else 1.0, dotted=False)
            if chosen:
                value = getattr(view.state.recipe_of(view.face), curve.field)
                name = translated(SETTINGS[curve.field].title)
                figure = f"{value:+.1f}".replace("-", "\N{MINUS SIGN}") if value else "0.0"
                text = tr("{name} {value} %", name=name, value=figure)
                beside = max(points, key=lambda at: at.x()) + QPointF(_MARGIN_PX, 0.0)
                glyphs.label(painter, beside, text, bold=True, within=place.viewport)
