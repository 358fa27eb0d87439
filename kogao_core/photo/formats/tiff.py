"""TIFF, of 8 and 16 bits and of 32-bit floating-point numbers."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from importlib.util import find_spec
from math import prod
from typing import IO, Final

import cv2
import numpy as np
from PIL import Image as Pillow

from kogao_core.base.atomic import Pieces
from kogao_core.base.geometry import Image
from kogao_core.base.installed import adding
from kogao_core.base.language import Text
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats import colour, common, tiff_pixels
from kogao_core.photo.formats.base import Content, FileFormat, Reader, Source
from kogao_core.photo.metadata import kinds, tiff, tiff_extras, trailers
from kogao_core.photo.metadata.kinds import Extra
from kogao_core.photo.metadata.upright import turn_upright
from kogao_core.photo.model import Photo

_LZW: Final = 5
# Lossless ways that every reader knows; what was compressed otherwise becomes LZW.
_KEPT: Final = {
    tiff_pixels.UNCOMPRESSED,
    _LZW,
    8,
    32773,
    32946,
}  # none, LZW, Deflate, PackBits, Deflate's old number
# Readers differ: darktable and libvips take them for linear, Java's for sRGB, as is whatever was
# divided by 255.
_SEEN: Final = Text(
    "32-bit numbers without a colour profile are seen as sRGB: linear ones look dark, and are "
    "written right all the same"
)


def _decode(source: Source) -> Photo:
    file, path = source.file, source.path
    tags = tiff.TiffTags.read(file)
    source.check(tags.width, tags.height)
    tags.check_whole(os.fstat(file.fileno()).st_size)
    notes: tuple[str, ...] = ()
    profile = tags.icc_profile
    # Both decoders turn TIFF pixels upright themselves. OpenCV's takes damaged 8-bit strips for
    # good, so Pillow's is asked where it can.
    tags.check_first(path)
    tags.check_compression(path)
    if tags.is_deep:
        if tags.is_plain:
            pixels = tags.decode(file)
        else:
            pixels, profile, notes = _rare(source, tags)
        if pixels.dtype == np.float32 and profile is None:
            notes = (*notes, _SEEN)
    else:
        file.seek(0)
        with Pillow.open(file, formats=["TIFF"]) as image:
            image.load()
            pixels, profile, notes = colour.to_array(image, tags.bits)
        notes = notes or tags.converted
    # What is unknown may speak of the pixels as they are stored.
    is_as_stored = tags.orientation == 1 and not any(
        note.startswith(colour.CONVERTED) for note in notes
    )
    if tags.is_big:
        notes = (*notes, Text("a BigTIFF becomes an ordinary TIFF"))
    return Photo(
        np.ascontiguousarray(pixels),
        path,
        "TIFF",
        icc_profile=profile,
        exif=tags.exif,
        xmp=tags.xmp,
        dpi=common.dpi(tags.dpi),
        aspect=common.aspect(tags.aspect),
        orientation=tags.orientation,
        tiff_compression=tags.compression,
        photoshop=tags.photoshop,
        notes=notes,
        carried=(tags.rare,) if tags.rare and is_as_stored else (),
    )


def _rare(source: Source, tags: tiff.TiffTags) -> tuple[Image, bytes | None, tuple[str, ...]]:
    """Return deep pixels that OpenCV doesn't decode, upright, their profile, and notes."""
    tags.check_rare(source.path)
    if not all(map(find_spec, ("tifffile", "imagecodecs"))):
        raise UnreadablePhoto(
            Text(
                "{path} is a TIFF of a rare kind, which an extra reads: {how}",
                path=source.path,
                how=adding("tiff"),
            )
        )
    import tifffile  # an extra

    logging.getLogger("tifffile").setLevel(logging.CRITICAL)  # it would complain on stderr
    source.file.seek(0)
    with tifffile.TiffFile(source.file) as opened:
        page = opened.pages.first
        # What is lacking it would fill up with zeros.
        if len(page.dataoffsets) != prod(page.chunked) or 0 in page.databytecounts:
            raise ValueError(Text("parts of the picture are missing"))
        stored = np.asarray(page.asarray(maxworkers=1))
        if page.axes == "SYX":  # planes, one behind the other
            stored = np.moveaxis(stored, 0, -1)
    if stored.shape[:2] != (tags.height, tags.width) or stored.ndim > 3:
        raise ValueError(Text("a picture of another shape than it says"))
    stored = turn_upright(stored, tags.orientation)
    if tags.is_ink:
        inks = Pillow.fromarray((stored >> 8).astype(np.uint8), "CMYK")
        inks.info["icc_profile"] = tags.icc_profile
        pixels, profile, notes = colour.to_array(inks)
        return pixels, profile, (colour.narrowed(16), *notes)
    if stored.dtype == np.float16:
        half = Text("converted from 16-bit to 32-bit floating-point numbers")
        return tags.meant(stored.astype(np.float32)), tags.icc_profile, (half,)
    return tags.meant(np.ascontiguousarray(stored)), tags.icc_profile, ()


def _encode(content: Content) -> Pieces:
    number = content.photo.tiff_compression
    if number == tiff_pixels.UNCOMPRESSED:
        directory, stored = tiff_pixels.laid_out(content.pixels)
    else:
        how = (cv2.IMWRITE_TIFF_COMPRESSION, number if number in _KEPT else _LZW)
        directory, stored = tiff.taken_apart(colour.encoded_deep(content.pixels, how))
    return tiff.with_metadata(
        directory,
        stored,
        photoshop_resources=content.resources,
        aspect=content.photo.aspect,
        rare=b"".join(content.carried),
        **content.blocks,
    )


def _inside(photo: Photo, file: IO[bytes]) -> Iterator[Extra]:
    file.seek(0)
    kept = tiff.directory_of(photo.carried[0]) if photo.carried else ()
    return tiff_extras.found(tiff.TiffTags.read(file).tags, photo.channels, kept)


def _recoded(photo: Photo) -> str:
    number = photo.tiff_compression
    if number is None or number in _KEPT:
        return ""
    return Text(
        "compressed by LZW instead of {compression}", compression=tiff.compression_name(number)
    )


def _lacks(photo: Photo) -> str:
    if not photo.exif or tiff.entries_of(photo.exif) is not None:
        return ""
    return Text("the EXIF block is damaged, and TIFF can't hold it as it is: it is left out")


def _behind(file: IO[bytes]) -> Iterator[Extra]:
    file.seek(0)
    if file.read(4) == tiff.BIG_HEAD:
        return iter(())  # its directories are of another form
    end = tiff_extras.end(file)
    if end == file.seek(0, os.SEEK_END):
        return iter(())  # as nearly always, and pixels may be large
    file.seek(0)
    return trailers.found(file.read(), end)


TIFF: Final = FileFormat(
    name="TIFF",
    title="TIFF",
    mime="image/tiff",
    suffixes=(".tif", ".tiff"),
    is_lossless=True,
    encode=_encode,
    layouts=dict.fromkeys(("uint8", "uint16", "float32"), (1, 3, 4)),
    kept=frozenset(
        {
            *(kinds.EXIF, kinds.XMP, kinds.IPTC, kinds.ICC, kinds.GREY_PROFILE),
            *(kinds.RESOLUTION, kinds.ASPECT, kinds.TIFF_TAGS),
        }
    ),
    moved=frozenset({kinds.MAKER_NOTE, kinds.MOVED_NOTE}),
    reader=Reader(tiff.is_tiff, _decode),
    inside=_inside,
    behind=_behind,
    note=None,
    lacks=_lacks,
    recoded=_recoded,
)
