"""Detections of the networks in a photograph: boxes of the detector, and meshes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Affine, Array, Image
from kogao_core.base.threads import ObjectPool
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import locked, search
from kogao_core.faces.landmarks.blazeface import INPUT_PX, BlazeFace, Detection, Square
from kogao_core.faces.landmarks.mesh import EYES, MOUTH
from kogao_core.faces.landmarks.outline import silhouette
from kogao_core.faces.landmarks.pixels import Pyramid, read_network

SURFACE: Final = 468
_LEAST_SCORE: Final = 0.8
_CROP: Final = 1.5
_PASSES: Final = 2


@dataclass(frozen=True, eq=False)
class Seen:
    """One face of a photograph."""

    box: Detection  # the detector's box, px of the photograph
    mesh: Array  # (478, 3): points of the mesh, px of the photograph; z grows away from the camera


class Networks:
    """Detector and mesh network together; returns all mesh points with their depth."""

    def __init__(self) -> None:
        self._detector = BlazeFace(locked.network(locked.DETECTOR))
        weights = str(locked.network(locked.MESH))
        self._meshes = ObjectPool(lambda: read_network(Path(weights)))

    def faces(self, picture: Pyramid) -> list[Seen]:
        """Return the faces with a confident detection and mesh."""
        # Several threads fit proposals, some in vain. Use only the fits that the search accepts.
        seen: dict[Face, Seen] = {}

        def fit(proposal: Detection) -> search.Fitted | None:
            boxes, _ = self._detector.look_closer(picture, proposal)
            if not boxes or boxes[0].score < _LEAST_SCORE:
                return None
            box = boxes[0]
            mesh, around = self._meshed(picture, box)
            eyes = mesh[list(EYES), :2]
            try:
                outline = silhouette(mesh[:, :2], eyes)
            except ValueError:
                return None
            face = Face(outline, eyes, mesh[list(MOUTH), :2])
            seen[face] = Seen(box, mesh)
            return search.Fitted(face, around)

        return [seen[face] for face in search.faces(picture, self._detector, fit)]

    def _meshed(self, picture: Pyramid, box: Detection) -> tuple[Array, Detection]:
        for _ in range(_PASSES):
            view = Square(box.center_px, _CROP * box.side_px, box.degrees).to_image
            pixels = picture.sample(view, INPUT_PX, cv2.BORDER_REPLICATE)
            planes = pixels.transpose(2, 0, 1)[None].astype(np.float32) / 255.0
            with self._meshes.one() as net:
                net.setInput(np.ascontiguousarray(planes))
                raw = net.forward("Identity").reshape(-1, 3).astype(np.float64)
            points = view(raw[:, :2] - 0.5)
            box = _around(points[:SURFACE], points[EYES[3]] - points[EYES[0]])
        return np.column_stack([points, raw[:, 2] * view.scale]), box


def _around(points: Array, across: Array) -> Detection:
    degrees = float(np.degrees(np.arctan2(across[1], across[0])))
    upright = Affine.similarity(1.0, -degrees, (0.0, 0.0))
    low, high = upright(points).min(axis=0), upright(points).max(axis=0)
    middle = upright.inverse((low + high) / 2.0)
    return Detection(middle, float((high - low).max()), degrees, 1.0)


def read(path: Path) -> Image:
    """Return a photograph, uint8 RGB of shape (H, W, 3)."""
    pixels = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if pixels is None:
        raise FileNotFoundError(f"{path} is missing or no picture")
    return cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB)
