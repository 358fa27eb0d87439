"""Write a changed JPEG: encode the changed blocks, copy all other blocks from the source."""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow

from kogao_core.base.atomic import temporary_folder
from kogao_core.base.geometry import Box, Image
from kogao_core.base.language import Text
from kogao_core.base.stderr import hushed
from kogao_core.photo.jpeg import coefficients
from kogao_core.photo.jpeg.coefficients import CannotKeepBlocks, Coefficients
from kogao_core.photo.jpeg.segments import APP_OR_COMMENT, START_OF_SCAN, segment, segments

_WORD: Final = 8  # pixel values compared at once
_ADOBE_RGB: Final = segment(0xEE, b"Adobe\0\x64" + bytes(5))  # version 100, no transform

Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Kept:
    """A JPEG file with the source's coefficients wherever no pixel changed."""

    data: bytes  # the file
    share: float  # share of the minimum coded units copied from the source, 0 to 1
    damage: tuple[str, ...] = ()  # the decoder's complaints about damaged data in the source


def keep_blocks(
    source: bytes, before: Image, after: Image, encode: Callable[[Box], bytes], folder: Path
) -> Kept:
    """Encode the surroundings of changed pixels and insert them into the source's coefficients.

    The result is sequential and has the headers from `encode`. The Huffman tables are the source's
    if standard, else optimised. Raises CannotKeepBlocks.
    """
    frame = coefficients.frame_of(source)
    if (frame.height, frame.width) != before.shape[:2]:
        raise CannotKeepBlocks(Text("its size has changed"))
    # One thread reads the source while this one encodes.
    with (
        temporary_folder(folder) as place,
        hushed() as complaints,
        ThreadPoolExecutor(1) as other,
    ):
        reading = other.submit(coefficients.read, source, place / "source")
        changed = _changed_units(before, after, frame.unit_px)
        units = _around(changed)
        high, wide = frame.unit_px
        box = Box(units.left * wide, units.top * high, units.right * wide, units.bottom * high)
        box = box.clipped(Box.of(before))
        encoded = encode(box)
        part = coefficients.read(encoded, place / "part")
        whole = reading.result()
        layouts = [(one.frame.colours, one.frame.factors) for one in (whole, part)]
        if layouts[0] != layouts[1] or not np.array_equal(whole.used, part.used):
            part = _by_component(after[box.slices], whole, place / "part")
        _put(part, whole, units, changed)
        merged = dataclasses.replace(whole, tables=part.tables, numbers=part.numbers)
        is_rgb = whole.frame.colours == coefficients.RGB
        data = _with_headers_of(encoded, coefficients.write(merged, place), is_rgb=is_rgb)
    return Kept(data, 1.0 - float(changed.mean()), tuple(complaints))


def _put(part: Coefficients, whole: Coefficients, box: Box, changed: Mask) -> None:
    """Copy the blocks of changed units into `whole`; `part` holds the blocks of a box."""
    for into, fresh, (down, along) in zip(
        whole.planes, part.planes, whole.frame.factors, strict=True
    ):
        at = Box(box.left * along, box.top * down, box.right * along, box.bottom * down)
        units = changed[box.slices].repeat(down, axis=0).repeat(along, axis=1)
        # Components end where the picture does, not with the last unit.
        mask = units[: fresh.shape[0], : fresh.shape[1]]
        into[at.slices][mask] = fresh[mask]


def _around(changed: Mask) -> Box:
    """Return the bounding box of all changed units; one unit if no unit changed."""
    rows, columns = (np.flatnonzero(changed.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return Box(0, 0, 1, 1)
    return Box(int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1)


def _by_component(pixels: Image, whole: Coefficients, copy: Path) -> Coefficients:
    """Return the coefficients of pixels as the whole's are: by a grey file for each component."""
    is_ycc = whole.frame.colours == coefficients.YCC
    seen = Pillow.fromarray(np.ascontiguousarray(pixels)).convert("YCbCr" if is_ycc else "RGB")
    most = np.max(whole.frame.factors, axis=0)
    planes: list[coefficients.Plane] = []
    for channel, factors, table in zip(
        seen.split(), whole.frame.factors, whole.used.tolist(), strict=True
    ):
        down, along = (most // factors).tolist()
        more = -channel.height % down, -channel.width % along
        full = np.pad(np.asarray(channel), [(0, one) for one in more], "edge")
        with io.BytesIO() as out:
            Pillow.fromarray(full).reduce((along, down)).save(out, "JPEG", qtables=[table])
            one = coefficients.read(out.getvalue(), copy)
        if one.used.tolist() != [table]:
            raise CannotKeepBlocks(Text("its quantisation tables can't be written again"))
        planes += one.planes
    return dataclasses.replace(whole, planes=tuple(planes))


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
