"""HEIC photos, decoded by libheif. Read-only."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, Final

import numpy as np

from kogao_core.base.display import eight_bits
from kogao_core.base.geometry import Image
from kogao_core.base.installed import adding
from kogao_core.base.language import BadValue, Text
from kogao_core.photo import profiles
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats.base import FileFormat, Source
from kogao_core.photo.formats.common import aspect
from kogao_core.photo.metadata import kinds, trailers, upright
from kogao_core.photo.metadata.kinds import Extra, Kind
from kogao_core.photo.model import Photo

_BRANDS: Final = {b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1"}
# Boxes of pictures, and boxes of additional content.
_PLAIN_BOXES: Final = (b"ftyp", b"meta", b"mdat", b"free", b"skip", b"idat")
_BOXES: Final = {b"mpvd": kinds.VIDEO, b"sefd": kinds.SAMSUNG, b"moov": kinds.FURTHER}
_CREDENTIALS: Final = bytes.fromhex("d8fec3d61b0e483c92975828877ec481")
# Items that libheif's package can't decode: uncompressed, AV1, JPEG, JPEG 2000, VVC, AVC.
_RARE: Final = re.compile(
    rb"infe[\x02\x03].{3}(?:..|.{4})..(unci|av01|jpeg|j2k1|vvc1|avc1)", re.DOTALL
)
_TONE_MAP: Final = re.compile(rb"infe\x02.{3}.{4}tmap", re.DOTALL)  # ISO 21496-1's item
# Kinds of auxiliary pictures, by a part of the name.
_AUXILIARY: Final = {
    "hdrgainmap": kinds.GAIN_MAP,
    "depth": kinds.DEPTH,
    "disparity": kinds.DEPTH,
    "matte": kinds.DEPTH,
    "auxid:2": kinds.DEPTH,
}


def _is_heif(file: IO[bytes], _: Path) -> bool:
    head = file.read(12)
    file.seek(0)
    return head[4:8] == b"ftyp" and head[8:] in _BRANDS


def _decode(source: Source) -> Photo:
    image = _opened(source)
    (width, height), (layout, *depth) = image.size, image.mode.split(";")
    source.check(width, height, len(layout) * (2 if depth else 1))
    if layout not in ("L", "I", "RGB", "RGBA"):
        raise BadValue("an unknown layout {mode}", mode=image.mode)
    pixels = np.array(image)  # a copy: the memory of a view goes with the image
    if depth:  # libheif leaves the lowest bits empty
        bits = image.info["bit_depth"]
        pixels = widened(pixels >> (16 - bits), bits)
    exif, xmp = image.info.get("exif"), image.info.get("xmp") or None
    exif = exif and upright.PREFIX + exif.removeprefix(upright.PREFIX)
    ratio = image.info.get("pixel_aspect_ratio")  # of a pixel's width to its height
    named = image.info.get("nclx_profile")
    photo = Photo(
        pixels,  # libheif turns them upright
        source.path,
        "HEIF",
        icc_profile=image.info.get("icc_profile") or None,
        exif=exif,
        xmp=xmp,
        orientation=upright.orientation(exif, xmp),
        aspect=aspect(ratio and ratio[::-1]),
        extras=tuple(_pictures(image)),
    )
    name = (named["color_primaries"], named["transfer_characteristics"]) if named else None
    return with_colours(photo, name, source.bits)


def widened(pixels: Image, bits: int) -> Image:
    """Scale channels of 10 or 12 bits to 16 bits."""
    return np.asarray(np.rint(pixels * (0xFFFF / (2**bits - 1))), np.uint16)


def with_colours(photo: Photo, name: profiles.Name | None, bits: int) -> Photo:
    """Add the colour profile of a CICP name to a photo without profile; reduce to `bits`."""
    if photo.icc_profile is None and name is not None:
        try:
            icc = profiles.of_name(name, photo.pixels)
            photo = dataclasses.replace(photo, icc_profile=icc)
        except KeyError:
            extras = (*photo.extras, Extra(kinds.RARE_COLOURS))
            photo = dataclasses.replace(photo, extras=extras)
    if bits == 8:
        photo, pixels = profiles.tone_mapped(photo, photo.pixels)
        photo = dataclasses.replace(photo, pixels=eight_bits(pixels))
    return photo


def _opened(source: Source) -> Any:
    """Open a file with libheif. The pixels are decoded on first access."""
    try:
        import pi_heif  # an extra
    except ImportError:
        raise UnreadablePhoto(
            "is a HEIC photo, which an extra reads: {how}", how=adding("heic")
        ) from None
    try:
        image = pi_heif.open_heif(source.file, convert_hdr_to_8bit=False)
        _ = image.mode
    except (IndexError, ValueError):  # IndexError: no picture that libheif knows
        if (coding := _RARE.search(source.data())) is not None:
            raise UnreadablePhoto(
                "is a HEIC photo of a rare kind ({coding}); save it as JPEG or PNG first",
                coding=coding[1].decode(),
            ) from None
        raise
    return image


def _pictures(image: Any) -> Iterator[Extra]:
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
