"""Photoshop image resources, the home of IPTC captions in JPEG, TIFF and PNG files."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

_SIGN: Final = b"8BIM"
# Signatures of resources by other programs.
_SIGNS: Final = (_SIGN, b"AgHg", b"DCSR", b"PHUT", b"MeSa")
_IPTC: Final = 0x0404
IPTC_START: Final = b"\x1c"
"""First byte of an IPTC record."""
# Two kinds of thumbnails, and copies of the EXIF and XMP blocks: all describe the original photo.
_XMP: Final = 0x0424
_STALE: Final = (0x0409, 0x040C, 0x0422, 0x0423, 0x0424)
# Guides, slices and paths.
_PLACES: Final = frozenset((1032, 1050, *range(2000, 2998), 2999))


def _parts(resources: bytes) -> Iterator[tuple[int, bytes, bytes]]:
    """Yield number, content and all bytes of each resource, up to the first damaged resource."""
    at = 0
    while resources[at : at + 4] in _SIGNS and at + 12 <= len(resources):
        number = int.from_bytes(resources[at + 4 : at + 6], "big")
        name = 1 + resources[at + 6]
        start = at + 6 + name + name % 2 + 4
        size = int.from_bytes(resources[start - 4 : start], "big")
        end = start + size + size % 2
        if start + size > len(resources):
            return
        yield number, resources[start : start + size], resources[at:end]
        at = end


def without_stale(resources: bytes, *, is_turned: bool = False) -> bytes:
    """Return the resources that a changed photo keeps, unchanged."""
    gone = _PLACES.union(_STALE) if is_turned else _STALE
    return b"".join(part for number, _, part in _parts(resources) if number not in gone)


def has_places(resources: bytes) -> bool:
    """Return True if resources contain positions in the picture."""
    return any(number in _PLACES for number, _, _ in _parts(resources))


def iptc_of(resources: bytes) -> bytes | None:
    """Return the IPTC record (IIM) among resources."""
    return _content(resources, _IPTC)


def xmp_of(resources: bytes) -> bytes | None:
    """Return the XMP packet among resources."""
    return _content(resources, _XMP)


def _content(resources: bytes, wanted: int) -> bytes | None:
    return next((content for number, content, _ in _parts(resources) if number == wanted), None)


def with_iptc(iptc: bytes) -> bytes:
    """Return a block of Photoshop resources that contains only an IPTC record."""
    head = _SIGN + _IPTC.to_bytes(2, "big") + b"\0\0" + len(iptc).to_bytes(4, "big")
    return head + iptc + b"\0" * (len(iptc) % 2)
