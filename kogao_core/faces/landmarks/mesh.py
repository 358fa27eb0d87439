"""The 478-point face mesh and the landmark source built on it."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Final, NamedTuple

import cv2
import numpy as np

from kogao_core.base import assets
from kogao_core.base.geometry import Affine, Array, Image, degrees_of
from kogao_core.base.threads import ObjectPool, one_blas_thread
from kogao_core.faces.doubt import ON_ITS_HEAD
from kogao_core.faces.face import Face, OnFace, ignored, in_reading_order
from kogao_core.faces.landmarks import locked, search
from kogao_core.faces.landmarks.blazeface import (
    CLOSE,
    INPUT_PX,
    SURE,
    WIDE,
    BlazeFace,
    Detection,
    Square,
    are_opposite,
)
from kogao_core.faces.landmarks.edges import MODEL, EdgeNetwork
from kogao_core.faces.landmarks.outline import forehead, joined, silhouette
from kogao_core.faces.landmarks.pixels import Pyramid, planes, read_network, sharpened

EYES: Final = (33, 133, 362, 263)
MOUTH: Final = (61, 291)
# Least score of a face. On the test photographs real faces score 0.5 to 0.95, patterns up to 0.48.
LEAST_SCORE: Final = 0.5
# Least score next to a sure face of similar size: half a face behind a head scores 0.3 to 0.5.
LEAST_IN_COMPANY: Final = 0.3

_CROP: Final = 1.5  # side of the crop, in sides of the face
# Another face's features, enlarged by `_AROUND_FEATURES`, may attract the mesh if they are within
# `_BESIDE` half sides of the face's box. Farther features move the mesh by less than 1 %.
_AROUND_FEATURES: Final = 1.3
_BESIDE: Final = 0.9
# Scale of the difference between two passes, in outer inter-ocular distances. Passes of a real face
# differ by 0.01 (95 % below 0.03), passes of a false face by 0.05 to 1.
_DIFFER: Final = 0.1
# Passes with a smaller difference, in outer inter-ocular distances, have settled; most settle at
# the second pass.
_SETTLED: Final = 0.03
_MOST_PASSES: Final = 3  # more passes drift away from hard faces
# Middle of a sigmoid over the network's log-odds, which would saturate in a plain sigmoid. 99 % of
# correct fits are above 3, half of the wrong fits below -3, a cat at 1.0.
_PRESENCE_MIDDLE: Final = -1.5
_PRESENCE_WIDTH: Final = 0.75  # of that sigmoid, in log-odds; larger: a softer decision
_NO_PRESENCE: Final = -8.0  # log-odds; a lower value ends the passes early
# Weight of the wide view in the score: it separates faces better than the close view, and both
# together separate best.
WIDE_SHARE: Final = 0.7
_DOUBT: Final = 0.86  # a face with a lower score is also fitted upside down
# Weight of an upside-down face's score against an upright face's. On 75 portraits with drawn masks,
# scarfs and veils, the false face scored more than the true face in a third, up to 1.22 times as
# much.
_ON_ITS_HEAD_SHARE: Final = 0.75
_CONTRADICTED: Final = 0.8  # factor of the score of a face that only this weight prefers

_AT_CORNER: Final = 0.06  # half side of the square at a corner, in inter-ocular distances
# Kind of each corner: outer eye (0), inner eye (1), mouth (2). `_CORNERS` are the weights of
# `corner_signs` and the constant for each kind.
KINDS: Final = np.array([0, 1, 1, 0, 2, 2])
_CORNERS: Final = np.array(
    [
        (-1.79, 1.03, -1.53, 0.75, 4.76),
        (-1.17, 1.05, -1.14, 0.56, 3.95),
        (-2.44, 0.59, 2.54, 0.79, 2.50),
    ]
)


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Output of the network for one crop; all px are px of the image."""

    outline: Array  # (21, 2): silhouette from the image's left of the upright face to its right
    eyes: Array  # (4, 2): eye corners, left to right
    mouth: Array  # (2, 2): mouth corners, left to right
    forehead: Array  # (15, 2): the rest of the silhouette, in the same direction
    box: Detection  # the mesh's square, upright along the eye line
    presence: float  # the network's log-odds that there is a face

    def differs_from(self, other: Mesh) -> float:
        """Return the mean distance of eye and mouth corners in outer inter-ocular distances."""
        corners, others = np.vstack([self.eyes, self.mouth]), np.vstack([other.eyes, other.mouth])
        apart = np.linalg.norm(corners - others, axis=1).mean()
        return float(apart / max(1e-6, np.linalg.norm(self.eyes[3] - self.eyes[0])))


@dataclass(frozen=True, slots=True, eq=False)
class MeshInput:
    """A face as the network's input."""

    pixels: Image  # uint8 (256, 256, 3): RGB
    to_image: Affine  # maps pixels of the crop to the image


class Passes(NamedTuple):
    """Repeated passes of the network over a box, each cropped by the previous pass."""

    last: Mesh  # the pass before the final one
    mesh: Mesh  # the final one
    mirrored: Mesh  # the mesh of the mirrored final crop
    crop: MeshInput  # the final crop


class MeshNetwork:
    """The landmark network. Thread-safe."""

    def __init__(self, weights: Path) -> None:
        self._nets = ObjectPool(lambda: read_network(weights))

    def look(self, image: Pyramid, box: Detection) -> tuple[Mesh | None, MeshInput]:
        """Return the mesh of the face in a box, None for a collapsed mesh, and the crop."""
        view = Square(box.center_px, _CROP * box.side_px, box.degrees)
        sampled = image.sample(view.to_image, INPUT_PX, cv2.BORDER_REPLICATE)
        crop = MeshInput(sharpened(sampled), view.to_image)
        points, presence = self._points(crop.pixels)
        return _read(crop.to_image(points), presence, mirrored=False), crop

    def settled(self, image: Pyramid, box: Detection) -> Passes | None:
        """Return the last passes over a box; None if the mesh collapses or no face is present."""
        last, (mesh, crop) = None, self.look(image, box)
        for _ in range(_MOST_PASSES - 1):
            if mesh is None:
                return None
            last, (mesh, crop) = mesh, self.look(image, mesh.box)
            if mesh is None or mesh.presence < _NO_PRESENCE:
                return None
            if mesh.differs_from(last) < _SETTLED:
                break
        mirrored = self.look_mirrored(crop)
        if last is None or mesh is None or mirrored is None:
            return None
        return Passes(last, mesh, mirrored, crop)

    def look_mirrored(self, crop: MeshInput) -> Mesh | None:
        """Return the mesh of the mirrored crop, mirrored back to the image."""
        points, presence = self._points(crop.pixels[:, ::-1])
        points[:, 0] = INPUT_PX - 1 - points[:, 0]
        return _read(crop.to_image(points), presence, mirrored=True)

    def _points(self, pixels: Image) -> tuple[Array, float]:
        with self._nets.one() as net:
            net.setInput(planes(pixels) / 255.0)
            flat, presence = net.forward(["Identity", "Identity_1"])
        # The network's coordinates start at the edge of the first pixel, ours at its centre. The
        # half pixel reduces the bias of the eye corners from 0.4 to 0.1 % of the eyes' distance.
        return flat.reshape(-1, 3)[:, :2].astype(np.float64) - 0.5, float(presence.item())


def _read(points: Array, presence: float, *, mirrored: bool) -> Mesh | None:
    order = slice(None, None, -1) if mirrored else slice(None)
    eyes, mouth = points[list(EYES)][order], points[list(MOUTH)][order]
    try:
        outline, rim = silhouette(points, eyes), forehead(points, eyes)
    except ValueError:
        return None
    box = _box(points, eyes[3] - eyes[0])
    return Mesh(outline, eyes, mouth, rim, box, presence)


def _box(points: Array, across: Array) -> Detection:
    degrees = degrees_of(across)
    upright = Affine.similarity(1.0, -degrees, (0.0, 0.0))
    turned = upright(points)
    low, high = turned.min(axis=0), turned.max(axis=0)
    return Detection(
        upright.inverse((low + high) / 2.0), float((high - low).max()), degrees, score=1.0
    )


def box_of(face: Face) -> Detection:
    """Return approximately the square of a face's mesh."""
    across = face.eyes[3] - face.eyes[0]
    rim = face.outline if face.forehead is None else np.vstack([face.outline, face.forehead])
    return _box(rim, across)


def _features(face: Face) -> Array:
    """Return a polygon around eyes and mouth, px."""
    corners = np.vstack([face.eyes, face.mouth])
    grown = face.middle + _AROUND_FEATURES * (corners - face.middle)
    return np.asarray(cv2.convexHull(grown.astype(np.float32))[:, 0], np.float64)


def _beside(points: Array, box: Detection) -> bool:
    """Return True if any of the points is in the face's box, without the rim of the box."""
    upright = Affine.similarity(1.0, -box.degrees, (0.0, 0.0))
    apart = np.abs(upright(points - box.center_px)).max(axis=1)
    return bool(apart.min() < _BESIDE * box.side_px / 2.0)


class MeshSource:
    """Faces by BlazeFace and the face mesh (section 3.1, with today's networks).

    Loads the networks at first use. Thread-safe. With `refined`, the mesh's silhouette moves onto
    the visible edge, and the confidence is estimated.
    """

    name = "mesh"
    _beards = True

    def __init__(self, *, refined: bool = True) -> None:
        self._refined = refined
        self._lock = threading.Lock()  # a second search at once would need more networks

    @cached_property
    def _detector(self) -> BlazeFace:
        return BlazeFace(locked.network(locked.DETECTOR))

    @cached_property
    def _edges(self) -> EdgeNetwork:
        return EdgeNetwork.read(assets.path(MODEL), beards=self._beards)

    @cached_property
    def _network(self) -> MeshNetwork:
        return MeshNetwork(locked.network(locked.MESH))

    def find(self, rgb: Image, on_face: OnFace = ignored) -> list[Face]:
        """Return the faces of an upright image, see `LandmarkSource`.

        `Face.score` is the detector's probability in closer views, lowered if the passes of the
        mesh disagree or the mesh network finds no face. Raises AssetMissing, ModelRefused,
        ValueError.
        """
        with self._lock, one_blas_thread():
            image = Pyramid.of(rgb)
            faces = search.faces(
                image,
                self._detector,
                lambda box: self._fit(image, box, LEAST_SCORE),
                lambda box: self._fit(image, box, LEAST_IN_COMPANY),
                on_face,
            )
            if not faces:
                image = image.mirrored()
                faces = search.cut_faces(
                    image, self._detector, lambda box: self._fit(image, box, LEAST_SCORE), on_face
                )
            faces = self._told_apart(image, faces)
        return in_reading_order(faces)

    def _told_apart(self, image: Pyramid, faces: list[Face]) -> list[Face]:
        """Return the faces; refit overlapping faces with the features of the others covered."""
        boxes, features = [box_of(face) for face in faces], [_features(face) for face in faces]
        result = []
        for face, box in zip(faces, boxes, strict=True):
            others = [part for one, part in zip(faces, features, strict=True) if one is not face]
            near = [part for part in others if _beside(part, box)]
            fitted = self._fit_in(image.covered(near), box, LEAST_IN_COMPANY) if near else None
            alone = face if fitted is None else replace(fitted.face, score=face.score)
            result.append(alone)
        return result

    def _fit(self, image: Pyramid, proposal: Detection, least: float) -> search.Fitted | None:
        """Return the face at a proposal, or None if a closer look does not confirm the face."""
        boxes, beside = self._detector.look_closer(image, proposal)
        if not boxes:
            return None
        fitted = self._fit_in(image, boxes[0], least)
        if _score(fitted) < _DOUBT:
            # A few percent of upside-down faces are first taken for upright faces, and a few masked
            # faces for upside-down faces, placed higher than the true face.
            over = self._over(image, boxes)
            if over is not None:
                fitted = _likelier(fitted, self._fit_in(image, over, least))
        return None if fitted is None else fitted._replace(beside=beside)

    def _over(self, image: Pyramid, boxes: list[Detection]) -> Detection | None:
        """Return the box of the likeliest face upside down, if that is plausible, else None."""
        for other in boxes[1:]:
            if are_opposite(boxes[0], other):
                return other
        over = replace(boxes[0], degrees=boxes[0].degrees + 180.0, score=0.0)
        return over if self._detector.sight(image, over, WIDE) > LEAST_SCORE else None

    def _fit_in(self, image: Pyramid, box: Detection, least: float) -> search.Fitted | None:
        passes = self._network.settled(image, box)
        if passes is None:
            return None
        last, mesh, mirrored, _ = passes
        trust = _trust(last, mesh, mirrored)
        if trust < least:
            return None
        score = trust * self._sight(image, box, mesh)
        if score < least:
            return None
        face = _mean(mesh, mirrored, score, self.name)
        if self._refined:
            outline, seen = self._edges.refined(image, face.eyes, face.outline)
            confidence = np.concatenate([seen, _sure_corners(passes, seen)])
            face = replace(face, outline=outline, confidence=confidence)
        rim = joined((mesh.forehead + mirrored.forehead) / 2.0, face.outline)
        return search.Fitted(replace(face, forehead=rim), mesh.box)

    def _sight(self, image: Pyramid, box: Detection, mesh: Mesh) -> float:
        if box.score > SURE:
            return box.score
        wide = self._detector.sight(image, mesh.box, WIDE)
        close = self._detector.sight(image, mesh.box, CLOSE, soft=True)
        return WIDE_SHARE * wide + (1.0 - WIDE_SHARE) * close


class ChinSource(MeshSource):
    """Like `MeshSource`, but a bearded face's outline follows the chin instead of the beard."""

    name = "chin"
    _beards = False


def _score(fitted: search.Fitted | None) -> float:
    return 0.0 if fitted is None else fitted.face.score


def _likelier(one: search.Fitted | None, other: search.Fitted | None) -> search.Fitted | None:
    """Return the likelier of two fits. Lower the score if only the orientation decides."""
    worse, better = sorted((one, other), key=_evidence)
    if better is None or _score(better) >= _score(worse):
        return better
    return better._replace(face=replace(better.face, score=_CONTRADICTED * better.face.score))


def _evidence(fitted: search.Fitted | None) -> float:
    """Return the score, reduced for an upside-down face: these are rare and masks resemble them."""
    if fitted is None:
        return 0.0
    on_its_head = abs((fitted.box.degrees + 180.0) % 360.0 - 180.0) > ON_ITS_HEAD
    return fitted.face.score * (_ON_ITS_HEAD_SHARE if on_its_head else 1.0)


def _trust(last: Mesh, mesh: Mesh, mirrored: Mesh) -> float:
    """Return the trust in a mesh, 0 to 1, from the agreement of passes and the presence."""
    differ = max(mesh.differs_from(last), mesh.differs_from(mirrored))
    presence = min(last.presence, mesh.presence, mirrored.presence)
    believed = 1.0 / (1.0 + np.exp((_PRESENCE_MIDDLE - max(presence, -30.0)) / _PRESENCE_WIDTH))
    return float(believed * np.exp(-((differ / _DIFFER) ** 2)))


def corner_signs(passes: Passes, seen: Array) -> Array:
    """Return the predictors of correct eye and mouth corners, shape (6, 4).

    For the eyes and for the mouth: the largest distance between the corners of a crop and of its
    mirror image (log), the network's presence, the mean confidence of the outline, and the least
    detail at the corners relative to the picture's contrast (log).
    """
    _, mesh, mirrored, crop = passes
    one, other = (np.vstack([each.eyes, each.mouth]) for each in (mesh, mirrored))
    unit = max(1e-6, float(np.linalg.norm(mesh.eyes[3] - mesh.eyes[0])))
    apart = np.minimum(np.linalg.norm(one - other, axis=1) / unit, 0.3)
    grey = cv2.cvtColor(crop.pixels, cv2.COLOR_RGB2GRAY).astype(np.float32)
    size = 2 * max(2, int(_AT_CORNER * unit / crop.to_image.scale)) + 1
    variance = cv2.blur(grey**2, (size, size)) - cv2.blur(grey, (size, size)) ** 2
    x, y = np.clip(np.round(crop.to_image.inverse(one)), 0, INPUT_PX - 1).astype(int).T
    spread = np.sqrt(np.maximum(variance[y, x], 0.0))
    detail = np.log((2.0 + spread) / (5.0 + grey.std()))
    presence = np.clip(min(mesh.presence, mirrored.presence), -20.0, 20.0) / 10.0
    parts = slice(0, 4), slice(4, 6)
    rows = [
        (np.log1p(50.0 * apart[part].max()), presence, seen.mean(), detail[part].min())
        for part in parts
    ]
    return np.repeat(rows, [4, 2], axis=0)


def _sure_corners(passes: Passes, seen: Array) -> Array:
    """Return the probability that each corner lies within 5 % of the outer inter-ocular distance.

    Learnt by `python -m resources.training.corners` on covered and blurred faces.
    """
    weights = _CORNERS[KINDS]
    odds = (corner_signs(passes, seen) * weights[:, :-1]).sum(axis=1) + weights[:, -1]
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(odds, -30.0, 30.0))))


def _mean(one: Mesh, other: Mesh, score: float, source: str) -> Face:
    # Averaging with the mirrored crop reduces errors a little (eyes 1.11 to 1.08 %, mouth 1.18 to
    # 1.10 %), and makes the result of a mirrored photo the mirrored result.
    return Face(
        (one.outline + other.outline) / 2.0,
        (one.eyes + other.eyes) / 2.0,
        (one.mouth + other.mouth) / 2.0,
        score=score,
        source=source,
    )
