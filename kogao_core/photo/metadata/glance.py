"""What XMP says of a photo, at a glance: stars for culling, and whether this program made it.

The photo isn't read, and never written: stars go into the sidecar that others read, too.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Final

from kogao_core.base.atomic import put
from kogao_core.photo.metadata.xmp import BadXmp, Walk

REJECTED: Final = -1
"""The rating of a photo that was looked at and isn't wanted."""
_HEAD_BYTES: Final = 1 << 18
_TAIL_BYTES: Final = 1 << 16
_PACKET: Final = re.compile(rb"<x:xmpmeta.*?</x:xmpmeta>", re.DOTALL)
_RATING: Final = re.compile(rb"""(xmp:Rating(?:\s*=\s*["']|>)\s*)(-?\d)""")
_OURS: Final = re.compile(rb"""stEvt:softwareAgent(?:\s*=\s*["']|>)Kogao """)
_DESCRIPTION: Final = re.compile(rb"<rdf:Description\b[^>]*")
_SPACE: Final = b' xmlns:xmp="http://ns.adobe.com/xap/1.0/"'
_NEW: Final = (
    b'<x:xmpmeta xmlns:x="adobe:ns:meta/">\n'
    b'<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">\n'
    b'<rdf:Description rdf:about=""/>\n</rdf:RDF>\n</x:xmpmeta>\n'
)


def packet(path: Path) -> bytes:
    """Return the XMP packet of a photo, where it lies near the file's beginning or end."""
    if not path.is_file():  # a pipe would be waited for
        return b""
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
        found = _PACKET.search(head)
        if found is None and len(head) == _HEAD_BYTES:
            file.seek(-min(_TAIL_BYTES, os.fstat(file.fileno()).st_size - len(head)), os.SEEK_END)
            found = _PACKET.search(file.read())
    return b"" if found is None else found[0]


def is_ours(path: Path) -> bool:
    """Tell whether an edit record says that this program made a file."""
    return _OURS.search(packet(path)) is not None


def sidecar_of(path: Path) -> Path:
    """Return where the XMP beside a photo lies: what is there, else ``portrait.jpg.xmp``."""
    whole, short = path.with_name(f"{path.name}.xmp"), path.with_suffix(".xmp")
    return short if not whole.is_file() and short.is_file() else whole


def rating(path: Path) -> int:
    """Return the stars of a photo, 0 to 5, or `REJECTED`; what lies beside it comes first."""
    beside = sidecar_of(path)
    for text in (beside.read_bytes() if beside.is_file() else b"", packet(path)):
        found = _RATING.search(text)
        if found is not None:
            return max(REJECTED, min(int(found[2]), 5))
    return 0


def rate(path: Path, stars: int) -> None:
    """Keep the stars of a photo in the XMP beside it; no other byte of that changes.

    Raises OSError, BadXmp.
    """
    place, number = sidecar_of(path), str(stars).encode()
    text = place.read_bytes() if place.is_file() else _NEW
    if _RATING.search(text):
        text = _RATING.sub(rb"\g<1>" + number, text, count=1)
    else:
        tag = _DESCRIPTION.search(text)
        if tag is None:
            raise BadXmp(f"{place.name} holds no rdf:Description")
        space = b"" if b"xmlns:xmp=" in text[: tag.end()] else _SPACE
        at = tag.start() + len(b"<rdf:Description")
        text = text[:at] + space + b' xmp:Rating="' + number + b'"' + text[at:]
    Walk(text, 2)
    put(text, place)
