"""Read and write DCT coefficients of JPEG files with jpeglib's copy of libjpeg-turbo.

This module calls the C functions directly, with NumPy arrays: jpeglib's classes decode a file twice
and copy both the file and the arrays.
"""

from __future__ import annotations

import ctypes
import io
import os
import sys
from collections.abc import Iterable
from concurrent.futures import Executor, Future
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from tempfile import gettempdir
from typing import Any, Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.language import TextError
from kogao_core.base.stderr import if_unsaid
from kogao_core.base.threads import default_threads, parallel_map
from kogao_core.photo.jpeg import scans
from kogao_core.photo.jpeg.segments import segments

BLOCK_PX: Final = 8
GREY, RGB, YCC = 1, 2, 3  # libjpeg's numbers of colour models
_LIBRARY: Final = "cjpeglib_turbo210.*[do]"  # the fastest that jpeglib has: half of 6b's time
_LONGEST: Final = 180  # letters of a folder, so that it opens files in it on every Windows
_OPTIMISE: Final = 1 << 6  # flag: compute optimised Huffman tables
_EVERY_FLAG: Final = 0xFFFFFFFF
_PART_ROWS: Final = 32  # of minimum coded units that are coded at once
_NUMBERS: Final = BLOCK_PX * BLOCK_PX
_MOST: Final = 4  # components, and tables
# Huffman codes: baseline, extended for 16-bit tables, progressive; then all there are.
_FRAMES: Final = (0xC0, 0xC1, 0xC2)
_ANY_FRAME: Final = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_JFIF, _ADOBE = 0xE0, 0xEE
_TRANSFORM_AT: Final = 15
_CODES: Final = 0xC4
_DECODING: Final = {*_ANY_FRAME, 0xDB, _CODES, 0xDD, _JFIF, _ADOBE}  # tables, codes, restarts
_COUNTS: Final = 17  # bytes of a Huffman table before its symbols: its number, and codes a length

Plane = npt.NDArray[np.int16]
_ahead: list[Future[tuple[bytes, Coefficients | None]]] = []  # see `read_ahead`


class CannotKeepBlocks(TextError):
    """A file's blocks can't be read, or don't fit the new file; the message says why."""


@dataclass(frozen=True, slots=True)
class Frame:
    """Frame header of a JPEG file: picture size in px, sampling factors and colour model."""

    height: int
    width: int
    # Blocks per minimum coded unit (down, along) of each component.
    factors: tuple[tuple[int, int], ...]
    colours: int  # `GREY`, `RGB` or `YCC`

    @property
    def unit_px(self) -> tuple[int, int]:
        """Height and width of a minimum coded unit."""
        down, along = (max(axis) for axis in zip(*self.factors, strict=True))
        return down * BLOCK_PX, along * BLOCK_PX

    @property
    def blocks(self) -> tuple[tuple[int, int], ...]:
        """Rows and columns of blocks of each component, without padding blocks."""
        high, wide = self.unit_px
        return tuple(
            (-(-self.height * down // high), -(-self.width * along // wide))
            for down, along in self.factors
        )


@dataclass(frozen=True, slots=True, eq=False)
class Coefficients:
    """All coefficients of a JPEG file, as quantised."""

    frame: Frame  # how they are laid out
    planes: tuple[Plane, ...]  # (rows, columns, 64): the blocks of each component
    tables: npt.NDArray[np.uint16]  # uint16 (4, 64): quantisation tables; zeros where there is none
    numbers: npt.NDArray[np.int16]  # int16 (4,): the table of each component
    # Whether the file uses the Huffman tables of annex K of the standard, like most cameras.
    has_usual_codes: bool

    @property
    def used(self) -> npt.NDArray[np.uint16]:
        """The tables of the components, shape (components, 64)."""
        return np.asarray(self.tables[self.numbers[: len(self.planes)]])


def read_ahead(path: Path, pool: Executor, photo: Future[Any]) -> None:
    """Read the coefficients of a file in another thread, for a later `read` of the same data.

    The thread first waits until the same file was read as a `photo`: a hostile file, which readers
    refuse, takes very long. The later call reads a damaged file again, to report the damage. Only
    on Linux: elsewhere, a signal could leave a temporary file.
    """

    def work() -> tuple[bytes, Coefficients | None]:
        return _early(path) if photo.exception() is None else (b"", None)

    _ahead.append(pool.submit(work))


def read_first(path: Path) -> None:
    """Read the coefficients of a file that was read as a photo, for a later `read`.

    While it reads, the library needs memory that a canvas can then have.
    """
    _ahead[:] = [Future()]  # not those of a photo that failed
    _ahead[0].set_result(_early(path))


def _early(path: Path) -> tuple[bytes, Coefficients | None]:
    if sys.platform == "linux":
        with suppress(OSError, CannotKeepBlocks), os.fdopen(os.memfd_create("jpeg")) as file:
            data, copy = path.read_bytes(), Path(f"/proc/self/fd/{file.fileno()}")
            return data, if_unsaid(lambda: _read(data, copy))
    return b"", None


def narrow(folder: Path) -> Path:
    """Return a folder for temporary files whose path the C library can open.

    On Windows the library takes neither letters outside the system's code page nor long paths.
    """
    if sys.platform == "win32":
        others = map(Path, (gettempdir(), os.environ.get("PROGRAMDATA", folder)))
        places = (one for one in (folder, *others) if len(str(one)) < _LONGEST)
        return next((one for one in places if str(one).isascii()), folder)
    return folder


def read(data: bytes, copy: Path) -> Coefficients:
    """Read the coefficients of a JPEG file. Raises CannotKeepBlocks."""
    for work in _ahead.copy():
        known, found = work.result()
        if known == data and found is not None:
            _ahead.remove(work)
            return found
    return _read(data, copy)


def _read(data: bytes, copy: Path) -> Coefficients:
    needed, start = _needed(data)
    frame, scans = _frame(needed), memoryview(data)[start:]
    # The library takes the array size from the file, so the copy must contain only one frame.
    with copy.open("wb") as out:
        out.writelines([b"\xff\xd8", *(segment for _, segment in needed), scans])
    planes = tuple(np.empty((*blocks, _NUMBERS), np.int16) for blocks in frame.blocks)
    tables, numbers = np.zeros((_MOST, _NUMBERS), np.uint16), np.zeros(_MOST, np.int16)
    is_done = _library().read_jpeg_dct(
        os.fsencode(copy), *_addresses(planes), *_addresses((tables, numbers), 2)
    )
    if not is_done:
        raise CannotKeepBlocks("its blocks can't be read")
    is_usual = _codes(needed) <= _usual_codes()
    return Coefficients(frame, planes, tables, numbers, is_usual)


def write(coefficients: Coefficients, folder: Path) -> bytes:
    """Return a sequential JPEG file with component numbers from 0.

    Standard Huffman tables are preserved: the data up to the first change then equal the source's,
    bit for bit. Threads code the parts of such a file, with the same result: the library copies the
    coefficients of a part. For other files, optimised tables are computed: smaller output, more
    time.
    """
    frame, last = coefficients.frame, coefficients.planes[-1][:, -1, -1]
    rows, down = -(-frame.height // frame.unit_px[0]), frame.factors[-1][0]
    ends = np.minimum(down * np.arange(1, rows + 1), len(last)) - 1  # the last unit may be cut
    most = max(default_threads(), rows // _PART_ROWS) if coefficients.has_usual_codes else 1
    parts = scans.parts(last[ends] == 0, most)
    # A part begins with the row before, because DC coefficients are coded as differences.
    wide = [(max(0, start - 1), stop) for start, stop in parts]
    heads = [(start - 1, start) for start, _ in parts[1:]]

    def code(some: tuple[int, int]) -> bytes:
        return _coded(coefficients, *some, folder / f"{some[0]}-{some[1]}")

    different = [*dict.fromkeys([*wide, *heads])]
    files = dict(zip(different, parallel_map(code, different), strict=True))
    if len(parts) == 1:
        return files[wide[0]]
    return scans.joined([files[one] for one in wide], [files[one] for one in heads], frame.height)


def _coded(coefficients: Coefficients, start: int, stop: int, file: Path) -> bytes:
    """Return a file of some rows of minimum coded units."""
    high = coefficients.frame.unit_px[0]
    height = min(coefficients.frame.height, stop * high) - start * high
    frame = replace(coefficients.frame, height=height)
    planes = [
        plane[start * down : stop * down]
        for plane, (down, _) in zip(coefficients.planes, frame.factors, strict=True)
    ]
    layout = ((frame.height, frame.width), frame.blocks, frame.factors)
    sizes = [np.array(one, np.intc) for one in layout]
    tables, numbers = coefficients.tables, coefficients.numbers
    is_done = _library().write_jpeg_dct(
        *(None, os.fsencode(file), *_addresses(planes)),
        *_addresses(sizes, 3),
        *(frame.colours, len(planes)),
        *(tables.ctypes.data, -1, numbers.ctypes.data),
        *(0, None, None, None, _OPTIMISE, 0 if coefficients.has_usual_codes else _EVERY_FLAG),
    )
    if not is_done:
        file.write_bytes(bytes(sum(plane.nbytes for plane in planes)))  # raises with the reason
        raise CannotKeepBlocks("its blocks can't be written")
    written = file.read_bytes()
    file.unlink()
    return written


def frame_of(data: bytes) -> Frame:
    """Return the frame header of a JPEG file. Raises CannotKeepBlocks."""
    return _frame(_needed(data)[0])


def _needed(data: bytes) -> tuple[list[tuple[int, bytes]], int]:
    """Return the segments that a decoder needs, and the position of the first scan's data."""
    with io.BytesIO(data) as file:
        found = [(code, segment) for code, segment in segments(file) if code in _DECODING]
        return found, file.tell()


def _frame(needed: list[tuple[int, bytes]]) -> Frame:
    frames = [(code, segment) for code, segment in needed if code in _ANY_FRAME]
    if len(frames) != 1 or len(frames[0][1]) < 10:
        raise CannotKeepBlocks("its blocks can't be read")
    code, segment = frames[0]
    height, width = (int.from_bytes(segment[at : at + 2], "big") for at in (5, 7))
    parts = [segment[at : at + 3] for at in range(10, len(segment) - 2, 3)]
    factors = tuple((part[1] & 15, part[1] >> 4) for part in parts)
    if len(segment) != 10 + 3 * segment[9] or not all(map(all, [(height, width), *factors])):
        raise CannotKeepBlocks("its blocks can't be read")
    if code not in _FRAMES or len(parts) not in (1, 3):
        raise CannotKeepBlocks("it is coded in a rare way")
    if len(parts) == 1:
        # Grey files ignore sampling factors: the blocks are coded one by one.
        return Frame(height, width, ((1, 1),), GREY)
    return Frame(height, width, factors, _colours(needed, bytes(part[0] for part in parts)))


def _colours(needed: list[tuple[int, bytes]], names: bytes) -> int:
    """Return the colour model that libjpeg assumes for three components with these names."""
    jfif, adobe = (
        [one for code, one in needed if code == marker and one[4:].startswith(name)]
        for marker, name in ((_JFIF, b"JFIF\0"), (_ADOBE, b"Adobe"))
    )
    if any(len(segment) >= 18 for segment in jfif):
        return YCC
    transforms = [segment[_TRANSFORM_AT] for segment in adobe if len(segment) > _TRANSFORM_AT]
    is_rgb = transforms[-1] == 0 if transforms else names == b"RGB"
    return RGB if is_rgb else YCC


def _codes(needed: Iterable[tuple[int, bytes]]) -> set[bytes]:
    """Return the Huffman tables in the segments, as stored."""
    found = set()
    for _, segment in (one for one in needed if one[0] == _CODES):
        rest = segment[4:]
        while rest:
            size = _COUNTS + sum(rest[1:_COUNTS])
            found.add(rest[:size])
            rest = rest[size:]
    return found


@cache
def _usual_codes() -> set[bytes]:
    """Return the standard's Huffman tables, OpenCV's default."""
    small = cv2.imencode(".jpg", np.zeros((BLOCK_PX, BLOCK_PX, 3), np.uint8))[1].tobytes()
    with io.BytesIO(small) as file:
        return _codes(segments(file))


@cache
def _library() -> ctypes.CDLL:
    """Load the C library without importing jpeglib: the import is slower than many photos."""
    found = find_spec("jpeglib")
    if found is None:
        raise CannotKeepBlocks("jpeglib isn't installed, or isn't available for this system")
    places = found.submodule_search_locations
    (file,) = Path((places or [""])[0], "cjpeglib").glob(_LIBRARY)
    library = ctypes.CDLL(str(file))
    name: Any = ctypes.c_char_p
    array, number = ctypes.c_void_p, ctypes.c_int
    library.read_jpeg_dct.argtypes = [name, *[array] * 6]
    library.write_jpeg_dct.argtypes = [
        *(name, name, *[array] * 7, number, number),
        *(array, ctypes.c_short, array),
        *(number, array, array, array, ctypes.c_uint, ctypes.c_uint),
    ]
    return library


def _addresses(arrays: Iterable[npt.NDArray[Any]], places: int = _MOST) -> list[int | None]:
    """Return the addresses of the arrays, padded with None to `places` items."""
    known: list[int | None] = [array.ctypes.data for array in arrays]
    return known + [None] * (places - len(known))
