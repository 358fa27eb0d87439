"""Pixels of any depth as a small picture, such as a notebook shows."""

from __future__ import annotations

from typing import Final

import cv2

from kogao_core.geometry import Image
from kogao_core.landmarks.pixels import rgb8

LONGEST_SIDE_PX: Final = 1024


def png(image: Image, longest_px: int = LONGEST_SIDE_PX) -> bytes:
    """Return an image as the bytes of an 8-bit PNG file; a larger one is reduced.

    Parameters
    ----------
    image : array of shape (H, W) or (H, W, C)
        Grey, RGB or RGBA; uint8, uint16 or float32 (0 to 1). Transparency isn't shown.
    longest_px : int
        Longest side of the picture.

    Returns
    -------
    bytes

    Examples
    --------
    >>> import numpy as np
    >>> from kogao_core.display import png
    >>> png(np.zeros((30, 40, 3), np.float32))[1:4]
    b'PNG'
    """
    height, width = image.shape[:2]
    scale = min(1.0, longest_px / max(height, width))
    small = rgb8(image)
    if scale < 1.0:
        size = max(1, round(scale * width)), max(1, round(scale * height))
        small = cv2.resize(small, size, interpolation=cv2.INTER_AREA)  # type: ignore[assignment]
    return cv2.imencode(".png", cv2.cvtColor(small, cv2.COLOR_RGB2BGR))[1].tobytes()
