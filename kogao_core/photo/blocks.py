"""JPEG to JPEG without compressing again what didn't change: the source's own blocks stay."""

from __future__ import annotations

import functools
import io
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Final

import jpeglib
import numpy as np
import numpy.typing as npt
from jpeglib import dct_jpeg

from kogao_core.atomic import aside
from kogao_core.geometry import Image
from kogao_core.photo.segments import APP_OR_COMMENT, START_OF_SCAN, segments
from kogao_core.stderr import hushed

_BLOCK_PX: Final = 8
_SEQUENTIAL_FRAMES: Final = (0xC0, 0xC1)  # baseline; extended, for 16-bit tables
_ARITHMETIC_FRAMES: Final = (0xC9, 0xCA)  # jpeglib's libjpeg knows none

Mask = npt.NDArray[np.bool_]


class CannotKeepBlocks(Exception):
    """The source's blocks don't fit the new file; the message says why."""


@dataclass(frozen=True, slots=True)
class Kept:
    """A JPEG file with the source's coefficients wherever no pixel changed.

    Parameters
    ----------
    data : bytes
        The file.
    share : float
        Part of the minimum coded units that are the source's, 0 to 1.
    damage : tuple of str
        The decoder's complaints about damaged data in the source.
    """

    data: bytes
    share: float
    damage: tuple[str, ...] = ()


def keep_blocks(source: Path, before: Image, after: Image, encoded: bytes, folder: Path) -> Kept:
    """Put a source's coefficients into a new encoding, except where pixels changed.

    Parameters
    ----------
    source : Path
        The JPEG file, with upright pixels.
    before, after : arrays of shape (H, W) or (H, W, C), uint8
        Its pixels and the new ones.
    encoded : bytes
        The new pixels as a JPEG with the source's tables and subsampling.
    folder : Path
        Where files may be laid aside for a moment: jpeglib knows nothing else.

    Returns
    -------
    Kept
        Sequential, with optimised Huffman codes and the headers of `encoded`.

    Raises
    ------
    CannotKeepBlocks
        If tables, subsampling, colours or size differ from the source's.
    """
    _check_coding(source)
    with aside(folder) as place, hushed() as complaints, _copies_in(place):
        fresh, merged = place / "fresh", place / "merged"
        fresh.write_bytes(encoded)
        old, new = _read(source), _read(fresh)
        _check_alike(old, new)
        factors = _factors(old)
        changed = _changed_units(before, after, factors.max(axis=0))
        for name, per_unit in zip(("Y", "Cb", "Cr"), factors, strict=False):
            kept = getattr(old, name)
            spread = changed.repeat(per_unit[0], axis=0).repeat(per_unit[1], axis=1)
            mask = spread[: kept.shape[0], : kept.shape[1]]
            kept[mask] = getattr(new, name)[mask]
            setattr(new, name, kept)
        new.write_dct(str(merged), flags=["+OPTIMIZE_CODING"])
        data = _with_headers_of(encoded, merged.read_bytes())
    return Kept(data, 1.0 - float(changed.mean()), tuple(complaints))


@contextmanager
def _copies_in(place: Path) -> Iterator[None]:
    """Let the copies that jpeglib makes of its sources lie there, not in the temporary folder.

    A program that is killed would leave whole photos there. One thread at a time.
    """
    theirs = dct_jpeg.tempfile
    dct_jpeg.tempfile = SimpleNamespace(
        NamedTemporaryFile=functools.partial(tempfile.NamedTemporaryFile, dir=place)
    )
    try:
        yield
    finally:
        dct_jpeg.tempfile = theirs


def _check_coding(source: Path) -> None:
    with source.open("rb") as file:
        if any(code in _ARITHMETIC_FRAMES for code, _ in segments(file)):
            raise CannotKeepBlocks("it is coded in a rare way")


def _read(path: Path) -> jpeglib.DCTJPEG:
    try:
        return jpeglib.read_dct(str(path))
    except (OSError, RuntimeError, ValueError) as error:
        raise CannotKeepBlocks("its blocks can't be read") from error


def _check_alike(old: jpeglib.DCTJPEG, new: jpeglib.DCTJPEG) -> None:
    # jpeglib's own comparison finds RGB and YCbCr equal.
    if old.jpeg_color_space.value != new.jpeg_color_space.value:
        raise CannotKeepBlocks("its colours are coded in another way")
    if (old.height, old.width) != (new.height, new.width):
        raise CannotKeepBlocks("its size has changed")
    if not np.array_equal(_factors(old), _factors(new)):
        raise CannotKeepBlocks("its chroma is subsampled in a rare way")
    if not np.array_equal(_tables(old), _tables(new)):
        raise CannotKeepBlocks("its quantisation tables can't be written again")


def _factors(jpeg: jpeglib.DCTJPEG) -> Image:
    """Return the blocks per unit (down, along) of each component, shape (components, 2)."""
    # A grey file is coded block by block, whatever its factors say.
    factors: Image = np.ones((1, 2), np.int64) if jpeg.Cb is None else jpeg.samp_factor
    return factors


def _tables(jpeg: jpeglib.DCTJPEG) -> Image:
    """Return the quantisation table of each component, shape (components, 8, 8)."""
    tables: Image = jpeg.qt[jpeg.quant_tbl_no]
    return tables


def _changed_units(before: Image, after: Image, factors: Image) -> Mask:
    """Return which minimum coded units hold a changed pixel, shape (rows, columns)."""
    height, width = before.shape[:2]
    unit_height, unit_width = (int(_BLOCK_PX * factor) for factor in factors)
    rows, columns = -(-height // unit_height), -(-width // unit_width)
    padded = np.zeros((rows * unit_height, columns * unit_width), bool)
    planes = (pixels.reshape(height, width, -1) for pixels in (before, after))
    for old, new in zip(*(np.moveaxis(plane, 2, 0) for plane in planes), strict=True):
        padded[:height, :width] |= old != new
    return np.asarray(padded.reshape(rows, unit_height, columns, unit_width).any(axis=(1, 3)))


def _with_headers_of(headers: bytes, body: bytes) -> bytes:
    """Return a JPEG's APP and comment segments, followed by all that isn't one of another's."""
    with io.BytesIO(headers) as mine, io.BytesIO(body) as theirs:
        kept = [segment for code, segment in segments(mine) if code in APP_OR_COMMENT]
        rest = [
            _renumbered(c, segment) for c, segment in segments(theirs) if c not in APP_OR_COMMENT
        ]
        return headers[:2] + b"".join([*kept, *rest, _renumbered(START_OF_SCAN, theirs.read())])


def _renumbered(code: int, segment: bytes) -> bytes:
    """Count components from 1, as JFIF demands; jpeglib counts from 0."""
    # Of the count; bytes each.
    starts = {**dict.fromkeys(_SEQUENTIAL_FRAMES, (9, 3)), START_OF_SCAN: (4, 2)}
    if code not in starts:
        return segment
    at, step = starts[code]
    renumbered = bytearray(segment)
    for k in range(segment[at]):
        renumbered[at + 1 + step * k] = k + 1
    return bytes(renumbered)
