"""Pixels of PNG files, packed in strips by several threads at once."""

from __future__ import annotations

import struct
import zlib
from typing import Final

import numpy as np

from kogao_core.base.geometry import Image
from kogao_core.base.threads import default_threads, share_in_order
from kogao_core.photo.metadata import chunks
from kogao_core.photo.model import channels_of

# Pillow's own level takes eight times as long and saves a tenth (docs/fidelity.md).
_LEVEL: Final = 1
_UP: Final = 2  # each line as its difference from the one above
_STRIP_BYTES: Final = 1 << 20
_COLOUR_TYPES: Final = {1: 0, 2: 4, 3: 2, 4: 6}
_RAW: Final = -zlib.MAX_WBITS  # no header and no checksum: strips have one of both together
_ZLIB_HEADER: Final = b"\x78\x01"  # a window of 32 KiB, the fastest level
_ADLER: Final = 65521

Strip = tuple[bytes, int, int]
"""Its chunk; the checksum and the number of the bytes that were packed."""


def header(pixels: Image) -> bytes:
    """Return the beginning of a file of pixels, up to the end of its header chunk."""
    height, width = pixels.shape[:2]
    colours = _COLOUR_TYPES[channels_of(pixels)]
    return chunks.SIGNATURE + chunks.made(
        b"IHDR", struct.pack(">IIBBBBB", width, height, 8 * pixels.itemsize, colours, 0, 0, 0)
    )


def packed(pixels: Image) -> list[bytes]:
    """Return the chunks that hold pixels, and the one that ends the file.

    The result doesn't depend on the number of threads.
    """
    lines = pixels.reshape(len(pixels), -1)
    rows = max(1, _STRIP_BYTES // (lines.shape[1] * lines.itemsize))
    tops = range(0, len(lines), rows)
    checksum, pieces = 1, list[bytes]()

    def take(_: int, strip: Strip) -> None:
        nonlocal checksum
        piece, own, count = strip
        checksum = _joined(checksum, own, count)
        pieces.append(piece)

    share_in_order(tops, lambda top: _packed(lines, top, rows), take, default_threads())
    return [*pieces, _idat(struct.pack(">I", checksum)), chunks.made(b"IEND", b"")]


def _packed(lines: Image, top: int, rows: int) -> Strip:
    filtered = _filtered(lines, top, min(len(lines), top + rows))
    packer = zlib.compressobj(_LEVEL, zlib.DEFLATED, _RAW)
    start = b"" if top else _ZLIB_HEADER
    end = zlib.Z_FINISH if top + rows >= len(lines) else zlib.Z_SYNC_FLUSH
    piece = _idat(start + packer.compress(filtered.data) + packer.flush(end))
    return piece, zlib.adler32(filtered.data), filtered.nbytes


def _idat(body: bytes) -> bytes:
    return chunks.made(b"IDAT", body)


def _filtered(lines: Image, top: int, bottom: int) -> Image:
    """Return lines as PNG stores them: bytes from the highest, less those above, by line's kind."""
    stored = lines[max(0, top - 1) : bottom]
    data = np.ascontiguousarray(stored, stored.dtype.newbyteorder(">")).view(np.uint8)
    filtered = np.empty((bottom - top, 1 + data.shape[1]), np.uint8)
    filtered[:, 0] = _UP
    if top == 0:
        filtered[0, 1:] = data[0]
    np.subtract(data[1:], data[:-1], out=filtered[len(filtered) - len(data) + 1 :, 1:])
    return filtered


def _joined(first: int, second: int, count: int) -> int:
    """Return the Adler-32 of two pieces from those of each; the second is `count` bytes long."""
    low, high = first & 0xFFFF, first >> 16
    low_of_second, high_of_second = second & 0xFFFF, second >> 16
    high = (high + high_of_second + count * (low - 1)) % _ADLER
    return high << 16 | (low + low_of_second - 1) % _ADLER
