"""PNG, of 8 and 16 bits."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import IO, Final

import numpy as np
from PIL import PngImagePlugin

from kogao_core.base.atomic import Pieces
from kogao_core.photo.formats import png_pixels
from kogao_core.photo.formats.base import Content, FileFormat
from kogao_core.photo.metadata import chunks, kinds, trailers
from kogao_core.photo.metadata.kinds import Extra
from kogao_core.photo.model import Photo


def _encode(content: Content) -> Pieces:
    aspect = content.photo.aspect
    shape = () if aspect is None else (chunks.shape(aspect),)
    return [
        png_pixels.header(content.pixels),
        *shape,
        *content.carried,
        _metadata(content),
        *png_pixels.packed(content.pixels),
    ]


def _metadata(content: Content) -> bytes:
    """Return the chunks that Pillow makes of the blocks."""
    xmp, resources = content.blocks.pop("xmp"), content.resources
    text = PngImagePlugin.PngInfo()
    if resources:
        # PNG itself knows no IPTC: this is where ImageMagick and ExifTool look for it.
        lines = "\n".join(textwrap.wrap(resources.hex(), 72))
        text.add_text("Raw profile type iptc", f"\niptc\n{len(resources):8}\n{lines}\n", zip=True)
    if xmp is not None:
        text.add_itxt("XML:com.adobe.xmp", xmp.decode("utf-8", "replace"))
    empty = Content(content.photo, np.zeros((1, 1), np.uint8), content.blocks)
    return chunks.before_pixels(empty.saved("PNG", pnginfo=text))


def _inside(photo: Photo, file: IO[bytes]) -> Iterator[Extra]:
    return chunks.found(file, photo.channels)


def _behind(file: IO[bytes]) -> Iterator[Extra]:
    data = file.read()
    return trailers.found(data, chunks.end(data))


PNG: Final = FileFormat(
    name="PNG",
    title="PNG",
    mime="image/png",
    suffixes=(".png",),
    is_lossless=True,
    encode=_encode,
    layouts={"uint8": (1, 2, 3, 4), "uint16": (1, 3, 4)},
    kept=frozenset(
        {
            *(kinds.EXIF, kinds.EXIF_TAGS, kinds.MAKER_NOTE, kinds.XMP, kinds.IPTC, kinds.ICC),
            *(kinds.GREY_PROFILE, kinds.RESOLUTION, kinds.ASPECT),
            *(kinds.TEXTS, kinds.COLOURS, kinds.CHUNKS, kinds.THUMBNAIL),
        }
    ),
    moved=frozenset({kinds.MOVED_NOTE}),
    inside=_inside,
    behind=_behind,
)
