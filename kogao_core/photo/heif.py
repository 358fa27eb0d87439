"""HEIC photos, through libheif: read, but never written."""

from __future__ import annotations

from pathlib import Path
from typing import IO, Any, Final

import numpy as np

from kogao_core.photo import metadata
from kogao_core.photo.errors import UnreadablePhoto

_BRANDS: Final = {b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1"}
_LAYOUTS: Final = ("L", "RGB", "RGBA")
# ITU-T H.273: BT.709, which is sRGB's, and "unspecified".
_PLAIN_PRIMARIES: Final = (1, 2)


def is_heif(file: IO[bytes]) -> bool:
    """Tell by the first bytes of an open file; leaves it at its start."""
    head = file.read(12)
    file.seek(0)
    return head[4:8] == b"ftyp" and head[8:] in _BRANDS


def opened(file: IO[bytes], path: Path, bits: int) -> Any:
    """Return what libheif says of a file; its pixels are decoded when they are asked for.

    Raises
    ------
    UnreadablePhoto
        If libheif isn't installed.
    """
    try:
        import pi_heif
    except ImportError:
        raise UnreadablePhoto(
            f"{path} is a HEIC photo; to read it, install the extra: pip install 'kogao[heic]'"
        ) from None
    return pi_heif.open_heif(file, convert_hdr_to_8bit=bits == 8)


def contents(image: Any) -> dict[str, Any]:
    """Return the pixels, which libheif turns upright, and metadata of a file; see `Photo`.

    Raises
    ------
    ValueError
        If it can't be decoded.
    """
    pixels = np.array(image)  # a copy: the memory of a view goes with the image
    if image.mode.split(";")[0] not in _LAYOUTS:
        raise ValueError(f"an unknown layout {image.mode}")
    exif = image.info.get("exif")
    notes = []
    if image.info.get("depth_images"):
        notes.append("its depth map isn't kept")
    primaries = image.info.get("nclx_profile", {}).get("color_primaries", 1)
    if "icc_profile" not in image.info and primaries not in _PLAIN_PRIMARIES:
        notes.append("its wide colours are named without a profile, which isn't kept")
    return {
        "pixels": pixels,
        "icc_profile": image.info.get("icc_profile") or None,
        "exif": exif and metadata.PREFIX + exif.removeprefix(metadata.PREFIX),
        "xmp": image.info.get("xmp") or None,
        "notes": tuple(notes),
    }
