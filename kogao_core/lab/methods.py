"""Rival warps: other methods that move the same landmarks to the same targets.

All rivals run as an image editor runs them: the displacement is computed on a grid of a few pixels,
interpolated linearly, and applied by one `cv2.remap` inside the box that moves.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Protocol

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.additions.fit import fit
from kogao_core.base.geometry import Array, Box, Image
from kogao_core.base.language import Text
from kogao_core.faces.face import Face
from kogao_core.faces.targets import FacePairs, aim
from kogao_core.field.fade import domain_of
from kogao_core.field.field import Field
from kogao_core.recipe.recipe import LOSSLESS_PX, Recipe
from kogao_core.recipe.settings import FITS, Fit
from kogao_core.resample.canvas import Canvas

_ALONG: Final = np.linspace(0.0, 1.0, 5)  # positions of the fixed points along each photo edge
_MOST_STEP_PX: Final = 8  # largest node spacing of an interpolated field
_NODES_A_SPACING: Final = 3.0  # at least this many nodes per landmark spacing
_NEAREST_PX: Final = 1e-6  # smallest distance used for weights of moving least squares
_WIDTH_SPACINGS: Final = 1.5  # width of the Gaussians, in landmark spacings
_STRIP: Final = 2**13  # nodes evaluated at a time, so that the weights stay in the cache


@dataclass(frozen=True, eq=False)
class WarpTask:
    """The landmarks and targets that every method gets."""

    image: Box  # the photo's pixels
    pairs: tuple[FacePairs, ...]  # landmarks and targets of each face
    faces: tuple[Face, ...]  # lattices are attached to the anchors of the faces
    recipe: Recipe  # lattice size and kernel, for the methods that have them

    @staticmethod
    def of(photo: Image, faces: Sequence[Face], recipe: Recipe) -> WarpTask:
        pairs = tuple(aim(face, recipe) for face in faces)
        return WarpTask(Box.of(photo), pairs, tuple(faces), recipe)

    @cached_property
    def target_px(self) -> Array:
        """Targets of all landmarks, shape (N, 2)."""
        return np.vstack([pairs.target_px for pairs in self.pairs])

    @cached_property
    def displacement_px(self) -> Array:
        """Requested backward displacement at the targets, shape (N, 2)."""
        return np.vstack([pairs.displacement_px for pairs in self.pairs])

    @property
    def spacing_px(self) -> float:
        """Mean landmark spacing of the faces."""
        return float(np.mean([face.anchor.spacing_px for face in self.faces]))

    @property
    def step_px(self) -> int:
        """Node spacing of an interpolated field."""
        return max(1, min(_MOST_STEP_PX, int(self.spacing_px / _NODES_A_SPACING)))

    def anchored(self, *, edges: bool = True) -> tuple[Array, Array]:
        """Return targets and displacements together with the fixed points of the references.

        The corners of eyes and mouth are fixed, as features, mesh vertices and handles are in the
        references. With `edges` 16 points on the photo's border are fixed, too, for methods whose
        displacement never ends. Result: two of shape (N, 2), px; fixed points last.
        """
        fixed = [np.vstack([face.eyes, face.mouth]) for face in self.faces]
        if edges:
            right, bottom = self.image.right - 1, self.image.bottom - 1
            grid = np.array([(x, y) for y in _ALONG for x in _ALONG])
            fixed.append(grid[((grid == 0.0) | (grid == 1.0)).any(axis=1)] * (right, bottom))
        points = np.vstack(fixed)
        target = np.vstack([self.target_px, points])
        return target, np.vstack([self.displacement_px, np.zeros_like(points)])

    def around(self, margin_px: float) -> Box:
        """Return the box of all landmarks and targets plus a margin, clipped to the photo."""
        points = np.vstack([self.target_px, self.target_px + self.displacement_px])
        low, high = points.min(axis=0) - margin_px, points.max(axis=0) + margin_px
        corners = np.concatenate([np.floor(low), np.ceil(high) + 1.0]).astype(int).tolist()
        return Box(*corners).clipped(self.image)


class Warp(Protocol):
    """A method fitted to a task: the output at x shows the photo at ``x + displacement``."""

    def at(self, points_px: Array) -> Array:
        """Return the backward displacement at points of shape (N, 2), px."""

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        """Return the displacement on the grid ``ys x xs``, shape (2, len(ys), len(xs)), px."""

    def pixels(self, photo: Image) -> Image:
        """Return the warped photo, resampled bilinearly."""


@dataclass(frozen=True, eq=False)
class Interpolated:
    """A displacement at the middles of square cells, linear between, zero outside the cells."""

    left: int  # of the first cell, px
    top: int
    step_px: int  # side of a cell
    nodes: Array  # (rows, columns, 2): backward displacement, px

    @staticmethod
    def of(at: Callable[[Array], Array], box: Box, step_px: int) -> Interpolated:
        """Evaluate a displacement, which takes points (N, 2), on cells that cover a box."""
        # One more cell on each side, so that pixels at the border have a node on both sides.
        left, top = box.left - step_px, box.top - step_px
        columns, rows = (-(-side // step_px) + 2 for side in (box.width, box.height))
        empty = Interpolated(left, top, step_px, np.empty((rows, columns, 2)))
        points = np.stack(np.meshgrid(*empty.axes_px), axis=-1).reshape(-1, 2)
        parts = [at(points[k : k + _STRIP]) for k in range(0, len(points), _STRIP)]
        nodes = np.concatenate(parts).reshape(rows, columns, 2)
        return dataclasses.replace(empty, nodes=nodes)

    @property
    def axes_px(self) -> tuple[Array, Array]:
        """The coordinates of the nodes, x and y."""
        rows, columns = self.nodes.shape[:2]
        middle = (self.step_px - 1) / 2.0
        xs: Array = self.left + self.step_px * np.arange(columns, dtype=np.float64) + middle
        ys: Array = self.top + self.step_px * np.arange(rows, dtype=np.float64) + middle
        return xs, ys

    def weights(self, points_px: Array) -> tuple[Array, Array]:
        """Return the flat indices of the four nodes around points, and their weights, (4, N)."""
        rows, columns = self.nodes.shape[:2]
        middle = (self.step_px - 1) / 2.0
        at = (points_px - (self.left + middle, self.top + middle)) / self.step_px
        cell = np.clip(np.floor(at), 0, (columns - 2, rows - 2))
        s, t = (at - cell).T
        inside = ((at >= -0.5) & (at <= (columns - 0.5, rows - 0.5))).all(axis=1)
        first = (cell[:, 1] * columns + cell[:, 0]).astype(np.intp)
        index = first + np.array([0, 1, columns, columns + 1])[:, None]
        # Outermost nodes hold for their cells' outer halves.
        s, t = np.clip(s, 0.0, 1.0), np.clip(t, 0.0, 1.0)
        weight = np.stack([(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t])
        return index, weight * inside

    def at(self, points_px: Array) -> Array:
        """Return the backward displacement at points of shape (N, 2), px."""
        index, weight = self.weights(np.asarray(points_px, np.float64))
        return np.asarray((weight[..., None] * self.nodes.reshape(-1, 2)[index]).sum(axis=0))

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        """Return the displacement on the grid ``ys x xs``, shape (2, len(ys), len(xs)), px."""
        points = np.stack(np.meshgrid(xs_px, ys_px), axis=-1)
        return self.at(points.reshape(-1, 2)).reshape(points.shape).transpose(2, 0, 1)

    def pixels(self, photo: Image) -> Image:
        """Return the warped photo; only the box of the nodes that move is resampled."""
        result = photo.copy()
        moving = np.hypot(self.nodes[..., 0], self.nodes[..., 1]) > LOSSLESS_PX
        if not moving.any():
            return result
        rows, columns = (np.flatnonzero(moving.any(axis=axis)) for axis in (1, 0))
        # One more node on each side: the displacement falls below the limit between nodes.
        first = np.maximum([rows[0] - 1, columns[0] - 1], 0)
        last = np.minimum([rows[-1] + 2, columns[-1] + 2], moving.shape)
        part = self.nodes[first[0] : last[0], first[1] : last[1]].astype(np.float32)
        width, height = self.step_px * part.shape[1], self.step_px * part.shape[0]
        left, top = self.left + self.step_px * first[1], self.top + self.step_px * first[0]
        cells = Box(int(left), int(top), int(left) + width, int(top) + height)
        box = cells.clipped(Box.of(photo))
        field = np.asarray(cv2.resize(part, (width, height), interpolation=cv2.INTER_LINEAR))
        field = field[box.top - cells.top :, box.left - cells.left :][: box.height, : box.width]
        x = field[..., 0] + np.arange(box.left, box.right, dtype=np.float32)
        y = field[..., 1] + np.arange(box.top, box.bottom, dtype=np.float32)[:, None]
        border = cv2.BORDER_REPLICATE
        result[box.slices] = cv2.remap(photo, x, y, cv2.INTER_LINEAR, borderMode=border)
        return result


@dataclass(frozen=True, slots=True)
class Method:
    """A way to warp a photo so that landmarks move to their targets."""

    name: str  # in file names
    title: str
    reference: str  # a number refers to the paper's list
    fit: Callable[[WarpTask], Warp]


@dataclass(frozen=True, eq=False)
class _FieldWarp:
    """A displacement field of the engine, resampled in its lossless domain."""

    field: Field

    def at(self, points_px: Array) -> Array:
        return self.field.at(points_px)

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        return self.field.on_grid(xs_px, ys_px)

    def pixels(self, photo: Image) -> Image:
        canvas = Canvas(photo)
        canvas.warp(self.field, domain_of(self.field, Box.of(photo), "threshold"), "bilinear")
        return canvas.pixels


def _spline(task: WarpTask, name: Fit, pairs: Sequence[FacePairs]) -> Field:
    anchors = [face.anchor for face in task.faces]
    recipe = dataclasses.replace(task.recipe, fit=name)
    return Field(fit(pairs, anchors, [recipe] * len(anchors)))


def bspline(name: Fit, title: str, reference: str) -> Method:
    """Return one of the fits of the control lattice as a method: one lattice for each face."""
    return Method(name, title, reference, lambda task: _FieldWarp(_spline(task, name, task.pairs)))


def _squares(points: Array, others: Array) -> Array:
    """Return the squared distances between points (N, 2) and others (M, 2), shape (N, M)."""
    apart = np.square(np.subtract.outer(points[:, 0], others[:, 0]))
    apart += np.square(np.subtract.outer(points[:, 1], others[:, 1]))
    return np.asarray(apart)


def _thin_plate(task: WarpTask) -> Warp:
    """Fit the surface with the least bending through all points; unbounded."""
    target, displacement = task.anchored()
    middle, unit_px = target.mean(axis=0), task.spacing_px

    def basis(points: Array) -> Array:
        apart = _squares(points / unit_px, target / unit_px)
        plate = apart * np.log(np.maximum(apart, 1e-300))
        return np.column_stack([plate, np.ones(len(points)), (points - middle) / unit_px])

    known = basis(target)
    affine = known[:, len(target) :]
    whole = np.vstack([known, np.column_stack([affine.T, np.zeros((3, 3))])])
    weights = np.linalg.solve(whole, np.vstack([displacement, np.zeros((3, 2))]))
    return Interpolated.of(lambda points: basis(points) @ weights, task.image, task.step_px)


def _gaussians(task: WarpTask) -> Warp:
    """Fit a sum of Gaussians, one per landmark, through all landmarks; bounded."""
    target, displacement = task.anchored(edges=False)
    width_px = _WIDTH_SPACINGS * task.spacing_px

    def basis(points: Array) -> Array:
        return np.exp(-_squares(points / width_px, target / width_px))

    weights = np.linalg.solve(basis(target), displacement)
    # Even if all Gaussians had their centre on the landmark nearest to a point, they would move
    # the point by less than LOSSLESS_PX at this distance.
    most_px = max(float(np.abs(weights).sum(axis=0).max()), 2.0 * LOSSLESS_PX)
    reach_px = width_px * float(np.sqrt(np.log(most_px / LOSSLESS_PX)))
    box = task.around(reach_px)
    return Interpolated.of(lambda points: basis(points) @ weights, box, task.step_px)


def _moving_least_squares(task: WarpTask) -> Warp:
    """Find the most rigid map near each node (Schaefer, McPhail, Warren 2006); unbounded.

    Weights fall with the square of the distance.
    """
    target_px, displacement_px = task.anchored()
    # Coordinates relative to the mean reduce rounding errors of products.
    middle = target_px.mean(axis=0)
    rest = target_px - middle
    goal = rest + displacement_px
    # In the complex plane a rotation with a scale is one factor; the best factor is a ratio of
    # weighted sums of the positions, of the goals, and of conj(position) * goal.
    turned = np.column_stack(
        [(rest * goal).sum(axis=1), rest[:, 0] * goal[:, 1] - rest[:, 1] * goal[:, 0]]
    )
    summed = np.column_stack([np.ones(len(rest)), rest, goal, turned])

    def at(points_px: Array) -> Array:
        x, y = np.ascontiguousarray((points_px - middle).T)
        apart = np.maximum(_squares(points_px - middle, rest), _NEAREST_PX**2)
        total, *sums = (np.reciprocal(apart, out=apart) @ summed).T
        from_x, from_y, goal_x, goal_y, along, across = (one / total for one in sums)
        along -= from_x * goal_x + from_y * goal_y
        across -= from_x * goal_y - from_y * goal_x
        # A rigid map keeps only the rotation of the factor.
        size = np.hypot(along, across)
        along[size == 0.0], size[size == 0.0] = 1.0, 1.0
        along, across = along / size, across / size
        u, v = x - from_x, y - from_y
        return np.column_stack(
            [along * u - across * v + goal_x - x, across * u + along * v + goal_y - y]
        )

    return Interpolated.of(at, task.image, task.step_px)


THIN_PLATE: Final = Method("thin-plate", Text("Thin-plate spline"), "[6]", _thin_plate)
RADIAL: Final = Method("radial", Text("Radial basis functions, Gaussian"), "[5]", _gaussians)
MOVING_LEAST_SQUARES: Final = Method(
    "moving",
    Text("Moving least squares, rigid"),
    Text("Schaefer et al. 2006"),
    _moving_least_squares,
)
METHODS: Final[tuple[Method, ...]] = (
    *(bspline(fit.name, Text("B-spline, {fit}", fit=fit.word), fit.reference) for fit in FITS),
    THIN_PLATE,
    RADIAL,
    MOVING_LEAST_SQUARES,
)
