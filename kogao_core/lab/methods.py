"""The warps of the paper's references and of today's practice, behind one interface.

Radial functions come from scipy and triangles from scikit-image, the extra ``experiments``; the
rigid form of moving least squares is our own because no library with it is kept up.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box, Image
from kogao_core.base.language import Text
from kogao_core.faces.face import Face
from kogao_core.faces.targets import Pairs, aim
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import FITS, Fit
from kogao_core.warp.canvas import Canvas
from kogao_core.warp.domain import reduce
from kogao_core.warp.field import Field
from kogao_core.warp.fit import fit

_ALONG: Final = np.linspace(0.0, 1.0, 5)  # places of the points that stay along each edge
_GRID_PX: Final = 8  # spacing of interpolated fields
_NEAREST_PX: Final = 1e-6  # a point on a landmark takes that landmark's displacement
_BRUSH_SPACINGS: Final = 1.0  # standard deviation of the brush, in landmark spacings
# Gaussians this wide, in landmark spacings, blend along the outline and end soon beside it.
_GAUSSIAN_SPACINGS: Final = 1.5


@dataclass(frozen=True, eq=False)
class WarpTask:
    """The same points for every method.

    Parameters
    ----------
    image : Box
        The photo's pixels.
    pairs : tuple of Pairs
        Landmarks and targets of each face.
    faces : tuple of Face
        Whose they are; lattices hang on their anchors.
    recipe : Recipe
        Lattice size and kernel for those methods that have them.
    """

    image: Box
    pairs: tuple[Pairs, ...]
    faces: tuple[Face, ...]
    recipe: Recipe

    @staticmethod
    def of(photo: Image, faces: Sequence[Face], recipe: Recipe) -> WarpTask:
        """Return the task of making these faces smaller."""
        pairs = tuple(aim(face, recipe) for face in faces)
        return WarpTask(Box.of(photo), pairs, tuple(faces), recipe)

    @cached_property
    def target_px(self) -> Array:
        """Where all landmarks go, shape (N, 2)."""
        return np.vstack([pairs.target_px for pairs in self.pairs])

    @cached_property
    def displacement_px(self) -> Array:
        """Backward displacement asked for there, shape (N, 2)."""
        return np.vstack([pairs.displacement_px for pairs in self.pairs])

    @property
    def spacing_px(self) -> float:
        """Mean landmark spacing of the faces."""
        return float(np.mean([face.anchor.spacing_px for face in self.faces]))

    def anchored(self, *, edges: bool = True) -> tuple[Array, Array]:
        """Return targets and displacements with what stays, as the references have it.

        Arad's and Litwinowicz's features, Wolberg's mesh and Schaefer's handles lie on all of a
        face: the corners of eyes and mouth stay. So do points round the picture, for methods
        without end. Result: two of shape (N, 2), px; all that stays comes last.
        """
        still = [np.vstack([face.eyes, face.mouth]) for face in self.faces]
        if edges:
            right, bottom = self.image.right - 1, self.image.bottom - 1
            grid = np.array([(x, y) for y in _ALONG for x in _ALONG])
            still.append(grid[((grid == 0.0) | (grid == 1.0)).any(axis=1)] * (right, bottom))
        stays = np.vstack(still)
        target = np.vstack([self.target_px, stays])
        return target, np.vstack([self.displacement_px, np.zeros_like(stays)])


class Warp(ABC):
    """A method fitted to a task: the output at x shows the photo at ``x + displacement``."""

    strip_px: ClassVar[int] = 2**13  # pixels mapped at a time: their weights stay in the cache

    @abstractmethod
    def at(self, points_px: Array) -> Array:
        """Return the backward displacement at points of shape (N, 2), px."""

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        """Return the displacement on the grid ``ys x xs``, shape (2, len(ys), len(xs)), px."""
        xs, ys = np.asarray(xs_px, np.float64), np.asarray(ys_px, np.float64)
        displacement = np.empty((2, len(ys), len(xs)))
        step = max(1, self.strip_px // len(xs))
        for top in range(0, len(ys), step):
            rows = ys[top : top + step]
            points = np.stack(np.meshgrid(xs, rows), axis=-1).reshape(-1, 2)
            displacement[:, top : top + step] = self.at(points).T.reshape(2, len(rows), len(xs))
        return displacement

    def pixels(self, photo: Image, moved: Array | None = None) -> Image:
        """Return the warped photo, bilinear; here the whole of it is resampled, strip by strip.

        Parameters
        ----------
        photo : array of shape (H, W) or (H, W, C)
            Left as it is.
        moved : float64 array of shape (2, H, W), optional
            Filled with the displacement of each pixel.
        """
        height, width = photo.shape[:2]
        result, xs = np.empty_like(photo), np.arange(width)
        step = max(1, self.strip_px // width)
        for top in range(0, height, step):
            ys = np.arange(top, min(top + step, height))
            displacement = self.on_grid(xs, ys)
            if moved is not None:
                moved[:, top : ys[-1] + 1] = displacement
            x, y = (
                (displacement[0] + xs).astype(np.float32),
                (displacement[1] + ys[:, None]).astype(np.float32),
            )
            border = cv2.BORDER_REPLICATE
            result[top : ys[-1] + 1] = cv2.remap(photo, x, y, cv2.INTER_LINEAR, borderMode=border)
        return result


class _Interpolated(Warp):
    """A warp as anyone would run it: its field on a grid of 8 px, linear between, all at once."""

    def __init__(self, warp: Warp) -> None:
        self._warp = warp

    def at(self, points_px: Array) -> Array:
        return self._warp.at(points_px)

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        return self._warp.on_grid(xs_px, ys_px)

    def pixels(self, photo: Image, moved: Array | None = None) -> Image:
        height, width = photo.shape[:2]
        # Nodes in the middles of 8 x 8 px, one row of them outside: so `resize` puts each pixel.
        xs, ys = (np.arange(-_GRID_PX, n + _GRID_PX, _GRID_PX) + 3.5 for n in (width, height))
        nodes = self._warp.on_grid(xs, ys).transpose(1, 2, 0).astype(np.float32)
        size = (_GRID_PX * len(xs), _GRID_PX * len(ys))
        field = np.asarray(cv2.resize(nodes, size, interpolation=cv2.INTER_LINEAR))
        field = field[_GRID_PX : _GRID_PX + height, _GRID_PX : _GRID_PX + width]
        if moved is not None:
            moved[:] = field.transpose(2, 0, 1)
        x = field[..., 0] + np.arange(width, dtype=np.float32)
        y = field[..., 1] + np.arange(height, dtype=np.float32)[:, None]
        border = cv2.BORDER_REPLICATE
        return np.asarray(cv2.remap(photo, x, y, cv2.INTER_LINEAR, borderMode=border))


def interpolated(fit: Callable[[WarpTask], Warp]) -> Callable[[WarpTask], Warp]:
    """Return what fits a method and runs it interpolated."""
    return lambda task: _Interpolated(fit(task))


@dataclass(frozen=True, slots=True)
class Method:
    """A way to warp a photo so that landmarks go to their targets.

    Parameters
    ----------
    name, title : str
        A short name for files, and what people read.
    reference : str
        Where it is described; numbers are those of the paper's list.
    library : str
        Who does the work.
    fit : callable
        Fits the method to a task; raises ImportError if `needs` is absent.
    needs : str
        The module that must be there, "" where none beyond this program's own.
    quick : callable, optional
        Fits it to be run as anyone would, to the same picture within 70 dB, where `fit` asks for
        every pixel, to the letter.
    """

    name: str
    title: str
    reference: str
    library: str
    fit: Callable[[WarpTask], Warp]
    needs: str = ""
    quick: Callable[[WarpTask], Warp] | None = None


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
    """The most rigid map near each pixel (Schaefer, McPhail, Warren 2006).

    Weights fall with the square of the distance, without an end: the edges stay.
    """

    def __init__(self, task: WarpTask) -> None:
        target_px, displacement_px = task.anchored()
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


MOVING_LEAST_SQUARES: Final = Method(
    "moving",
    Text("Moving least squares, rigid"),
    Text("Schaefer et al. 2006"),
    Text("own (numpy)"),
    _Moving,
    quick=interpolated(_Moving),
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
    width_px = _BRUSH_SPACINGS * task.spacing_px
    full = _Pushed(task.target_px, task.displacement_px, width_px).at(task.target_px)
    asked = np.linalg.norm(task.displacement_px, axis=1).mean()
    strength = asked / max(float(np.linalg.norm(full, axis=1).mean()), 1e-12)
    return _Pushed(task.target_px, strength * task.displacement_px, width_px)


LIQUIFY: Final = Method(
    "liquify", Text("Liquify, Gaussian brush"), Text("today's practice"), Text("own (numpy)"),
    _brushed, quick=interpolated(_brushed),
)  # fmt: skip


class _Radial(Warp):
    def __init__(self, target_px: Array, displacement_px: Array, **shape: Any) -> None:
        from scipy.interpolate import RBFInterpolator  # an extra

        self._interpolator = RBFInterpolator(target_px, displacement_px, **shape)

    def at(self, points_px: Array) -> Array:
        return np.asarray(self._interpolator(points_px), np.float64)


def _thin_plate(task: WarpTask) -> Warp:
    """Fit the surface that bends least through all points; it never ends: the edges stay."""
    return _Radial(*task.anchored(), kernel="thin_plate_spline")


def _gaussians(task: WarpTask) -> Warp:
    """Fit a Gaussian on each landmark, together through all of them; they end by themselves."""
    epsilon = 1.0 / (_GAUSSIAN_SPACINGS * task.spacing_px)
    return _Radial(*task.anchored(edges=False), kernel="gaussian", epsilon=epsilon, degree=-1)


class _Piecewise(Warp):
    """Map each of the Delaunay triangles of all points affinely."""

    strip_px: ClassVar[int] = 2**16  # each asks every triangle

    def __init__(self, task: WarpTask) -> None:
        from skimage.transform import PiecewiseAffineTransform  # an extra

        self._target, displacement = task.anchored()
        self._source = self._target + displacement
        self._transform = PiecewiseAffineTransform.from_estimate(self._target, self._source)

    def at(self, points_px: Array) -> Array:
        shown = np.asarray(self._transform(points_px), np.float64)
        # Rounding puts points of the rim outside all triangles; both coordinates say -1 there.
        outside = (shown == -1.0).all(axis=1)
        return np.where(outside[:, None], 0.0, shown - points_px)


class _Triangles(_Piecewise):
    """The same, run triangle by triangle by OpenCV."""

    def pixels(self, photo: Image, moved: Array | None = None) -> Image:
        from scipy.spatial import Delaunay  # an extra

        if moved is not None:
            moved[:] = self.on_grid(*(np.arange(n) for n in photo.shape[1::-1]))
        result = photo.copy()
        targets, sources = self._target.astype(np.float32), self._source.astype(np.float32)
        for corners in Delaunay(targets).simplices:
            target, source = targets[corners], sources[corners]
            left, top, width, height = cv2.boundingRect(target)
            mask = np.zeros((height, width), np.uint8)
            cv2.fillConvexPoly(mask, np.round(target - (left, top)).astype(np.int32), 1)
            affine = cv2.getAffineTransform(target - np.array((left, top), np.float32), source)
            flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
            part = cv2.warpAffine(
                photo, affine, (width, height), flags=flags, borderMode=cv2.BORDER_REPLICATE
            )
            box = (slice(top, top + height), slice(left, left + width))
            cv2.copyTo(part, mask, result[box])
        return result


THIN_PLATE: Final = Method(
    "thin-plate", Text("Thin-plate spline"), "[6]", "scipy", _thin_plate, needs="scipy",
    quick=interpolated(_thin_plate),
)  # fmt: skip
RADIAL: Final = Method(
    "radial",
    Text("Radial basis functions, Gaussian"),
    "[5]",
    "scipy",
    _gaussians,
    needs="scipy",
    quick=interpolated(_gaussians),
)
PIECEWISE_AFFINE: Final = Method(
    "mesh", Text("Piecewise-affine mesh"), "[4]", "scikit-image", _Piecewise,
    needs="skimage",
    quick=_Triangles,
)  # fmt: skip


METHODS: Final[tuple[Method, ...]] = (
    *(bspline(fit.name, Text("B-spline, {fit}", fit=fit.word), fit.reference) for fit in FITS),
    THIN_PLATE,
    RADIAL,
    PIECEWISE_AFFINE,
    MOVING_LEAST_SQUARES,
    LIQUIFY,
)
