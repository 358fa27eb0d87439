"""Pixels as Qt paints them, small pictures of faces, and pictures as files."""

from __future__ import annotations

import errno
from typing import Final

import numpy as np
from PySide6.QtCore import QBuffer, QIODevice, Qt
from PySide6.QtGui import QIcon, QImage, QPixmap

from kogao_core.base.display import Rgb8
from kogao_core.base.geometry import Box, Image
from kogao_core.faces.face import Face

from ..pyramid import PicturePyramid

_FORMATS: Final = {3: QImage.Format.Format_RGB888, 4: QImage.Format.Format_RGBA8888}


def qt_image(pixels: Rgb8) -> QImage:
    """Return a QImage view of a picture of shape (H, W, 3), or (H, W, 4) with straight alpha."""
    height, width, channels = pixels.shape
    return QImage(pixels.data, width, height, pixels.strides[0], _FORMATS[channels])


def face_icon(photo: PicturePyramid, face: Face, size_px: int, ratio: float) -> QIcon:
    """Return a square icon of a face, `size_px` wide at `ratio` device px per px.

    The pixels come from the smallest level that is large enough.
    """
    left, top, width, height = face.box
    side = max(width, height)
    level = photo.level_for(size_px / max(side, 1.0))
    pixels = photo.shown[level]
    corner = np.array([left + (width - side) / 2, top + (height - side) / 2]) / 2**level
    x, y = np.round(corner).astype(int).tolist()
    length = max(1, round(side / 2**level))
    box = Box(x, y, x + length, y + length).clipped(Box.of(pixels))
    if not box.area:
        return QIcon()
    rows, columns = box.slices
    return untinted(scaled(pixels[rows, columns], size_px, ratio))


def scaled(pixels: Image, size_px: int, ratio: float) -> QPixmap:
    """Return an RGB or RGBA picture with a longer side of `size_px` at `ratio` device px per px."""
    image = qt_image(np.ascontiguousarray(pixels))
    side = round(size_px * ratio)
    keep, smooth = Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
    picture = QPixmap.fromImage(image.copy()).scaled(side, side, keep, smooth)
    picture.setDevicePixelRatio(ratio)
    return picture


def untinted(picture: QPixmap) -> QIcon:
    """Return an icon with the same colours when selected."""
    icon = QIcon(picture)
    icon.addPixmap(picture, QIcon.Mode.Selected)
    return icon


def encoded(picture: QPixmap, suffix: str) -> bytes:
    """Encode a picture in the format of a file suffix. Raises OSError for an unknown suffix."""
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    if not picture.save(buffer, suffix.removeprefix(".") or "png"):
        raise OSError(errno.EINVAL, f"no kind of picture ends in {suffix}")
    return bytes(buffer.data().data())
