"""Pixels as Qt paints them."""

from __future__ import annotations

from typing import Final

from PySide6.QtGui import QImage

from .pyramid import Rgb8

_FORMATS: Final = {3: QImage.Format.Format_RGB888, 4: QImage.Format.Format_RGBA8888}


def qt_image(pixels: Rgb8) -> QImage:
    """Return a view of a picture of shape (H, W, 3), or (H, W, 4) with straight alpha."""
    height, width, channels = pixels.shape
    return QImage(pixels.data, width, height, pixels.strides[0], _FORMATS[channels])
