"""What else is in a photo's file: one reader for all formats, by the table in `kinds`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import IO

from PIL import Image as Pillow

from kogao_core.photo import (
    chunks,
    heif,
    jpeg_extras,
    kinds,
    riff,
    segments,
    stale,
    tiff,
    tiff_extras,
    trailers,
)
from kogao_core.photo.kinds import Extra
from kogao_core.photo.model import Photo


def found(photo: Photo, file: IO[bytes]) -> tuple[Extra, ...]:
    """Return what an open file holds beside pixels, profile, EXIF, XMP, IPTC and resolution.

    Parameters
    ----------
    photo : Photo
        What was read of it; a decoder may have told of extras already.
    file : file
        Open, anywhere.

    Returns
    -------
    tuple of Extra
        In the order things are found; each of them once.
    """
    seen = (*photo.extras, *_inside(photo, file), *_told(photo), *_behind(photo, file))
    return tuple(dict.fromkeys(seen))


def _inside(photo: Photo, file: IO[bytes]) -> Iterator[Extra]:
    channels = 1 if photo.pixels.ndim == 2 else photo.pixels.shape[2]
    if photo.format == "JPEG":
        yield from jpeg_extras.found(file)
    elif photo.format == "PNG":
        yield from chunks.found(file, channels)
    elif photo.format == "WEBP":
        yield from riff.found(file)
    elif photo.format == "TIFF":
        file.seek(0)
        yield from tiff_extras.found(tiff.TiffTags.read(file).tags, channels)
    elif photo.format == "HEIF":
        yield from heif.found(_all_of(file))


def _told(photo: Photo) -> Iterator[Extra]:
    """Yield what the metadata blocks tell of."""
    yield from map(Extra, stale.found(photo.xmp) if photo.xmp else ())
    if photo.exif is None:
        return
    tags = Pillow.Exif()
    try:
        tags.load(photo.exif)
        has_note = tiff_extras.has_maker_note(tags)
    except Exception:  # a damaged block, which is kept as it is
        return
    if photo.format == "RAW" and has_note:
        yield Extra(kinds.MOVED_NOTE)
    elif photo.format not in ("RAW", "TIFF"):
        if has_note:
            yield Extra(kinds.MAKER_NOTE)
        if rare := tiff_extras.rare_tags(tags):
            yield Extra(kinds.EXIF_TAGS, f"EXIF tags {' '.join(map(str, rare))}")


def _behind(photo: Photo, file: IO[bytes]) -> Iterator[Extra]:
    """Yield what follows the end of the picture."""
    if photo.format in ("RAW", "HEIF"):
        return
    data = _all_of(file)
    if photo.format == "JPEG":
        end, late = segments.end_of_picture(data, 2)
        if late:
            yield Extra(kinds.LATE_SEGMENTS)
    elif photo.format == "PNG":
        end = chunks.end(data)
    elif photo.format == "WEBP":
        end = riff.riff_end(data[:12])
    else:
        end = tiff_extras.end(data)
    yield from trailers.found(data, end)


def _all_of(file: IO[bytes]) -> bytes:
    file.seek(0)
    return file.read()
