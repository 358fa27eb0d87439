"""Write a changed JPEG: code the changed blocks, copy all other blocks from the source.

The changed blocks need no encoder: this module computes the DCT coefficients, and the source's
quantisation tables and sampling factors apply.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.atomic import temporary_folder
from kogao_core.base.geometry import Array, Image
from kogao_core.base.stderr import hushed
from kogao_core.base.threads import default_threads, parallel_for
from kogao_core.photo.jpeg import coefficients
from kogao_core.photo.jpeg.coefficients import BLOCK_PX, CannotKeepBlocks, Coefficients
from kogao_core.photo.jpeg.segments import APP_OR_COMMENT, START_OF_SCAN, segment, segments

_WORD: Final = 8  # pixel values compared at once
_ADOBE_RGB: Final = segment(0xEE, b"Adobe\0\x64" + bytes(5))  # version 100, no transform
_STRIP_PX: Final = 128  # height of the strips that are coded at once: they stay in the cache
_MIDDLE: Final = 128.0  # the DCT counts from this level
# Y, Cb and Cr of red, green and blue (JFIF 1.02).
_RED, _BLUE = 0.299, 0.114
_YCC: Final = np.array(
    [
        (_RED, 1.0 - _RED - _BLUE, _BLUE, 0.0),
        (-_RED / 2.0 / (1.0 - _BLUE), (_RED + _BLUE - 1.0) / 2.0 / (1.0 - _BLUE), 0.5, _MIDDLE),
        (0.5, (_RED + _BLUE - 1.0) / 2.0 / (1.0 - _RED), -_BLUE / 2.0 / (1.0 - _RED), _MIDDLE),
    ],
    np.float32,
)

Mask = npt.NDArray[np.bool_]
Values = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Kept:
    """A JPEG file with the source's coefficients wherever no pixel changed."""

    data: bytes  # the file
    share: float  # share of the minimum coded units copied from the source, 0 to 1
    damage: tuple[str, ...] = ()  # the decoder's complaints about damaged data in the source


def keep_blocks(source: bytes, before: Image, after: Image, headers: bytes, folder: Path) -> Kept:
    """Return `source` with the changed pixels of `after`, and the metadata of the JPEG `headers`.

    `folder`: for temporary files. The result is sequential. The Huffman tables are the source's if
    standard, else optimised. Raises CannotKeepBlocks.
    """
    frame = coefficients.frame_of(source)
    if (frame.height, frame.width) != before.shape[:2]:
        raise CannotKeepBlocks("its size has changed")
    high, wide = frame.unit_px
    changed = np.zeros((-(-frame.height // high), -(-frame.width // wide)), bool)
    rows = max(1, _STRIP_PX // high)  # of units
    with temporary_folder(coefficients.narrow(folder)) as place, hushed() as complaints:
        whole = coefficients.read(source, place / "source")

        def code(top: int) -> None:
            """Code the changed units of a strip, from a row of units on."""
            strip = slice(top * high, (top + rows) * high)
            changed[top : top + rows] = _changed_units(before[strip], after[strip], frame.unit_px)
            _code(whole, after[strip], changed[top : top + rows], top)

        parallel_for(range(0, len(changed), rows), lambda: code, default_threads())
        is_rgb = frame.colours == coefficients.RGB
        data = _with_headers_of(headers, coefficients.write(whole, place), is_rgb=is_rgb)
    return Kept(data, 1.0 - float(changed.mean()), tuple(complaints))


def _code(whole: Coefficients, pixels: Image, changed: Mask, top: int) -> None:
    """Put the blocks of changed units into `whole`; `pixels` begin with row `top` of units."""
    columns = np.flatnonzero(changed.any(axis=0))
    if not len(columns):
        return
    high, wide = whole.frame.unit_px
    left, right = int(columns[0]), int(columns[-1]) + 1
    changed, pixels = changed[:, left:right], pixels[:, left * wide : right * wide]
    below, beside = high * len(changed) - pixels.shape[0], wide * (right - left) - pixels.shape[1]
    pixels = cv2.copyMakeBorder(
        np.ascontiguousarray(pixels), 0, below, 0, beside, cv2.BORDER_REPLICATE
    )
    if whole.frame.colours == coefficients.YCC:
        # Whole numbers, as decoders return: fractions would be rounded twice.
        pixels = cv2.transform(pixels, _YCC)
    for plane, component, (down, along), table in zip(
        whole.planes, cv2.split(pixels), whole.frame.factors, whole.used, strict=True
    ):
        size = BLOCK_PX * along * (right - left), BLOCK_PX * down * len(changed)
        values = np.asarray(component, np.float32)
        if size != values.shape[::-1]:
            values = np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA), np.float32)
        blocks = _quantised(values, table)
        # Components end where the picture does, not with the last unit.
        into = plane[top * down :, left * along :][: len(blocks), : blocks.shape[1]]
        mask = changed.repeat(down, axis=0).repeat(along, axis=1)[: into.shape[0], : into.shape[1]]
        into[mask] = blocks[: into.shape[0], : into.shape[1]][mask]


def _quantised(values: Values, table: npt.NDArray[np.uint16]) -> coefficients.Plane:
    """Return the quantised DCT coefficients of all blocks, shape (rows, columns, 64)."""
    rows, columns = values.shape[0] // BLOCK_PX, values.shape[1] // BLOCK_PX
    dct, divisors = _dct(), np.asarray(table.reshape(BLOCK_PX, BLOCK_PX), np.float32)
    across = np.matmul(dct, values.reshape(rows, BLOCK_PX, -1)).reshape(-1, BLOCK_PX) @ dct.T
    blocks = across.reshape(rows, BLOCK_PX, -1)
    blocks /= np.tile(divisors, columns)  # whole rows at once: four times as fast
    blocks[:, 0, ::BLOCK_PX] -= BLOCK_PX * _MIDDLE / divisors[0, 0]
    # Eight coefficients are one item of 16 bytes: twice as fast.
    items = np.rint(blocks, out=blocks).astype(np.int16).view("V16")
    ordered = np.ascontiguousarray(items.reshape(rows, BLOCK_PX, columns).transpose(0, 2, 1))
    return ordered.view(np.int16)


def _dct() -> Values:
    """Return the orthonormal DCT-II of eight values as a matrix (ITU-T T.81, A.3.3)."""
    order = np.arange(BLOCK_PX)
    waves: Array = np.cos(np.outer(order, 2 * order + 1) * (np.pi / 2 / BLOCK_PX))
    waves[0] /= np.sqrt(2.0)
    return np.asarray(waves * np.sqrt(2.0 / BLOCK_PX), np.float32)


def _changed_units(before: Image, after: Image, unit_px: tuple[int, int]) -> Mask:
    """Return which minimum coded units hold a changed pixel, shape (rows, columns)."""
    height, width = before.shape[:2]
    high, wide = unit_px
    changed = np.zeros((-(-height // high), -(-width // wide)), bool)
    values = before[0].size
    words = wide * values // width // _WORD  # of a row of a unit
    differs = np.zeros(-(-values // _WORD) * _WORD, np.uint8)
    for row, top in enumerate(range(0, height, high)):
        # Turned pixels are copied here, some rows at a time.
        old, new = (pixels[top : top + high].reshape(-1, values) for pixels in (before, after))
        # Whole rows at once: ten times as fast as asking for any difference pixel by pixel.
        np.bitwise_or.reduce(np.bitwise_xor(old, new), axis=0, out=differs[:values])
        changed[row, np.flatnonzero(differs.view(np.uint64)) // words] = True
    return changed


def _with_headers_of(headers: bytes, body: bytes, *, is_rgb: bool) -> bytes:
    """Combine the APP and comment segments of one JPEG with all other segments of another.

    RGB components are marked by the Adobe segment and by names: JFIF allows YCbCr only.
    """
    with io.BytesIO(headers) as mine, io.BytesIO(body) as theirs:
        kept = [one for code, one in segments(mine) if code in APP_OR_COMMENT]
        rest = [one for code, one in segments(theirs) if code not in APP_OR_COMMENT]
        scans = theirs.read()
    if is_rgb:
        kept = [_ADOBE_RGB, *(one for one in kept if not one[4:].startswith(b"JFIF\0"))]
    else:
        rest = [_renumbered(one[1], one) for one in rest]
        scans = _renumbered(START_OF_SCAN, scans)
    return headers[:2] + b"".join([*kept, *rest, scans])


def _renumbered(code: int, body: bytes) -> bytes:
    """Count components from 1, as JFIF demands; jpeglib counts from 0."""
    # Of the count; bytes each.
    starts = {0xC0: (9, 3), 0xC1: (9, 3), START_OF_SCAN: (4, 2)}
    if code not in starts:
        return body
    at, step = starts[code]
    renumbered = bytearray(body)
    for k in range(body[at]):
        renumbered[at + 1 + step * k] = k + 1
    return bytes(renumbered)
