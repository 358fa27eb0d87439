"""Segment people near each face, as a soft mask."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.display import Rgb8
from kogao_core.base.geometry import Affine, Array, Box, Image, degrees_of
from kogao_core.base.threads import ObjectPool, parallel_map
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import locked
from kogao_core.faces.landmarks.blazeface import INPUT_PX, Square
from kogao_core.faces.landmarks.pixels import Pyramid, planes, read_network

Opacity = npt.NDArray[np.float32]

_FINE: Final = 2  # pixels of the mask per pixel of the network, along each axis
_SIDES: Final = 3.0  # side of a crop, in longer sides of the face's box
# Radius of the guided filter, and the standard deviation of brightness that it keeps as an edge.
_REACH_PX: Final = 8
_EDGE: Final = 2.5
# A crop is used if at least this share of its face is segmented as a person.
_LEAST_SURE: Final = 0.8
_HALF: Final = 0.5  # places of more opacity are people
_FREE, _TAKEN = np.uint8(1), np.uint8(2)  # 0: outside all crops
# Side of the smallest figure that may be a person and of the smallest that counts in full, in sides
# of a face. An opacity from `_HALF` to the last value nearby makes a figure surely a person.
_LEAST_OTHER: Final = 0.1
_FULL_OTHER: Final = 0.3
_SURE: Final = 0.95
_UNSURE: Final = 3.0  # a point of half a weight counts as so many landmark spacings farther away
_EVERY_PX: Final = 4  # distance between points in a neighbour, px of the network


@dataclass(frozen=True, slots=True, eq=False)
class PersonLook:
    """Segmentation of a crop round one face."""

    opacity: Opacity  # float32 (N, N): 0 is background, 1 a person
    to_image: Affine  # maps its pixels to the photo
    sure: float  # share of the face that is segmented as a person, 0 to 1

    @property
    def box(self) -> Box:
        """Bounding box of the crop, px of the photo; may extend beyond the photo."""
        side = len(self.opacity) - 0.5
        corners = self.to_image([(-0.5, -0.5), (side, -0.5), (side, side), (-0.5, side)])
        low, high = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0)) + 1
        return Box(*low.astype(int).tolist(), *high.astype(int).tolist())


@dataclass(frozen=True, slots=True, eq=False)
class PersonMask:
    """Mask of people, known inside the crops round faces."""

    looks: tuple[PersonLook, ...] = ()  # crops that are sure enough
    missed: int = 0  # number of faces whose crop is not sure enough
    whose: tuple[int, ...] = ()  # index of the face of each crop

    def at(self, points: Array) -> Array:
        """Return the mask at points (H, W, 2): 0 background, 1 a person, NaN outside all crops."""
        shown = np.full(points.shape[:2], np.nan)
        for look in self.looks:
            x, y = np.moveaxis(look.to_image.inverse(points), -1, 0)
            at = x.astype(np.float32), y.astype(np.float32)
            seen = cv2.remap(look.opacity, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            middle = (len(look.opacity) - 1) / 2.0
            within = np.maximum(np.abs(x - middle), np.abs(y - middle)) <= middle + 0.5
            # A crop can miss a neighbour at its edge: the largest value counts.
            shown = np.fmax(shown, np.where(within, seen, np.nan))
        return shown

    def grown(self, share: float) -> PersonMask:
        """Return the mask dilated by `share` of a face's longer side."""
        reach = round(share / _SIDES * _FINE * INPUT_PX)
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
        looks = (
            replace(look, opacity=np.asarray(cv2.dilate(look.opacity, disc), np.float32))
            for look in self.looks
        )
        return replace(self, looks=tuple(looks))

    def neighbours(self, faces: Sequence[Face], others: Sequence[Face] = ()) -> tuple[Array, ...]:
        """Return points (M, 3) on and inside other people, for each face: x, y, and z, px.

        z is how unsure the point is, as a height above the photo: it makes the point's distance
        from places in the photo larger, so that a figure fades out instead of coming and going.
        Another person is a separate figure. A figure that touches the face's own is divided: each
        pixel belongs to the nearest face, in sizes of the faces. Other members of `faces` are left
        out, because their outlines move. Without a mask the points are landmarks of `others`.
        """
        found = []
        for index, face in enumerate(faces):
            rest = [one for one in others if _is_near(one, face)]
            parts = [np.insert(one.points, 2, 0.0, axis=1) for one in rest]
            if index in self.whose:
                parts.append(_others(self.looks[self.whose.index(index)], face, rest))
            found.append(np.concatenate([np.zeros((0, 3)), *parts]))
        return tuple(found)

    def mapped(self, transform: Affine) -> PersonMask:
        looks = (replace(look, to_image=transform.after(look.to_image)) for look in self.looks)
        return replace(self, looks=tuple(looks))

    def free(self, width: int, height: int) -> npt.NDArray[np.uint8]:
        """Return 1 for known background, 0 for people and unknown pixels. uint8 (H, W)."""
        shown = np.zeros((height, width), np.uint8)
        for look, box in self._seen(width, height):
            to_box = Affine(look.to_image.matrix, look.to_image.shift - (box.left, box.top))
            kinds = np.where(look.opacity < _HALF, _FREE, _TAKEN)
            seen = cv2.warpAffine(
                kinds, to_box.opencv, (box.width, box.height), flags=cv2.INTER_NEAREST
            )
            np.maximum(shown[box.slices], seen, out=shown[box.slices])
        return np.asarray(shown == _FREE, np.uint8)

    def picture(self, width: int, height: int) -> Rgb8:
        """Return the mask as uint8 (H, W): 255 is a person, 0 background or unknown."""
        picture = np.zeros((height, width), np.uint8)
        for _, box in self._seen(width, height):
            x, y = np.meshgrid(np.arange(box.left, box.right), np.arange(box.top, box.bottom))
            shown = self.at(np.stack([x, y], axis=-1))
            seen = ~np.isnan(shown)
            picture[box.slices][seen] = np.rint(255.0 * shown[seen])
        return picture

    def _seen(self, width: int, height: int) -> Iterator[tuple[PersonLook, Box]]:
        """Yield each crop that overlaps a photo of this size, with the overlap, px."""
        for look in self.looks:
            box = look.box.clipped(Box(0, 0, width, height))
            if box.area > 0:
                yield look, box


class PersonNetwork:
    """The segmentation network. Thread-safe."""

    def __init__(self, weights: Path) -> None:
        self._nets = ObjectPool(lambda: read_network(weights))

    def look(self, image: Pyramid, face: Face) -> PersonLook:
        """Segment a square crop round a face."""
        view = _view(face)
        fine_px = _FINE * INPUT_PX
        to_image = view.to_image.after(Affine.resize(_FINE, _FINE).inverse)
        picture = image.sample(to_image, fine_px, cv2.BORDER_REPLICATE)
        coarse = cv2.resize(picture, (INPUT_PX, INPUT_PX), interpolation=cv2.INTER_AREA)
        with self._nets.one() as net:
            net.setInput(planes(np.asarray(coarse, np.uint8)) / 255.0)
            rough = cv2.resize(net.forward()[0, 0], (fine_px, fine_px))
        opacity = _refined(rough, picture)
        return PersonLook(opacity, to_image, _of_the_face(opacity, to_image.inverse(face.points)))


class PersonFinder:
    """Segments people near faces and caches the crops of the newest photo. Thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._photo: Callable[[], Image | None] = lambda: None
        self._kept: dict[tuple[float, ...], PersonLook] = {}

    @cached_property
    def _network(self) -> PersonNetwork:
        return PersonNetwork(locked.network(locked.PERSON))

    def find(self, photo: Image | Pyramid, faces: Sequence[Face]) -> PersonMask:
        """Return the mask of people near faces. Raises AssetMissing, ModelRefused."""
        with self._lock:
            image = Pyramid.of(photo)
            known = self._kept if self._photo() is image.image else {}
            new = {key: face for face in faces if (key := _key(face)) not in known}
            made = parallel_map(lambda face: self._network.look(image, face), [*new.values()])
            known = {**known, **dict(zip(new, made, strict=True))}
            looks = [known[_key(face)] for face in faces]
            self._kept = {_key(face): look for face, look in zip(faces, looks, strict=True)}
            self._photo = weakref.ref(image.image)
        sure = [index for index, look in enumerate(looks) if look.sure >= _LEAST_SURE]
        return PersonMask(
            tuple(looks[index] for index in sure), len(looks) - len(sure), tuple(sure)
        )


def _key(face: Face) -> tuple[float, ...]:
    return tuple(face.points.ravel().tolist())


def _view(face: Face) -> Square:
    points = face.points
    low, high = points.min(axis=0), points.max(axis=0)
    degrees = degrees_of(face.eyes[3] - face.eyes[0])
    return Square((low + high) / 2.0, max(1.0, _SIDES * float((high - low).max())), degrees)


def _refined(rough: Opacity, picture: Rgb8) -> Opacity:
    """Align the edge of a mask with the edge in the picture."""
    guide = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    fine = cv2.ximgproc.guidedFilter(guide, rough, _REACH_PX, _EDGE**2)
    return np.asarray(np.clip(fine, 0.0, 1.0), np.float32)


def _others(look: PersonLook, face: Face, rest: Sequence[Face]) -> Array:
    """Return points (M, 3) on people other than the face's own figure; see `neighbours`."""
    opacity = cv2.resize(look.opacity, None, fx=0.5, fy=0.5)
    people = (opacity > _HALF).astype(np.uint8)
    to_image = look.to_image.after(Affine.resize(0.5, 0.5).inverse)
    _, figures, counts, _ = cv2.connectedComponentsWithStats(people, connectivity=8)
    own = _hull(people.shape, to_image.inverse(face.points))
    seen = np.bincount(figures[own > 0], minlength=len(counts))
    sides = np.sqrt(counts[:, cv2.CC_STAT_AREA]) / len(people) * _SIDES
    large = np.clip((sides - _LEAST_OTHER) / (_FULL_OTHER - _LEAST_OTHER), 0.0, 1.0)
    apart = (seen == 0) & (large > 0.0)
    apart[0] = False  # the background
    mask = apart[figures]
    if rest:
        places = to_image(np.indices(people.shape)[::-1].reshape(2, -1).T.astype(np.float64))
        away = _sides_away(places, face)
        nearer = np.logical_or.reduce([_sides_away(places, one) < away for one in rest])
        mask |= (people > 0) & nearer.reshape(people.shape) & (own == 0)
    whole = mask.astype(np.uint8)
    edge = whole - cv2.erode(whole, np.ones((3, 3), np.uint8))
    within = _EVERY_PX * np.argwhere(whole[::_EVERY_PX, ::_EVERY_PX])
    rows, columns = np.concatenate([np.argwhere(edge), within]).T
    near = cv2.dilate(opacity, np.ones((_EVERY_PX + 1,) * 2, np.uint8))[rows, columns]
    size = np.where(apart, large, 1.0)[figures[rows, columns]]
    sure = size * np.clip((near - _HALF) / (_SURE - _HALF), 1e-3, 1.0)
    unsure_px = _UNSURE * face.anchor.spacing_px * (1.0 / sure - 1.0)
    places = to_image(np.column_stack([columns, rows]).astype(np.float64))
    return np.column_stack([places, unsure_px])


def _sides_away(points: Array, face: Face) -> Array:
    """Return the distance of points from the middle of a face, in longer sides of the face."""
    low, high = face.points.min(axis=0), face.points.max(axis=0)
    offsets = points - (low + high) / 2.0
    return np.asarray(np.hypot(offsets[:, 0], offsets[:, 1]) / float((high - low).max()))


def _is_near(one: Face, face: Face) -> bool:
    """Return whether a landmark of one face lies in the crop of another."""
    return bool(_sides_away(one.points, face).min() < _SIDES / 2.0)


def _hull(shape: tuple[int, ...], points: Array) -> npt.NDArray[np.uint8]:
    """Return 1 within the hull of points, 0 elsewhere."""
    face = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(face, np.rint(cv2.convexHull(points.astype(np.float32))).astype(np.int32), 1)
    return face


def _of_the_face(opacity: Opacity, points: Array) -> float:
    """Return the share of a face that is a person, 0 to 1."""
    face = _hull(opacity.shape, points)
    return float(opacity[face > 0].mean()) if face.any() else 0.0
