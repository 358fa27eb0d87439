"""Straight edges of the background near a face, as soft maps in twelve directions.

No edge is found or left out by a decision. Every weight is a continuous function of the photo, so
two shots of the same scene give nearly the same result.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.background.people import Opacity, PersonLook
from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.landmarks.pixels import Pyramid

_WEAK: Final = 2.0  # weaker edges don't count; grey levels per px of the look
_STRONG: Final = 8.0  # stronger edges count in full; the same unit
_BLUR_PX: Final = 1.1  # blur before the gradient (standard deviation); larger: less noise
# People are grown by this before edges count: hair stands off. All lengths below are in lattice
# spacings unless they are px of the look.
_MARGIN: Final = 0.3
_DIRECTIONS: Final = 12  # directions of an edge over a half turn; larger: slower
_POOL_PX: Final = 4  # edges are summed over squares of this side
_SPREAD: Final = 0.6  # standard deviation of the blur of the sums
# An edge stands out by what its direction has beyond this many times the median of all: texture
# has the same in all directions.
_TEXTURE: Final = 1.5
_AROUND: Final = 1.25  # standard deviation of a further blur of that median; larger: calmer
# Distances between the two places of a row. The shortest holds the ends of lines beside a head.
_ARMS: Final = (0.6, 1.0, 2.0, 4.0)
_CHECKED: Final = 2.0  # from this distance on, the edge must also be seen halfway
# Edges as long as this shall not shift across either: where nothing else moves them, they stay.
_LONG: Final = 4.0
_WEIGHT: Final = 2200.0  # weight of a row of full contrast; larger: edges turn and bend less
_STAYS: Final = 60.0  # the same against a shift of a long edge; larger: hair beside gives way
# Subtracted from each weight, so that rows fade out instead of coming and going.
_LEAST: Final = 2e-3
# Up to about this weight, rows count with the square of their weight, so that a faint edge that
# noise makes come and go does little. Larger: faint edges turn more, shaken photos change less.
_FAINT: Final = 0.045
# Rows so near to a line that is let go lose all weight; from twice as far, none.
_LOOSE: Final = 1.2
_PERSON: Final = 0.3  # places of less opacity are left out; from there to 1 they count more


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Differences of the displacement along edges near a face that a warp should keep at zero.

    A row requires that ``normal . (d(a) - tied d(b)) = 0`` for the displacement d at two places a,
    b on a line: with `tied` 1 the line neither turns nor bends, with `tied` 0 it stays.
    """

    places_px: Array  # (S, 2, 2)
    tied: Array  # (S,)
    normals: Array  # (S, 2)
    weights: Array  # (S,)
    people_px: Array  # (P, 2): places on people, which keep their displacement
    opacities: Array  # (P,): how sure it is that a person is there, 0 to 1
    spacing_px: float = 1.0  # landmark spacing of the face

    def mapped(self, transform: Affine) -> Edges:
        """Return the rows in another image's px."""
        turned = self.normals @ (transform.matrix / transform.scale).T
        places = transform(self.places_px.reshape(-1, 2)).reshape(-1, 2, 2)
        people, spacing = transform(self.people_px), self.spacing_px * transform.scale
        return Edges(places, self.tied, turned, self.weights, people, self.opacities, spacing)

    def without(self, lines: Array) -> Edges:
        """Return edges with weight 0 on the lines (N, 2, 2) and on parallel edges nearby."""
        keep, reach_px = np.ones(len(self.weights)), _LOOSE * self.spacing_px
        for start, end in lines:
            along = (end - start) / max(1e-9, float(np.hypot(*(end - start))))
            offsets = self.places_px.mean(axis=1) - start
            forth = np.clip(offsets @ along, 0.0, float(np.hypot(*(end - start))))
            away = np.hypot(*(offsets - forth[:, None] * along).T) / reach_px
            alike = np.abs(self.normals @ np.array([-along[1], along[0]]))
            near = np.clip(2.0 - away, 0.0, 1.0) * np.clip((alike - 0.8) / 0.1, 0.0, 1.0)
            keep *= 1.0 - near
        return replace(self, weights=self.weights * keep)


def no_edges() -> Edges:
    """Return an empty set of rows."""
    none = np.zeros((0, 2))
    return Edges(np.zeros((0, 2, 2)), np.zeros(0), none, np.zeros(0), none, np.zeros(0))


def edges_of(photo: Pyramid, look: PersonLook, spacing_px: float) -> Edges:
    """Find edges in the crop round one face and return a row for each; see `Edges`."""
    side = len(look.opacity)
    h = spacing_px / look.to_image.scale
    density, offset = _densities(photo, look, h)
    near = np.roll(density, 1, 2) + density + np.roll(density, -1, 2)
    middle = np.sort(density, axis=2)[:, :, _DIRECTIONS // 2 - 1 : _DIRECTIONS // 2 + 1]
    # The median of one square is as noisy as an edge, and would count several times.
    texture = cv2.GaussianBlur(middle.mean(axis=2), (0, 0), _AROUND * h / _POOL_PX)
    stands_out = near - 3.0 * _TEXTURE * texture[:, :, None]
    sample = _Sampler(np.clip(stands_out, 0.0, 1.0) ** 2, side)
    axis = np.arange(0.5 * h, side, h)
    places = np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    own, turn, around = (sample.all_of(values, places) for values in (density, offset, near))
    place, channel = np.nonzero(own > 0.0)
    here = own[place, channel]
    direction = np.asarray(channel + np.clip(turn[place, channel] / here, -1.0, 1.0), np.float64)
    weight = sample.at(places[place], direction) * here / np.maximum(around[place, channel], 1e-6)
    # The blur carries edges onto hair beside them; a row with an end there would pull the edge.
    seen = _read(look.opacity, places)
    weight *= (1.0 - seen[place]) ** 2
    on = weight > _LEAST
    place, direction, weight = place[on], direction[on], weight[on]
    angle = direction * (np.pi / _DIRECTIONS)
    way, at = np.stack([np.cos(angle), np.sin(angle)], -1), places[place]
    rows, stays = [], np.zeros(len(at))
    for arm in _ARMS:
        half, end = at + 0.5 * arm * h * way, at + arm * h * way
        product = weight * sample.at(end, direction) * (1.0 - _read(look.opacity, end)) ** 2
        if arm >= _CHECKED:
            product = product * sample.at(half, direction)
        product = np.maximum(product / arm - _LEAST, 0.0)
        product *= product / (product + _FAINT)
        if arm >= _LONG:
            stays += product
        on = product > 0.0
        rows.append((np.stack([at, end], 1)[on], way[on], _WEIGHT * product[on], np.ones(on.sum())))
    on = stays > 0.0
    rows.append((np.stack([at, at], 1)[on], way[on], _STAYS * stays[on], np.zeros(on.sum())))
    pairs, ways, weights, tied = (np.concatenate(part) for part in zip(*rows, strict=True))
    normals = np.stack([-ways[:, 1], ways[:, 0]], -1)
    seen = (seen - _PERSON) / (1.0 - _PERSON)
    person, opacities = places[seen > 0.0], seen[seen > 0.0]
    rows_px = Edges(pairs, tied, normals, weights, person, opacities, h)
    return rows_px.mapped(look.to_image)


def _densities(photo: Pyramid, look: PersonLook, h: float) -> tuple[Array, Array]:
    """Return the density of edges and their angle, for squares of a crop, (R, R, K) each.

    K directions. A density of 1 is one edge of full strength. The angle is the mean difference from
    the direction, in steps between directions, times the density.
    """
    side, (height, width) = len(look.opacity), photo.image.shape[:2]
    picture = photo.sample(look.to_image, side, cv2.BORDER_REPLICATE)
    grey = cv2.transform(np.ascontiguousarray(picture), np.full((1, 3), 1.0 / 3.0))
    grey = cv2.GaussianBlur(np.asarray(grey, np.float32), (0, 0), _BLUR_PX)
    slope_x = cv2.Scharr(grey, cv2.CV_32F, 1, 0, scale=1.0 / 32.0)
    slope_y = cv2.Scharr(grey, cv2.CV_32F, 0, 1, scale=1.0 / 32.0)
    length, angle = cv2.cartToPolar(slope_x, slope_y)
    free = np.clip(1.5 - 2.0 * _grown(look.opacity, _MARGIN * h), 0.0, 1.0)
    strength = (np.clip((length - _WEAK) / (_STRONG - _WEAK), 0.0, 1.0) * free).ravel()
    at = np.flatnonzero(strength)
    x, y = look.to_image(np.column_stack([at % side, at // side])).T
    room = 2.0 * look.to_image.scale
    at = at[
        (np.abs(x - width / 2.0) < width / 2.0 - room)
        & (np.abs(y - height / 2.0) < height / 2.0 - room)
    ]
    rows = -(-side // _POOL_PX)
    cell = at // side // _POOL_PX * rows + at % side // _POOL_PX
    tangent = (angle.ravel()[at] + np.pi / 2.0) * (_DIRECTIONS / np.pi)
    low = np.floor(tangent).astype(np.int64)
    part, strength = tangent - low, strength[at]
    sums = []
    for moment in (0, 1):
        total: Array = np.zeros(rows * rows * _DIRECTIONS)
        for step, share, away in ((0, 1.0 - part, part), (1, part, part - 1.0)):
            index = cell * _DIRECTIONS + (low + step) % _DIRECTIONS
            total += np.bincount(index, strength * share * away**moment, len(total))
        shaped = np.asarray(total.reshape(rows, rows, _DIRECTIONS), np.float32)
        sums.append(cv2.GaussianBlur(shaped, (0, 0), _SPREAD * h / _POOL_PX))
    # A blurred edge of full strength is about 2.5 px wide.
    one = _SPREAD * h * np.sqrt(2.0 * np.pi) / 2.5 / _POOL_PX**2
    return np.asarray(one * sums[0], np.float64), np.asarray(one * sums[1], np.float64)


def _read(values: Opacity, places: Array) -> Array:
    """Return the values of a mask at places (N, 2), (N,)."""
    if not len(places):
        return np.zeros(0)
    x, y = np.asarray(places, np.float32).T[..., None]
    seen = cv2.remap(values, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(seen[:, 0], np.float64)


def _grown(opacity: Opacity, radius_px: float) -> Opacity:
    """Return a mask dilated by a disc, blended between the discs of the two nearest whole radii."""
    low = int(radius_px)
    discs = (
        cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
        for radius in (low, low + 1)
    )
    small, large = (cv2.dilate(opacity, disc) for disc in discs)
    return np.asarray(small + (radius_px - low) * (large - small), np.float32)


class _Sampler:
    """Bilinear samples of maps over squares of a look."""

    def __init__(self, stands_out: Array, side: int) -> None:
        self._map, self._rows, self._side = stands_out.reshape(-1), len(stands_out), side

    def _corners(self, places: Array) -> Iterator[tuple[npt.NDArray[np.int64], Array]]:
        """Yield the number of each of the four squares round places (N, 2), and its weight."""
        u = np.clip((places + 0.5) / _POOL_PX - 0.5, 0.0, self._rows - 1.001)
        low = u.astype(np.int64)
        part = u - low
        inside = ((places > -0.5) & (places < self._side - 0.5)).all(axis=1)
        for right in (0, 1):
            for down in (0, 1):
                x, y = np.abs(np.array((1.0 - right, 1.0 - down)) - part).T
                yield (low[:, 1] + down) * self._rows + low[:, 0] + right, x * y * inside

    def all_of(self, values: Array, places: Array) -> Array:
        """Return the values of all directions at places (N, 2), (N, K)."""
        flat = values.reshape(-1, _DIRECTIONS)
        return np.asarray(sum(flat[at] * weight[:, None] for at, weight in self._corners(places)))

    def at(self, places: Array, direction: Array) -> Array:
        """Return the contrast of an edge against other directions at places (N, 2), (N,)."""
        low = np.floor(direction).astype(np.int64)
        part, total = direction - low, np.zeros(len(places))
        for at, weight in self._corners(places):
            one = self._map[at * _DIRECTIONS + low % _DIRECTIONS]
            two = self._map[at * _DIRECTIONS + (low + 1) % _DIRECTIONS]
            total += weight * (one * (1.0 - part) + two * part)
        return total
