"""Extras of a JPEG file: segments before the first scan and between scans."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from typing import IO, Final

from kogao_core.base.language import Text
from kogao_core.photo.jpeg import segments
from kogao_core.photo.jpeg.segments import APP_OR_COMMENT
from kogao_core.photo.metadata import kinds, references
from kogao_core.photo.metadata.kinds import Extra, Kind

_EXTENSION: Final = b"http://ns.adobe.com/xmp/extension/\0"
_PACKET: Final = b"http://ns.adobe.com/xap/1.0/\0"
_EXIF: Final = b"Exif\0"
_EXIF_AT: Final = 10
_TIFF_HEADS: Final = (b"II*\0", b"MM\0*")
_PACKET_AT: Final = 4 + len(_PACKET)
_JUMBF: Final = b"JP"
_ISO_GAIN_MAP: Final = b"urn:iso:std:iso:ts:21496:-1\0"
# Kinds by marker and first bytes. All other segments are makers' segments.
_KNOWN: Final[tuple[tuple[int, bytes, Kind], ...]] = (
    (0xFE, b"", kinds.COMMENTS),
    (0xE0, b"JFIF\0", kinds.RESOLUTION),
    (0xE0, b"JFXX\0", kinds.THUMBNAIL),
    (0xE1, _EXIF, kinds.EXIF),
    (0xE1, _PACKET, kinds.XMP),
    (0xE1, _EXTENSION, kinds.XMP_EXTENSION),
    (0xE2, b"ICC_PROFILE\0", kinds.ICC),
    (0xE2, b"MPF\0", kinds.INDEX),
    (0xE2, _ISO_GAIN_MAP, kinds.GAIN_MAP),
    (0xEB, b"HDR_RI", kinds.JPEG_HDR),
    (0xEB, _JUMBF, kinds.JUMBF),
    (0xED, segments.PHOTOSHOP_HEAD, kinds.IPTC),
    (0xEE, b"Adobe", kinds.ADOBE),
)
_RGB: Final = b"\0"  # Adobe's number for colours without a transform
# Metadata that is written separately.
_BLOCKS: Final = (kinds.EXIF, kinds.XMP, kinds.IPTC, kinds.RESOLUTION)
# A maker's series of segments goes or stays as one.
_CARRIED: Final = (
    *(kinds.COMMENTS, kinds.SEGMENTS, kinds.XMP_EXTENSION, kinds.GAIN_MAP, kinds.JUMBF),
    *(kinds.SECOND_XMP, kinds.SECOND_PROFILE),
)
_TEXTS: Final = (b"json", b"xml ", b"cbor")  # JUMBF's kinds of content


def carried(file: IO[bytes], *, is_grey: bool) -> tuple[bytes, ...]:
    """Return the segments that are copied into a changed photo.

    Copied: comments, the rest of a long XMP, further packets and profiles, data of cameras and
    programs, data of a gain map. Left out: segments with a picture, with their whole series,
    because the picture would show the original. The encoder writes a new Adobe segment for RGB.
    """
    return tuple(
        segment
        for kind, segment in _judged(_found(file))
        if kind in _CARRIED or (kind is kinds.ADOBE and (is_grey or segment[15:16] != _RGB))
    )


def exif(file: IO[bytes]) -> bytes | None:
    """Return the first EXIF block, ``Exif`` included; a long one goes on in the next segments."""
    found = [one for kind, one in _judged(_found(file)) if kind is kinds.EXIF]
    return b"".join([one[4 if n == 0 else _EXIF_AT :] for n, one in enumerate(found)]) or None


def packet(file: IO[bytes]) -> bytes | None:
    """Return the first XMP packet, as most readers do."""
    found = (one for kind, one in _judged(_found(file)) if kind is kinds.XMP)
    return next(found, b"")[_PACKET_AT:] or None


def with_packet(segment: bytes, change: Callable[[bytes], bytes]) -> bytes:
    """Apply a change to the XMP packet of a segment; return b"" if the result is too long."""
    if segment[4:_PACKET_AT] != _PACKET:
        return segment
    body = _PACKET + change(segment[_PACKET_AT:])
    return segments.segment(segment[1], body) if len(body) <= segments.MOST_BYTES else b""


def is_colour(segment: bytes) -> bool:
    """Return True if a segment holds part of a colour profile, or tells how colours are coded."""
    return kind_of(segment) in (kinds.ICC, kinds.ADOBE)


def found(file: IO[bytes], *, is_turned: bool) -> Iterator[Extra]:
    """Yield the extras before the first scan, in file order."""
    for kind, segment in _judged(_found(file)):
        if kind in (kinds.PREVIEW, kinds.UNKNOWN):
            name = kinds.JUMBF.name if kind_of(segment) is kinds.JUMBF else kind.name
            yield Extra(kind, Text("{known} (APP{n})", known=name, n=segment[1] & 15))
        elif kind is kinds.SECOND_XMP:
            yield Extra(kind)
            yield from map(Extra, references.found(segment[_PACKET_AT:], is_turned=is_turned))
        elif kind not in (*_BLOCKS, kinds.SECOND_PROFILE):
            yield Extra(kind)
    whole, rest = segments.profiles(file)
    if len(whole) > 1:
        yield Extra(kinds.SECOND_PROFILE)
    if rest:
        yield Extra(kinds.SECOND_PROFILE, Text("an incomplete colour profile"))


def _found(file: IO[bytes]) -> list[tuple[int, bytes]]:
    """Return marker and bytes of the segments before the first scan.

    Segments of the first colour profile are left out; other profiles come last.
    """
    whole, rest = segments.profiles(file)
    more = [(one[1], one) for one in (*chain(*whole[1:]), *rest)]
    return [one for one in segments.segments(file) if kind_of(one[1]) is not kinds.ICC] + more


def _judged(of: Iterable[tuple[int, bytes]]) -> Iterator[tuple[Kind, bytes]]:
    found = [(kind_of(segment), segment) for code, segment in of if code in APP_OR_COMMENT]
    shown = {
        _series(one)
        for kind, one in found
        if kind is kinds.SEGMENTS and segments.holds_picture(one)
    }
    is_signed = any(kind is kinds.JUMBF and b"c2pa" in segment for kind, segment in found)
    extension = b"".join(one for kind, one in found if kind is kinds.XMP_EXTENSION)
    holds_picture = references.is_picture_in(extension)
    packets = blocks = 0
    for kind, segment in found:
        packets += kind is kinds.XMP
        blocks += kind is kinds.EXIF and segment[_EXIF_AT:].startswith(_TIFF_HEADS)
        if kind is kinds.EXIF and blocks > 1:
            yield kinds.SECOND_EXIF, segment
        elif kind is kinds.XMP and packets > 1:
            yield kinds.SECOND_XMP, segment
        elif kind is kinds.ICC:
            yield kinds.SECOND_PROFILE, segment
        elif kind is kinds.SEGMENTS and _series(segment) in shown:
            yield kinds.PREVIEW, segment
        elif kind is kinds.JUMBF and is_signed:
            yield kinds.CREDENTIALS, segment
        elif kind is kinds.JUMBF and not _is_text(segment):
            yield kinds.UNKNOWN, segment
        elif kind is kinds.XMP_EXTENSION and holds_picture:
            yield kinds.DEPTH, segment
        else:
            yield kind, segment


def kind_of(segment: bytes) -> Kind:
    """Return the kind of a segment by its first bytes."""
    for known, start, kind in _KNOWN:
        if segment[1] == known and segment[4:].startswith(start):
            return kind
    return kinds.SEGMENTS


def _series(segment: bytes) -> bytes:
    """Return the marker and the name shared by a series of makers' segments."""
    return segment[1:2] + segment[4:].split(b"\0", 1)[0][:32]


def _is_text(segment: bytes) -> bool:
    """Return True if a JUMBF segment is one complete text box and not JPEG XT data."""
    size, box, _, described, content = struct.unpack_from(">I4sI4s4s", segment.ljust(32), 12)
    is_whole = size == len(segment) - 12 and (box, described) == (b"jumb", b"jumd")
    return is_whole and content in _TEXTS and not segments.holds_picture(segment)
