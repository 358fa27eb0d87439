"""Disclose a retouch on request: an edit record in the XMP, a label in the picture."""

from __future__ import annotations

import dataclasses
import html
import re
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

import kogao_core
from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.photo.disclosure.label import draw_label
from kogao_core.photo.errors import CannotDisclose
from kogao_core.photo.metadata import xmp
from kogao_core.photo.model import Photo, is_same

_MEDIA: Final = "http://ns.adobe.com/xap/1.0/mm/"
_EVENT: Final = "http://ns.adobe.com/xap/1.0/sType/ResourceEvent#"
_IPTC: Final = "http://iptc.org/std/Iptc4xmpExt/2008-02-29/"
_KINDS: Final = "http://cv.iptc.org/newscodes/digitalsourcetype/"
_EDITED: Final = f"{_KINDS}humanEdits"
# "Human edits" replaces these source types only; a composite stays a composite.
_CAPTURE: Final = re.compile(
    f"{_KINDS}(digitalCapture|computationalCapture|negativeFilm|positiveFilm|print)\\b".encode()
)
_ABOUT: Final = (*xmp.DESCRIPTION, f"{xmp.RDF} about")
_SOURCE_TYPE: Final = (*xmp.DESCRIPTION, f"{_IPTC} DigitalSourceType")
_HISTORY: Final = (*xmp.DESCRIPTION, f"{_MEDIA} History")
_HISTORY_LIST: Final = (*_HISTORY, f"{xmp.RDF} Seq")


@dataclass(frozen=True, slots=True)
class Disclosure:
    """Options for the disclosure of a result; all are off by default."""

    # Add an edit record to the XMP: an event in ``xmpMM:History`` and, where the photo is a plain
    # capture so far, the IPTC digital source type "human edits".
    record: bool = False
    label: str = ""  # text to draw into the bottom right corner; none if empty
    # Font file of the label, for letters missing in the built-in Latin font.
    font: str | None = None
    film: bool = False  # keep the video of a motion photo; the video shows the original face

    @property
    def is_wanted(self) -> bool:
        """Whether anything is to be disclosed."""
        return self.record or bool(self.label)


NO_DISCLOSURE = Disclosure()


def disclose(
    photo: Photo,
    pixels: Image,
    disclosure: Disclosure,
    *,
    what: str = "",
    when: datetime | None = None,
) -> tuple[Photo, Image]:
    """Return the photo with an edit record and the new pixels with a label, ready for `write`.

    A result equal to the photo gets neither (see `undisclosed`). A label changes the pixels of one
    rectangle only; a record changes the XMP packet only. Without a label, the same array is
    returned. Raises CannotDisclose.
    """
    if not disclosure.is_wanted or is_same(photo.pixels, pixels):
        return photo, pixels
    if disclosure.label:
        pixels = draw_label(pixels, disclosure.label, disclosure.font)
    if disclosure.record:
        xmp = added(photo.xmp, what, when or datetime.now(UTC))
        photo = dataclasses.replace(photo, xmp=xmp)
    return photo, pixels


def undisclosed(photo: Photo, pixels: Image, disclosure: Disclosure) -> str:
    """Return a note about disclosure that a result equal to the photo does not get, or ""."""
    if not disclosure.is_wanted or not is_same(photo.pixels, pixels):
        return ""
    missing, record = Text("label"), Text("edit record")
    if disclosure.record:
        both = Text("{one} and {other}", one=missing, other=record)
        missing = both if disclosure.label else record
    return Text("nothing was changed, so there is no {missing}", missing=missing)


def added(packet: bytes | None, what: str, when: datetime) -> bytes:
    """Add an event to the history of an XMP packet. Return the packet.

    The IPTC digital source type becomes "human edits" if the type is missing or a capture.
    Histories of nested pictures stay. Raises CannotDisclose.
    """
    try:
        return _added((packet or xmp.EMPTY).rstrip(b"\0"), what, when)
    except xmp.BadXmp as error:
        raise CannotDisclose(
            "the photo's XMP can't take an edit record ({reason}); save without one, or repair it",
            reason=error,
        ) from None


def _added(packet: bytes, what: str, when: datetime) -> bytes:
    parts = xmp.parts(packet)
    spans = {part.path: part.span for part in parts}
    edits, new = {}, ""
    if (span := spans.get(_SOURCE_TYPE)) is None:
        new += f"<Iptc4xmpExt:DigitalSourceType>{_EDITED}</Iptc4xmpExt:DigitalSourceType>"
    else:
        edits[span] = _CAPTURE.sub(_EDITED.encode(), packet[slice(*span)])
    event = _event(what, when)
    if (span := spans.get(_HISTORY_LIST)) is not None:
        edits |= xmp.appended(packet, span, event)
    elif _HISTORY in spans:
        raise xmp.BadXmp("its history is of an unknown form")
    else:
        new += f"<xmpMM:History><rdf:Seq>{event}</rdf:Seq></xmpMM:History>"
    if new:
        values = (part.value(packet) for part in parts if part.path == _ABOUT)
        abouts = (packet[slice(*value)] for value in values if value and value[0] < value[1])
        about = _quoted(html.unescape(next(abouts, b"").decode()))
        attributes = f'xmlns:xmpMM="{_MEDIA}" xmlns:Iptc4xmpExt="{_IPTC}" rdf:about={about}'
        edits |= xmp.described(packet, parts, f"{attributes}>{new}</rdf:Description>")
    return xmp.replaced(packet, edits)


def _event(what: str, when: datetime) -> str:
    """Return an event of the history (XMP specification, part 2)."""
    event = {
        "action": "edited",
        "when": when.isoformat(timespec="seconds"),
        "softwareAgent": f"Kogao {kogao_core.__version__}",
        "changed": "/",
        **({"parameters": what} if what else {}),
    }
    fields = " ".join(f"stEvt:{name}={_quoted(value)}" for name, value in event.items())
    return f'<rdf:li xmlns:rdf="{xmp.RDF}" xmlns:stEvt="{_EVENT}" {fields}/>'


def _quoted(value: str) -> str:
    text = html.escape(value, quote=False).replace('"', "&quot;")
    return '"' + re.sub(r"[\t\n\r]", lambda one: f"&#{ord(one[0])};", text) + '"'
