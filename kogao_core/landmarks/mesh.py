"""The 478-point face mesh and the landmark source built on it."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core import assets
from kogao_core.face import Face
from kogao_core.geometry import Affine, Array, Image
from kogao_core.landmarks import search
from kogao_core.landmarks.blazeface import CLOSE, INPUT_PX, SURE, WIDE, BlazeFace, Detection, View
from kogao_core.landmarks.outline import silhouette
from kogao_core.landmarks.pixels import Pyramid

EYES: Final = (33, 133, 362, 263)
MOUTH: Final = (61, 291)
# Chosen on the photographs at hand: real faces score 0.53 to 0.95 there, patterns up to 0.48.
LEAST_SCORE: Final = 0.5

_SURFACE: Final = 468  # the last ten points are the irises
_CROP: Final = 1.5  # side of the crop, in sides of the face
# In outer inter-ocular distances. Two passes of a real face differ by 0.01 (95 % below 0.03), those
# of a pattern that the detector mistakes for a face by 0.05 to 1.
_DIFFER: Final = 0.1
# Passes that differ less have settled, most at the second; more than three drift off hard faces.
_SETTLED: Final = 0.03
_MOST_PASSES: Final = 3
# The wide look separates faces from the rest better than the close one, both best.
_WIDE_SHARE: Final = 0.7
_DOUBT: Final = 0.86


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """What the network made of one crop; all px of the image.

    Parameters
    ----------
    outline : array of shape (21, 2)
        Silhouette from the image's left of the upright face to its right.
    eyes : array of shape (4, 2)
        Eye corners, left to right.
    mouth : array of shape (2, 2)
        Mouth corners, left to right.
    box : Detection
        The square that the mesh fills, upright along the eye line.
    """

    outline: Array
    eyes: Array
    mouth: Array
    box: Detection

    def differs_from(self, other: Mesh) -> float:
        """Return the mean distance of eye and mouth corners in outer inter-ocular distances."""
        corners, others = np.vstack([self.eyes, self.mouth]), np.vstack([other.eyes, other.mouth])
        apart = np.linalg.norm(corners - others, axis=1).mean()
        return float(apart / max(1e-6, np.linalg.norm(self.eyes[3] - self.eyes[0])))


class MeshNetwork:
    """The landmark network; not thread-safe.

    Parameters
    ----------
    weights : path
        ``face_landmarks_detector.tflite``.
    """

    def __init__(self, weights: Path) -> None:
        self._net = cv2.dnn.readNetFromTFLite(str(weights))

    def look(self, image: Pyramid, box: Detection, *, mirrored: bool = False) -> Mesh | None:
        """Return the mesh of the face in a box, or None when it collapses.

        Parameters
        ----------
        image : Pyramid
            The image.
        box : Detection
            The face, its middle and its angle.
        mirrored : bool
            Show the network a mirror image; the result lies on the image as it is.
        """
        view = View(box.center_px, _CROP * box.side_px, box.degrees)
        pixels = image.sample(view.to_image, INPUT_PX, cv2.BORDER_REPLICATE)
        if mirrored:
            pixels = pixels[:, ::-1]
        planes = pixels.transpose(2, 0, 1)[None].astype(np.float32) / 255.0
        self._net.setInput(np.ascontiguousarray(planes))
        # The network counts from the edge of its first pixel, we from its centre. The half pixel is
        # measured, too: it takes the bias of the eye corners from 0.4 to 0.1 % of their distance.
        points = self._net.forward("Identity").reshape(-1, 3)[:, :2].astype(np.float64) - 0.5
        if mirrored:
            points[:, 0] = INPUT_PX - 1 - points[:, 0]
        return _read(view.to_image(points), mirrored)


def _read(points: Array, mirrored: bool) -> Mesh | None:
    order = slice(None, None, -1) if mirrored else slice(None)
    eyes, mouth = points[list(EYES)][order], points[list(MOUTH)][order]
    try:
        outline = silhouette(points)[order]
    except ValueError:
        return None
    return Mesh(outline, eyes, mouth, _box(points[:_SURFACE], eyes[3] - eyes[0]))


def _box(points: Array, across: Array) -> Detection:
    degrees = float(np.degrees(np.arctan2(across[1], across[0])))
    upright = Affine.similarity(1.0, -degrees, (0.0, 0.0))
    turned = upright(points)
    low, high = turned.min(axis=0), turned.max(axis=0)
    return Detection(
        upright.inverse((low + high) / 2.0), float((high - low).max()), degrees, score=1.0
    )


class MeshSource:
    """Faces by BlazeFace and the face mesh (section 3.1, with today's networks).

    Weights are read at the first use. One source may be shared between threads.
    """

    name = "mesh"

    def __init__(self) -> None:
        self._lock = threading.Lock()  # OpenCV's networks keep state between their calls

    @cached_property
    def _detector(self) -> BlazeFace:
        return BlazeFace(assets.path("models/face_detection_back.tflite"))

    @cached_property
    def _network(self) -> MeshNetwork:
        return MeshNetwork(assets.path("models/face_landmarks_detector.tflite"))

    def find(self, rgb: Image) -> list[Face]:
        """Return the faces of an upright image, largest first.

        Parameters
        ----------
        rgb : array of shape (H, W) or (H, W, C)
            Grey, RGB or RGBA; uint8, uint16 or float32 (0 to 1).

        Returns
        -------
        list of Face
            Empty when there is none. `Face.score` is the detector's probability in two closer
            looks, lowered where the passes of the mesh disagree.

        Raises
        ------
        AssetMissing
            If the networks aren't in this installation.
        ValueError
            If `rgb` isn't an image.
        """
        with self._lock:
            image = Pyramid(rgb)
            faces = search.faces(image, self._detector, lambda box: self._fit(image, box))
        return sorted(faces, key=lambda face: -face.interocular_px)

    def _fit(self, image: Pyramid, proposal: Detection) -> search.Fitted | None:
        """Return the face at a proposal, or None when a closer look doesn't bear it out."""
        box = self._detector.look_closer(image, proposal)
        if box is None:
            return None
        fitted = self._fit_in(image, box)
        if fitted is None or fitted[0].score < _DOUBT:
            # A few faces in a hundred that lie upside down are first taken for upright ones.
            over = self._fit_in(image, replace(box, degrees=box.degrees + 180.0, score=0.0))
            fitted = max(filter(None, (fitted, over)), key=lambda one: one[0].score, default=None)
        return fitted if fitted is not None and fitted[0].score > LEAST_SCORE else None

    def _fit_in(self, image: Pyramid, box: Detection) -> search.Fitted | None:
        last, mesh = None, self._network.look(image, box)
        for _ in range(_MOST_PASSES - 1):
            last, mesh = mesh, mesh and self._network.look(image, mesh.box)
            if last and mesh and mesh.differs_from(last) < _SETTLED:
                break
        mirrored = last and self._network.look(image, last.box, mirrored=True)
        if last is None or mesh is None or mirrored is None:
            return None
        differ = max(mesh.differs_from(last), mesh.differs_from(mirrored))
        wide = box.score if box.score > SURE else self._detector.sight(image, mesh.box, WIDE)
        close = self._detector.sight(image, mesh.box, CLOSE)
        sure = _WIDE_SHARE * wide + (1.0 - _WIDE_SHARE) * close
        score = sure * float(np.exp(-((differ / _DIFFER) ** 2)))
        return _mean(mesh, mirrored, score), mesh.box


def _mean(one: Mesh, other: Mesh, score: float) -> Face:
    # A crop and its mirror image together are a little better (eyes 1.11 to 1.08 %, mouth 1.18 to
    # 1.10 %), and the result in a mirrored photo is the mirrored result.
    return Face(
        (one.outline + other.outline) / 2.0,
        (one.eyes + other.eyes) / 2.0,
        (one.mouth + other.mouth) / 2.0,
        score=score,
        source=MeshSource.name,
    )
