"""Pixels deeper than 8 bits, which Pillow would cut: OpenCV decodes and encodes them."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import IO, Final

import cv2
import numpy as np
from PIL import Image as Pillow

from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.photo.model import channels_of

_LOCK: Final = threading.Lock()
_levels: Final[list[int]] = []
_OPAQUE: Final = 0xFFFF
_GREYS: Final = (0, 4)  # PNG's numbers: without alpha, and with


def png_layout(image: Pillow.Image, file: IO[bytes]) -> tuple[int, bool] | None:
    """Return bits of a channel, and whether it is grey, from the IHDR chunk of an open PNG file.

    None for other formats.
    """
    if image.format != "PNG":
        return None
    position = file.tell()
    file.seek(24)
    bits, colour_type = file.read(2)
    file.seek(position)
    return bits, colour_type in _GREYS


def verify_png(file: IO[bytes]) -> None:
    """Check every chunk of an open PNG file, where OpenCV would complain on stderr; stays put."""
    position = file.tell()
    file.seek(0)
    with Pillow.open(file, formats=["PNG"]) as image:
        image.verify()
    file.seek(position)


def decode(data: bytes) -> Image:
    """Decode a file at full depth to grey, RGB or RGBA."""
    with _silent_opencv():
        stored = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if stored is None:
        raise ValueError(Text("OpenCV can't decode it"))
    return _swapped(np.asarray(stored))


def _swapped(pixels: Image) -> Image:
    """Return RGB(A) as BGR(A), in which OpenCV has colours, or the other way round; grey as is."""
    flip = {3: cv2.COLOR_RGB2BGR, 4: cv2.COLOR_RGBA2BGRA}.get(channels_of(pixels))
    return pixels if flip is None else np.asarray(cv2.cvtColor(pixels, flip))


def with_alpha(grey: Image, transparent: int) -> Image:
    """Return 16-bit grey as RGBA that can be seen through where it is of one value.

    OpenCV does so with colours alone.
    """
    alpha = np.where(grey == transparent, 0, _OPAQUE).astype(np.uint16)
    return np.dstack([grey, grey, grey, alpha])


@contextmanager
def _silent_opencv() -> Iterator[None]:
    """Keep OpenCV's log silent while any thread is inside; its level is the whole program's."""
    logging = cv2.utils.logging
    with _LOCK:
        _levels.append(logging.setLogLevel(logging.LOG_LEVEL_SILENT))
    try:
        yield
    finally:
        with _LOCK:  # whoever leaves last takes the level that the first one found
            logging.setLogLevel(_levels.pop())


def encode(pixels: Image, how: Sequence[int] = ()) -> bytes:
    """Encode grey, RGB or RGBA pixels at full depth as TIFF."""
    with _silent_opencv():
        done, data = cv2.imencode(".tiff", _swapped(pixels), how)
    if not done:
        raise ValueError(Text("OpenCV can't encode it"))
    return data.tobytes()
