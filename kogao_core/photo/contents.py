"""What a JPEG, PNG or WebP file says beside its pixels, as far as Pillow tells and further."""

from __future__ import annotations

import math
import os
import struct
from collections.abc import Iterator
from typing import IO, Any, Final

from PIL import Image as Pillow
from PIL import JpegImagePlugin

from kogao_core.photo import chunks, metadata, segments
from kogao_core.photo.model import JpegCoding

_RARE_FRAMES: Final = (0xC3, *range(0xC5, 0xC8), *range(0xC9, 0xCC), *range(0xCD, 0xD0))


def jpeg_coding(image: Pillow.Image) -> JpegCoding | None:
    """Return how a JPEG file is compressed."""
    if not isinstance(image, JpegImagePlugin.JpegImageFile):
        return None
    tables = tuple(tuple(image.quantization[key]) for key in sorted(image.quantization))
    # -1 is grey or a sampling that Pillow can't write: keep all the colour there is.
    subsampling = max(0, JpegImagePlugin.get_sampling(image))
    return JpegCoding(tables, subsampling, bool(image.info.get("progressive")))


def is_rare_jpeg(file: IO[bytes]) -> bool:
    """Tell whether an open JPEG file is lossless, hierarchical or arithmetically coded."""
    return any(code in _RARE_FRAMES for code, _ in segments.segments(file))


def blocks(image: Pillow.Image, file: IO[bytes]) -> dict[str, Any]:
    """Return the metadata blocks of an open file, by their names in `Photo`."""
    exif = image.info.get("exif") or _raw_profile(image, "exif")
    if exif is not None and not exif.startswith(metadata.PREFIX):
        exif = metadata.PREFIX + exif
    xmp = image.info.get("xmp")
    xmp = xmp.encode() if isinstance(xmp, str) else xmp
    return {
        "icc_profile": image.info.get("icc_profile") or None,
        "exif": exif,
        "xmp": xmp or None,
        **_native(image, file),
    }


def _native(image: Pillow.Image, file: IO[bytes]) -> dict[str, Any]:
    """Return what has another place in every format."""
    if isinstance(image, JpegImagePlugin.JpegImageFile):
        return {"photoshop": segments.photoshop(file), "carried": segments.carried(file)}
    if image.format == "PNG":
        return {"photoshop": _raw_profile(image, "iptc"), "carried": chunks.carried(file)}
    return {}


def _raw_profile(image: Pillow.Image, name: str) -> bytes | None:
    """Return a block that ImageMagick has written into a text of a PNG file."""
    text = image.info.get(f"Raw profile type {name}")
    try:
        return bytes.fromhex("".join(text.split("\n")[3:])) if isinstance(text, str) else None
    except ValueError:
        return None  # damaged, not worth the photo


def dpi(value: Any) -> tuple[float, float] | None:
    """Return a resolution (x, y) in dots per inch, if it is one."""
    try:
        x, y = (float(part) for part in value)
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    return (x, y) if 0 < x < math.inf and 0 < y < math.inf else None


def is_lossless_webp(file: IO[bytes]) -> bool:
    """Tell whether an open file is a WebP file that loses nothing."""
    file.seek(8)
    if file.read(4) != b"WEBP":
        return False
    while len(head := file.read(8)) == 8:
        name, size = struct.unpack("<4sI", head)
        if name in (b"VP8 ", b"VP8L"):
            return bool(name == b"VP8L")
        file.seek(size + size % 2, os.SEEK_CUR)
    return False


def not_kept(image: Pillow.Image, file: IO[bytes]) -> Iterator[str]:
    """Yield what a changed photo can't keep, in words."""
    if getattr(image, "n_frames", 1) > 1:
        yield "only the first picture of the file is read and kept"
    is_jpeg = isinstance(image, JpegImagePlugin.JpegImageFile)
    if (is_jpeg and segments.has_credentials(file)) or (
        image.format == "PNG" and chunks.has_credentials(file)
    ):
        yield "content credentials (C2PA) are kept only in a photo that isn't changed"
