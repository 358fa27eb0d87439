"""AVIF with 8 bits, through Pillow's libavif."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Final

from PIL import features

from kogao_core.base.atomic import Chunks
from kogao_core.base.language import Text
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats import common, heif
from kogao_core.photo.formats.base import BLOCKS, Content, FileFormat, Source
from kogao_core.photo.metadata import upright
from kogao_core.photo.metadata.kinds import Extra
from kogao_core.photo.model import Photo

_QUALITY: Final = 95  # as close to the pixels as a JPEG of 95, a tenth shorter
_SPEED: Final = 8  # a quarter of the time of 6, and 2 % longer
_BRANDS: Final = {b"avif", b"avis"}
_HEAD_BYTES: Final = 64
_DEEP: Final = re.compile(rb"av1C\x81.([\x00-\xff])", re.DOTALL)
_HIGH, _TWELVE = 0x40, 0x20
_NAMED_COLOURS: Final = re.compile(rb"colrnclx\0(.)\0(.)", re.DOTALL)
_SRGB: Final = ((1, 2), (1, 2, 6, 13))  # ITU-T H.273: primaries and transfer curves shown as sRGB
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
            Text("is an AVIF photo, which this Pillow was built without; install Kogao by pip")
        )
    photo, data = common.decode(source, ("AVIF",)), source.data()
    notes = list(photo.notes)
    deep = max((one[1][0] & (_HIGH | _TWELVE) for one in _DEEP.finditer(data)), default=0)
    if deep:
        bits = 12 if deep & _TWELVE else 10
        notes.append(Text("converted from {bits} bits to 8", bits=bits))
    named = [tuple(one[k][0] for k in (1, 2)) for one in _NAMED_COLOURS.finditer(data)]
    is_srgb = all(one in known for pair in named for one, known in zip(pair, _SRGB, strict=True))
    if photo.icc_profile is None and not is_srgb:
        notes.append(heif.WIDE)
    return dataclasses.replace(photo, notes=tuple(notes))


def _encode(content: Content) -> Chunks:
    if not features.check("avif"):
        raise ValueError(Text("this Pillow was built without it"))
    del content.blocks["dpi"]  # AVIF can store neither resolution nor Photoshop resources
    exif: bytes = _exif(content.blocks["exif"])
    # Pillow would rewrite a block with an orientation. Write an empty block, then replace it.
    empty = _EMPTY + exif[len(_EMPTY) :] if exif else b""
    content.blocks["exif"] = empty
    saved = content.saved("AVIF", quality=_QUALITY, subsampling="4:4:4", speed=_SPEED)
    return [saved.replace(empty, exif, 1)]


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
    layouts={"uint8": (3, 4)},
    longest_side_px=16384,
    kept=BLOCKS,
    recognises=_is_avif,
    decode=_decode,
    inside=_inside,
    holds_exif=lambda block: bool(_exif(block)),
)
