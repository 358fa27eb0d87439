"""Pictures as the bytes of files, for reports and figures."""

from __future__ import annotations

import base64
from typing import Final

import cv2
import numpy as np

from kogao_core.geometry import Image

LONGEST_SIDE_PX: Final = 640
_QUALITY: Final = 90


def reduced(pixels: Image, longest_px: int = LONGEST_SIDE_PX) -> Image:
    """Return a picture made smaller, if need be, to `longest_px` along its longer side."""
    shrink = longest_px / max(pixels.shape[:2])
    if shrink >= 1.0:
        return pixels
    size = [max(1, round(side * shrink)) for side in pixels.shape[1::-1]]
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))


def png(pixels: Image) -> bytes:
    """Return a grey or RGB picture as the bytes of a PNG file."""
    return _file(pixels, ".png")


def data_uri(pixels: Image, *, exact: bool) -> str:
    """Return a grey or RGB picture as a data URI: its very pixels (PNG), or JPEG."""
    jpeg = cv2.IMWRITE_JPEG_QUALITY, _QUALITY
    data = png(pixels) if exact else _file(pixels, ".jpg", *jpeg)
    return f"data:image/{'png' if exact else 'jpeg'};base64,{base64.b64encode(data).decode()}"


def _file(pixels: Image, kind: str, *options: int) -> bytes:
    bgr = pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
    _, data = cv2.imencode(kind, bgr, options)
    return data.tobytes()
