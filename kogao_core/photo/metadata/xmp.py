"""Find elements and attributes in an XMP packet by byte position, to edit the packet in place."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final
from xml.parsers import expat

from kogao_core.base.language import TextError

RDF: Final = "http://www.w3.org/1999/02/22-rdf-syntax-ns#"
DESCRIPTION: Final = (f"{RDF} RDF", f"{RDF} Description")
EMPTY: Final = (
    '<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>\n'
    '<x:xmpmeta xmlns:x="adobe:ns:meta/">\n'
    f'<rdf:RDF xmlns:rdf="{RDF}">\n</rdf:RDF>\n</x:xmpmeta>\n'
    '<?xpacket end="w"?>'
).encode()
"""An empty packet."""
_DEEPEST: Final = 17  # elements within each other
_WRAPPER: Final = "adobe:ns:meta/ xmpmeta"
# A valid start tag, and one attribute of a start tag.
_TAG: Final = re.compile(rb"""<([^\s/>]+)(?:[^"'>]|"[^"]*"|'[^']*')*>""")
_ATTRIBUTE: Final = re.compile(rb"""\s+([^\s=]+)\s*=\s*("[^"]*"|'[^']*')""")

Span = tuple[int, int]
NamePath = tuple[str, ...]


class BadXmp(TextError, ValueError):
    """The packet can't be read; the message says why."""


@dataclass(frozen=True, slots=True)
class XmpPart:
    """An element or an attribute of a packet; RDF treats both alike."""

    path: NamePath  # ``namespace local`` names from ``rdf:RDF`` down to this part
    # From the start tag to the end of the end tag; for an attribute, with the space before.
    span: Span
    holder: int  # start of the parent element

    def value(self, packet: bytes) -> Span | None:
        """Return the span of the text, or None if the part has child elements."""
        start, end = self.span
        if packet[start : start + 1] != b"<":
            at = packet.index(b"=", start) + 1
            return at + len(packet[at:end]) - len(packet[at:end].lstrip()) + 1, end - 1
        start = tag_end(packet, start)
        end = packet.rfind(b"</", start, end)
        return (start, end) if 0 <= end == packet.find(b"<", start, self.span[1]) else None


def parts(packet: bytes) -> list[XmpPart]:
    """Return the parts of a packet: attributes at start tags, elements at end tags.

    Parts nested deeper than all known properties are skipped. Raises BadXmp if the packet is not
    well-formed UTF-8 or declares a document type, which could define entities that expand
    endlessly.
    """
    packet = packet.rstrip(b"\0")
    found: list[XmpPart] = []
    names: list[str] = []
    starts: list[int] = [0]
    parser = expat.ParserCreate("UTF-8", namespace_separator=" ")

    def path() -> NamePath:
        return tuple(names[names[:1] == [_WRAPPER] :])

    def start(name: str, attributes: dict[str, str]) -> None:
        at = parser.CurrentByteIndex
        names.append(name)
        starts.append(at)
        if attributes and len(names) <= _DEEPEST:
            spans = attribute_spans(packet, at)
            if len(spans) != len(attributes):
                raise BadXmp("it isn't UTF-8")
            for one, span in zip(attributes, spans, strict=True):
                found.append(XmpPart((*path(), one), span, at))

    def end(_: str) -> None:
        at = starts.pop()
        if len(names) <= _DEEPEST:
            stop = tag_end(packet, at)
            if packet[stop - 2 : stop] != b"/>":
                stop = packet.index(b">", parser.CurrentByteIndex) + 1
            found.append(XmpPart(path(), (at, stop), starts[-1]))
        names.pop()

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = _refuse_types
    try:
        parser.Parse(packet, True)
    except expat.ExpatError as error:
        raise BadXmp(str(error)) from None
    return found


def known_parts(packet: bytes) -> list[XmpPart]:
    """Return the parts of a packet; none if the packet is damaged."""
    try:
        return parts(packet)
    except BadXmp:
        return []


def _refuse_types(*_: object) -> None:
    raise BadXmp("it declares a document type")


def tag_end(packet: bytes, start: int) -> int:
    """Return the end offset of a start tag. Raises BadXmp."""
    return start + len(_tag(packet, start)[0])


def tag_name(packet: bytes, start: int) -> bytes:
    """Return the name of a start tag, with the prefix."""
    return bytes(_tag(packet, start)[1])


def _tag(packet: bytes, start: int) -> re.Match[bytes]:
    tag = _TAG.match(packet, start)
    if tag is None:
        raise BadXmp("it isn't UTF-8")
    return tag


def attribute_spans(packet: bytes, start: int) -> list[Span]:
    """Return the spans of the attributes of a start tag, with the space before; no namespaces."""
    end = tag_end(packet, start)
    found = _ATTRIBUTE.finditer(packet, start + 1 + len(tag_name(packet, start)), end)
    return [part.span() for part in found if part[1] != b"xmlns" and part[1][:6] != b"xmlns:"]


def replaced(packet: bytes, new: Mapping[Span, bytes]) -> bytes:
    """Replace spans of a packet. A span inside another span is skipped."""
    kept, at = [], 0
    for (start, end), content in sorted(new.items()):
        if start >= at:
            kept += [packet[at:start], content]
            at = end
    return b"".join([*kept, packet[at:]])


def appended(packet: bytes, span: Span, content: str) -> dict[Span, bytes]:
    """Return the replacement that appends content to an element."""
    start, end = span
    if tag_end(packet, start) < end:
        at = packet.rindex(b"</", start, end)
        return {(at, at): content.encode()}
    return {(end - 2, end): b">" + content.encode() + b"</" + tag_name(packet, start) + b">"}


def described(packet: bytes, parts: Iterable[XmpPart], rest: str) -> dict[Span, bytes]:
    """Return the replacement that appends an rdf:Description. Raises BadXmp.

    `rest`: attributes, the end of the start tag, and the content.
    """
    top = next((one.span for one in parts if one.path == DESCRIPTION[:1]), None)
    if top is None:
        raise BadXmp("it holds no rdf:RDF")
    return appended(packet, top, f'<rdf:Description xmlns:rdf="{RDF}" {rest}\n')
