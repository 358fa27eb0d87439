"""Convert images of any depth for display: 8-bit RGB, reduced size, PNG and JPEG bytes."""

from __future__ import annotations

import base64
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Image

NOTEBOOK_PX: Final = 1024  # longest sides
REPORT_PX: Final = 640
_QUALITY: Final = 90
_OPAQUE: Final = 255

Rgb8 = npt.NDArray[np.uint8]


def rgb8(image: Image) -> Rgb8:
    """Return `image` as 8-bit RGB.

    Result uint8 (H, W, 3); `image` itself if it already has this form.
    """
    if image.ndim not in (2, 3) or 0 in image.shape or (image.ndim == 3 and image.shape[2] > 4):
        raise ValueError(f"expected an image of shape (H, W) or (H, W, 1..4), got {image.shape}")
    return _three_channels(eight_bits(image))


def rgba8(image: Image) -> Rgb8:
    """Return `image` as 8-bit RGB, or RGBA if any pixel is transparent.

    Result uint8 (H, W, 3), or of shape (H, W, 4) with straight alpha.
    """
    colours = rgb8(image)
    if image.ndim == 2 or image.shape[2] not in (2, 4):
        return colours
    alpha = eight_bits(np.ascontiguousarray(image[..., -1:]))
    return colours if (alpha == _OPAQUE).all() else np.concatenate([colours, alpha], axis=2)


def eight_bits(image: Image) -> Rgb8:
    """Return an image of any depth with 8 bits per channel, of the same shape."""
    if image.dtype == np.uint8:
        return np.asarray(image, np.uint8)
    if image.dtype == np.uint16:
        return np.asarray(cv2.convertScaleAbs(image, alpha=1.0 / 257.0), np.uint8).reshape(
            image.shape
        )
    if image.dtype == np.float32:
        inside = np.clip(np.nan_to_num(image), 0.0, 1.0)
        return np.asarray(cv2.convertScaleAbs(inside, alpha=255.0), np.uint8).reshape(image.shape)
    raise ValueError(f"expected uint8, uint16 or float32 pixels, got {image.dtype}")


def _three_channels(image: Rgb8) -> Rgb8:
    channels = 1 if image.ndim == 2 else image.shape[2]
    if channels == 3:
        return image
    if channels == 4:
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGBA2RGB), np.uint8)
    grey = image if image.ndim == 2 else np.ascontiguousarray(image[..., 0])
    return np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2RGB), np.uint8)


def preview(image: Image, longest_px: int = NOTEBOOK_PX) -> bytes:
    """Return the bytes of an 8-bit PNG of an image, reduced to at most `longest_px`."""
    return png(reduced(rgb8(image), longest_px))


def reduced(pixels: Image, longest_px: int = REPORT_PX) -> Image:
    """Return an 8-bit image, reduced if its longer side exceeds `longest_px`."""
    shrink = longest_px / max(pixels.shape[:2])
    if shrink >= 1.0:
        return pixels
    size = [max(1, round(side * shrink)) for side in pixels.shape[1::-1]]
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))


def png(pixels: Image) -> bytes:
    """Return the bytes of a PNG file of an 8-bit image, grey (H, W) or RGB (H, W, 3)."""
    return _file(pixels, ".png")


def data_uri(pixels: Image) -> str:
    """Return an 8-bit image as a JPEG data URI."""
    data = _file(pixels, ".jpg", cv2.IMWRITE_JPEG_QUALITY, _QUALITY)
    return f"data:image/jpeg;base64,{base64.b64encode(data).decode()}"


def _file(pixels: Image, kind: str, *options: int) -> bytes:
    bgr = pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
    _, data = cv2.imencode(kind, bgr, options)
    return data.tobytes()
