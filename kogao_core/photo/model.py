"""A photo: upright pixels, and the metadata and coding to preserve when saving."""

from __future__ import annotations

import os
from dataclasses import KW_ONLY, dataclass, field
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

    # Quantisation tables, 64 numbers each, in Pillow's order; empty for a lossless file.
    tables: tuple[tuple[int, ...], ...]
    subsampling: int  # pillow's code: 0 is 4:4:4, 1 is 4:2:2, 2 is 4:2:0
    progressive: bool  # whether the scans are progressive
    # Version, unit and density from the JFIF segment, seven bytes; empty without a JFIF segment.
    jfif: bytes = b""


@dataclass(frozen=True, slots=True)
class Stamp:
    """File size in bytes and modification time in ns, used to detect changes."""

    size: int
    changed_ns: int
    file: int = field(default=0, compare=False)  # inode: drives may number files anew

    @staticmethod
    def of(state: os.stat_result) -> Stamp:
        """Create a stamp from a stat result."""
        return Stamp(state.st_size, state.st_mtime_ns, state.st_ino)


@dataclass(frozen=True, slots=True, eq=False)
class Companion:
    """Data after the main image of a JPEG: a gain map, a video or an application record."""

    kind: Kind
    data: bytes  # the embedded file, as read
    # Gain maps only: new pixels (upright) and old pixels (stored orientation).
    pixels: Image | None = None
    before: Image | None = None


@dataclass(frozen=True, eq=False)
class Photo:
    r"""A photo as read from a file.

    Parameters
    ----------
    pixels : array of shape (H, W) or (H, W, C)
        Grey, grey + alpha (C = 2), RGB or RGBA; uint8, uint16 or float32; upright; read-only.
    path : Path
        The file that was read.
    format : str
        Name of the `FileFormat`, detected from the content; for raw files, from the file name.
    icc_profile, exif, xmp : bytes, optional
        Metadata as stored. `exif` starts with ``Exif\0\0`` and contains the file's orientation.
    photoshop : bytes, optional
        Photoshop image resources, including the IPTC record.
    carried : tuple of bytes
        Format-specific data, copied unchanged: JPEG segments, PNG or WebP chunks, or a directory of
        rare TIFF tags.
    dpi : tuple of float, optional
        Print resolution (x, y).
    aspect : tuple of int, optional
        Pixel density ratio (x, y), for files without a print resolution.
    orientation : int
        EXIF orientation 1 to 8 of the file. Already applied to `pixels`, but not to the metadata.
    jpeg : JpegCoding, optional
        Compression of a JPEG source, reused when saving.
    tiff_compression : int, optional
        Compression tag of a TIFF source, reused when saving.
    lossless_webp : bool
        Whether a WebP source was lossless.
    stamp : Stamp, optional
        Size and modification time of the file when read.
    notes : tuple of str
        Messages about conversions during reading.
    extras : tuple of Extra
        Additional content of the file; see `kinds`.
    companions : tuple of Companion
        Data after the main image to copy to a changed JPEG; see `accompanied`.
    picture : str
        SHA-256 of the picture without metadata, see `picture.hashes_of`; empty for a new photo.
    sha256 : str
        SHA-256 of the file as read.

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
    _: KW_ONLY
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
    picture: str = ""
    sha256: str = ""

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
        """Whether the file is unchanged since it was read."""
        try:
            # An earlier save in place also changes the stamp.
            return self.stamp is not None and Stamp.of(self.path.stat()) == self.stamp
        except OSError:
            return False

    @property
    def bits(self) -> int:
        """Bits per channel: 8, 16 or 32 (float)."""
        return 8 * int(self.pixels.dtype.itemsize)

    def _repr_png_(self) -> bytes:
        """Return a PNG preview for notebooks."""
        return preview(self.pixels)


def channels_of(pixels: Image) -> int:
    """Return the channels of pixels of shape (H, W) or (H, W, C)."""
    return 1 if pixels.ndim == 2 else int(pixels.shape[2])


def is_same(before: Image, after: Image) -> bool:
    """Return whether two arrays have the same type, shape and bytes; NaN equals the same NaN."""
    if before.dtype != after.dtype or before.shape != after.shape:
        return False
    if before.dtype == np.float32:
        before, after = before.view(np.uint32), after.view(np.uint32)
    # Comparing blocks of rows needs little memory and stops at the first difference.
    tops = range(0, len(before), _ROWS)
    return all(np.array_equal(before[top : top + _ROWS], after[top : top + _ROWS]) for top in tops)
