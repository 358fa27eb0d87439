"""A walk through an XMP packet that knows where everything lies, so that no byte must be rewritten.

expat finds the places; nothing is parsed and written anew.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final
from xml.parsers import expat

from kogao_core.base.language import Text

RDF: Final = "http://www.w3.org/1999/02/22-rdf-syntax-ns#"
DESCRIPTION: Final = (f"{RDF} RDF", f"{RDF} Description")
EMPTY: Final = (
    '<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>\n'
    '<x:xmpmeta xmlns:x="adobe:ns:meta/">\n'
    f'<rdf:RDF xmlns:rdf="{RDF}">\n</rdf:RDF>\n</x:xmpmeta>\n'
    '<?xpacket end="w"?>'
).encode()
"""A packet that says nothing."""
_WRAPPER: Final = "adobe:ns:meta/ xmpmeta"
# A start tag that expat has found sound, and one of its attributes.
_TAG: Final = re.compile(rb"""<([^\s/>]+)(?:[^"'>]|"[^"]*"|'[^']*')*>""")
_ATTRIBUTE: Final = re.compile(rb"""\s+([^\s=]+)\s*=\s*("[^"]*"|'[^']*')""")

Span = tuple[int, int]
NamePath = tuple[str, ...]


class BadXmp(ValueError):
    """The packet can't be read; the message says why."""


class Walk:
    """A walk through a packet; subclasses note what they look for.

    Names are ``namespace local``, ways the names from ``rdf:RDF`` down. A way is empty below the
    depth asked for: a hostile packet may be nested a million deep. Spans go from the first byte of
    a start tag to past the last one of the end tag.

    Raises
    ------
    BadXmp
        If the packet is no well-formed UTF-8, or declares a document type: that is where entities
        that expand without end would be.
    """

    def __init__(self, packet: bytes, deepest: int) -> None:
        self.packet = packet
        self._deepest = deepest + 1
        self._open: list[tuple[str, int]] = []
        parser = expat.ParserCreate("UTF-8", namespace_separator=" ")
        parser.StartElementHandler = self._starts
        parser.EndElementHandler = self._ends
        parser.StartDoctypeDeclHandler = _refuse_types
        self._parser = parser
        try:
            parser.Parse(packet, True)
        except expat.ExpatError as error:
            raise BadXmp(str(error)) from None

    def starts(self, path: NamePath, attributes: dict[str, str], at: int) -> None:
        """Handle a start tag."""

    def ends(self, path: NamePath, span: Span) -> None:
        """Handle the end of an element."""

    def _starts(self, name: str, attributes: dict[str, str]) -> None:
        at = self._parser.CurrentByteIndex
        self._open.append((name, at))
        self.starts(self._path(), attributes, at)

    def _ends(self, _: str) -> None:
        path = self._path()
        _, start = self._open.pop()
        self.ends(path, (start, self._element_end(start, self._parser.CurrentByteIndex)))

    def _path(self) -> NamePath:
        if len(self._open) > self._deepest:
            return ()
        names = tuple(name for name, _ in self._open)
        return names[1:] if names[:1] == (_WRAPPER,) else names

    def _element_end(self, start: int, end_tag: int) -> int:
        end = tag_end(self.packet, start)
        return end if self.packet[end - 2 : end] == b"/>" else self.packet.index(b">", end_tag) + 1


def _refuse_types(*_: object) -> None:
    raise BadXmp(Text("it declares a document type"))


def tag_end(packet: bytes, start: int) -> int:
    """Return where a start tag ends. Raises BadXmp."""
    return start + len(_tag(packet, start)[0])


def tag_name(packet: bytes, start: int) -> bytes:
    """Return the name of a start tag as it is written, with its prefix."""
    return bytes(_tag(packet, start)[1])


def _tag(packet: bytes, start: int) -> re.Match[bytes]:
    tag = _TAG.match(packet, start)
    if tag is None:
        raise BadXmp(Text("it isn't UTF-8"))
    return tag


def attribute_spans(packet: bytes, start: int) -> list[Span]:
    """Return where the attributes of a start tag lie, with the space before; no declarations."""
    end = tag_end(packet, start)
    found = _ATTRIBUTE.finditer(packet, start + 1 + len(tag_name(packet, start)), end)
    return [part.span() for part in found if part[1] != b"xmlns" and part[1][:6] != b"xmlns:"]


def replaced(packet: bytes, new: Mapping[Span, bytes]) -> bytes:
    """Return a packet with other bytes at some places; one within another is passed over."""
    kept, at = [], 0
    for (start, end), content in sorted(new.items()):
        if start >= at:
            kept += [packet[at:start], content]
            at = end
    return b"".join([*kept, packet[at:]])


def appended(packet: bytes, span: Span, content: str) -> tuple[int, int, bytes]:
    """Return where to put what, for an element to have more content at its end."""
    start, end = span
    if tag_end(packet, start) < end:
        at = packet.rindex(b"</", start, end)
        return at, at, content.encode()
    name = tag_name(packet, start)
    return end - 2, end, b">" + content.encode() + b"</" + name + b">"
