"""An edit record in an XMP packet, put between what is there: no other byte changes."""

from __future__ import annotations

import re
from datetime import datetime
from typing import Final, NoReturn
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

import kogao_core
from kogao_core.photo.errors import CannotDisclose

_RDF: Final = "http://www.w3.org/1999/02/22-rdf-syntax-ns#"
_MEDIA: Final = "http://ns.adobe.com/xap/1.0/mm/"
_EVENT: Final = "http://ns.adobe.com/xap/1.0/sType/ResourceEvent#"
_IPTC: Final = "http://iptc.org/std/Iptc4xmpExt/2008-02-29/"
_KINDS: Final = "http://cv.iptc.org/newscodes/digitalsourcetype/"
_EDITED: Final = f"{_KINDS}humanEdits"
# Only these are less than "edited by a human"; a composite, say, stays one.
_CAPTURE: Final = re.compile(
    f"{_KINDS}(digitalCapture|computationalCapture|negativeFilm|positiveFilm|print)\\b".encode()
)
_ABOUT: Final = f"{_RDF} about"
_SOURCE_TYPE: Final = f"{_IPTC} DigitalSourceType"
_WRAPPER: Final = "adobe:ns:meta/ xmpmeta"
_DESCRIPTION: Final = (f"{_RDF} RDF", f"{_RDF} Description")
_HISTORY: Final = (*_DESCRIPTION, f"{_MEDIA} History")
_HISTORY_LIST: Final = (*_HISTORY, f"{_RDF} Seq")
_DEEPEST: Final = 1 + len(_HISTORY_LIST)
_NO_PACKET: Final = (
    '<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>\n'
    '<x:xmpmeta xmlns:x="adobe:ns:meta/">\n'
    f'<rdf:RDF xmlns:rdf="{_RDF}">\n</rdf:RDF>\n</x:xmpmeta>\n'
    '<?xpacket end="w"?>'
).encode()


_Span = tuple[int, int]
# A start tag that expat has found sound.
_TAG: Final = re.compile(rb"""<([^\s/>]+)(?:[^"'>]|"[^"]*"|'[^']*')*>""")


def added(xmp: bytes | None, what: str, when: datetime) -> bytes:
    """Return an XMP packet with one more event in its history.

    The IPTC digital source type becomes "human edits" where there is none, or that of a capture.

    Parameters
    ----------
    xmp : bytes, optional
        The packet so far.
    what : str
        A few words on what was done.
    when : datetime
        With a time zone.

    Raises
    ------
    CannotDisclose
        If the packet can't be read, or its history is of another form.
    """
    packet = (xmp or _NO_PACKET).rstrip(b"\0")
    places = _Places(packet)
    event = _event(what, when)
    edits, new = [], ""
    if places.source_type is None:
        new += f"<Iptc4xmpExt:DigitalSourceType>{_EDITED}</Iptc4xmpExt:DigitalSourceType>"
    else:
        start, end = places.source_type
        edits.append((start, end, _CAPTURE.sub(_EDITED.encode(), packet[start:end])))
    if places.sequence is not None:
        edits.append(_appended(packet, places.sequence, event))
    elif places.has_history:
        _refuse("its history is of an unknown form")
    else:
        new += f"<xmpMM:History><rdf:Seq>{event}</rdf:Seq></xmpMM:History>"
    if new:
        edits.append(_appended(packet, places.top, _description(places.about, new)))
    for start, end, content in sorted(edits, reverse=True):
        packet = packet[:start] + content + packet[end:]
    return packet


class _Places:
    """Where the parts of a packet lie, in bytes: from the first of the start tag to past the end.

    Attributes
    ----------
    top, sequence, source_type : tuple of int
        ``rdf:RDF``, the ``rdf:Seq`` of the history, and what tells the digital source type: an
        element, or the start tag whose attribute it is.
    has_history : bool
        Whether there is a history of any form.
    about : str
        Which picture the packet is about; one name for all descriptions.
    """

    def __init__(self, packet: bytes) -> None:
        self.top: _Span = (0, 0)
        self.sequence: _Span | None = None
        self.source_type: _Span | None = None
        self.has_history, self.about = False, ""
        self._open: list[tuple[str, int]] = []
        self._packet = packet
        parser = expat.ParserCreate("UTF-8", namespace_separator=" ")
        parser.StartElementHandler = self._starts
        parser.EndElementHandler = self._ends
        parser.StartDoctypeDeclHandler = _refuse_types
        self._parser = parser
        try:
            parser.Parse(packet, True)
        except expat.ExpatError as error:
            _refuse(str(error))
        if self.top == (0, 0):
            _refuse("it holds no rdf:RDF")

    def _starts(self, name: str, attributes: dict[str, str]) -> None:
        at = self._parser.CurrentByteIndex
        self._open.append((name, at))
        way = self._way()
        if way == _DESCRIPTION:
            self.about = self.about or attributes.get(_ABOUT, "")
            if _SOURCE_TYPE in attributes:
                self.source_type = at, _tag_end(self._packet, at)
        self.has_history |= way == _HISTORY or (way == _DESCRIPTION and _HISTORY[-1] in attributes)

    def _ends(self, _: str) -> None:
        way = self._way()
        _, start = self._open.pop()
        span = start, _element_end(self._packet, start, self._parser.CurrentByteIndex)
        if way == _DESCRIPTION[:1]:
            self.top = span
        elif way == _HISTORY_LIST:
            self.sequence = span
        elif way == (*_DESCRIPTION, _SOURCE_TYPE):
            self.source_type = span

    def _way(self) -> tuple[str, ...]:
        """Return the names from ``rdf:RDF`` down; what is nested elsewhere is another picture's."""
        if len(self._open) > _DEEPEST:  # a hostile packet may be nested a million deep
            return ()
        names = tuple(name for name, _ in self._open)
        return names[1:] if names[:1] == (_WRAPPER,) else names


def _refuse_types(*_: object) -> None:
    _refuse("it declares a document type")  # where entities that expand without end would be


def _tag_end(packet: bytes, start: int) -> int:
    tag = _TAG.match(packet, start)
    if tag is None:
        _refuse("it isn't UTF-8")
    return tag.end()


def _element_end(packet: bytes, start: int, end_tag: int) -> int:
    tag_end = _tag_end(packet, start)
    return tag_end if packet[tag_end - 2 : tag_end] == b"/>" else packet.index(b">", end_tag) + 1


def _appended(packet: bytes, span: _Span, content: str) -> tuple[int, int, bytes]:
    """Return where to put what, for an element to have more content at its end."""
    start, end = span
    tag_end = _tag_end(packet, start)
    if tag_end < end:
        at = packet.rindex(b"</", start, end)
        return at, at, content.encode()
    tag = _TAG.match(packet, start)
    assert tag is not None
    return end - 2, end, b">" + content.encode() + b"</" + tag[1] + b">"


def _description(about: str, content: str) -> str:
    return (
        f'<rdf:Description xmlns:rdf="{_RDF}" xmlns:xmpMM="{_MEDIA}" xmlns:Iptc4xmpExt="{_IPTC}" '
        f"rdf:about={quoteattr(about)}>{content}</rdf:Description>\n"
    )


def _event(what: str, when: datetime) -> str:
    """Return an event as the XMP specification part 2 defines it."""
    told = {
        "action": "edited",
        "when": when.isoformat(timespec="seconds"),
        "softwareAgent": f"Kogao {kogao_core.__version__}",
        "changed": "/",
        **({"parameters": what} if what else {}),
    }
    fields = " ".join(f"stEvt:{name}={quoteattr(value)}" for name, value in told.items())
    return f'<rdf:li xmlns:rdf="{_RDF}" xmlns:stEvt="{_EVENT}" {fields}/>'


def _refuse(reason: str) -> NoReturn:
    raise CannotDisclose(
        f"the photo's XMP can't take an edit record ({reason}); save without one, or repair it"
    )
