"""Methods of our own: the paper's B-splines, moving least squares, and a retoucher's brush.

The rigid form of moving least squares is ours because no library with it is kept up.
"""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box, Image
from kogao_core.base.language import Text
from kogao_core.lab.methods.base import Method, Warp, WarpTask, interpolated
from kogao_core.recipe.settings import Fit
from kogao_core.warp.canvas import Canvas
from kogao_core.warp.domain import reduce
from kogao_core.warp.field import Field
from kogao_core.warp.fit import fit

_NEAREST_PX: Final = 1e-6  # a point on a landmark takes that landmark's displacement
BRUSH_SPACINGS: Final = 1.0  # standard deviation of the brush, in landmark spacings


class _FieldWarp(Warp):
    """A displacement field; resampled in its lossless domain only."""

    def __init__(self, field: Field) -> None:
        self.field = field

    def at(self, points_px: Array) -> Array:
        return self.field.at(points_px)

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        return self.field.on_grid(xs_px, ys_px)

    def pixels(self, photo: Image, moved: Array | None = None) -> Image:
        if moved is not None:
            moved[:] = self.on_grid(*(np.arange(n) for n in photo.shape[1::-1]))
        canvas = Canvas(photo)
        canvas.warp(self.field, reduce(self.field, Box.of(photo), "threshold"), "bilinear")
        return canvas.pixels


def bspline(name: Fit, title: str, reference: str) -> Method:
    """Return one of the fits of the control lattice, as a method: one lattice to each face."""

    def fitted(task: WarpTask) -> Warp:
        anchors = [face.anchor for face in task.faces]
        recipe = dataclasses.replace(task.recipe, fit=name)
        return _FieldWarp(Field(fit(task.pairs, anchors, [recipe] * len(anchors))))

    return Method(name, title, reference, "Kogao", fitted)


class _Moving(Warp):
    """The most rigid map near each pixel (Schaefer, McPhail, Warren 2006)."""

    def __init__(self, target_px: Array, displacement_px: Array) -> None:
        # Counted from the middle, so that products of places lose little to rounding.
        self._middle = target_px.mean(axis=0)
        self._from = target_px - self._middle
        at, goal = self._from, self._from + displacement_px
        # In the complex plane a turn with a scaling is one factor; its best one is a ratio of
        # weighted sums: of the places, the goals, and conj(place) * goal.
        turned = np.column_stack(
            [(at * goal).sum(axis=1), at[:, 0] * goal[:, 1] - at[:, 1] * goal[:, 0]]
        )
        self._summed = np.column_stack([np.ones(len(at)), at, goal, turned])

    def at(self, points_px: Array) -> Array:
        x, y = np.ascontiguousarray((points_px - self._middle).T)
        apart = np.square(x[:, None] - self._from[:, 0])
        apart += np.square(y[:, None] - self._from[:, 1])
        weight = np.reciprocal(np.maximum(apart, _NEAREST_PX**2, out=apart), out=apart)
        total, *sums = (weight @ self._summed).T
        from_x, from_y, goal_x, goal_y, along, across = (one / total for one in sums)
        # Of the factor the rigid map keeps the turn.
        along -= from_x * goal_x + from_y * goal_y
        across -= from_x * goal_y - from_y * goal_x
        size = np.hypot(along, across)
        still = size == 0.0
        size[still], along[still] = 1.0, 1.0
        along, across = along / size, across / size
        u, v = x - from_x, y - from_y
        return np.column_stack(
            [along * u - across * v + goal_x - x, across * u + along * v + goal_y - y]
        )


def _fit_rigid(task: WarpTask) -> Warp:
    """Weights fall with the square of the distance, without an end: the edges stay."""
    return _Moving(*task.anchored())


MOVING_LEAST_SQUARES: Final = Method(
    "moving",
    Text("Moving least squares, rigid"),
    Text("Schaefer et al. 2006"),
    Text("own (numpy)"),
    _fit_rigid,
    quick=interpolated(_fit_rigid),
)


class _Pushed(Warp):
    """Strokes one after the other; a point goes back through them, the last one first."""

    def __init__(self, target_px: Array, displacement_px: Array, width_px: float) -> None:
        self._target, self._displacement, self._width_px = target_px, displacement_px, width_px

    def at(self, points_px: Array) -> Array:
        x, y = np.array(np.transpose(points_px), np.float64, order="C")
        for target, displacement in zip(self._target[::-1], self._displacement[::-1], strict=True):
            apart = np.square(x - target[0])
            apart += np.square(y - target[1])
            apart /= -2.0 * self._width_px**2
            pushed = np.exp(apart, out=apart)
            x += pushed * displacement[0]
            y += pushed * displacement[1]
        return np.column_stack([x, y]) - points_px


def _brushed(task: WarpTask) -> Warp:
    """Choose the strength of the strokes, all composed before the photo is resampled once.

    Neighbouring strokes add up, so all are made weaker by one factor, such that landmarks move as
    far as they should on average: what a careful hand would do.
    """
    width_px = BRUSH_SPACINGS * task.spacing_px
    full = _Pushed(task.target_px, task.displacement_px, width_px).at(task.target_px)
    asked = np.linalg.norm(task.displacement_px, axis=1).mean()
    strength = asked / max(float(np.linalg.norm(full, axis=1).mean()), 1e-12)
    return _Pushed(task.target_px, strength * task.displacement_px, width_px)


LIQUIFY: Final = Method(
    "liquify", Text("Liquify, Gaussian brush"), Text("today's practice"), Text("own (numpy)"),
    _brushed, quick=interpolated(_brushed),
)  # fmt: skip
