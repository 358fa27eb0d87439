"""A photo: its upright pixels and whatever must come out of the editor as it went in."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from kogao_core.base.display import preview
from kogao_core.base.geometry import Image
from kogao_core.photo.metadata.kinds import Extra, Kind

_ROWS: Final = 64


@dataclass(frozen=True, slots=True)
class JpegCoding:
    """How a JPEG file was compressed."""

    # Quantisation tables, 64 numbers each, in Pillow's order; none in a lossless file.
    tables: tuple[tuple[int, ...], ...]
    subsampling: int  # pillow's code: 0 is 4:4:4, 1 is 4:2:2, 2 is 4:2:0
    progressive: bool  # whether the scans are progressive
    # Version, unit and density of its JFIF segment, seven bytes; empty without one.
    jfif: bytes = b""


@dataclass(frozen=True, slots=True)
class Stamp:
    """What differs in a later version of a file: size in bytes and time of change in ns."""

    size: int
    changed_ns: int

    @staticmethod
    def of(state: os.stat_result) -> Stamp:
        """Return the stamp of a file's state."""
        return Stamp(state.st_size, state.st_mtime_ns)


@dataclass(frozen=True, slots=True, eq=False)
class Companion:
    """What goes along behind the picture of a JPEG: a gain map for HDR, a film, or a record."""

    kind: Kind
    data: bytes  # its own file, as it was read
    # What a gain map is to hold now, upright, and what it holds, as it lies.
    pixels: Image | None = None
    before: Image | None = None


@dataclass(frozen=True, eq=False)
class Photo:
    r"""A photograph as it was read.

    Parameters
    ----------
    pixels : array of shape (H, W) or (H, W, C)
        Grey, grey + alpha (C = 2), RGB or RGBA; uint8, uint16 or float32; upright; read-only.
    path : Path
        Where it was read.
    format : {"JPEG", "PNG", "TIFF", "WEBP", "AVIF", "HEIF", "RAW"}
        What the file is, whatever its name says; but raw files go by their names.
    icc_profile, exif, xmp : bytes, optional
        Metadata as stored; `exif` starts with ``Exif\0\0`` and still tells the file's own
        orientation.
    photoshop : bytes, optional
        Photoshop image resources, which hold the IPTC record.
    carried : tuple of bytes
        Segments of a JPEG or chunks of a PNG or WebP, as stored, or a directory of a TIFF's rare
        tags: what only its own format can hold.
    dpi : tuple of float, optional
        Print resolution (x, y).
    aspect : tuple of int, optional
        Pixels along x and y in the same length, where that is given without a resolution.
    orientation : int
        EXIF orientation 1 to 8 of the file; `pixels` are already turned by it, the metadata aren't.
    jpeg : JpegCoding, optional
        Compression of a JPEG source, for writing another like it.
    tiff_compression : int, optional
        TIFF's number of how a TIFF source was compressed, for writing another like it.
    lossless_webp : bool
        Whether a WebP source was lossless.
    stamp : Stamp, optional
        The version of the file that was read.
    notes : tuple of str
        What reading changed.
    extras : tuple of Extra
        What else is in the file; see `kinds`.
    companions : tuple of Companion
        What of it goes along into a changed JPEG; see `accompanied`.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> photo = kogao.read(kogao.sample())
    >>> photo.format, photo.width, photo.height, photo.bits
    ('JPEG', 900, 900, 8)
    >>> photo.pixels.flags.writeable
    False
    """

    pixels: Image
    path: Path
    format: str
    icc_profile: bytes | None = None
    exif: bytes | None = None
    xmp: bytes | None = None
    dpi: tuple[float, float] | None = None
    orientation: int = 1
    jpeg: JpegCoding | None = None
    lossless_webp: bool = False
    stamp: Stamp | None = None
    notes: tuple[str, ...] = ()
    photoshop: bytes | None = None
    carried: tuple[bytes, ...] = ()
    aspect: tuple[int, int] | None = None
    extras: tuple[Extra, ...] = ()
    tiff_compression: int | None = None
    companions: tuple[Companion, ...] = ()

    @property
    def width(self) -> int:
        """Columns of the upright photo, px."""
        return int(self.pixels.shape[1])

    @property
    def height(self) -> int:
        """Rows of the upright photo, px."""
        return int(self.pixels.shape[0])

    @property
    def channels(self) -> int:
        """Channels of a pixel: 1 to 4."""
        return channels_of(self.pixels)

    @property
    def is_as_read(self) -> bool:
        """Whether its file is still the version that was read."""
        try:
            # Saving over it earlier would have left other bytes there.
            return self.stamp is not None and Stamp.of(self.path.stat()) == self.stamp
        except OSError:
            return False

    @property
    def bits(self) -> int:
        """Bits per channel: 8, 16 or 32 (float)."""
        return 8 * int(self.pixels.dtype.itemsize)

    def _repr_png_(self) -> bytes:
        """Return the photo as a notebook shows it."""
        return preview(self.pixels)


def channels_of(pixels: Image) -> int:
    """Return the channels of pixels of shape (H, W) or (H, W, C)."""
    return 1 if pixels.ndim == 2 else int(pixels.shape[2])


def is_same(before: Image, after: Image) -> bool:
    """Tell whether pixels are the same, type and shape included; NaN equals nothing."""
    if before.dtype != after.dtype or before.shape != after.shape:
        return False
    # Some rows at a time: ends where they differ, and compares in no memory worth the name.
    tops = range(0, len(before), _ROWS)
    return all(np.array_equal(before[top : top + _ROWS], after[top : top + _ROWS]) for top in tops)
