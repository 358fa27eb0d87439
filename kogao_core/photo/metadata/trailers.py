"""Trailers: data after the end of the picture, such as videos, gain maps and records."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from kogao_core.base.language import Text
from kogao_core.photo.jpeg import segments
from kogao_core.photo.metadata import kinds
from kogao_core.photo.metadata.kinds import Extra, Kind

_SAMSUNG_ENTRY: Final = 12  # bytes
_SAMSUNG_VIDEO: Final = b"MotionPhoto_Data"
# Text blocks with time, place and settings of the shot, without data of Samsung's photo editor.
_SAMSUNG_TEXTS: Final = re.compile(
    rb"(?:\0\0..[\4-\x1f]\0\0\0(?!PhotoEditor|Original)[ -~]{0,2000})+", re.DOTALL
)
_FTYP: Final = b"ftyp"
_BOX_HEAD: Final = 8
_FULL: Final = re.compile(rb"[^\0]")
_GAIN_MAPS: Final = (b"hdr-gain-map/1.0", b"HDRGainMap", b"urn:iso:std:iso:ts:21496:-1")
_DEPTHS: Final = (b"aux:depth", b"aux:disparity", b"portraiteffectsmatte", b"/depthmap/")


def found(data: bytes, start: int) -> Iterator[Extra]:
    """Yield the extras of a file from `start`, the end of the picture.

    Records of programs are detected by their last bytes, from the end backwards; other data by
    their first bytes. Zeros are padding.
    """
    end = len(data)
    records: list[Extra] = []
    while (record := _record(data, start, end)) is not None:
        end, extras = record
        records = [*extras, *records]
    yield from _from_start(data, start, end)
    yield from records


def box_end(data: bytes, at: int, end: int) -> int | None:
    """Return the end offset of an ISO base media box, or None."""
    if at + _BOX_HEAD > end or not data[at + 4 : at + 8].isalnum():
        return None
    size = int.from_bytes(data[at : at + 4], "big")
    if size == 1:
        size = int.from_bytes(data[at + 8 : at + 16], "big")
    if size == 0:
        return end
    return min(at + size, end) if size >= _BOX_HEAD else None


def _from_start(data: bytes, at: int, end: int) -> Iterator[Extra]:
    unknown = 0
    while at < end:
        if data[at] == 0 and data[at + 4 : at + 8] != _FTYP:
            full = _FULL.search(data, at, end)
            at = max(at + 1, full.start() - 3) if full else end  # a box starts with zeros, too
        elif data.startswith(segments.SOI, at, end):
            stop = min(segments.end_of_picture(data, at + 2)[0], end)
            kind = _kind_of_picture(data[at:stop])
            yield Extra(kind, data=data[at:stop] if kind is kinds.GAIN_MAP else b"")
            at = stop
        elif data[at + 4 : at + 8] == _FTYP:
            stop = _past_boxes(data, at, end)
            yield Extra(kinds.VIDEO, data=data[at:stop])
            at = stop
        else:
            stop = _next_known(data, at + 1, end)
            unknown += stop - at
            at = stop
    if unknown:
        yield Extra(
            kinds.UNKNOWN, Text("{unknown:,} bytes of unknown data at the end", unknown=unknown)
        )


def _next_known(data: bytes, at: int, end: int) -> int:
    places = [data.find(segments.SOI, at, end), data.find(_FTYP, at + 4, end) - 4]
    return min((place for place in places if place >= at), default=end)


def _past_boxes(data: bytes, at: int, end: int) -> int:
    while (stop := box_end(data, at, end)) is not None:
        at = stop
    return at


def _kind_of_picture(data: bytes) -> Kind:
    if any(sign in data for sign in _GAIN_MAPS):
        return kinds.GAIN_MAP
    return kinds.DEPTH if any(sign in data for sign in _DEPTHS) else kinds.FURTHER


def _record(data: bytes, start: int, end: int) -> tuple[int, tuple[Extra, ...]] | None:
    """Return the start offset of the record that ends at `end`, and its extras."""
    size = 0
    extras: tuple[Extra, ...] = ()
    if data.endswith(b"SEFT", start, end):
        size, extras = _samsung(data, start, end)
    elif data.endswith(b"cbipcbbl", start, end):
        size = 12 + int.from_bytes(data[end - 12 : end - 8], "big")
        extras = (_kept(kinds.PHOTO_MECHANIC, data[max(start, end - size) : end]),)
    elif data.endswith(b"\xa1\xb2\xc3\xd4", start, end):
        size = int.from_bytes(data[end - 8 : end - 4], "big")
        extras = (_kept(kinds.FOTOSTATION, data[max(start, end - size) : end]),)
    return (max(start, end - size), extras) if size > 0 else None


def _kept(kind: Kind, record: bytes) -> Extra:
    """Return a program's record; unknown data if the record holds a picture."""
    if segments.holds_picture(record):
        return Extra(kinds.UNKNOWN, kind.name)
    return Extra(kind, data=record)


def _samsung(data: bytes, start: int, end: int) -> tuple[int, tuple[Extra, ...]]:
    """Return the length of Samsung's record with its blocks, and the extras."""
    length = int.from_bytes(data[end - 8 : end - 4], "little")
    head = end - 8 - length
    if head < start or data[head : head + 4] != b"SEFH":
        return 0, ()
    starts = range(head + _SAMSUNG_ENTRY, end - 8 - _SAMSUNG_ENTRY + 1, _SAMSUNG_ENTRY)
    back = max((int.from_bytes(data[at + 4 : at + 8], "little") for at in starts), default=0)
    first = max(start, head - back)
    more: tuple[Extra, ...] = ()
    if (named := data.find(_SAMSUNG_VIDEO, first, head)) >= 0:
        start = named + len(_SAMSUNG_VIDEO)
        more = (Extra(kinds.VIDEO, data=data[start : _past_boxes(data, start, head)]),)
    if _SAMSUNG_TEXTS.fullmatch(data, first, head):
        return end - first, (*more, Extra(kinds.SAMSUNG, data=data[first:end]))
    return end - first, (*more, Extra(kinds.UNKNOWN, kinds.SAMSUNG.name))
