"""Uncompressed pixels of TIFF files: they lie there as in memory, and need no decoder."""

from __future__ import annotations

from typing import IO, Any, Final

import numpy as np
from PIL import Image as Pillow
from PIL import TiffImagePlugin, TiffTags
from PIL.ExifTags import Base as Tag

from kogao_core.base.geometry import Image
from kogao_core.photo.metadata.upright import turn_upright
from kogao_core.photo.model import channels_of

UNCOMPRESSED: Final = 1
_BIG_ENDIAN: Final = b"MM"
_DEPTHS: Final[dict[tuple[int, int], np.dtype[Any]]] = {
    (16, 1): np.dtype(np.uint16),
    (32, 3): np.dtype(np.float32),
}
_FORMATS: Final = {"u": 1, "f": 3}
_UNSIGNED, _USUAL_ORDER = 1, 1  # of a byte's bits
_BLACK_IS_ZERO, _RGB, _INTERLEAVED = 1, 2, 1
_USUAL_STRIP: Final = 8192  # bytes, as TIFF advises
_MOST_SHORT: Final = 0xFFFF


def read(file: IO[bytes], tags: Pillow.Exif, orientation: int) -> Image | None:
    """Read deep pixels, upright, if they lie in a file uncompressed and one behind the other.

    Result (H, W) or (H, W, 3..4), uint16 or float32, or None: None, where it takes a decoder.
    """
    width, height = tags[Tag.ImageWidth], tags[Tag.ImageLength]
    samples = tags.get(Tag.SamplesPerPixel, 1)
    depth = _depth(tags, samples)
    start = None if depth is None else _start(tags, height, width * samples * depth.itemsize)
    if depth is None or start is None:
        return None
    file.seek(0)
    stored = depth.newbyteorder(">" if file.read(2) == _BIG_ENDIAN else "<")
    file.seek(start)
    pixels = np.fromfile(file, stored, height * width * samples)
    channels = () if samples == 1 else (samples,)
    pixels = pixels.astype(depth, copy=False).reshape(height, width, *channels)
    return turn_upright(pixels, orientation)


def _depth(tags: Pillow.Exif, samples: int) -> np.dtype[Any] | None:
    """Return the type that all channels have, if they are stored as in memory."""
    bits = numbers(tags, Tag.BitsPerSample)
    formats = numbers(tags, Tag.SampleFormat) or (_UNSIGNED,) * samples
    is_plain = (
        tags.get(Tag.Compression, UNCOMPRESSED) == UNCOMPRESSED
        and tags.get(Tag.FillOrder, _USUAL_ORDER) == _USUAL_ORDER
        and Tag.TileWidth not in tags
        and bits == bits[:1] * samples
        and formats == formats[:1] * samples
    )
    return _DEPTHS.get((bits[0], formats[0])) if is_plain else None


def _start(tags: Pillow.Exif, height: int, row_bytes: int) -> int | None:
    """Return where the pixels start, if one strip follows the other."""
    starts, lengths = (
        np.array(numbers(tags, tag), np.int64) for tag in (Tag.StripOffsets, Tag.StripByteCounts)
    )
    rows = min(int(tags.get(Tag.RowsPerStrip, height)), height)
    wanted = np.full(-(-height // max(1, rows)), rows * row_bytes)
    wanted[-1] -= len(wanted) * rows * row_bytes - height * row_bytes
    if not np.array_equal(lengths, wanted) or len(starts) != len(lengths):
        return None
    return int(starts[0]) if np.array_equal(np.diff(starts), lengths[:-1]) else None


def numbers(tags: Pillow.Exif, tag: int) -> tuple[int, ...]:
    """Return all numbers of an entry of a directory; none where there is no such entry."""
    value = tags.get(tag, ())
    return value if isinstance(value, tuple) else (value,)


def laid_out(pixels: Image) -> tuple[TiffImagePlugin.ImageFileDirectory_v2, memoryview]:
    """Return the directory of a file that holds pixels uncompressed, and its bytes of pixels.

    `directory`: as libtiff writes it, but strips are counted from the first pixel; `stored`: those
    of `pixels` themselves, where this machine stores numbers as the file does.
    """
    height, width = pixels.shape[:2]
    samples = channels_of(pixels)
    row_bytes = width * samples * pixels.itemsize
    rows = min(height, max(1, _USUAL_STRIP // row_bytes))
    starts = tuple(range(0, height * row_bytes, rows * row_bytes))
    lengths = tuple(min(rows * row_bytes, height * row_bytes - start) for start in starts)
    directory = TiffImagePlugin.ImageFileDirectory_v2()
    sizes = {
        Tag.ImageWidth: (width,),
        Tag.ImageLength: (height,),
        Tag.RowsPerStrip: (rows,),
        Tag.StripByteCounts: lengths,
    }
    for tag, values in sizes.items():
        directory.tagtype[tag] = TiffTags.SHORT if max(values) <= _MOST_SHORT else TiffTags.LONG
        directory[tag] = values
    directory[Tag.BitsPerSample] = (8 * pixels.itemsize,) * samples
    directory[Tag.SampleFormat] = (_FORMATS[pixels.dtype.kind],) * samples
    directory[Tag.Compression], directory[Tag.PlanarConfiguration] = UNCOMPRESSED, _INTERLEAVED
    directory[Tag.PhotometricInterpretation] = _BLACK_IS_ZERO if samples == 1 else _RGB
    directory[Tag.SamplesPerPixel] = samples
    directory[Tag.StripOffsets] = starts
    stored = np.ascontiguousarray(pixels, pixels.dtype.newbyteorder("<"))
    return directory, stored.reshape(-1).view(np.uint8).data
