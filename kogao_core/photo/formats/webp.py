"""WebP, lossless where nothing was lost in the source."""

from __future__ import annotations

from collections.abc import Iterator
from typing import IO, Final

from kogao_core.atomic import Pieces
from kogao_core.photo import kinds, riff, trailers
from kogao_core.photo.formats.base import Content, FileFormat
from kogao_core.photo.kinds import Extra
from kogao_core.photo.model import Photo

_QUALITY: Final = 95
_EFFORT: Final = 50  # of lossless WebP: a quarter of the time of 95, and 0.1 % longer


def _encode(content: Content) -> Pieces:
    del content.blocks["dpi"]  # WebP has no place for it, nor for Photoshop's resources
    lossless = content.is_lossless
    quality = _EFFORT if lossless else _QUALITY
    return [content.saved("WEBP", quality=quality, lossless=lossless, exact=True, method=4)]


def _inside(_: Photo, file: IO[bytes]) -> Iterator[Extra]:
    return riff.found(file)


def _behind(file: IO[bytes]) -> Iterator[Extra]:
    data = file.read()
    return trailers.found(data, riff.riff_end(data[:12]))


WEBP: Final = FileFormat(
    name="WEBP",
    title="WebP",
    suffixes=(".webp",),
    is_lossless=False,
    encode=_encode,
    layouts={"uint8": (3, 4)},
    longest_side_px=16383,
    kept=frozenset({kinds.EXIF, kinds.EXIF_TAGS, kinds.MAKER_NOTE, kinds.XMP, kinds.ICC}),
    moved=frozenset({kinds.MOVED_NOTE}),
    inside=_inside,
    behind=_behind,
)
