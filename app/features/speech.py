"""The canvas in words, for a screen reader: faces chosen, points taken and moved, messages."""

from __future__ import annotations

import numpy as np

from kogao_core.geometry import Array
from kogao_core.pipeline import Rendering

from ..canvas import handles
from ..canvas.handles import Handle
from ..i18n import tr
from ..render.live import RenderedFrame
from ..widgets.spoken import announce
from .feature import Context, Feature
from .points import Points
from .recipe import RecipeEditing

_LEAST_PX = 0.05


class Speech(Feature):
    """Announces what else is only seen: the choice at once, a move with what became of it."""

    def __init__(self, context: Context, points: Points, recipe: RecipeEditing) -> None:
        super().__init__(context)
        self._point: Handle | None = None
        # Where the selected point was when it was last spoken of, px of the photo.
        self._at: Array = np.zeros(2)
        points.restyled.connect(self._tell_point)
        recipe.chosen.connect(self._tell_face)
        self.live.drawn.connect(self._tell_move)
        self.window.bar.appeared.connect(lambda: self._say(self.window.bar.text.text()))

    def _tell_face(self) -> None:
        face, count = self.view.face, len(self.document.state.faces)
        if face is None:
            self._say(tr("All faces"))
        else:
            off = face in self.document.state.off
            words = tr("Face {n} of {count}", n=face + 1, count=count)
            self._say(tr("{face}, left as it is", face=words) if off else words)

    def _tell_point(self) -> None:
        """Name the point that the arrow keys move from now on."""
        point = self.view.selected
        if point == self._point:
            return
        self._point = point
        if point is not None:
            self._at = handles.position(self.document.state, point)
            self._say(self._name(point))

    def _tell_move(self, frame: RenderedFrame) -> None:
        """Say how far the selected point went, once it is known whether the warp folds there."""
        point = self.view.selected
        moving = self.document.in_gesture or not self.live.is_final(frame)
        if point is None or point != self._point or moving:
            return
        to = handles.position(self.document.state, point)
        away, self._at = to - self._at, to
        if np.abs(away).max() >= _LEAST_PX:
            parts = (self._name(point), *_ways(*away.tolist()), _verdict(frame.rendering))
            self._say(", ".join(parts))

    def _name(self, point: Handle) -> str:
        return handles.name(point, len(self.document.state.faces[point.face].outline))

    def _say(self, text: str) -> None:
        announce(self.window.canvas, text)


def _ways(right_px: float, down_px: float) -> list[str]:
    """Return how far something went along either axis, px of the photo."""
    across = tr("{px:.3g} px right") if right_px > 0 else tr("{px:.3g} px left")
    along = tr("{px:.3g} px down") if down_px > 0 else tr("{px:.3g} px up")
    ways = ((across, abs(right_px)), (along, abs(down_px)))
    return [words.format(px=round(px, 1)) for words, px in ways if px >= _LEAST_PX]


def _verdict(rendering: Rendering) -> str:
    check = rendering.one_to_one
    if check.folds:
        return tr("folds in {n} cells", n=len(check.folded_cells))
    return tr("no folds") if check.edges_proven and check.settled else tr("small folds possible")
