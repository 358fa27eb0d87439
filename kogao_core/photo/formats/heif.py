"""HEIC photos, decoded by libheif. Read-only."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, Final

import numpy as np

from kogao_core.base.installed import adding
from kogao_core.base.language import Text
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats.base import FileFormat, Source
from kogao_core.photo.formats.common import aspect
from kogao_core.photo.metadata import kinds, trailers, upright
from kogao_core.photo.metadata.kinds import Extra, Kind
from kogao_core.photo.model import Photo

_BRANDS: Final = {b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1"}
# Boxes of pictures, and boxes of additional content.
_PLAIN_BOXES: Final = (b"ftyp", b"meta", b"mdat", b"free", b"skip", b"idat")
_BOXES: Final = {
    b"mpvd": kinds.VIDEO,
    b"sefd": kinds.SAMSUNG,
    b"moov": kinds.FURTHER,
}
_CREDENTIALS: Final = bytes.fromhex("d8fec3d61b0e483c92975828877ec481")
_TONE_MAP: Final = re.compile(rb"infe\x02.{3}.{4}tmap", re.DOTALL)  # ISO 21496-1's item
# Kinds of auxiliary pictures, by a part of the name.
_AUXILIARY: Final = {
    "hdrgainmap": kinds.GAIN_MAP,
    "depth": kinds.DEPTH,
    "disparity": kinds.DEPTH,
    "matte": kinds.DEPTH,
    "auxid:2": kinds.DEPTH,
}
WIDE: Final = Text("its wide colours are named without a profile, which isn't kept")


def _is_heif(file: IO[bytes], _: Path) -> bool:
    head = file.read(12)
    file.seek(0)
    return head[4:8] == b"ftyp" and head[8:] in _BRANDS


def _decode(source: Source) -> Photo:
    image = _opened(source)
    (width, height), (layout, *depth) = image.size, image.mode.split(";")
    source.check(width, height, len(layout) * (2 if depth else 1))
    pixels = np.array(image)  # a copy: the memory of a view goes with the image
    if image.mode.split(";")[0] not in ("L", "RGB", "RGBA"):
        raise ValueError(Text("an unknown layout {mode}", mode=image.mode))
    exif, xmp = image.info.get("exif"), image.info.get("xmp") or None
    exif = exif and upright.PREFIX + exif.removeprefix(upright.PREFIX)
    ratio = image.info.get("pixel_aspect_ratio")  # of a pixel's width to its height
    notes = []
    primaries = image.info.get("nclx_profile", {}).get("color_primaries", 1)
    is_srgb = primaries in (1, 2)  # ITU-T H.273: BT.709, unspecified
    if "icc_profile" not in image.info and not is_srgb:
        notes.append(WIDE)
    return Photo(
        pixels,  # libheif turns them upright
        source.path,
        "HEIF",
        icc_profile=image.info.get("icc_profile") or None,
        exif=exif,
        xmp=xmp,
        orientation=upright.orientation(exif, xmp),
        aspect=aspect(ratio and ratio[::-1]),
        notes=tuple(notes),
        extras=tuple(_pictures(image)),
    )


def _opened(source: Source) -> Any:
    """Open a file with libheif. The pixels are decoded on first access."""
    try:
        import pi_heif  # an extra
    except ImportError:
        raise UnreadablePhoto(
            Text("is a HEIC photo, which an extra reads: {how}", how=adding("heic"))
        ) from None
    return pi_heif.open_heif(source.file, convert_hdr_to_8bit=source.bits == 8)


def _pictures(image: Any) -> Iterator[Extra]:
    """Yield an extra for each additional picture."""
    if image.info.get("depth_images"):
        yield Extra(kinds.DEPTH)
    for kind in image.info.get("aux", {}):
        yield Extra(next(auxiliary(kind), kinds.FURTHER))
    if len(image) > 1:
        yield Extra(kinds.FURTHER)


def auxiliary(name: str) -> Iterator[Kind]:
    """Yield the kinds that match the name of an auxiliary picture."""
    return (kind for part, kind in _AUXILIARY.items() if part in name.lower())


def boxes(_: Photo, file: IO[bytes]) -> Iterator[Extra]:
    """Yield the extras in separate boxes, in file order, and after the last box."""
    file.seek(0)
    data = file.read()
    at, unknown = 0, []
    while (end := trailers.box_end(data, at, len(data))) is not None:
        name = data[at + 4 : at + 8]
        if name == b"uuid" and data[at + 8 : at + 24] == _CREDENTIALS:
            yield Extra(kinds.CREDENTIALS)
        elif name == b"meta" and _TONE_MAP.search(data, at, end):
            yield Extra(kinds.GAIN_MAP)
        elif name in _BOXES:
            yield Extra(_BOXES[name])
        elif name not in _PLAIN_BOXES:
            unknown.append(name.decode("latin-1"))
        at = end
    if unknown:
        yield Extra(
            kinds.UNKNOWN, Text("unknown data ({names})", names=" ".join(dict.fromkeys(unknown)))
        )
    yield from trailers.found(data, at)


HEIF: Final = FileFormat(
    name="HEIF",
    title="HEIC",
    suffixes=(".heic", ".heif", ".hif"),
    is_lossless=False,
    recognises=_is_heif,
    decode=_decode,
    inside=boxes,
)
