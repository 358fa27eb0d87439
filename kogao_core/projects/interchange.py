"""Import of landmarks of Kogao and other programs, export to JSON and CSV (docs/interchange.md).

Coordinates are px of the upright photo: pixel centres at whole numbers from 0, x to the right, y
down. `landmark_files` holds the table of formats.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path, PureWindowsPath
from typing import Final

import numpy as np

from kogao_core.additions.limits import OutOfBounds, check_faces
from kogao_core.base import json_reader
from kogao_core.base.atomic import atomic_write
from kogao_core.base.geometry import Array, Box
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.faces.face import OUTLINE_POINTS, Face
from kogao_core.faces.landmarks import find, networks_are_here
from kogao_core.faces.landmarks.mesh import EYES, MOUTH
from kogao_core.faces.landmarks.outline import resampled, silhouette
from kogao_core.photo import Photo
from kogao_core.photo.profiles import for_search
from kogao_core.projects import landmark_files
from kogao_core.projects.landmark_files import MESH_COUNTS, SUFFIXES, Format, Listed, Mark

_PARTS: Final = {"outline": OUTLINE_POINTS, "eye": 4, "mouth": 2}
_OWN_NAMES: Final = tuple(
    f"{part}-{number}" for part, count in _PARTS.items() for number in range(1, count + 1)
)
_STEPS: Final = 16  # straight pieces between two points of an outline
# Outline, eyes and mouth among the points of other programs.
_LAYOUTS: Final[Mapping[int, tuple[Sequence[int], ...]]] = {
    27: (range(21), range(21, 25), (25, 26)),
    68: (range(17), (36, 39, 42, 45), (48, 54)),  # iBUG, dlib
    189: (  # WebMorph, FRL
        (109, 185, 110, 186, 111, *range(125, 134), 114, 188, 113, 187, 112),
        (18, 22, 23, 27),
        (87, 93),
    ),
    **dict.fromkeys(MESH_COUNTS, ((), EYES, MOUTH)),  # MediaPipe: its silhouette is the outline
}
# Our points in a mirrored photo.
_MIRRORED: Final = [*range(20, -1, -1), 24, 23, 22, 21, 26, 25]
# Mean distance of points that fit, in outer inter-ocular distances. Hand labels are at 0.03, a
# missing face's neighbours in groups at 0.1.
_FITS: Final = 0.06
# MediaPipe's points lie half a pixel of the network's input too far right and down. Measured on 8
# portraits and their mirror images, in outer inter-ocular distances.
_MESH_SHIFT: Final = 0.0038
# Coordinates up to this are shares of the photo's size, not px.
_MOST_SHARE: Final = 2.0


def faces_of(photo: Photo, place: Path) -> list[Face]:
    """Read and check the faces of a photo from a landmark file or folder. Raises BadFile."""
    image = Box.of(photo.pixels)
    faces = read(file_for(photo.path, place), photo.path.name, image)
    check_inside(faces, image)
    if networks_are_here():
        check_found(faces, find(for_search(photo)), image)
    return faces


def read(path: Path, photo: str, image: Box) -> list[Face]:
    """Read the faces of a photo from a landmark file, px; at least one. Raises BadFile.

    `photo` is the photo's file name, for files about several photos.
    """
    if (suffix := path.suffix.lower()) not in SUFFIXES:
        names = ", ".join(SUFFIXES)
        raise BadFile("{path} must end in one of {names}", path=path, names=names)
    data = json_reader.read(path, landmark_files.MOST_BYTES)
    try:
        form, faces = landmark_files.parse(data, suffix)
        found = [
            marks if isinstance(marks, Face) else face_of(_pixels(marks, form, image))
            for marks in _about(faces, photo)
        ]
        for number, face in enumerate(found, start=1):
            _check_shape(face, number)
    except (BadFile, ValueError) as error:
        raise BadFile("{path} can't be used: {error}", path=path, error=error) from None
    return found


def _about(faces: Sequence[Listed | Face], photo: str) -> Sequence[Listed | Face]:
    """Return the faces of one photo. Raises BadFile if a file of several photos lacks the photo."""
    stems = [
        "" if isinstance(face, Face) else PureWindowsPath(face.photo).stem.lower() for face in faces
    ]
    if len(set(stems)) == 1:
        return faces
    own = PureWindowsPath(photo).stem.lower()
    if own not in stems:
        raise BadFile("the file has points for other photos, none for {photo}", photo=photo)
    return [face for face, stem in zip(faces, stems, strict=True) if stem == own]


def _pixels(marks: Listed, form: Format, image: Box) -> Array:
    """Return the points of a face in the order of their names, px of the photo. Raises BadFile."""
    size = image.width, image.height
    if marks.size not in (None, size):
        sizes = [f"{width} x {height}" for width, height in (marks.size, size)]
        raise BadFile(
            "it marks a photo of {size} px, this one has {own} px", size=sizes[0], own=sizes[1]
        )
    ordered, outline = _in_order(marks.points)
    points = landmark_files.coordinates(ordered)
    shares = np.abs(points).max(initial=0.0) <= _MOST_SHARE
    if len(points) in MESH_COUNTS:
        points *= size if shares else 1.0
        across = points[EYES[3]] - points[EYES[0]]
        return points - _MESH_SHIFT * np.array([across[0] - across[1], across[1] + across[0]])
    if shares:
        raise BadFile("its points are shares of the photo's size; multiply by width and height")
    if outline not in (0, OUTLINE_POINTS):
        points = np.vstack([along(points[:outline], OUTLINE_POINTS), points[outline:]])
    return points - form.first_pixel


def _in_order(marks: list[Mark]) -> tuple[list[Mark], int]:
    """Sort points by names or numbers; keep the order if the names mean nothing to Kogao.

    Equal names count from 1 in the order of the file. Also return the number of outline points if
    the names are ours, else 0. Raises BadFile.
    """
    seen: Counter[str] = Counter()
    keys: list[tuple[str, int]] = []
    names = [re.sub(r"[\s_]+", "-", str(mark[0]).strip().lower()) for mark in marks]
    for name in names if len(set(names)) > 1 else [""] * len(names):
        part = name.rstrip("0123456789")
        seen[part] += 1
        keys.append((part.rstrip("-").removesuffix("s"), int(name[len(part) :][-9:] or seen[part])))
    counts = Counter(part for part, _ in keys)
    is_ours = counts.keys() == set(_PARTS)
    if len(counts) > 1 and not is_ours:
        return marks, 0
    order = sorted(range(len(marks)), key=lambda k: ("outline eye mouth".find(keys[k][0]), keys[k]))
    lows = {part: min(number for one, number in keys if one == part) for part in counts}
    wanted = {(part, lows[part] + k) for part, count in counts.items() for k in range(count)}
    if set(keys) != wanted or max(lows.values(), default=0) > 1:
        raise BadFile("its points must be numbered from 0 or 1, each number once")
    return [marks[k] for k in order], counts["outline"] if is_ours else 0


def file_for(photo: Path, place: Path) -> Path:
    """Return `place`, or the landmark file of a photo if `place` is a folder. Raises BadFile."""
    if not place.is_dir():
        return place
    candidates = [place / f"{photo.stem}{suffix}" for suffix in SUFFIXES]
    file = next((file for file in candidates if file.is_file()), None)
    if file is None:
        raise BadFile(
            "{folder} has no points for {photo}; expected {name} with one of {endings}",
            photo=photo.name,
            folder=place,
            name=photo.stem,
            endings=", ".join(SUFFIXES),
        )
    return file


def write(faces: Sequence[Face], path: Path) -> str:
    """Write faces as JSON or, for the suffix .csv, as a table of 27 points.

    Return a note if an outline was resampled.
    """
    if path.suffix == ".json":
        atomic_write(faces_text(faces).encode(), path)
        return ""
    atomic_write(csv_text([own_points(face) for face in faces]).encode(), path)
    if all(len(face.outline) == OUTLINE_POINTS for face in faces):
        return ""
    return Text("the outline was resampled to {count} points", count=OUTLINE_POINTS)


def check_inside(faces: Sequence[Face], image: Box) -> None:
    """Check that the middle of each face lies in the photo. Raises BadFile."""
    for number, face in enumerate(faces, start=1):
        x, y = face.middle
        if not (image.left <= x < image.right and image.top <= y < image.bottom):
            place, size = f"{x:.0f}, {y:.0f}", f"{image.width} x {image.height}"
            raise BadFile(
                "face {number} lies at {place}, outside the photo of {size} px; the points "
                "belong to another photo or size",
                number=number,
                place=place,
                size=size,
            )
    try:
        check_faces(faces, image, typed=True)
    except OutOfBounds as error:
        raise BadFile(str(error)) from None


def check_found(faces: Sequence[Face], found: Sequence[Face], image: Box) -> None:
    """Raise BadFile if points fit a found face only in another scale, mirrored or turned.

    Points where no face was found are accepted.
    """
    last = np.array([image.width - 1.0, image.height - 1.0])
    for number, face in enumerate(faces, start=1):
        points = own_points(face)
        goals = [(own_points(other), other.interocular_px) for other in found]
        direct = min((_apart(points, *goal) for goal in goals), default=0.0)
        for goal, unit in goals if direct > _FITS else ():
            scale = (points * goal).sum() / (points**2).sum()
            across, down = np.round((last + 1.0) / scale)
            tried = {
                Text("a photo of {w:.0f} x {h:.0f} px", w=across, h=down): points * scale,
                Text("the mirrored photo"): (last * [1, 0] + points * [-1, 1])[_MIRRORED],
                Text("the photo upside down"): last - points,
                Text("the photo turned right"): last * [1, 0] + points[:, ::-1] * [-1, 1],
                Text("the photo turned left"): last * [0, 1] + points[:, ::-1] * [1, -1],
            }
            for other, moved in tried.items():
                if _apart(moved, goal, unit) < min(_FITS, direct / 2.0):
                    text = Text("face {n} is beside the face, as on {other}", n=number, other=other)
                    raise BadFile(text)


def _apart(points: Array, goal: Array, unit: float) -> float:
    """Return the mean distance of points in outer inter-ocular distances."""
    return float(np.linalg.norm(points - goal, axis=1).mean() / max(unit, 1e-9))


def face_of(points: Array) -> Face:
    """Return the face in points of a known layout (`_LAYOUTS`), shape (N, 2). Raises BadFile.

    The outline of another program is spaced evenly.
    """
    if len(points) not in _LAYOUTS:
        counts = ", ".join(map(str, _LAYOUTS))
        raise BadFile("it has {n} points instead of {counts}", n=len(points), counts=counts)
    outline, eyes, mouth = (points[list(numbers)] for numbers in _LAYOUTS[len(points)])
    if len(points) in MESH_COUNTS:
        outline = silhouette(points, eyes)
    elif len(outline) != OUTLINE_POINTS:
        outline = along(outline, OUTLINE_POINTS)
    if not np.linalg.norm(np.diff(outline, axis=0), axis=1).all():
        raise BadFile("two neighbouring points of the outline are equal")
    return Face(outline, eyes, mouth, source="points")


def _check_shape(face: Face, number: int) -> None:
    """Raise BadFile with the likely reason if points form no face that is seen from outside."""
    across, down = face.eyes[3] - face.eyes[0], face.mouth_center - face.eye_center
    outline = own_points(face)[:OUTLINE_POINTS]
    reason = None
    if _cross(across, down) < 0.0:
        if abs(across[1]) > abs(across[0]):
            reason = Text("x and y are exchanged")
        elif across[0] > 0.0:
            reason = Text("y counts upwards instead of downwards")
        else:
            reason = Text("left and right are exchanged")
    elif (
        _cross(outline[:-1], outline[1:]).sum() > 0.0
        or (face.mouth[1] - face.mouth[0]) @ across < 0.0
    ):
        reason = Text("its outline or mouth runs from right to left, the eyes from left to right")
    elif _crosses_itself(outline):
        reason = Text("the outline crosses itself, so the points are in another order")
    if reason is not None:
        raise BadFile("face {n} is no face: {reason}", n=number, reason=reason)


def _cross(first: Array, second: Array) -> Array:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def _crosses_itself(line: Array) -> bool:
    """Tell whether two pieces of a polyline (N, 2) cross."""
    starts, steps = line[:-1], np.diff(line, axis=0)
    # Sides of both ends of each piece (columns) beside the line through each other piece (rows).
    first = _cross(steps[:, None], starts - starts[:, None])
    last = _cross(steps[:, None], line[1:] - starts[:, None])
    parts = first * last < 0.0
    return bool((parts & parts.T).any())


def own_points(face: Face) -> Array:
    """Return our 27 points of a face, shape (27, 2). Resamples outlines of other lengths."""
    outline = face.outline
    if len(outline) != OUTLINE_POINTS:
        outline = along(outline, OUTLINE_POINTS)
    return np.vstack([outline, face.eyes, face.mouth])


def along(line: Array, count: int) -> Array:
    """Return `count` evenly spaced points on the Catmull-Rom curve through a line (N, 2), N >= 2.

    Result (count, 2), with both ends of the line. Straight pieces would cut every bend: on an oval
    face, 21 points to 17 and back lose 1.5 % of the distance between the eyes.
    """
    ends = 2.0 * line[[0, -1]] - line[[1, -2]]
    around = np.vstack([ends[:1], line, ends[1:]])
    before, first, last, after = (around[k : len(around) - 3 + k, None] for k in range(4))
    t = (np.arange(_STEPS) / _STEPS)[:, None]
    pieces = first + t / 2.0 * (
        last - before
        + t * (2.0 * before - 5.0 * first + 4.0 * last - after)
        + t**2 * (3.0 * (first - last) + after - before)
    )  # fmt: skip
    return resampled(np.vstack([pieces.reshape(-1, 2), line[-1:]]), count)


def csv_text(faces: Sequence[Array]) -> str:
    """Return a table with one named row for each of the 27 points of each face."""
    rows: list[tuple[object, ...]] = [("face", "point", "x", "y")]
    for index, points in enumerate(faces, start=1):
        for name, (x, y) in zip(_OWN_NAMES, points.tolist(), strict=True):
            rows.append((index, name, f"{x:.3f}", f"{y:.3f}"))
    with io.StringIO(newline="") as out:
        csv.writer(out, lineterminator="\n").writerows(rows)
        return out.getvalue()


def faces_text(faces: Sequence[Face]) -> str:
    """Return faces as JSON, without rounding."""
    return json.dumps({"faces": [face.to_dict() for face in faces]}, indent=1) + "\n"
