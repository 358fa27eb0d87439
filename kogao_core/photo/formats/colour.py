"""Decoded 8-bit pictures of any colour model as grey, grey + alpha, RGB or RGBA."""

from __future__ import annotations

import io
from typing import Final

import numpy as np
from PIL import Image as Pillow
from PIL import ImageCms

from kogao_core.base.geometry import Image
from kogao_core.base.language import Text

_ROWS: Final = 64
_BITS, _WHITE = 8, 255
CONVERTED: Final = "converted from"
"""How the note begins on a photo whose colour model isn't that of its file."""
_PLAIN: Final = ("L", "LA", "RGB", "RGBA")
# The palette, transparency and premultiplied modes lose nothing here.
_WIDER: Final = {"1": "L", "P": "RGB", "PA": "RGBA", "La": "LA", "RGBa": "RGBA", "RGBX": "RGB"}
_WIDENED: Final = {
    "1": Text("converted from 1 bit to 8-bit grey"),
    **dict.fromkeys(("P", "PA"), Text("converted from a palette to RGB")),
}


def to_array(image: Pillow.Image, bits: int = _BITS) -> tuple[Image, bytes | None, tuple[str, ...]]:
    """Return uint8 pixels of shape (H, W) or (H, W, 2..4), their ICC profile, and notes."""
    profile = image.info.get("icc_profile") or None
    if image.mode == "L" and bits < _BITS:
        _scale_transparency(image, bits)
        note = Text("converted from {bits} bits to 8-bit grey", bits=bits)
        return _pixels(_plain(image)), profile, (note,)
    if image.mode in _PLAIN or image.mode in _WIDER:
        notes = (_WIDENED[image.mode],) if image.mode in _WIDENED else ()
        return _pixels(_plain(image)), profile, notes
    if image.mode == "CMYK" and profile:
        try:
            return *_managed(image, profile), (
                Text("converted from {mode} to RGB by its colour profile", mode=image.mode),
            )
        except (ImageCms.PyCMSError, OSError):
            pass
    return (
        _pixels(image.convert("RGB")),
        None,
        (Text("converted from {mode} to RGB without a colour profile", mode=image.mode),),
    )


def narrowed(bits: int) -> Text:
    """Return the note on a photo of so many bits, of which 8 are read."""
    return Text("converted from {bits} bits to 8", bits=bits)


def _pixels(image: Pillow.Image) -> Image:
    """Return a picture's pixels; some rows at a time, which stay within the processor's cache.

    All at once they are laid out three times in fresh memory, which takes four times as long.
    """
    channels = len(image.getbands())
    shape = (image.height, image.width, channels)[: 2 if channels == 1 else 3]
    pixels = np.empty(shape, np.uint8)
    for top in range(0, image.height, _ROWS):
        bottom = min(image.height, top + _ROWS)
        pixels[top:bottom] = np.asarray(image.crop((0, top, image.width, bottom)))
    return pixels


def _scale_transparency(image: Pillow.Image, bits: int) -> None:
    """Scale the grey that is transparent as Pillow has scaled the pixels."""
    grey = image.info.get("transparency")
    if isinstance(grey, int):
        image.info["transparency"] = grey * _WHITE // (2**bits - 1)


def _plain(image: Pillow.Image) -> Pillow.Image:
    if "transparency" in image.info:
        return image.convert("LA" if image.mode == "L" else "RGBA")
    return image.convert(_WIDER[image.mode]) if image.mode in _WIDER else image


def _managed(image: Pillow.Image, profile: bytes) -> tuple[Image, bytes]:
    srgb = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB"))
    source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
    converted = ImageCms.profileToProfile(image, source, srgb, outputMode="RGB")
    if converted is None:
        raise ImageCms.PyCMSError("no picture came back")
    return _pixels(converted), srgb.tobytes()
