"""Google's directory of what follows a picture, and where a film lies, made true of a changed file.

Nothing else in the XMP packet changes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from kogao_core.photo.metadata import kinds, xmp
from kogao_core.photo.metadata.kinds import Kind

_SPACE: Final = "http://ns.google.com/photos/1.0/"
_DIRECTORY: Final = (*xmp.DESCRIPTION, f"{_SPACE}container/ Directory")
_ITEM: Final = (*_DIRECTORY, f"{xmp.RDF} Seq", f"{xmp.RDF} li")
_OFFSET: Final = f"{_SPACE}camera/ MicroVideoOffset"
_PROPERTY: Final = f"{_SPACE}container/item/ "
_SEMANTICS: Final = {"GainMap": kinds.GAIN_MAP, "MotionPhoto": kinds.VIDEO}
_PICTURE: Final = "Primary"
_VALUE: Final = re.compile(rb"""=\s*["'](.*)["']$|^<[^>]*>([^<]*)</""", re.DOTALL)
_DEEPEST: Final = 8


class _Items(xmp.Walk):
    """The items of the directory, each with where its values lie, and a film's offset."""

    def __init__(self, packet: bytes) -> None:
        self.items: dict[xmp.Span, dict[str, xmp.Span]] = {}
        self.offset: xmp.Span | None = None
        self._item: dict[str, xmp.Span] = {}
        super().__init__(packet, _DEEPEST)

    def starts(self, path: xmp.NamePath, attributes: dict[str, str], at: int) -> None:
        """Note attributes."""
        if path == xmp.DESCRIPTION or path[: len(_ITEM)] == _ITEM:
            for name, span in zip(attributes, xmp.attribute_spans(self.packet, at), strict=True):
                self._note(name, span)

    def ends(self, path: xmp.NamePath, span: xmp.Span) -> None:
        """Note elements, and the end of an item."""
        if path == _ITEM:
            self.items[span], self._item = self._item, {}
        elif path[-1:]:
            self._note(path[-1], span)

    def _note(self, name: str, span: xmp.Span) -> None:
        value = _VALUE.search(self.packet[slice(*span)])
        if value is None:
            return
        start, end = (span[0] + at for at in value.span(value.lastindex or 0))
        if name == _OFFSET:
            self.offset = start, end
        elif name.startswith(_PROPERTY):
            self._item[name.removeprefix(_PROPERTY)] = start, end


def adjusted(packet: bytes, lengths: Mapping[Kind, int]) -> bytes:
    """Return a packet that tells of the companions of these lengths, in bytes, and of no others.

    They lie one behind the other, the film last.
    """
    try:
        found = _Items(packet.rstrip(b"\0"))
    except xmp.BadXmp:
        return packet
    new: dict[xmp.Span, bytes] = {}
    for span, values in found.items.items():
        semantic = packet[slice(*values.get("Semantic", (0, 0)))].decode("latin-1")
        kind = _SEMANTICS.get(semantic)
        if semantic != _PICTURE and kind not in lengths:
            new[span] = b""
            continue
        length = 0 if kind is None else lengths[kind]
        told = {"Length": length, "Padding": 0}
        new |= {values[name]: b"%d" % told[name] for name in told if name in values}
    if found.offset is not None and kinds.VIDEO in lengths:
        new[found.offset] = b"%d" % lengths[kinds.VIDEO]
    return xmp.replaced(packet, new)


def tells_film(packet: bytes) -> bool:
    """Tell whether a packet says where a film lies, so that it can be found."""
    try:
        found = _Items(packet.rstrip(b"\0"))
    except xmp.BadXmp:
        return False
    items = (packet[slice(*one.get("Semantic", (0, 0)))] for one in found.items.values())
    return found.offset is not None or b"MotionPhoto" in items
