"""The displacement field of all faces together: displacement, Jacobian, residual."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, curve, points_of, smoothstep
from kogao_core.faces.targets import FacePairs
from kogao_core.field.protection import NOTHING, Protection, axes, share, slopes_on_grid
from kogao_core.paper.lattice import Lattice, Spline

_INVERSION_STEPS: Final = 64  # most iterations of `shown_at`
_INVERTED_PX: Final = 1e-4  # largest error of a converged point, px
# Most extrapolation of a step, in previous steps: near a fold the secant is unreliable.
_MOST_AHEAD: Final = 32.0


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """Backward displacement ``d(x)``: the result at x shows the photo at ``x + d(x)``.

    `at` evaluates the displacement at points, `on_grid` and `det_jacobian` on an ascending grid.

    Parameters
    ----------
    lattices : tuple of Lattice
        One for each face, then the lattices of brush strokes; displacements add up.
    fade_px : float
        Displacements shorter than this fade to zero, smoothly over this length to twice this
        length (section 4.2 without its step); 0 leaves the spline unchanged.
    protection : Protection
        Regions where the displacement fades to zero.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> photo = kogao.read(kogao.sample())
    >>> face = kogao.template_face((450, 480), 400)
    >>> field = kogao.render(photo.pixels, [face], kogao.Recipe(percent=5)).field
    >>> field.at([(450.0, 640.0)]).shape, field.on_grid([0, 1, 2], [5, 6]).shape
    ((1, 2), (2, 2, 3))
    >>> field.det_jacobian([0, 1, 2], [5, 6]).shape
    (2, 3)
    """

    lattices: tuple[Lattice, ...]
    fade_px: float = 0.0
    protection: Protection = NOTHING

    @property
    def _spline(self) -> Spline:
        """The sum of the lattices, without fade and protection."""
        return Spline(self.lattices)

    @property
    def is_plain(self) -> bool:
        """True without a fade and without protection."""
        return self.fade_px <= 0.0 and not self.protection.strokes

    def at(self, points_px: npt.ArrayLike) -> Array:
        """Return the displacement at points.

        Parameters
        ----------
        points_px : array of shape (N, 2)
            Points of the result, x and y, px.

        Returns
        -------
        array of shape (N, 2)
            Backward displacement, px.
        """
        points = points_of(points_px)
        displacement = self._spline.at(points)
        if self.is_plain:
            return displacement
        displacement = displacement * fade(np.hypot(*displacement.T), self.fade_px)[:, None]
        x, y = points.T
        return displacement * share(self.protection.strokes, x, y, displacement.T)[:, None]

    def on_grid(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        """Return the displacement on a grid; much faster than at single points.

        Parameters
        ----------
        xs_px, ys_px : array of shape (N,) and (M,)
            Ascending coordinates of the grid, px.

        Returns
        -------
        array of shape (2, M, N)
            x and y component of the backward displacement, px.
        """
        displacement = self._spline.on_grid(xs_px, ys_px)
        if self.is_plain:
            return displacement
        displacement = displacement * fade(np.hypot(*displacement), self.fade_px)
        return displacement * share(self.protection.strokes, *axes(xs_px, ys_px), displacement)

    def protected_share(self, points_px: Array) -> Array:
        """Return the share of the displacement that protection leaves at points.

        Parameters
        ----------
        points_px : array of shape (N, 2)
            Points of the result, x and y, px.

        Returns
        -------
        array of shape (N,)
            0 where nothing moves, 1 without protection.
        """
        unprotected = dataclasses.replace(self, protection=NOTHING)
        x, y = points_px.T
        return share(self.protection.strokes, x, y, unprotected.at(points_px).T)

    def det_jacobian(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> Array:
        """Return the Jacobian determinant of ``x + d(x)`` on a grid.

        Parameters
        ----------
        xs_px, ys_px : array of shape (N,) and (M,)
            Ascending coordinates of the grid, px.

        Returns
        -------
        array of shape (M, N)
            Below 1 the result is stretched, above 1 compressed; 0 or less is a fold.
        """
        return det_of(*self.slopes(xs_px, ys_px))

    def slopes(self, xs_px: npt.ArrayLike, ys_px: npt.ArrayLike) -> tuple[Array, Array]:
        """Return the derivatives of the displacement along x and along y on a grid.

        Without a fade and protection the slopes of several fields add up.

        Parameters
        ----------
        xs_px, ys_px : array of shape (N,) and (M,)
            Ascending coordinates of the grid, px.

        Returns
        -------
        along_x, along_y : array of shape (2, M, N)
            Derivatives of the x and y component, px per px.
        """
        along_x, along_y = self._spline.slopes(xs_px, ys_px)
        if not self.is_plain:
            displacement = self._spline.on_grid(xs_px, ys_px)
            if self.fade_px > 0.0:
                along_x, along_y = self._faded_slopes(displacement, along_x, along_y)
                displacement = displacement * fade(np.hypot(*displacement), self.fade_px)
            if self.protection.strokes:
                around = xs_px, ys_px, displacement
                along_x, along_y = slopes_on_grid(
                    self.protection.strokes, *around, along_x, along_y
                )
        return along_x, along_y

    def _faded_slopes(
        self, displacement: Array, along_x: Array, along_y: Array
    ) -> tuple[Array, Array]:
        # (f(|d|) d)' = f d' + f'(|d|) |d|' d
        length = np.hypot(displacement[0], displacement[1])
        factor, slope = fade(length, self.fade_px), _fade_slope(length, self.fade_px)
        unit = displacement / np.where(length > 0.0, length, 1.0)
        grown_x = factor * along_x + slope * (unit * along_x).sum(axis=0) * displacement
        grown_y = factor * along_y + slope * (unit * along_y).sum(axis=0) * displacement
        return grown_x, grown_y


def det_of(along_x: Array, along_y: Array) -> Array:
    """Return det(I + D) for slopes D.

    `along_x`, `along_y` (2, ...), px per px. Result: of shape (...).
    """
    return np.asarray((1.0 + along_x[0]) * (1.0 + along_y[1]) - along_x[1] * along_y[0])


def fade(length_px: Array, threshold_px: float) -> Array:
    """Return the smoothstep of displacement lengths over [T, 2T]; 1 everywhere when T = 0.

    Result: 0 to 1, of the shape of `length_px`.
    """
    if threshold_px <= 0.0:
        return np.ones_like(length_px)
    return smoothstep(length_px / threshold_px - 1.0)


def _fade_slope(length_px: Array, threshold_px: float) -> Array:
    t = np.clip(length_px / threshold_px - 1.0, 0.0, 1.0)
    return np.asarray(6.0 * t * (1.0 - t) / threshold_px)


class Displacing(Protocol):
    """A backward displacement, such as a `Field` or the field of another method."""

    def at(self, points_px: Array, /) -> Array:
        """Return the displacement at points of shape (N, 2), px."""


def shown_at(field: Displacing, source_px: Array, start_px: Array | None = None) -> Array:
    """Return where the result shows points of the photo: solves ``x + d(x) = source``.

    Parameters
    ----------
    field : Field
        The backward displacement, such as `Rendering.field`.
    source_px : array of shape (N, 2)
        Points of the photo, x and y, px.
    start_px : array of shape (N, 2), optional
        First guess; the points themselves by default.

    Returns
    -------
    array of shape (N, 2)
        Points of the result, px, to 0.0001 px where the field doesn't fold.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> photo = kogao.read(kogao.sample())
    >>> face = kogao.template_face((450, 480), 400)
    >>> rendering = kogao.render(photo.pixels, [face], kogao.Recipe(percent=5))
    >>> chin = kogao.shown_at(rendering.field, face.outline[10:11])
    >>> bool(abs(chin - rendering.pairs[0].target_px[10]).max() < 0.01)
    True
    """
    if not hasattr(field, "at"):
        given = type(field).__name__
        raise TypeError(f"expected a Field such as rendering.field, got {given}")
    source_px = points_of(source_px)
    x = np.array(source_px if start_px is None else start_px, np.float64)
    left, miss, move = np.arange(len(x)), np.zeros_like(x), np.zeros_like(x)
    for turn in range(_INVERSION_STEPS):
        last, miss = miss, source_px[left] - field.at(x[left]) - x[left]
        move = _accelerated(miss, last, move) if turn else miss
        x[left] += move
        far = np.abs(miss).max(axis=1) >= _INVERTED_PX
        if not far.any():
            break
        left, miss, move = left[far], miss[far], move[far]
    return x


def inverted(displacement: Callable[[Array], Array], points: Array, steps: int) -> Array:
    """Return where points of shape (N, 2) are shown, px: solve ``x + d(x) = point`` in `steps`."""
    shown = points
    for _ in range(steps):
        shown = points - displacement(shown)
    return shown


def _accelerated(miss: Array, last: Array, move: Array) -> Array:
    """Return the next moves of points, by Anderson acceleration of depth 1 (Anderson 1965).

    `miss` and `last` are the current and the previous error, `move` is the previous move. The
    plain iteration (`miss` alone) converges slowly or not at all near a fold.
    """
    change = miss - last
    share = (change * miss).sum(axis=1) / np.maximum((change**2).sum(axis=1), 1e-30)
    return np.asarray(miss - np.clip(share, -_MOST_AHEAD, 1.0)[:, None] * (move + change))


@dataclass(frozen=True, slots=True)
class Residual:
    """Distance between actual and requested displacement, px: at the targets and between them.

    Between targets, the curve through the targets gives the requested displacement. A landmark may
    land up to 4 % nearer to its target (see `shown_at`): the displacement differs where it lands.
    """

    mean_px: float
    max_px: float
    contour_mean_px: float
    contour_max_px: float


def residual(field: Field, pairs: Sequence[FacePairs]) -> Residual:
    """Compare the field with the displacement requested by landmarks and the curve through them.

    Result: all zeros without a face.
    """
    if not pairs:
        return Residual(0.0, 0.0, 0.0, 0.0)
    wanted = [np.hstack([p.target_px, p.displacement_px]) for p in pairs]
    requested = np.concatenate([*wanted, *(curve(each) for each in wanted)])
    missed = np.linalg.norm(field.at(requested[:, :2]) - requested[:, 2:], axis=1)
    points, between = np.split(missed, [sum(len(each) for each in wanted)])
    return Residual(
        float(points.mean()), float(points.max()), float(between.mean()), float(between.max())
    )
