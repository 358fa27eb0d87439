"""An edit record in an XMP packet, put between what is there: no other byte changes."""

from __future__ import annotations

import re
from datetime import datetime
from typing import Final, NoReturn
from xml.sax.saxutils import quoteattr

import kogao_core
from kogao_core.base.language import Text
from kogao_core.photo.errors import CannotDisclose
from kogao_core.photo.metadata import xmp

_MEDIA: Final = "http://ns.adobe.com/xap/1.0/mm/"
_EVENT: Final = "http://ns.adobe.com/xap/1.0/sType/ResourceEvent#"
_IPTC: Final = "http://iptc.org/std/Iptc4xmpExt/2008-02-29/"
_KINDS: Final = "http://cv.iptc.org/newscodes/digitalsourcetype/"
_EDITED: Final = f"{_KINDS}humanEdits"
# Only these are less than "edited by a human"; a composite, say, stays one.
_CAPTURE: Final = re.compile(
    f"{_KINDS}(digitalCapture|computationalCapture|negativeFilm|positiveFilm|print)\\b".encode()
)
_ABOUT: Final = f"{xmp.RDF} about"
_SOURCE_TYPE: Final = f"{_IPTC} DigitalSourceType"
_HISTORY: Final = (*xmp.DESCRIPTION, f"{_MEDIA} History")
_HISTORY_LIST: Final = (*_HISTORY, f"{xmp.RDF} Seq")


def added(packet: bytes | None, what: str, when: datetime) -> bytes:
    """Return an XMP packet with one more event in its history.

    The IPTC digital source type becomes "human edits" where there is none, or that of a capture.
    Raises CannotDisclose.
    """
    packet = (packet or xmp.EMPTY).rstrip(b"\0")
    places = _Places(packet)
    event = _event(what, when)
    edits, new = [], ""
    if places.source_type is None:
        new += f"<Iptc4xmpExt:DigitalSourceType>{_EDITED}</Iptc4xmpExt:DigitalSourceType>"
    else:
        start, end = places.source_type
        edits.append((start, end, _CAPTURE.sub(_EDITED.encode(), packet[start:end])))
    if places.sequence is not None:
        edits.append(xmp.appended(packet, places.sequence, event))
    elif places.has_history:
        _refuse(Text("its history is of an unknown form"))
    else:
        new += f"<xmpMM:History><rdf:Seq>{event}</rdf:Seq></xmpMM:History>"
    if new:
        edits.append(xmp.appended(packet, places.top, _description(places.about, new)))
    for start, end, content in sorted(edits, reverse=True):
        packet = packet[:start] + content + packet[end:]
    return packet


class _Places(xmp.Walk):
    """Where the parts of a packet lie.

    What is nested elsewhere is another picture's.
    """

    def __init__(self, packet: bytes) -> None:
        self.top: xmp.Span = (0, 0)
        self.sequence: xmp.Span | None = None
        self.source_type: xmp.Span | None = None
        self.has_history, self.about = False, ""
        try:
            super().__init__(packet, len(_HISTORY_LIST))
        except xmp.BadXmp as error:
            _refuse(str(error))
        if self.top == (0, 0):
            _refuse(Text("it holds no rdf:RDF"))

    def starts(self, path: xmp.NamePath, attributes: dict[str, str], at: int) -> None:
        """Note an attribute that holds the source type or a history."""
        if path == xmp.DESCRIPTION:
            self.about = self.about or attributes.get(_ABOUT, "")
            if _SOURCE_TYPE in attributes:
                self.source_type = at, xmp.tag_end(self.packet, at)
        self.has_history |= path == _HISTORY or (
            path == xmp.DESCRIPTION and _HISTORY[-1] in attributes
        )

    def ends(self, path: xmp.NamePath, span: xmp.Span) -> None:
        """Take down an element that is looked for."""
        if path == xmp.DESCRIPTION[:1]:
            self.top = span
        elif path == _HISTORY_LIST:
            self.sequence = span
        elif path == (*xmp.DESCRIPTION, _SOURCE_TYPE):
            self.source_type = span


def _description(about: str, content: str) -> str:
    return (
        f'<rdf:Description xmlns:rdf="{xmp.RDF}" xmlns:xmpMM="{_MEDIA}" '
        f'xmlns:Iptc4xmpExt="{_IPTC}" '
        f"rdf:about={quoteattr(about)}>{content}</rdf:Description>\n"
    )


def _event(what: str, when: datetime) -> str:
    """Return an event as the XMP specification part 2 defines it."""
    event = {
        "action": "edited",
        "when": when.isoformat(timespec="seconds"),
        "softwareAgent": f"Kogao {kogao_core.__version__}",
        "changed": "/",
        **({"parameters": what} if what else {}),
    }
    fields = " ".join(f"stEvt:{name}={quoteattr(value)}" for name, value in event.items())
    return f'<rdf:li xmlns:rdf="{xmp.RDF}" xmlns:stEvt="{_EVENT}" {fields}/>'


def _refuse(reason: str) -> NoReturn:
    raise CannotDisclose(
        Text(
            "the photo's XMP can't take an edit record ({reason}); save without one, or repair it",
            reason=reason,
        )
    )
