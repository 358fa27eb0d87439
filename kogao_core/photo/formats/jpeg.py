"""JPEG, with the tables and subsampling of the source."""

from __future__ import annotations

import dataclasses
import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Final

import numpy as np

from kogao_core.base.atomic import Chunks
from kogao_core.base.geometry import Box, Image
from kogao_core.base.language import Text
from kogao_core.base.stderr import hushed
from kogao_core.photo.formats import companions
from kogao_core.photo.formats.base import BLOCKS, OF_PRINTS, Content, Encode, FileFormat
from kogao_core.photo.jpeg import segments
from kogao_core.photo.jpeg.blocks import keep_blocks
from kogao_core.photo.jpeg.coefficients import CannotKeepBlocks
from kogao_core.photo.metadata import jpeg_extras, kinds, trailers
from kogao_core.photo.metadata.kinds import Extra
from kogao_core.photo.metadata.upright import as_stored
from kogao_core.photo.model import Photo, channels_of

QUALITY: Final = 95
_FINE: Final = 90  # from this quality on colours are kept in full


def _encode(content: Content) -> Chunks:
    more = (*content.carried, *segments.photoshop_segments(content.resources or b""))
    opaque = dataclasses.replace(content, pixels=_without_alpha(content.pixels))
    return [segments.inserted(_plain(opaque), more)]


def _plain(content: Content) -> bytes:
    coding = content.photo.jpeg
    if content.quality:
        subsampling = "4:4:4" if content.quality >= _FINE else "4:2:0"
        quality = {"quality": content.quality, "subsampling": subsampling}
        saved = content.saved("JPEG", **quality, optimize=True)
    elif coding is None or not coding.tables:
        saved = content.saved("JPEG", quality=QUALITY, subsampling="4:4:4")
    else:
        saved = content.saved(
            "JPEG",
            qtables=[list(table) for table in coding.tables],
            subsampling=coding.subsampling,
            progressive=coding.progressive,
        )
    if coding is not None and coding.jfif:
        return segments.with_jfif(saved, coding.jfif)
    if content.photo.aspect is None:
        return saved
    shape = struct.pack(">BBBHH", 1, 1, 0, *content.photo.aspect)  # JFIF 1.01, no unit
    return segments.with_jfif(saved, shape)


def _without_alpha(pixels: Image) -> Image:
    channels = channels_of(pixels)
    if channels in (1, 3):
        return pixels
    return np.ascontiguousarray(pixels[..., :3] if channels == 4 else pixels[..., 0])


def _inside(photo: Photo, file: IO[bytes]) -> Iterator[Extra]:
    return jpeg_extras.found(file, is_turned=photo.orientation != 1)


def _behind(file: IO[bytes]) -> Iterator[Extra]:
    data = file.read()
    end, late = segments.end_of_picture(data, 2)
    if late:
        yield Extra(kinds.UNKNOWN, Text("metadata between the scans"))
    yield from trailers.found(data, end)


def _why_none_stays(photo: Photo) -> str:
    if photo.jpeg is None:
        return Text("its colours were converted to RGB")
    return "" if photo.jpeg.tables else Text("it was lossless")


def _folder(path: Path) -> Path:
    return Path(os.path.realpath(path)).parent


def _keep(photo: Photo, pixels: Image, encode: Encode, path: Path) -> tuple[Chunks, str]:
    """Keep every block in which no pixel changed."""
    photo = companions.settled(photo, _folder(path))
    reason = _why_none_stays(photo)
    if not reason and pixels.shape != photo.pixels.shape:
        reason = Text("its size or its colours have changed")
    if not reason and not photo.is_as_read:
        there = photo.path.exists()
        changed = Text("{path} has changed since it was read", path=photo.path)
        reason = changed if there else Text("{path} is gone", path=photo.path)
    if not reason:
        try:
            before, after = (as_stored(one, photo.orientation) for one in (photo.pixels, pixels))
            with hushed():  # libjpeg cautions of coarse tables
                headers = b"".join(encode(photo, Box(0, 0, 1, 1)))
            kept = keep_blocks(photo.path.read_bytes(), before, after, headers, _folder(path))
        except CannotKeepBlocks as why:
            reason = str(why)
        else:
            note = Text("{share:.1f} % of the JPEG unchanged", share=100.0 * kept.share)
            is_progressive = photo.jpeg is not None and photo.jpeg.progressive
            more = Text(", in one scan instead of progressive ones") if is_progressive else ""
            damage = [Text("the file is slightly damaged: {one}", one=one) for one in kept.damage]
            whole = companions.joined(photo, kept.data)
            return [whole], Text.joined("; ", [Text.joined("", [note, more]), *damage])
    with hushed():
        whole = companions.joined(photo, b"".join(encode(photo, None)))
    return [whole], Text("every block of the JPEG was compressed again: {reason}", reason=reason)


JPEG: Final = FileFormat(
    name="JPEG",
    title="JPEG",
    suffixes=(".jpg", ".jpeg", ".jfif", ".jpe", ".jif"),
    is_lossless=False,
    encode=_encode,
    layouts={"uint8": (1, 3)},
    longest_side_px=65500,
    kept=BLOCKS
    | OF_PRINTS
    | {
        *(kinds.XMP_EXTENSION, kinds.SECOND_XMP, kinds.SECOND_PROFILE, kinds.ADOBE),
        *(kinds.PLACES, kinds.COMMENTS, kinds.SEGMENTS, kinds.JUMBF, *kinds.RECORDS),
    },
    inside=_inside,
    behind=_behind,
    companions=frozenset({kinds.GAIN_MAP, kinds.VIDEO}),
    keeps_turn=True,
    keep=_keep,
)
