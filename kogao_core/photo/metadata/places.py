"""What an XMP packet tells of the picture's sides and of places in it, turned with the picture.

Places that aren't understood well enough go (`stale`). Numbers keep as many decimals as they have.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from decimal import Decimal
from typing import Final

from kogao_core.photo.metadata import xmp
from kogao_core.photo.metadata.upright import Turn

_ADOBE: Final = "http://ns.adobe.com/"
_EXIF, _TIFF = f"{_ADOBE}exif/1.0/ ", f"{_ADOBE}tiff/1.0/ "
_AREA, _SIZE = f"{_ADOBE}xmp/sType/Area# ", f"{_ADOBE}xap/1.0/sType/Dimensions# "
_REGION: Final = "http://ns.microsoft.com/photo/1.2/t/Region# Rectangle"
_SUBJECTS: Final = (f"{_EXIF}SubjectArea", f"{_EXIF}SubjectLocation")
_DIMENSIONS: Final = (f"{_SIZE}w", f"{_SIZE}h")
_CENTRE: Final = (f"{_AREA}x", f"{_AREA}y")
_SIDES: Final = (
    _DIMENSIONS,
    (f"{_AREA}w", f"{_AREA}h"),
    (f"{_TIFF}XResolution", f"{_TIFF}YResolution"),
    (f"{_EXIF}FocalPlaneXResolution", f"{_EXIF}FocalPlaneYResolution"),
)
_RDF_ITEM: Final = f"{xmp.RDF} li"
_DEEPEST: Final = 16
_VALUE: Final = re.compile(rb"""=\s*["'](.*)["']$""", re.DOTALL)
_PART: Final = re.compile(rb"[^,\s]+")
_NUMBER: Final = re.compile(rb"-?\d{1,9}(\.\d{1,20})?")

_ORIENTATION: Final = re.compile(rb"""(tiff:Orientation(?:=["']|>)\s*)[1-8]""")
_SIZES: Final = [
    re.compile(rb"""((?:tiff:Image%s|exif:Pixel%sDimension)(?:=["']|>)\s*)[0-9]+""" % names)
    for names in ((b"Width", b"X"), (b"Length", b"Y"))
]
_THUMBNAILS: Final = (b"xmp:Thumbnails>", b"xap:Thumbnails>")

_Structure = dict[str, xmp.Span]
_Changes = Iterator[tuple[xmp.Span, bytes]]
_ONE: Final = Decimal(1)


class _Values(xmp.Walk):
    """Where the simple values of each structure of a packet lie, by name, and those of lists."""

    def __init__(self, packet: bytes) -> None:
        self.structures: dict[int, _Structure] = {}
        self.lists: dict[str, list[xmp.Span]] = {}
        super().__init__(packet, _DEEPEST)

    def starts(self, path: xmp.NamePath, attributes: dict[str, str], at: int) -> None:
        """Note the values of attributes."""
        if path and attributes:
            for name, span in zip(attributes, xmp.attribute_spans(self.packet, at), strict=True):
                if (value := _VALUE.search(self.packet, *span)) is not None:
                    self.structures.setdefault(at, {})[name] = value.span(1)

    def ends(self, path: xmp.NamePath, span: xmp.Span) -> None:
        """Note an element that holds text alone."""
        start = xmp.tag_end(self.packet, span[0])
        end = self.packet.rfind(b"</", start, span[1])
        is_text = 0 <= end == self.packet.find(b"<", start, span[1])
        if len(path) <= len(xmp.DESCRIPTION) or not is_text:
            return
        if path[-1] == _RDF_ITEM:
            self.lists.setdefault(path[-3], []).append((start, end))
        else:
            self.structures.setdefault(self._open[-1][1], {})[path[-1]] = start, end


def turned_xmp(packet: bytes, turn: Turn) -> bytes:
    """Return a packet for a picture that was turned, without its thumbnails.

    Regions of faces (MWG's and Microsoft's), EXIF's subject and resolutions are turned, sizes set.
    In a packet that can't be read, only what can be told by its words is.
    """
    for pattern, size in zip(_SIZES, (turn.width, turn.height), strict=True):
        packet = pattern.sub(rb"\g<1>%d" % size, packet)
    for name in _THUMBNAILS:
        packet = _without(packet, b"<" + name, b"</" + name)
    if turn.orientation == 1:
        return packet
    packet = _ORIENTATION.sub(rb"\g<1>1", packet)
    try:
        found = _Values(packet.rstrip(b"\0"))
    except xmp.BadXmp:
        return packet
    return xmp.replaced(packet, _new(packet, found, turn))


def _without(text: bytes, start: bytes, end: bytes) -> bytes:
    # In one pass: a hostile text may start a million times and never end.
    kept, at = [], 0
    while (first := text.find(start, at)) >= 0 and (last := text.find(end, first)) >= 0:
        kept.append(text[at:first])
        at = last + len(end)
    return b"".join([*kept, text[at:]])


def _new(packet: bytes, found: _Values, turn: Turn) -> dict[xmp.Span, bytes]:
    structures = list(found.structures.values())
    new: dict[xmp.Span, bytes] = {}
    with suppress(ValueError):  # sizes that are no numbers: the specification's axes
        if _is_upright(packet, structures, turn):
            names = {*_DIMENSIONS, *_CENTRE}
            structures = [one for one in structures if not names & one.keys()]
    for one in structures:
        new.update(_turned(packet, one, turn))
    ends = Decimal(turn.width - 1), Decimal(turn.height - 1)
    for name in _SUBJECTS:
        spans = found.lists.get(name, [])
        new.update(_changed(packet, spans[:2], lambda at: turn.place(at, ends)))
        new.update(_changed(packet, spans[2:4], turn.sides))
    return new


def _is_upright(packet: bytes, structures: list[_Structure], turn: Turn) -> bool:
    """Tell whether regions say that they apply to the upright picture, as some programs do."""
    for one in structures:
        if turn.swaps_sides and one.keys() >= set(_DIMENSIONS):
            width, height = (_number(packet, one[name]) for name in _DIMENSIONS)
            return width != height and (width > height) == (turn.width > turn.height)
    return False


def _turned(packet: bytes, structure: _Structure, turn: Turn) -> _Changes:
    for pair in _SIDES:
        if turn.swaps_sides and structure.keys() >= set(pair):
            spans = [structure[name] for name in pair]
            yield from zip(spans, [packet[slice(*span)] for span in spans[::-1]], strict=True)
    if structure.keys() >= set(_CENTRE):
        centre = [structure[name] for name in _CENTRE]
        yield from _changed(packet, centre, lambda at: turn.place(at, (_ONE, _ONE)))
    if _REGION in structure:
        parts = [part.span() for part in _PART.finditer(packet, *structure[_REGION])]
        yield from _changed(packet, parts, lambda of: _rectangle(of, turn))


def _rectangle(of: Sequence[Decimal], turn: Turn) -> tuple[Decimal, ...]:
    """Return a rectangle: left, top, width, height, in parts of the picture's."""
    left, top, width, height = of
    corners = [turn.place(at, (_ONE, _ONE)) for at in ((left, top), (left + width, top + height))]
    x, y = (min(places) for places in zip(*corners, strict=True))
    return (x, y, *turn.sides((width, height)))


def _changed(
    packet: bytes, spans: list[xmp.Span], change: Callable[[list[Decimal]], Iterable[Decimal]]
) -> _Changes:
    """Yield places in a packet with the numbers to write there; none, where there is another."""
    with suppress(ValueError, IndexError):
        changed = change([_number(packet, span) for span in spans])
        yield from zip(spans, (str(one).encode() for one in changed), strict=True)


def _number(packet: bytes, span: xmp.Span) -> Decimal:
    text = packet[slice(*span)].strip()
    if _NUMBER.fullmatch(text) is None:
        raise ValueError(text)
    return Decimal(text.decode())
