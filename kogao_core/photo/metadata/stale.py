"""Properties of an XMP packet that describe parts of its file which a changed photo lacks.

Only these properties go; every other byte of the packet stays.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Final

from kogao_core.photo.metadata import kinds, xmp
from kogao_core.photo.metadata.kinds import Kind

_GOOGLE: Final = "http://ns.google.com/photos/"
_CONTAINER: Final = f"{_GOOGLE}1.0/container/ "
EXTENSION_LINK: Final = "http://ns.adobe.com/xmp/note/ HasExtendedXMP"
# Properties by the start of their names, with what they speak of.
_STALE: Final[dict[str, Kind]] = {
    "http://ns.adobe.com/hdr-gain-map/1.0/ ": kinds.GAIN_MAP,
    "http://ns.apple.com/HDRGainMap/1.0/ ": kinds.GAIN_MAP,
    f"{_GOOGLE}1.0/camera/ MotionPhoto": kinds.VIDEO,
    f"{_GOOGLE}1.0/camera/ MicroVideo": kinds.VIDEO,
    "http://ns.oplus.com/photos/1.0/camera/ MotionPhoto": kinds.VIDEO,
    "http://ns.oplus.com/photos/1.0/camera/ OLivePhoto": kinds.VIDEO,
    "http://ns.oplus.com/photos/1.0/camera/ VideoLength": kinds.VIDEO,
    "http://ns.xiaomi.com/photos/1.0/camera/ XMPMeta": kinds.INDEX,
    _CONTAINER: kinds.INDEX,
    f"{_GOOGLE}1.0/depthmap/ ": kinds.DEPTH,
    f"{_GOOGLE}dd/1.0/": kinds.DEPTH,
    f"{_GOOGLE}1.0/image/ ": kinds.ORIGINAL,
    "http://purl.org/dc/terms/ provenance": kinds.CREDENTIALS_LINK,
}
_LIGHTROOM: Final = "http://ns.adobe.com/camera-raw-settings/1.0/ "
# Places in the picture, where it is turned: of Lightroom's crops, masks and spots, and of others.
_PLACES: Final[dict[str, Kind]] = dict.fromkeys(
    (
        *(f"{_LIGHTROOM}{name}" for name in (
            "Crop", "HasCrop", "Retouch", "RedEye", "MaskGroup", "GradientBased", "PaintBased",
            "CircularGradientBased", "Perspective", "Upright")),
        "http://ns.acdsee.com/regions/ ",
        f"{_GOOGLE}1.0/panorama/ ",
        "http://iptc.org/std/Iptc4xmpExt/2008-02-29/ ImageRegion",
    ),
    kinds.PLACES,
)  # fmt: skip
_PICTURES: Final = tuple(
    name.strip().encode() for name, kind in _STALE.items() if kind in (kinds.DEPTH, kinds.ORIGINAL)
)
_ABSENT: Final = re.compile(rb"""(=\s*["']|>)\s*0\s*["'<]""")


class _Stale(xmp.Walk):
    """Where stale properties lie: attributes and elements of top descriptions."""

    def __init__(self, packet: bytes, names: dict[str, Kind]) -> None:
        self.spans: list[xmp.Span] = []
        self.kinds: dict[Kind, None] = {}
        self._names = names
        super().__init__(packet, len(xmp.DESCRIPTION) + 1)

    def starts(self, path: xmp.NamePath, attributes: dict[str, str], at: int) -> None:
        """Note stale attributes."""
        if path == xmp.DESCRIPTION:
            for name, span in zip(attributes, xmp.attribute_spans(self.packet, at), strict=True):
                self._judge(name, span)

    def ends(self, path: xmp.NamePath, span: xmp.Span) -> None:
        """Note stale elements."""
        if path[:-1] == xmp.DESCRIPTION:
            self._judge(path[-1], span)

    def _judge(self, name: str, span: xmp.Span) -> None:
        kind = next((kind for start, kind in self._names.items() if name.startswith(start)), None)
        if kind is None:
            return
        self.spans.append(span)
        # "MotionPhoto" may be 0: the camera could have made one.
        if not (kind == kinds.VIDEO and _ABSENT.search(self.packet, *span)):
            self.kinds[kind] = None


def _names(*, is_extended: bool, is_turned: bool, along: Collection[Kind] = ()) -> dict[str, Kind]:
    names = {
        **_STALE,
        **({} if is_extended else {EXTENSION_LINK: kinds.INDEX}),
        **(_PLACES if is_turned else {}),
    }
    if along:
        names.pop(_CONTAINER)
    return {name: kind for name, kind in names.items() if kind not in along}


def found(packet: bytes, *, is_turned: bool = False) -> tuple[Kind, ...]:
    """Return the kinds that an XMP packet describes; none if it can't be read."""
    names = _names(is_extended=True, is_turned=is_turned)
    try:
        return tuple(_Stale(packet.rstrip(b"\0"), names).kinds)
    except xmp.BadXmp:
        return ()


def without(
    packet: bytes, *, is_extended: bool, is_turned: bool = False, along: Collection[Kind] = ()
) -> bytes:
    """Return a packet without the properties of parts that a changed photo doesn't have.

    `along`: what accompanies it; its directory is put right by `container`.
    """
    names = _names(is_extended=is_extended, is_turned=is_turned, along=along)
    try:
        spans = _Stale(packet.rstrip(b"\0"), names).spans
    except xmp.BadXmp:
        return packet
    return xmp.replaced(packet, dict.fromkeys(spans, b""))


def is_picture_in(extension: bytes) -> bool:
    """Tell whether the rest of a long packet holds pictures or depth maps."""
    return any(name in extension for name in _PICTURES)
