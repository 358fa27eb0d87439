"""Photographs and the faces that the networks find in them."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import MeshSource

Scene = tuple[np.ndarray, Face]


def picture_of(path: Path, longest_px: float = np.inf) -> np.ndarray:
    """Return a photograph, RGB, shape (H, W, 3), with no side longer than `longest_px`."""
    rgb = cv2.cvtColor(cv2.imread(str(path)), cv2.COLOR_BGR2RGB)
    scale = min(1.0, longest_px / max(rgb.shape))
    return cv2.resize(rgb, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


def found_in(paths: list[Path], source: MeshSource, longest_px: float = 640.0) -> list[Scene]:
    """Return photographs with the one face that is found in each."""
    scenes = []
    for path in paths:
        picture = picture_of(path, longest_px)
        (face,) = source.find(picture)
        scenes.append((picture, face))
    return scenes
