"""Decode pictures to arrays of grey, grey + alpha, RGB or RGBA.

Pillow decodes 8 bits, OpenCV decodes more: Pillow would reduce the depth.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import MappingProxyType
from typing import IO, Final

import cv2
import numpy as np
from PIL import Image as Pillow

from kogao_core.base.geometry import Image
from kogao_core.base.language import BadValue, Text
from kogao_core.photo import profiles
from kogao_core.photo.filling import filled
from kogao_core.photo.model import channels_of

_BITS, _WHITE = 8, 255
CONVERTED: Final = "converted from"
"""How the note begins on a photo whose colour model isn't that of its file."""
_PLAIN: Final = ("L", "LA", "RGB", "RGBA")
# These conversions of palettes, transparency and premultiplied alpha are exact.
_WIDER: Final = {"1": "L", "P": "RGB", "PA": "RGBA", "La": "LA", "RGBa": "RGBA", "RGBX": "RGB"}
_WIDENED: Final = {
    "1": Text("converted from 1 bit to 8-bit grey"),
    **dict.fromkeys(("P", "PA"), Text("converted from a palette to RGB")),
}
_LOCK: Final = threading.Lock()
_levels: Final[list[int]] = []
_OPAQUE: Final = 0xFFFF
_GREYS: Final = (0, 4)  # PNG's numbers: without alpha, and with


def to_array(image: Pillow.Image, bits: int = _BITS) -> tuple[Image, bytes | None, tuple[str, ...]]:
    """Return uint8 pixels of shape (H, W) or (H, W, 2..4), their ICC profile, and notes."""
    profile = image.info.get("icc_profile") or None
    if image.mode == "L" and bits < _BITS:
        _scale_transparency(image, bits)
        note = Text("converted from {bits} bits to 8-bit grey", bits=bits)
        return np.asarray(_plain(image)), profile, (note,)
    if image.mode in _PLAIN or image.mode in _WIDER:
        notes = (_WIDENED[image.mode],) if image.mode in _WIDENED else ()
        return np.asarray(_plain(image)), profile, notes
    if image.mode == "CMYK" and profile:
        try:
            pixels = np.asarray(profiles.picture_to_srgb(image, profile))
            note = Text("converted from {mode} to RGB by its colour profile", mode=image.mode)
            return pixels, profiles.srgb(), (note,)
        except profiles.DAMAGED:
            pass
    return (
        np.asarray(image.convert("RGB")),
        None,
        (Text("converted from {mode} to RGB without a colour profile", mode=image.mode),),
    )


def _scale_transparency(image: Pillow.Image, bits: int) -> None:
    """Scale the transparent grey value as Pillow scales the pixels."""
    grey = image.info.get("transparency")
    if isinstance(grey, int):
        image.info["transparency"] = grey * _WHITE // (2**bits - 1)


def _plain(image: Pillow.Image) -> Pillow.Image:
    if "transparency" in image.info:
        return image.convert("LA" if image.mode == "L" else "RGBA")
    return image.convert(_WIDER[image.mode]) if image.mode in _WIDER else image


def png_layout(image: Pillow.Image, file: IO[bytes]) -> tuple[int, bool] | None:
    """Return the bits per channel and whether the picture is grey, from a PNG's IHDR chunk.

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


def decoded_deep(data: bytes) -> Image:
    """Decode a file at full depth to grey, RGB or RGBA."""
    with _silent_opencv():
        stored = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if stored is None:
        raise BadValue("OpenCV can't decode it")
    return _swapped(np.asarray(stored))


def filled_deep(pixels: Image, file: IO[bytes]) -> bool:
    """Decode an open TIFF file at full depth into `pixels`, see `filled`."""
    with _silent_opencv():
        is_done = filled(pixels, file, cv2.IMREAD_UNCHANGED)
    _swapped(pixels, pixels)
    return is_done


def _swapped(pixels: Image, out: Image | None = None) -> Image:
    """Return RGB(A) as BGR(A), in which OpenCV has colours, or the other way round; grey as is."""
    flip = {3: cv2.COLOR_RGB2BGR, 4: cv2.COLOR_RGBA2BGRA}.get(channels_of(pixels))
    return pixels if flip is None else np.asarray(cv2.cvtColor(pixels, flip, dst=out))


def with_alpha(grey: Image, transparent: int) -> Image:
    """Add alpha to 16-bit grey, with 0 for the grey value `transparent`.

    OpenCV does this for colours only.
    """
    return np.dstack([grey, np.where(grey == transparent, 0, _OPAQUE).astype(np.uint16)])


@contextmanager
def _silent_opencv() -> Iterator[None]:
    """Silence OpenCV's log while any thread is inside. The log level is global."""
    logging = cv2.utils.logging
    with _LOCK:
        _levels.append(logging.setLogLevel(logging.LOG_LEVEL_SILENT))
    try:
        yield
    finally:
        with _LOCK:  # the last thread restores the original level
            logging.setLogLevel(_levels.pop())


def encoded_deep(
    pixels: Image,
    how: Sequence[int] = (),
    ending: str = ".tiff",
    blocks: Mapping[int, bytes] = MappingProxyType({}),
) -> bytes:
    """Encode grey, RGB or RGBA pixels at full depth, with metadata blocks by OpenCV's numbers."""
    known = {number: np.frombuffer(block, np.uint8) for number, block in blocks.items() if block}
    with _silent_opencv():
        done, data = cv2.imencodeWithMetadata(
            ending, _swapped(pixels), list(known), list(known.values()), how
        )
    if not done:
        raise BadValue("OpenCV can't encode it")
    return data.tobytes()
