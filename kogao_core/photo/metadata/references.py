"""XMP properties that refer to other parts of the file, such as a gain map or a video.

A changed photo loses some parts. The properties of lost parts are removed, and Google's container
directory is updated. All other bytes of the packet stay.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Final

from kogao_core.photo.metadata import kinds, xmp
from kogao_core.photo.metadata.kinds import Kind

_GOOGLE: Final = "http://ns.google.com/photos/"
_CONTAINER: Final = f"{_GOOGLE}1.0/container/ "
EXTENSION_LINK: Final = "http://ns.adobe.com/xmp/note/ HasExtendedXMP"
# Kind of the described part, by prefix of the property name.
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
# Positions in the picture, removed if the picture is rotated: Lightroom's crops, masks, spots.
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
_DIRECTORY: Final = (*xmp.DESCRIPTION, f"{_CONTAINER}Directory")
_ITEM: Final = (*_DIRECTORY, f"{xmp.RDF} Seq", f"{xmp.RDF} li")
_OFFSET: Final = (*xmp.DESCRIPTION, f"{_GOOGLE}1.0/camera/ MicroVideoOffset")
_PROPERTY: Final = f"{_GOOGLE}1.0/container/item/ "
_SEMANTICS: Final = {"GainMap": kinds.GAIN_MAP, "MotionPhoto": kinds.VIDEO}


def _names(*, is_extended: bool, is_turned: bool, along: Collection[Kind] = ()) -> dict[str, Kind]:
    names = {
        **_STALE,
        **({} if is_extended else {EXTENSION_LINK: kinds.INDEX}),
        **(_PLACES if is_turned else {}),
    }
    if along:
        names.pop(_CONTAINER)
    return {name: kind for name, kind in names.items() if kind not in along}


def _spoken_of(packet: bytes, names: dict[str, Kind]) -> list[tuple[xmp.Span, Kind]]:
    """Return the spans of top-level properties and the kind of part that each describes."""
    own = (one for one in xmp.known_parts(packet) if one.path[:-1] == xmp.DESCRIPTION)
    known = ((one, name) for one in own for name in names if one.path[-1].startswith(name))
    return [(one.span, names[name]) for one, name in known]


def found(packet: bytes, *, is_turned: bool = False) -> tuple[Kind, ...]:
    """Return the kinds described by an XMP packet; none if the packet is damaged."""
    spoken = _spoken_of(packet, _names(is_extended=True, is_turned=is_turned))
    # "MotionPhoto" may be 0: the camera could have made one.
    real = (
        kind for span, kind in spoken if kind != kinds.VIDEO or not _ABSENT.search(packet, *span)
    )
    return tuple(dict.fromkeys(real))


def without(
    packet: bytes, *, is_extended: bool, is_turned: bool = False, along: Collection[Kind] = ()
) -> bytes:
    """Remove the properties of parts that a changed photo lacks. Return the packet.

    `along`: kinds of companions. `adjusted` updates the directory of the companions.
    """
    names = _names(is_extended=is_extended, is_turned=is_turned, along=along)
    return xmp.replaced(packet, {span: b"" for span, _ in _spoken_of(packet, names)})


def is_picture_in(extension: bytes) -> bool:
    """Return True if the extended XMP holds pictures or depth maps."""
    return any(name in extension for name in _PICTURES)


def _items(packet: bytes) -> tuple[dict[xmp.Span, dict[str, xmp.Span]], xmp.Span | None]:
    """Return the values of each item in the directory, and the span of the video offset."""
    items: dict[xmp.Span, dict[str, xmp.Span]] = {}
    values: dict[str, xmp.Span] = {}
    offset = None
    for part in xmp.known_parts(packet):
        if part.path == _ITEM:
            items[part.span], values = values, {}
        elif (value := part.value(packet)) is not None:
            if part.path == _OFFSET:
                offset = value
            elif part.path[-1].startswith(_PROPERTY):
                values[part.path[-1].removeprefix(_PROPERTY)] = value
    return items, offset


def adjusted(packet: bytes, lengths: Mapping[Kind, int]) -> bytes:
    """Set the lengths of the companions, in bytes, in a packet; remove items of other parts.

    The companions follow each other; the video comes last.
    """
    items, offset = _items(packet)
    new: dict[xmp.Span, bytes] = {}
    for span, values in items.items():
        semantic = packet[slice(*values.get("Semantic", (0, 0)))].decode("latin-1")
        kind = _SEMANTICS.get(semantic)
        if semantic != "Primary" and kind not in lengths:
            new[span] = b""
            continue
        length = 0 if kind is None else lengths[kind]
        told = {"Length": length, "Padding": 0}
        new |= {values[name]: b"%d" % told[name] for name in told if name in values}
    if offset is not None and kinds.VIDEO in lengths:
        new[offset] = b"%d" % lengths[kinds.VIDEO]
    return xmp.replaced(packet, new)


def locates_video(packet: bytes) -> bool:
    """Return True if a packet gives the position of a video."""
    items, offset = _items(packet)
    semantics = (packet[slice(*one.get("Semantic", (0, 0)))] for one in items.values())
    return offset is not None or b"MotionPhoto" in semantics
