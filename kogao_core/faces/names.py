"""Names that other programs wrote into a photo, with the place of each face, and whose face is it.

Read are the regions of the Metadata Working Group (Lightroom, digiKam, Picasa) and of Microsoft.
A region that fits no face or several, or may be out of date, names nobody.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Final
from xml.etree import ElementTree

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.base.language import Text
from kogao_core.faces.doubt import AllDoubted
from kogao_core.faces.face import Face
from kogao_core.photo.metadata import xmp
from kogao_core.photo.metadata.upright import Turn, turned_xmp
from kogao_core.photo.model import Photo
from kogao_core.recipe.recipe import Recipe

_MWG: Final = "{http://www.metadataworkinggroup.com/schemas/regions/}"
_AREA: Final = "{http://ns.adobe.com/xmp/sType/Area#}"
_SIZE: Final = "{http://ns.adobe.com/xap/1.0/sType/Dimensions#}"
_MICROSOFT: Final = "{http://ns.microsoft.com/photo/1.2/t/Region#}"
# Least intersection over union of a region with a head.
_LEAST_OVERLAP: Final = 0.2
_CLEARLY: Final = 1.25  # least ratio of the overlaps of two ways to read the places
_FOREHEAD: Final = 0.6  # height above the landmarks, in heights of the landmarks
_PERSON: Final = re.compile(r"\s*([^=]*[^=\s])\s*=\s*(-?\d+(?:\.\d+)?)\s*(?:,|$)")

NO_REGION: Final = Text("the photo has no face of this name")
NO_FACE: Final = Text("no face was found where the photo has this name")
SEVERAL: Final = Text("faces and names don't correspond one to one there")
OUTDATED: Final = Text("the photo may have been cropped or turned since the names were written")

People = tuple[tuple[str, float], ...]
"""Names with Amounts, %."""


class NobodyNamed(AllDoubted):
    """The photo names none of the people without doubt; the message gives the reasons."""


@dataclass(frozen=True, slots=True, eq=False)
class FaceRegion:
    """A named region; corners (left, top), (right, bottom) in shares of the upright photo."""

    name: str
    corners: Array
    otherwise: Array  # the corners if the program wrote them for the upright photo
    is_microsoft: bool = False
    is_outdated: bool = False  # written for a photo of another shape
    is_same_size: bool = False  # written for a photo of this size


@dataclass(frozen=True, slots=True)
class FaceNames:
    """Whose faces a photo shows."""

    names: tuple[str, ...] = ()  # of each face; "" for an unknown face
    doubts: Mapping[str, Text] = field(default_factory=dict)  # reason for each other name, folded

    def index(self, name: str) -> int | Text:
        """Return the index of a person's face, or why there is none."""
        known = [folded(one) for one in self.names]
        if folded(name) in known:
            return known.index(folded(name))
        return self.doubts.get(folded(name), NO_REGION)


def folded(name: str) -> str:
    """Return a name for comparison: without case and outer spaces."""
    return unicodedata.normalize("NFC", name).strip().casefold()


def people_of(text: str) -> People:
    """Return names with Amounts, %, from a text such as ``Ann=3,Kate=0``; empty if it is none."""
    found, at = list[tuple[str, float]](), 0
    while at < len(text) and (part := _PERSON.match(text, at)):
        found.append((part[1], float(part[2])))
        at = part.end()
    known = {folded(name) for name, _ in found}
    return tuple(found) if at == len(text) and len(known) == len(found) else ()


def regions_of(photo: Photo) -> list[FaceRegion]:
    """Return the named faces in the photo's metadata."""
    turn, packet = Turn(photo.orientation, photo.width, photo.height), photo.xmp or b""
    both = zip(_regions(turned_xmp(packet, turn), turn), _regions(packet, turn), strict=False)
    found = [
        one
        if one.is_same_size and turn.swaps_sides and turn.width != turn.height
        else replace(one, otherwise=other.corners)
        for one, other in both
    ]
    # Of a name in both forms, take the one that knows the size of its photo.
    known = {folded(one.name) for one in found if not one.is_microsoft}
    return [one for one in found if not one.is_microsoft or folded(one.name) not in known]


def names_of(photo: Photo, faces: Sequence[Face]) -> FaceNames:
    """Return the name of each face that the photo's metadata name without doubt."""
    regions, names, doubts = regions_of(photo), [""] * len(faces), dict[str, Text]()
    size_px = np.array([photo.width, photo.height], np.float64)
    ways = [
        [_fits(corners * size_px, faces) for corners in way]
        for way in ([one.corners for one in regions], [one.otherwise for one in regions])
    ]
    # Some programs write places in the upright photo. The places that fit better are meant.
    fits, others = sorted(ways, key=_quality, reverse=True)
    is_clear = _quality(fits) > _CLEARLY * _quality(others)
    for region, fit, other in zip(regions, fits, others, strict=True):
        name, mine = folded(region.name), fit.keys()
        alike = [one.keys() for one, r in zip(fits, regions, strict=True) if folded(r.name) == name]
        rest = [one.keys() for one, r in zip(fits, regions, strict=True) if folded(r.name) != name]
        # A photo of another size may be a crop: then, the places of all must be right, and of
        # another shape, of more than one.
        is_usual = fits is ways[0] and not region.is_outdated
        is_sure = (region.is_same_size and is_usual) or (
            all(fits) and (is_usual or len(regions) > 1)
        )
        if not is_sure or not (is_clear or mine == other.keys()):
            doubts[name] = OUTDATED
        elif not mine:
            doubts[name] = NO_FACE
        elif len(mine) > 1 or any(one != mine for one in alike) or any(mine & one for one in rest):
            doubts[name] = SEVERAL
        else:
            names[next(iter(mine))] = region.name
    return FaceNames(tuple("" if folded(name) in doubts else name for name in names), doubts)


def _fits(corners_px: Array, faces: Sequence[Face]) -> dict[int, float]:
    """Return the overlap with each face whose middle and head lie in these corners."""
    low, high = corners_px
    return {
        k: overlap
        for k, face in enumerate(faces)
        if (low < face.middle).all()
        and (face.middle < high).all()
        and (overlap := _overlap(corners_px, _head(face))) >= _LEAST_OVERLAP
    }


def _quality(fits: Sequence[Mapping[int, float]]) -> float:
    return sum(max(one.values(), default=0.0) for one in fits)


def identify(
    people: People, photo: Photo, faces: Sequence[Face], recipe: Recipe
) -> tuple[list[Face], str, Text]:
    """Return faces with the Amounts of people, the numbers of their faces, and a note on doubts.

    The note has no names. Raises NobodyNamed.
    """
    names, changed, notes = names_of(photo, faces), dict[int, Face](), list[Text]()
    for number, (name, percent) in enumerate(people, 1):
        index = names.index(name)
        if isinstance(index, int):
            changed[index] = replace(faces[index], recipe=replace(recipe, percent=percent))
        else:
            notes.append(
                Text("person {number} of the named people: {why}", number=number, why=index)
            )
    note = Text.joined("; ", notes)
    if not changed:
        raise NobodyNamed(note)
    which = ",".join(str(index + 1) for index in changed)
    return [changed.get(k, face) for k, face in enumerate(faces)], which, note


def _regions(packet: bytes, turn: Turn) -> Iterator[FaceRegion]:
    if not xmp.known_parts(packet):  # also refuses document types
        return
    root = ElementTree.fromstring(packet.rstrip(b"\0"))
    sizes = [_values(one) for one in root.iter(f"{_MWG}AppliedToDimensions")]
    width, height = (_number(sizes[0].get(f"{_SIZE}{side}")) if sizes else 0.0 for side in "wh")
    is_outdated = abs(width * turn.height - height * turn.width) > max(width, height)
    is_same_size = (width, height) == (turn.width, turn.height)
    for values in map(_values, root.iter(f"{{{xmp.RDF}}}li")):
        name = values.get(f"{_MICROSOFT}PersonDisplayName", "").strip()
        is_known: tuple[bool, ...] = (True,)
        place = [_number(one) for one in values.get(f"{_MICROSOFT}Rectangle", "").split(",")]
        if not name and values.get(f"{_MWG}Type", "Face") == "Face":
            name, is_known = (
                values.get(f"{_MWG}Name", "").strip(),
                (False, is_outdated, is_same_size),
            )
            x, y, w, h = (_number(values.get(f"{_AREA}{one}")) for one in "xywh")
            place = [x - w / 2.0, y - h / 2.0, w, h]
        if name and len(place) == 4 and place[2] > 0.0 and place[3] > 0.0:
            corners = np.array([place[:2], np.add(place[:2], place[2:])])
            yield FaceRegion(name, corners, corners, *is_known)


def _values(node: ElementTree.Element) -> dict[str, str]:
    """Return all texts and attributes below an element; RDF treats both alike."""
    found = {one.tag: one.text or "" for one in node.iter()}
    return found | {name: text for one in node.iter() for name, text in one.attrib.items()}


def _number(text: str | None) -> float:
    """Return a number of a packet; 0 if the text is none."""
    with suppress(ValueError, TypeError):
        number = float(text or "")
        return number if isfinite(number) else 0.0
    return 0.0


def _head(face: Face) -> Array:
    """Return the corners of a head, px."""
    x, y, width, height = face.box
    return np.array([[x, y - _FOREHEAD * height], [x + width, y + height]])


def _overlap(one: Array, other: Array) -> float:
    """Return the intersection over union of two rectangles, from their corners."""
    sides = np.minimum(one[1], other[1]) - np.maximum(one[0], other[0])
    both = float(np.prod(np.maximum(sides, 0.0)))
    return both / float(np.prod(one[1] - one[0]) + np.prod(other[1] - other[0]) - both)
