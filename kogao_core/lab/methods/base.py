"""The interface of every warp, so that all can be compared on the same points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box, Image
from kogao_core.faces.face import Face
from kogao_core.faces.targets import Pairs, aim
from kogao_core.recipe.recipe import Recipe

_ALONG: Final = np.linspace(0.0, 1.0, 5)  # places of the points that stay along each edge
_GRID_PX: Final = 8  # spacing of interpolated fields


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
