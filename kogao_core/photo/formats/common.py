"""The formats that Pillow recognises and decodes."""

from __future__ import annotations

import os
from typing import IO

from PIL import Image as Pillow
from PIL import JpegImagePlugin, UnidentifiedImageError

from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats import colour, deep, webp
from kogao_core.photo.formats.base import Source
from kogao_core.photo.formats.turning import turn_upright
from kogao_core.photo.jpeg import decoding
from kogao_core.photo.metadata import contents, upright
from kogao_core.photo.model import Photo, channels_of

_USUAL, _DEEP = 8, 16  # bits of a channel
_HEAD_BYTES = 16  # by which Pillow recognises a format


def decode(source: Source, names: tuple[str, ...]) -> Photo:
    """Return the photo of a file that is of one of these formats. Raises UnreadablePhoto."""
    file = source.file
    try:
        opened = Pillow.open(file, formats=names)
    except UnidentifiedImageError:
        if contents.is_rare_jpeg(file):
            raise _rare(source) from None
        _check_damage(file, names)
        raise
    with opened as image:
        source.check(*image.size)
        jpeg = contents.jpeg_coding(image)
        bits, is_grey = deep.png_layout(image, file) or (_USUAL, False)
        notes: tuple[str, ...] = ()
        sound = None
        if bits == _DEEP:
            deep.verify_png(file)
        elif jpeg is not None and decoding.check(file, source.path):
            sound = decoding.pixels(source.data(), image.size, image.mode)
        decoded, damage = (image, ()) if sound is not None else _decoded(image, source)
        contents.settle_profile(decoded, file)
        if sound is not None:
            pixels = sound
        elif bits == _DEEP:
            pixels, notes = _deep_png(image, source, is_grey=is_grey)
        else:
            pixels, image.info["icc_profile"], notes = colour.to_array(decoded, bits)
        blocks = contents.blocks(image, file, channels_of(pixels))
        if image.format == "WEBP":
            blocks["carried"] = webp.carried(file)
        turn = upright.orientation(blocks["exif"], blocks["xmp"])
        return Photo(
            turn_upright(pixels, turn),
            source.path,
            # MPO is what phones call a JPEG followed by a depth or gain map.
            "JPEG" if jpeg is not None else next(name for name in names if name == image.format),
            **blocks,
            **contents.density(image),
            orientation=turn,
            jpeg=jpeg if not notes else None,
            lossless_webp=webp.is_lossless(file),
            notes=(*damage, *notes),
        )


def _check_damage(file: IO[bytes], names: tuple[str, ...]) -> None:
    """Raise ValueError where a file that Pillow can't identify begins as one of the formats."""
    file.seek(0)
    head = file.read(_HEAD_BYTES)
    accepts = (Pillow.OPEN[name][1] for name in names)
    if any(accept is not None and accept(head) is True for accept in accepts):
        raise ValueError(Text("its headers are damaged"))


def _rare(source: Source) -> UnreadablePhoto:
    return UnreadablePhoto(
        Text(
            "{path} is a JPEG of a rare kind (hierarchical, or deeper than 8 bits); "
            "save it as an ordinary JPEG or as PNG first",
            path=source.path,
        )
    )


def _deep_png(
    image: Pillow.Image, source: Source, *, is_grey: bool
) -> tuple[Image, tuple[str, ...]]:
    """Return the pixels of a 16-bit PNG file, and notes; grey with alpha becomes RGBA."""
    pixels = deep.decode(source.data())
    if pixels.ndim == 2 and "transparency" in image.info:
        pixels = deep.with_alpha(pixels, image.info["transparency"])
    if pixels.ndim == 2 or not is_grey or not image.info.get("icc_profile"):
        return pixels, ()
    image.info["icc_profile"] = None
    return pixels, (Text("converted from grey to RGB, without its colour profile"),)


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
        whole = decoding.without_end(source.data())
        if whole is None:
            raise
        return whole, (Text("the file is slightly damaged: its end marker is missing"),)
    return image, ()
