"""The paper's method and its relatives, by this program's own engine."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box, Image
from kogao_core.lab.methods.base import Method, Warp, WarpTask
from kogao_core.recipe.settings import Fit
from kogao_core.warp.canvas import Canvas
from kogao_core.warp.domain import reduce
from kogao_core.warp.field import Field
from kogao_core.warp.fit import fit


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
