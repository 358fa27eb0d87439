"""PNG, of 8 and 16 bits."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import IO, Final

import cv2
import numpy as np
from PIL import PngImagePlugin

from kogao_core.atomic import Pieces
from kogao_core.photo import chunks, deep, kinds, trailers
from kogao_core.photo.formats.base import Content, FileFormat
from kogao_core.photo.kinds import Extra
from kogao_core.photo.model import Photo

_GREY_WITH_ALPHA: Final = 2
# Pillow's own level takes eight times as long and saves a tenth (docs/fidelity.md).
_LEVEL: Final = 1
_FAST: Final = (
    *(cv2.IMWRITE_PNG_COMPRESSION, _LEVEL),
    *(cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_DEFAULT),
    *(cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_UP),
)


def _encode(content: Content) -> Pieces:
    aspect = content.photo.aspect
    shape = () if aspect is None else (chunks.shape(aspect),)
    header, *rest = _plain(content)
    return [header, *shape, *content.carried, *rest]


def _plain(content: Content) -> Pieces:
    """Return the header, and in other pieces the rest."""
    xmp, resources = content.blocks.pop("xmp"), content.resources
    text = PngImagePlugin.PngInfo()
    if resources:
        # PNG itself knows no IPTC: this is where ImageMagick and ExifTool look for it.
        lines = "\n".join(textwrap.wrap(resources.hex(), 72))
        text.add_text("Raw profile type iptc", f"\niptc\n{len(resources):8}\n{lines}\n", zip=True)
    if xmp is not None:
        text.add_itxt("XML:com.adobe.xmp", xmp.decode("utf-8", "replace"))
    if content.pixels.ndim == 3 and content.pixels.shape[2] == _GREY_WITH_ALPHA:
        saved = content.saved("PNG", pnginfo=text, compress_level=_LEVEL)  # OpenCV knows none
        return chunks.taken_apart(saved)
    # Pillow can't write 16-bit colour and takes longer for the rest: OpenCV writes the pixels,
    # Pillow the chunks around them.
    empty = Content(content.photo, np.zeros((1, 1), np.uint8), content.blocks)
    carrier = empty.saved("PNG", pnginfo=text)
    header, pixels = chunks.taken_apart(deep.encode(content.pixels, ".png", _FAST))
    return [header, chunks.before_pixels(carrier), pixels]


def _inside(photo: Photo, file: IO[bytes]) -> Iterator[Extra]:
    return chunks.found(file, photo.channels)


def _behind(file: IO[bytes]) -> Iterator[Extra]:
    data = file.read()
    return trailers.found(data, chunks.end(data))


PNG: Final = FileFormat(
    name="PNG",
    title="PNG",
    suffixes=(".png",),
    is_lossless=True,
    encode=_encode,
    layouts={"uint8": (1, 2, 3, 4), "uint16": (1, 3, 4)},
    kept=frozenset(
        {
            *(kinds.EXIF, kinds.EXIF_TAGS, kinds.MAKER_NOTE, kinds.XMP, kinds.IPTC, kinds.ICC),
            *(kinds.GREY_PROFILE, kinds.RESOLUTION, kinds.ASPECT),
            *(kinds.TEXTS, kinds.COLOURS, kinds.CHUNKS),
        }
    ),
    moved=frozenset({kinds.MOVED_NOTE}),
    inside=_inside,
    behind=_behind,
)
