"""Read TIFF directories, and extend the directory of a file written by OpenCV."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Final

import numpy as np
from PIL import ExifTags, TiffImagePlugin
from PIL import Image as Pillow
from PIL import TiffTags as TiffTypes
from PIL.ExifTags import Base as Tag

from kogao_core.base.geometry import Image
from kogao_core.base.language import BadValue, Text
from kogao_core.base.stderr import no_warnings
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.metadata import photoshop

HEADS: Final = (b"II*\0", b"MM\0*")
_BIG_HEADS: Final = (b"II+\0", b"MM\0+")
_TEXT, _TEXT_UTF8 = 2, 129
# Types in EXIF's directories, where Pillow would guess from the values.
for _group, _kind, _tags in (
    (Tag.ExifOffset, TiffTypes.UNDEFINED, (0x9101, 0x927C, 0x9286, 0xA300, 0xA301, 0xA302, 0xA40B)),
    (Tag.ExifOffset, TiffTypes.SIGNED_RATIONAL, (0x9201, 0x9203, 0x9204, 0x9400, 0x9402, 0x9405)),
    (Tag.GPSInfo, TiffTypes.UNDEFINED, (0x1B, 0x1C)),
):
    TiffTypes.TAGS_V2_GROUPS.setdefault(_group, {}).update(
        {tag: TiffTypes.TagInfo(tag, str(tag), _kind, 1) for tag in _tags}
    )
# EXIF 3.0's texts, which Pillow skips, are read and written like other texts: byte by byte.
_LOADERS: Final = TiffImagePlugin.ImageFileDirectory_v2._load_dispatch
_LOADERS[_TEXT_UTF8] = _LOADERS[_TEXT]
DENSITY: Final = (Tag.XResolution, Tag.YResolution, Tag.ResolutionUnit)
_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _YCBCR = 0, 1, 2, 6
_CHANNELS: Final = {_WHITE_IS_ZERO: (1,), _BLACK_IS_ZERO: (1, 2), _RGB: (3, 4)}
_UNSIGNED, _SIGNED, _FLOAT = 1, 2, 3
_UNSPECIFIED, _PREMULTIPLIED = 0, 1
_MEANING: Final = Tag.PhotometricInterpretation
# Values of missing tags; otherwise 0.
_DEFAULTS: Final[dict[int, int]] = {
    **dict.fromkeys((Tag.BitsPerSample, Tag.Compression, Tag.FillOrder, Tag.Orientation), 1),
    **dict.fromkeys((Tag.SamplesPerPixel, Tag.PlanarConfiguration, Tag.SampleFormat), 1),
    **dict.fromkeys((_MEANING, Tag.ResolutionUnit, Tag.ExtraSamples), 2),  # RGB, inch, straight
}
_JPEGS: Final = (6, 7)
LOSSLESS: Final = {1, 5, 8, 32773, 32946}
"""Compressions that all readers support: none, LZW, Deflate, PackBits, old Deflate."""
_PILLOW_READS: Final = TiffImagePlugin.COMPRESSION_INFO.keys() - {50001}
_HEADER_BYTES = 8
RARE: Final = Text(
    "is a TIFF of a kind that Kogao doesn't read; save it as interleaved RGB with "
    "8 or 16 bits, or 32-bit float, with straight alpha"
)
# Exceptions of different Pillow versions for damaged blocks.
_DAMAGED: Final = (SyntaxError, struct.error, LookupError, AttributeError, TypeError, ValueError)
# Tags that describe the picture, not the storage: names, description, make, model, software, date,
# artist, computer, white point and primaries, ratings, copyright, Windows' texts, print matching.
PICTURE_TAGS: Final = (
    *(269, 270, 271, 272, 285, 305, 306, 315, 316, 318, 319, 0x4746, 0x4749, 33432),
    *(*range(0x9C9B, 0x9CA0), 50341, Tag.ExifOffset, Tag.GPSInfo),
)


# Tags of the pixel storage, metadata blocks that are written separately, layers, credentials and
# further directories.
_KNOWN: Final = {
    *(254, 255, 256, 257, 258, 259, 262, 263, 264, 265, 266, 273, 274, 277, 278, 279),
    *(282, 283, 284, 288, 289, 292, 293, 296, 317, 320, 322, 323, 324, 325, 330, 338, 339),
    *(347, 512, 513, 514, 515, 517, 518, 519, 520, 521, 529, 530, 531, 532),
    *(700, 33723, 34377, 34675, 34853, 34665, 37724, 40965, 52545),
    *PICTURE_TAGS,
}  # fmt: skip
# Types of texts, short and signed numbers, fractions. Other types may hold file offsets.
_WITHOUT_PLACES: Final = (_TEXT, 3, 5, 6, 8, 10, 11, 12, _TEXT_UTF8)
# Tags of extreme values, of inks, of the storage of Silicon Graphics and raw photos, and of
# geographic positions.
_OF_PIXELS: Final = {
    *(280, 281, 340, 341), *range(332, 338), *range(32995, 32999), *range(50706, 52600),
    *(33550, 33922, 34264),
}  # fmt: skip


# Tags of the file, which a changed TIFF keeps: subfile types, halftones, bit order, orientation,
# resolution, number of the page.
_OF_FILE: Final = (254, 255, 263, 264, 265, Tag.FillOrder, Tag.Orientation, *DENSITY, 297)


def is_rare(tag: int) -> bool:
    """Return True if a new directory does not set this tag."""
    return tag not in _KNOWN


def compression_name(number: int) -> str:
    """Return Pillow's name of a TIFF compression, or the number."""
    return TiffImagePlugin.COMPRESSION_INFO.get(number, str(number))


def is_tiff(file: IO[bytes], _: Path) -> bool:
    """Detect a TIFF file and rewind the file. Raises UnreadablePhoto."""
    head = file.read(4)
    file.seek(0)
    if head in _BIG_HEADS:
        raise UnreadablePhoto("is a BigTIFF; save it as an ordinary TIFF")
    return head in HEADS


@dataclass(frozen=True)
class TiffTags:
    """The first directory of a TIFF file, including files that Pillow cannot open."""

    tags: Pillow.Exif
    directory: TiffImagePlugin.ImageFileDirectory_v2  # the same, with the types of the tags
    iptc: bytes | None = None

    @staticmethod
    def read(file: IO[bytes]) -> TiffTags:
        tags, head = Pillow.Exif(), file.read(_HEADER_BYTES)
        file.seek(0)
        tags.load_from_fp(file)
        if Tag.ImageWidth not in tags or Tag.ImageLength not in tags:
            raise BadValue("a directory without a picture")
        there = _directory(head, file)
        # Most programs use 32-bit numbers; Pillow would keep the first number only.
        there.tagtype[Tag.IPTCNAA] = TiffTypes.UNDEFINED
        iptc = _in_order(there.get(Tag.IPTCNAA, b"")) or None
        return TiffTags(tags, there, iptc)

    def __getitem__(self, tag: int) -> int:
        """Return the first number of a tag, or TIFF's default."""
        value = self.tags.get(tag, _DEFAULTS.get(tag, 0))
        return int(value[0] if isinstance(value, tuple) else value)

    def check_whole(self, file_bytes: int) -> None:
        """Check that the file holds all pixels: libtiff would print warnings."""
        for places, lengths in (
            (Tag.StripOffsets, Tag.StripByteCounts),
            (Tag.TileOffsets, Tag.TileByteCounts),
        ):
            parts = zip(numbers(self.tags, places), numbers(self.tags, lengths), strict=False)
            if any(start + length > file_bytes for start, length in parts):
                raise BadValue("the file ends before its pixels")

    @property
    def orientation(self) -> int:
        """EXIF orientation, 1 to 8."""
        value = self[Tag.Orientation]
        return value if 1 <= value <= 8 else 1

    @property
    def pixel_bytes(self) -> int:
        return max(1, self[Tag.BitsPerSample] // 8) * self[Tag.SamplesPerPixel]

    @property
    def is_deep(self) -> bool:
        """Whether a channel has more than 8 bits."""
        return self[Tag.BitsPerSample] > 8

    @property
    def converted(self) -> tuple[str, ...]:
        """Note about conversions that Pillow does while decoding."""
        if self[Tag.ExtraSamples] == _PREMULTIPLIED:
            return (Text("converted from premultiplied to straight alpha"),)
        # A JPEG's pixels are RGB for everybody.
        if self[_MEANING] == _YCBCR and self[Tag.Compression] not in _JPEGS:
            return (Text("converted from {mode} to RGB", mode="YCbCr"),)
        return ()

    @property
    def is_inverted(self) -> bool:
        """Whether 0 is white (photometric interpretation WhiteIsZero)."""
        return self[_MEANING] == _WHITE_IS_ZERO

    @property
    def has_reversed_bits(self) -> bool:
        """Whether the first pixel is in the lowest bits of a byte (fill order 2)."""
        return self[Tag.FillOrder] == 2

    def check(self) -> None:
        """Check that the first picture is no thumbnail, and that compression and layout are known.

        Raises UnreadablePhoto.
        """
        is_copy = self[Tag.NewSubfileType] & 1
        if is_copy and (Tag.SubIFDs in self.tags or self.tags.get_ifd(ExifTags.IFD.IFD1)):
            raise UnreadablePhoto(
                "is a TIFF that begins with a small copy of its picture; save it as an "
                "ordinary TIFF first, or give a raw photo its own ending again"
            )
        number = self[Tag.Compression]
        if number not in (LOSSLESS if self.is_deep else _PILLOW_READS):
            raise UnreadablePhoto(
                "is a TIFF of a compression that Kogao doesn't read "
                "({compression}); save it uncompressed, or with LZW or Deflate",
                compression=compression_name(number),
            )
        samples = self[Tag.SamplesPerPixel]
        # OpenCV derives the number of channels from the photometric interpretation and fills
        # missing channels with uninitialised memory.
        if self.is_deep and not (
            self.depth in ((16, _UNSIGNED), (32, _FLOAT))
            and samples in _CHANNELS.get(self[_MEANING], ())
            and (samples == 1 or self[Tag.PlanarConfiguration] == 1)
            and self[Tag.ExtraSamples] != _PREMULTIPLIED
        ):
            raise UnreadablePhoto(RARE)
        if self[Tag.SampleFormat] == _SIGNED:
            raise UnreadablePhoto(RARE)

    @property
    def depth(self) -> tuple[int, int]:
        """Bits per channel and sample format: 1 unsigned, 3 float."""
        return self[Tag.BitsPerSample], self[Tag.SampleFormat]

    def meant(self, pixels: Image) -> Image:
        """Return decoded channels as grey, RGB or RGBA."""
        if self.is_inverted and pixels.dtype == np.uint16:
            np.invert(pixels, out=pixels)
        if pixels.ndim == 3 and self[Tag.ExtraSamples] == _UNSPECIFIED:
            return pixels[..., :3]  # a fourth channel is a selection, or anything
        return pixels

    @property
    def icc_profile(self) -> bytes | None:
        return _as_bytes(self.tags.get(Tag.InterColorProfile))

    @property
    def xmp(self) -> bytes | None:
        return _as_bytes(self.tags.get(Tag.XMLPacket))

    @property
    def photoshop(self) -> bytes | None:
        """Photoshop image resources; built from a separate IPTC record if necessary."""
        resources = _as_bytes(self.tags.get(Tag.ImageResources))
        if self.iptc is None or (resources and photoshop.iptc_of(resources)):
            return resources
        return (resources or b"") + photoshop.with_iptc(self.iptc)

    def density(self) -> tuple[tuple[Any, Any] | None, tuple[Any, Any] | None]:
        """Return the resolution (x, y) in dots per inch, or the pixel ratio if no unit is given."""
        x, y = (self.tags.get(tag) for tag in (Tag.XResolution, Tag.YResolution))
        unit = self[Tag.ResolutionUnit]
        if unit == 1 or x is None or y is None:
            return None, (x, y) if unit == 1 else None
        per_inch = {2: 1.0, 3: 2.54}.get(unit)
        return (x * per_inch, y * per_inch) if per_inch else None, None

    @property
    def exif(self) -> bytes | None:
        """The directory's entries about the picture, as a block like a JPEG's."""
        block = Pillow.Exif()
        for tag, value in _picture_tags(self.tags):
            block[tag] = value
        try:
            return block.tobytes() if len(block) else None
        except (struct.error, TypeError, ValueError):  # damaged entries, not worth the photo
            return None

    def kept(self, *, is_converted: bool) -> bytes:
        """Return a directory of the tags that a changed TIFF keeps, or b"".

        Kept: tags of the file, and unknown texts and numbers of a picture that is neither turned
        nor converted.
        """
        is_turned, kept = self.orientation != 1, TiffImagePlugin.ImageFileDirectory_v2()
        of_file = set(_OF_FILE).difference((Tag.Orientation, *DENSITY) if is_turned else ())
        of_file -= {Tag.FillOrder} if self.has_reversed_bits else set()
        for tag, kind in self.directory.tagtype.items():
            is_text = is_rare(tag) and tag not in _OF_PIXELS and kind in _WITHOUT_PLACES
            if tag in of_file or (is_text and not (is_turned or is_converted)):
                kept.tagtype[tag] = _TEXT if kind == _TEXT_UTF8 else kind
                kept[tag] = as_read(self.directory[tag])
        with io.BytesIO() as out:
            try:
                kept.save(out)
            except _DAMAGED:
                return b""
            return out.getvalue() if len(kept) else b""


def directory_of(rare: bytes) -> TiffImagePlugin.ImageFileDirectory_v2:
    """Parse a separate directory."""
    return _directory(rare[:_HEADER_BYTES], io.BytesIO(rare))


def numbers(tags: Pillow.Exif, tag: int) -> tuple[int, ...]:
    """Return all numbers of a tag; empty if the tag is missing."""
    value = tags.get(tag, ())
    return value if isinstance(value, tuple) else (value,)


def _directory(head: bytes, file: IO[bytes]) -> TiffImagePlugin.ImageFileDirectory_v2:
    directory = TiffImagePlugin.ImageFileDirectory_v2(head)
    file.seek(directory.next)
    directory.load(file)
    return directory


def _as_bytes(value: object) -> bytes | None:
    if isinstance(value, tuple):  # a wrong type in the file: numbers for bytes
        value = bytes(value)
    return value if isinstance(value, bytes) and value else None


def _in_order(iptc: bytes) -> bytes:
    """Restore the byte order of a record that was written as 32-bit numbers."""
    start = photoshop.IPTC_START
    if iptc[:1] != start and iptc[3:4] == start and len(iptc) % 4 == 0:
        return np.frombuffer(iptc, np.uint32).byteswap().tobytes()
    return iptc


def entries_of(exif: bytes | None) -> list[tuple[int, Any]] | None:
    """Return the tags that a TIFF directory can take from an EXIF block; None if damaged."""
    found, directory = told_by(exif), TiffImagePlugin.ImageFileDirectory_v2()
    with no_warnings():
        try:
            for tag, value in found or ():
                directory[tag] = value
            directory.save(io.BytesIO())
        except _DAMAGED:
            return None
    return found


def told_by(exif: bytes | None) -> list[tuple[int, Any]] | None:
    """Return the picture tags of an EXIF block; None if missing or damaged."""
    if exif is None:
        return None
    block = Pillow.Exif()
    with no_warnings():
        try:
            block.load(exif)
            density = [(tag, block[tag]) for tag in DENSITY if tag in block]
            return [*_picture_tags(block), *density]
        except _DAMAGED:
            return None


def _picture_tags(tags: Pillow.Exif) -> Iterator[tuple[int, Any]]:
    for tag in PICTURE_TAGS:
        if tag in tags and tag not in (Tag.ExifOffset, Tag.GPSInfo):
            yield tag, as_read(tags[tag])
    for tag in (Tag.ExifOffset, Tag.GPSInfo):
        if tag in tags:
            inner = {name: as_read(value) for name, value in tags.get_ifd(tag).items()}
            if (further := Tag.ExifInteroperabilityOffset) in inner:
                inner[further] = dict(tags.get_ifd(further))
            yield tag, inner


class _Text(str):
    """Text that encodes as Latin-1: Pillow reads Latin-1 but writes ASCII and "?"."""

    __slots__ = ()

    def encode(self, encoding: str = "latin-1", errors: str = "strict") -> bytes:
        del encoding, errors
        return super().encode("latin-1")


def as_read(value: object) -> object:
    """Return a tag value from Pillow in a form that Pillow writes unchanged."""
    return _Text(value) if isinstance(value, str) else value
