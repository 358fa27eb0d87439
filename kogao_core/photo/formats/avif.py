"""AVIF: 8 bits through Pillow's libavif, 10 and 12 bits through OpenCV's."""

from __future__ import annotations

import dataclasses
import math
import re
import struct
from collections.abc import Iterator
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import IO, Final

import cv2
import numpy as np
from PIL import features

from kogao_core.base.atomic import Chunks
from kogao_core.base.geometry import Box, Image
from kogao_core.base.language import BadValue, Text
from kogao_core.photo import profiles
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats import colour, common, heif
from kogao_core.photo.formats.base import BLOCKS, Content, FileFormat, Source
from kogao_core.photo.metadata import trailers, upright
from kogao_core.photo.metadata.kinds import Extra
from kogao_core.photo.metadata.upright import as_stored, turn_upright
from kogao_core.photo.model import Photo

_QUALITY: Final = 95  # as close to the pixels as a JPEG of 95, a tenth shorter
_LOSSLESS: Final = 100  # below, OpenCV halves the resolution of colours
_SPEED: Final = 8  # a quarter of the time of 6, and 2 % longer
_BRANDS: Final = {b"avif", b"avis"}
_HEAD_BYTES: Final = 64
_CODING: Final = re.compile(rb"av1C(\x81..)", re.DOTALL)
_HIGH, _TWELVE = 0x40, 0x20
_WRITTEN_BITS: Final = 10  # of 16-bit pixels
_LONGEST_PX: Final = 16384
# Colour names that libavif writes: sRGB, or unspecified beside a profile.
_NCLX: Final = re.compile(rb"(?<=colrnclx)(?:\0\x01\0\r|\0\x02\0\x02)")
_URN: Final = re.compile(rb"urn:[\x21-\x7e]+")
_TIFF_HEADS: Final = (b"II*\0", b"MM\0*")
_EMPTY: Final = b"II*\0\x08\0\0\0" + bytes(6)  # a directory without an entry


def _is_avif(file: IO[bytes], _: Path) -> bool:
    head = file.read(_HEAD_BYTES)
    file.seek(0)
    size = int.from_bytes(head[:4], "big")
    brands = {head[at : at + 4] for at in range(8, min(size, len(head)), 4)}
    return head[4:8] == b"ftyp" and bool(brands & _BRANDS)


def _decode(source: Source) -> Photo:
    if not features.check("avif"):
        raise UnreadablePhoto(
            "is an AVIF photo, which this Pillow was built without; install Kogao by pip"
        )
    data = source.data()
    properties = dict[bytes, bytes]()
    with suppress(LookupError):  # boxes in a rare order
        properties.update(_properties(data))
    try:
        photo = common.decode(source, ("AVIF",))
    except ValueError:
        photo = _lenient(source, properties)
    coding = properties.get(b"av1C")  # of the picture; else of its tiles
    codings = _CODING.findall(data) if coding is None else [coding]
    deep = max((one[2] & (_HIGH | _TWELVE) for one in codings), default=0)
    stored = as_stored(photo.pixels, photo.orientation)
    if deep and photo.bits == 8 and cv2.haveImageWriter(".avif"):
        source.check(photo.width, photo.height, 2 * photo.channels)
        stored = colour.decoded_deep(data)
    if stored.dtype == np.uint16:
        stored = heif.widened(stored, 12 if deep & _TWELVE else 10)
    elif deep:
        note = Text("converted from {bits} bits to 8", bits=12 if deep & _TWELVE else 10)
        photo = dataclasses.replace(photo, notes=(*photo.notes, note))
    upright = turn_upright(_cropped(stored, properties.get(b"clap")), photo.orientation)
    photo = dataclasses.replace(photo, pixels=upright)
    nclx = properties.get(b"nclx")
    name = struct.unpack_from(">HH", nclx) if nclx else None
    return heif.with_colours(photo, name, source.bits)


def _lenient(source: Source, properties: dict[bytes, bytes]) -> Photo:
    """Decode with OpenCV a file that breaks a rule of libavif's strict mode."""
    width, height = struct.unpack_from(">4xII", properties[b"ispe"])
    if max(width, height) > _LONGEST_PX:
        raise UnreadablePhoto(
            "is an AVIF photo of more than {px} px a side; make it smaller", px=_LONGEST_PX
        )
    source.check(width, height, 8)
    note = Text("its metadata are of a kind that isn't kept")
    pixels = colour.decoded_deep(source.data())
    profile = properties.get(b"prof")
    return Photo(pixels, source.path, "AVIF", icc_profile=profile, notes=(note,))


def _cropped(stored: Image, aperture: bytes | None) -> Image:
    """Return the part of stored pixels inside the clean aperture (ISO 14496-12, ``clap``)."""
    if aperture is None:
        return stored
    numbers = struct.unpack_from(">IIIIiIiI", aperture)
    if 0 in numbers[1::2]:
        return stored
    width, height, right, down = (Fraction(*numbers[at : at + 2]) for at in range(0, 8, 2))
    whole = Box.of(stored)
    left, top = (whole.width - width) / 2 + right, (whole.height - height) / 2 + down
    inside = Box(*map(math.floor, (left, top, left + width, top + height)))
    return stored[inside.slices] if inside.area and inside.clipped(whole) == inside else stored


def _properties(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield name and body of each property of the primary item; colours by ``nclx`` or ``prof``."""
    meta = next((one for name, one in _boxes(data) if name == b"meta"), b"")[4:]
    found = dict(_boxes(meta))
    pitm, iprp = found[b"pitm"], dict(_boxes(found[b"iprp"]))
    primary = int.from_bytes(pitm[4:], "big")
    known = list(_boxes(iprp[b"ipco"]))
    ipma = iprp[b"ipma"]
    size, step = (4 if ipma[0] else 2), (2 if ipma[3] & 1 else 1)
    at = 8
    for _ in range(int.from_bytes(ipma[4:8], "big")):
        item, at = int.from_bytes(ipma[at : at + size], "big"), at + size
        numbers = [ipma[k : k + step] for k in range(at + 1, at + 1 + step * ipma[at], step)]
        at += 1 + step * ipma[at]
        for number in numbers if item == primary else ():
            index = int.from_bytes(number, "big") & (1 << 8 * step - 1) - 1
            name, body = known[index - 1]
            yield (body[:4], body[4:]) if name == b"colr" else (name, body)


def _boxes(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 0
    while (end := trailers.box_end(data, at, len(data))) is not None:
        yield data[at + 4 : at + 8], data[at + 8 : end]
        at = end


def _encode(content: Content) -> Chunks:
    if not features.check("avif"):
        raise BadValue("this Pillow was built without it")
    blocks = content.blocks
    del blocks["dpi"]  # AVIF can store neither resolution nor Photoshop resources
    exif: bytes = _exif(blocks["exif"])
    if content.pixels.dtype == np.uint16:
        blocks["exif"] = exif
        saved = _deep(content)
    else:
        # Pillow would rewrite a block with an orientation. Write an empty block, then replace it.
        blocks["exif"] = empty = _EMPTY + exif[len(_EMPTY) :] if exif else b""
        saved = content.saved("AVIF", quality=_QUALITY, subsampling="4:4:4", speed=_SPEED)
        saved = saved.replace(empty, exif, 1)
    if (name := profiles.name_of(blocks["icc_profile"])) is not None:
        saved = _NCLX.sub(lambda _: struct.pack(">HH", *name), saved, count=1)
    return [saved]


def _deep(content: Content) -> bytes:
    """Encode 16-bit pixels with 10 bits, with OpenCV."""
    kinds = {
        "exif": cv2.IMAGE_METADATA_EXIF,
        "xmp": cv2.IMAGE_METADATA_XMP,
        "icc_profile": cv2.IMAGE_METADATA_ICCP,
    }
    how = (cv2.IMWRITE_AVIF_DEPTH, _WRITTEN_BITS, cv2.IMWRITE_AVIF_QUALITY, _LOSSLESS)
    blocks = {number: content.blocks[name] or b"" for name, number in kinds.items()}
    stored = np.rint(content.pixels * ((2**_WRITTEN_BITS - 1) / 0xFFFF)).astype(np.uint16)
    return colour.encoded_deep(stored, (*how, cv2.IMWRITE_AVIF_SPEED, _SPEED), ".avif", blocks)


def _exif(block: bytes | None) -> bytes:
    """Return an EXIF block without prefix, or b"" if AVIF readers would reject the block."""
    inner = (block or b"")[len(upright.PREFIX) :]
    return inner if inner.startswith(_TIFF_HEADS) and len(inner) >= len(_EMPTY) else b""


def _inside(photo: Photo, file: IO[bytes]) -> Iterator[Extra]:
    yield from heif.boxes(photo, file)
    file.seek(0)
    for urn in dict.fromkeys(_URN.findall(file.read())):
        yield from map(Extra, heif.auxiliary(urn.decode()))


AVIF: Final = FileFormat(
    name="AVIF",
    title="AVIF",
    suffixes=(".avif",),
    is_lossless=False,
    encode=_encode,
    layouts={"uint8": (3, 4), "uint16": (3, 4)},
    deep_bits=_WRITTEN_BITS,
    holds_hdr=True,
    longest_side_px=_LONGEST_PX,
    kept=BLOCKS,
    recognises=_is_avif,
    decode=_decode,
    inside=_inside,
    holds_exif=lambda block: bool(_exif(block)),
)
