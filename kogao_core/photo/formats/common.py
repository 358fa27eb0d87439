"""The formats that Pillow recognises and decodes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from PIL import Image as Pillow
from PIL import JpegImagePlugin, UnidentifiedImageError

from kogao_core.language import Text
from kogao_core.photo import colour, contents, deep, jpeg_data, metadata, riff
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats.base import Source
from kogao_core.photo.model import Photo
from kogao_core.photo.turning import turn_upright

if TYPE_CHECKING:
    from kogao_core.photo.formats import SourceFormat


def decode(source: Source, names: tuple[SourceFormat, ...]) -> Photo:
    """Return the photo of a file that is of one of these formats.

    Raises
    ------
    UnreadablePhoto
        If it is a JPEG of a kind that libjpeg doesn't know.
    UnidentifiedImageError
        If it is none of them.
    """
    file = source.file
    try:
        opened = Pillow.open(file, formats=names)
    except UnidentifiedImageError:
        if contents.is_rare_jpeg(file):
            raise _rare(source) from None
        raise
    with opened as image:
        source.check(*image.size)
        jpeg = contents.jpeg_coding(image)
        deep_png = deep.is_16_bit_png(image, file)
        if deep_png:
            deep.verify_png(file)
        elif jpeg is not None:
            jpeg_data.check(file, source.path)
        decoded, damage = _decoded(image, source)
        contents.settle_profile(decoded, file)
        notes: tuple[str, ...] = ()
        if deep_png:
            pixels = deep.decode(source.data())
        else:
            pixels, image.info["icc_profile"], notes = colour.to_array(decoded)
        blocks = contents.blocks(image, file, 1 if pixels.ndim == 2 else pixels.shape[2])
        turn = metadata.orientation(blocks["exif"], blocks["xmp"])
        return Photo(
            turn_upright(pixels, turn),
            source.path,
            # MPO is what phones call a JPEG followed by a depth or gain map.
            "JPEG" if jpeg is not None else next(name for name in names if name == image.format),
            **blocks,
            **contents.density(image),
            orientation=turn,
            jpeg=jpeg if not notes else None,
            lossless_webp=riff.is_lossless(file),
            notes=(*damage, *notes),
        )


def _rare(source: Source) -> UnreadablePhoto:
    return UnreadablePhoto(
        Text(
            "{path} is a JPEG of a rare kind (hierarchical, or deeper than 8 bits); "
            "save it as an ordinary JPEG or as PNG first",
            path=source.path,
        )
    )


def _decoded(image: Pillow.Image, source: Source) -> tuple[Pillow.Image, tuple[str, ...]]:
    """Decode an open picture; return it, or what a JPEG without its end holds, and a note."""
    if isinstance(image, JpegImagePlugin.JpegImageFile):
        # At once: between pieces of 64 KiB it would wait for Python's lock.
        image.decodermaxblock = os.fstat(source.file.fileno()).st_size
    try:
        image.load()  # PNG metadata may follow the pixels, so even where OpenCV decodes them
    except OSError:
        if not isinstance(image, JpegImagePlugin.JpegImageFile):
            raise
        if contents.is_rare_jpeg(source.file):
            raise _rare(source) from None
        whole = jpeg_data.without_end(source.data())
        if whole is None:
            raise
        return whole, (Text("the file is slightly damaged: its end marker is missing"),)
    return image, ()
