"""Photographs to measure with: real ones where a folder of them is at hand, else made up."""

from __future__ import annotations

import os
from pathlib import Path

import cv2
import numpy as np
from scenes import textured_photo

from kogao_core.base import assets
from kogao_core.base.geometry import Image

SHARED = Path(os.environ.get("KOGAO_SHARED", Path(__file__).parents[3] / "shared" / "data"))
_SAMPLES = ("average", "women", "men")
_SETTINGS = {".jpg": [cv2.IMWRITE_JPEG_QUALITY, 92], ".tif": [cv2.IMWRITE_TIFF_COMPRESSION, 1]}
_FACE_SHARE = 0.8  # of a place that a pasted portrait fills


def portraits(count: int) -> list[Image]:
    """Return pictures of one face each, RGB; real ones if they are there."""
    real = sorted((SHARED / "frll").glob("*_neutral.jpg"))[:count]
    made = [assets.path(f"samples/{name}.jpg") for name in _SAMPLES]
    files = real if len(real) == count else [made[k % len(made)] for k in range(count)]
    return [_read(file) for file in files]


def portrait(width: int, height: int) -> Image:
    """Return a photo of one face, about half as high as the photo."""
    real = SHARED / "large" / "p04.jpg"
    if not real.exists():
        return crowd(1, width, height)
    whole = _read(real)
    # Cut to the shape, then scaled.
    scale = max(width / whole.shape[1], height / whole.shape[0])
    cut = whole[: round(height / scale), : round(width / scale)]
    return np.asarray(cv2.resize(cut, (width, height), interpolation=cv2.INTER_CUBIC))


def group(width: int, height: int) -> Image:
    """Return a photo of 18 faces; a real group where there is one."""
    real = SHARED / "groups" / "g2.jpg"
    if not real.exists():
        return crowd(18, width, height)
    return np.asarray(cv2.resize(_read(real), (width, height), interpolation=cv2.INTER_AREA))


def crowd(count: int, width: int, height: int) -> Image:
    """Return portraits pasted side by side on a textured wall."""
    photo = textured_photo(width, height)
    columns = int(np.ceil(np.sqrt(count * width / height)))
    rows = int(np.ceil(count / columns))
    place = min(width // columns, height // rows)
    for number, face in enumerate(portraits(count)):
        side = int(_FACE_SHARE * place)
        square = face[: face.shape[1]] if face.shape[0] > face.shape[1] else face
        shown = cv2.resize(square, (side, side), interpolation=cv2.INTER_AREA)
        left = (number % columns) * (width // columns) + (width // columns - side) // 2
        top = (number // columns) * (height // rows) + (height // rows - side) // 2
        photo[top : top + side, left : left + side] = shown
    return photo


def write(pixels: Image, file: Path) -> Path:
    """Write RGB pixels: JPEG at quality 92, TIFF as it is."""
    cv2.imwrite(str(file), cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR), _SETTINGS[file.suffix])
    return file


def _read(file: Path) -> Image:
    return np.asarray(cv2.cvtColor(cv2.imread(str(file)), cv2.COLOR_BGR2RGB))
