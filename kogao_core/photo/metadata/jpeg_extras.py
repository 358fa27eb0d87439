"""What a JPEG file holds ahead of its first scan beside the blocks that have a way of their own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import IO, Final

from kogao_core.base.language import Text
from kogao_core.photo.jpeg import segments
from kogao_core.photo.jpeg.segments import APP_OR_COMMENT
from kogao_core.photo.metadata import kinds, stale
from kogao_core.photo.metadata.kinds import Extra, Kind

_EXTENSION: Final = b"http://ns.adobe.com/xmp/extension/\0"
_PACKET: Final = b"http://ns.adobe.com/xap/1.0/\0"
_JUMBF: Final = b"JP"
_ISO_GAIN_MAP: Final = b"urn:iso:std:iso:ts:21496:-1\0"
# By marker and start; what starts otherwise is the maker's.
_KNOWN: Final[tuple[tuple[int, bytes, Kind], ...]] = (
    (0xFE, b"", kinds.COMMENTS),
    (0xE0, b"JFIF\0", kinds.RESOLUTION),
    (0xE0, b"JFXX\0", kinds.THUMBNAIL),
    (0xE1, b"Exif\0", kinds.EXIF),
    (0xE1, _PACKET, kinds.XMP),
    (0xE1, _EXTENSION, kinds.XMP_EXTENSION),
    (0xE2, b"ICC_PROFILE\0", kinds.ICC),
    (0xE2, b"MPF\0", kinds.INDEX),
    (0xE2, _ISO_GAIN_MAP, kinds.GAIN_MAP),
    (0xEB, b"HDR_RI", kinds.JPEG_HDR),
    (0xEB, _JUMBF, kinds.JUMBF),
    (0xED, segments.PHOTOSHOP_HEAD, kinds.IPTC),
)
_ADOBE_CODING: Final = (0xEE, b"Adobe")  # an encoder writes its own
# A maker's series of segments goes or stays as one.
_CARRIED: Final = (kinds.COMMENTS, kinds.SEGMENTS, kinds.XMP_EXTENSION, kinds.GAIN_MAP)
_NAMES: Final = {
    b"FPXR": Text("FlashPix data"),
    b"II\x1a\0": Text("CIFF data"),
    b"MM\0\x1a": Text("CIFF data"),
}


def carried(file: IO[bytes]) -> tuple[bytes, ...]:
    """Return segments that a changed photo keeps as they are.

    These are comments, the rest of a long XMP, what makers and programs add, and what goes along
    with a gain map. Those that hold a picture would show the photo as it was; the series that such
    a segment belongs to goes whole.
    """
    return tuple(segment for kind, segment in _judged(file) if kind in _CARRIED)


def is_extension(segment: bytes) -> bool:
    """Tell whether a segment holds part of the rest of a long XMP."""
    return segment[4:].startswith(_EXTENSION)


def tells_gain_map(segment: bytes) -> bool:
    """Tell whether a segment says that a gain map follows."""
    return segment[4:].startswith(_ISO_GAIN_MAP)


def found(file: IO[bytes]) -> Iterator[Extra]:
    """Yield what there is, in the order of the file."""
    packets = 0
    for kind, segment in _judged(file):
        packets += kind is kinds.XMP
        if kind is kinds.XMP and packets > 1:
            yield Extra(kinds.SECOND_XMP)
        elif kind is kinds.PREVIEW:
            yield Extra(kind, _preview_name(segment))
        elif kind not in (kinds.EXIF, kinds.XMP, kinds.ICC, kinds.IPTC, kinds.RESOLUTION):
            yield Extra(kind)
    whole, is_part_left = segments.profiles(file)
    if len(whole) > 1:
        yield Extra(kinds.SECOND_PROFILE)
    if is_part_left:
        yield Extra(kinds.SECOND_PROFILE, Text("an incomplete colour profile"))


def _judged(file: IO[bytes]) -> Iterator[tuple[Kind, bytes]]:
    found = [
        (_kind(code, segment), segment)
        for code, segment in segments.segments(file)
        if code in APP_OR_COMMENT
        and not (code == _ADOBE_CODING[0] and segment[4:].startswith(_ADOBE_CODING[1]))
    ]
    shown = {_series(one) for kind, one in found if kind is kinds.SEGMENTS and segments.SOI in one}
    is_signed = any(kind is kinds.JUMBF and b"c2pa" in segment for kind, segment in found)
    extension = b"".join(one for kind, one in found if kind is kinds.XMP_EXTENSION)
    is_stale = stale.is_picture_in(extension)
    for kind, segment in found:
        if kind is kinds.SEGMENTS and _series(segment) in shown:
            yield kinds.PREVIEW, segment
        elif kind is kinds.JUMBF and is_signed:
            yield kinds.CREDENTIALS, segment
        elif kind is kinds.XMP_EXTENSION and is_stale:
            yield kinds.DEPTH, segment
        else:
            yield kind, segment


def _kind(code: int, segment: bytes) -> Kind:
    for known, start, kind in _KNOWN:
        if code == known and segment[4:].startswith(start):
            return kind
    return kinds.SEGMENTS


def _series(segment: bytes) -> bytes:
    """Return the marker and the name that a maker's segments of one series start with."""
    return segment[1:2] + segment[4:].split(b"\0", 1)[0][:32]


def _preview_name(segment: bytes) -> str:
    place = f"APP{segment[1] & 15}"
    known = next((name for start, name in _NAMES.items() if segment[4:].startswith(start)), "")
    return Text("{known} ({place})", known=known or kinds.PREVIEW.name, place=place)
