"""Raw photos of cameras, developed by LibRaw. Read-only."""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Final

import numpy as np

from kogao_core.base.installed import adding
from kogao_core.base.language import Text
from kogao_core.photo import profiles
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats.base import FileFormat, Source
from kogao_core.photo.jpeg import segments
from kogao_core.photo.metadata import kinds, tiff, tiff_extras
from kogao_core.photo.metadata.kinds import Extra
from kogao_core.photo.model import Photo

_SUFFIXES: Final = (
    *(".dng", ".cr2", ".cr3", ".nef", ".nrw", ".arw", ".orf", ".raf"),
    *(".rw2", ".pef", ".srw"),
)
_PICTURES: Final = (segments.SOI, b"\x89PNG", b"RIFF")  # developed, in spite of the name


def _is_raw(file: IO[bytes], path: Path) -> bool:
    """Detect a raw photo by file name: most raw files are also valid TIFF files."""
    head = file.read(4)
    file.seek(0)
    return path.suffix.strip().lower() in _SUFFIXES and not head.startswith(_PICTURES)


def _decode(source: Source) -> Photo:
    """Develop a raw photo: sRGB, upright, with the camera's white balance."""
    path = source.path
    try:
        import rawpy  # an extra
    except ImportError:
        raise UnreadablePhoto(
            "is a raw photo, which an extra reads: {how}", how=adding("raw")
        ) from None
    data = source.data()
    try:
        with rawpy.imread(io.BytesIO(data)) as raw:
            source.check(raw.sizes.iwidth, raw.sizes.iheight, 3 * source.bits // 8)
            pixels = raw.postprocess(
                use_camera_wb=True,
                output_bps=source.bits,
                no_auto_bright=True,
                output_color=rawpy.ColorSpace.sRGB,
            )
    except rawpy.LibRawFileUnsupportedError:
        raise UnreadablePhoto(
            "is no raw photo that LibRaw knows; develop it elsewhere and open the result"
        ) from None
    if pixels.shape[2] == 1:  # a monochrome camera: the profile needs 3 channels
        pixels = np.repeat(pixels, 3, axis=2)
    note = Text("developed to {bits} bits with the camera's white balance", bits=source.bits)
    photo = Photo(pixels, path, "RAW", icc_profile=profiles.srgb())
    if not data.startswith(tiff.HEADS):
        more = Text("its metadata are of a kind that isn't kept")
        return dataclasses.replace(photo, notes=(note, more))
    tags = tiff.TiffTags.read(io.BytesIO(data))
    return dataclasses.replace(
        photo, exif=tags.exif, xmp=tags.xmp, orientation=tags.orientation, notes=(note,)
    )


def _inside(_: Photo, file: IO[bytes]) -> Iterator[Extra]:
    file.seek(0)
    head = file.read(4)
    file.seek(0)
    if head in tiff.HEADS and tiff_extras.CREDENTIALS in tiff.TiffTags.read(file).tags:
        yield Extra(kinds.CREDENTIALS)


RAW: Final = FileFormat(
    name="RAW",
    title=Text("raw"),
    suffixes=_SUFFIXES,
    is_lossless=True,
    recognises=_is_raw,
    decode=_decode,
    inside=_inside,
    note=kinds.MOVED_NOTE,
)
