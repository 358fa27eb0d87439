"""Handles: the draggable points of a face, their names, and the effect of a drag."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from collections.abc import Set as AbstractSet
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces import reshape
from kogao_core.faces.face import Face
from kogao_core.faces.targets import center_candidates

from ..document import State
from ..i18n import tr
from ..view_state import Following, Handle, Kind

MOVABLE: Final[frozenset[Kind]] = frozenset({"outline", "eye", "mouth", "target"})
# Kinds with one handle per outline point; neighbours may follow.
ON_OUTLINE: Final[frozenset[Kind]] = frozenset({"outline", "target"})
_ALONE: Final = Following()
_LEAST_TURN_PX: Final = 1e-3
# Height of the hairline above the eyes, as a multiple of the distance from mouth to eyes.
_FOREHEAD: Final = 1.0
# Least landmark spacing on screen, px. Marks of closer landmarks would overlap.
_ROOM_PX: Final = 8.0


def handles(
    state: State, kinds: AbstractSet[Kind], placing: int | None = None
) -> Iterator[tuple[Handle, Array]]:
    """Yield handles of active faces with positions, px, topmost first."""
    if placing is not None:
        yield from _numbered(state, "corner", placing)
    shown = [kind for kind in _POINTS if kind in kinds]
    if state.mode == "manual":
        # A target marked by a click is on its landmark, so the target must be on top to be dragged.
        shown.sort(key=lambda kind: kind != "target")
    for face in range(len(state.faces)):
        if face not in state.off:
            for kind in shown:
                yield from _numbered(state, kind, face)


def _numbered(state: State, kind: Kind, face: int) -> Iterator[tuple[Handle, Array]]:
    for index, position in enumerate(points(state, kind, face)):
        yield Handle(kind, face, index), position


def apart(face: Face, zoom: float) -> bool:
    """Return whether the points of a face are distinguishable at `zoom` (screen px per photo px).

    Otherwise only the outline is drawn, and no point can be grabbed.
    """
    return face.anchor.spacing_px * zoom >= _ROOM_PX


def exists(state: State, handle: Handle) -> bool:
    """Return whether the face, and for outline handles the point, still exists."""
    if handle.face >= len(state.faces):
        return False
    return handle.kind not in ON_OUTLINE or handle.index < len(state.faces[handle.face].outline)


def position(state: State, handle: Handle) -> Array:
    """Return the position of a handle, px of the photo."""
    return np.asarray(points(state, handle.kind, handle.face)[handle.index])


def points(state: State, kind: Kind, face: int) -> Array:
    """Return the points of a kind, px of the photo, shape (N, 2)."""
    return _POINTS[kind](state, face)


def moved(
    state: State,
    handle: Handle,
    start: npt.ArrayLike,
    to: npt.ArrayLike,
    following: Following = _ALONE,
) -> State:
    """Return the state with a handle dragged from `start` (position in `state`) to `to`, px.

    Neighbours follow outline landmarks and targets only.
    """
    face = state.faces[handle.face]
    far, symmetric = reach_px(face, following), following.symmetric
    match handle.kind:
        case "outline":
            face = reshape.moved(face, handle.index, to, far, symmetric=symmetric)
        case "eye":
            face = face.with_eye_point(handle.index, to)
        case "mouth":
            face = face.with_mouth_point(handle.index, to)
        case "target":
            targets = state.pairs[handle.face].target_px
            face = reshape.with_target_moved(
                face, targets, handle.index, to, far, symmetric=symmetric
            )
        case "corner":
            face = face.mapped(_turn(corners(face).mean(axis=0), start, to))
        case "body":
            face = face.mapped(Affine(np.eye(2), np.asarray(to) - np.asarray(start)))
        case "centre" | "mark":
            return state
    return state.with_face(handle.face, face)


def reach_px(face: Face, following: Following) -> float:
    """Return the follow range along the outline, px of the photo; 0 without soft following."""
    return following.reach * face.anchor.spacing_px if following.soft else 0.0


def corners(face: Face) -> Array:
    """Return the corners of the frame round a face, shape (4, 2), clockwise from the top left."""
    left, top, width, height = face.box
    margin = 0.15 * max(width, height)
    x0, x1, y0, y1 = left - margin, left + width + margin, top - margin, top + height + margin
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


# Functions that return the points of a kind, px of the photo, shape (N, 2).
_POINTS: Final[dict[Kind, Callable[[State, int], Array]]] = {
    "outline": lambda state, face: state.faces[face].outline,
    "eye": lambda state, face: state.faces[face].eyes,
    "mouth": lambda state, face: state.faces[face].mouth,
    "target": lambda state, face: state.pairs[face].target_px,
    "centre": lambda state, face: center_candidates(state.faces[face]),
    "corner": lambda state, face: corners(state.faces[face]),
    "body": lambda state, face: corners(state.faces[face]).mean(axis=0, keepdims=True),
}


def name(handle: Handle, count: int) -> str:
    """Return the name of a handle. `count` is the number of outline points."""
    number = handle.index + 1
    eyes = (
        tr("left eye, outer corner"),
        tr("left eye, inner corner"),
        tr("right eye, inner corner"),
        tr("right eye, outer corner"),
    )
    match handle.kind:
        case "outline":
            return tr("outline {n}, {part}", n=number, part=_part(handle.index, count))
        case "target":
            return tr("target {n}, {part}", n=number, part=_part(handle.index, count))
        case "eye":
            return eyes[handle.index]
        case "mouth":
            return (tr("left mouth corner"), tr("right mouth corner"))[handle.index]
        case "centre":
            return tr("centre {n}", n=number)
        case "corner":
            return tr("turn and size the face")
        case "body":
            return tr("move the face")
        case "mark":
            return tr("a new landmark")


def index_of(face: Face, handle: Handle) -> int:
    """Return the index of a landmark in `face.points`: outline, eyes, mouth."""
    first = {"outline": 0, "eye": len(face.outline), "mouth": len(face.outline) + 4}
    return first[handle.kind] + handle.index


def confidence(face: Face, handle: Handle) -> float | None:
    """Return the confidence of a landmark, 0 to 1; None if unknown or no landmark."""
    if face.confidence is None or handle.kind not in ("outline", "eye", "mouth"):
        return None
    return float(face.confidence[index_of(face, handle)])


def _part(index: int, count: int) -> str:
    place = index / max(1, count - 1)
    if abs(place - 0.5) < 0.5 / count:
        return tr("chin")
    side = tr("left") if place < 0.5 else tr("right")
    from_end = min(place, 1.0 - place)
    if from_end < 0.5 / count:
        return tr("{side} temple", side=side)
    where = tr("cheek") if from_end < 0.25 else tr("jaw")
    return tr("{side} {where}", side=side, where=where)


def _turn(pivot: Array, start: npt.ArrayLike, to: npt.ArrayLike) -> Affine:
    """Return the rotation and scaling about `pivot` that maps `start` to `to`."""
    before, after = np.asarray(start) - pivot, np.asarray(to) - pivot
    length = max(_LEAST_TURN_PX, float(np.linalg.norm(before)))
    scale = max(_LEAST_TURN_PX, float(np.linalg.norm(after))) / length
    degrees = np.degrees(np.arctan2(after[1], after[0]) - np.arctan2(before[1], before[0]))
    turn = Affine.similarity(scale, float(degrees), (0.0, 0.0))
    return Affine(turn.matrix, pivot - turn(pivot))


def face_at(faces: Sequence[Face], at: Array, margin_px: float) -> int | None:
    """Return the face with the greatest depth at a point, in landmark spacings. `at` (2,) px."""
    found, deepest = None, -np.inf
    for index, face in enumerate(faces):
        x, y = at.tolist()
        inside_px = cv2.pointPolygonTest(_rim(face), (x, y), measureDist=True)
        depth = inside_px / face.anchor.spacing_px
        if inside_px >= -margin_px and depth > deepest:
            found, deepest = index, depth
    return found


def _rim(face: Face) -> Array:
    """Return the hull of landmarks and estimated hairline; the outline excludes the forehead."""
    up = face.eye_center - face.mouth_center
    hairline = face.eyes[[0, 3]] + _FOREHEAD * up
    points = np.concatenate([face.points, hairline]).astype(np.float32)
    return np.asarray(cv2.convexHull(points))
