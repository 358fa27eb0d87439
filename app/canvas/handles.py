"""The points of a face that can be taken hold of, their names, and what moving one means."""

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
_ALONE: Final = Following()
_LEAST_TURN_PX: Final = 1e-3
# The hairline lies about as far above the eyes as the mouth lies below them.
_FOREHEAD: Final = 1.0
# Landmarks that are closer on screen have marks that touch, and none could be aimed at.
_ROOM_PX: Final = 8.0


def handles(
    state: State, kinds: AbstractSet[Kind], placing: int | None = None
) -> Iterator[tuple[Handle, Array]]:
    """Yield the handles of all active faces with their positions, px; the first ones lie on top."""
    if placing is not None:
        yield from _numbered(state, "corner", placing)
    shown = [kind for kind in _POINTS if kind in kinds]
    if state.mode == "manual":
        # A target marked with a mere click lies on its landmark and must be drawn out of it.
        shown.sort(key=lambda kind: kind != "target")
    for face in range(len(state.faces)):
        if face not in state.off:
            for kind in shown:
                yield from _numbered(state, kind, face)


def _numbered(state: State, kind: Kind, face: int) -> Iterator[tuple[Handle, Array]]:
    for index, position in enumerate(_POINTS[kind](state, face)):
        yield Handle(kind, face, index), position


def apart(face: Face, zoom: float) -> bool:
    """Return whether a face's points can be told apart at so many screen px per photo px.

    Where they can't, nothing but the face's outline is shown, and none can be taken hold of.
    """
    return face.anchor.spacing_px * zoom >= _ROOM_PX


def exists(state: State, handle: Handle) -> bool:
    """Return whether a face, and a point of its outline, is still there."""
    if handle.face >= len(state.faces):
        return False
    on_outline = handle.kind in ("outline", "target")
    return not on_outline or handle.index < len(state.faces[handle.face].outline)


def position(state: State, handle: Handle) -> Array:
    """Return where a handle lies, px of the photo."""
    return np.asarray(_POINTS[handle.kind](state, handle.face)[handle.index])


def moved(
    state: State,
    handle: Handle,
    start: npt.ArrayLike,
    to: npt.ArrayLike,
    following: Following = _ALONE,
) -> State:
    """Return the state with a handle dragged from `start`, where it lay in `state`, to `to`, px.

    Only on the outline does anything follow; targets set by hand stay where they are.
    """
    face = state.faces[handle.face]
    match handle.kind:
        case "outline":
            far, symmetric = reach_px(face, following), following.symmetric
            face = reshape.moved(face, handle.index, to, far, symmetric=symmetric)
        case "eye":
            face = face.with_eye_point(handle.index, to)
        case "mouth":
            face = face.with_mouth_point(handle.index, to)
        case "target":
            face = face.with_target(handle.index, to)
        case "corner":
            face = face.mapped(_turn(corners(face).mean(axis=0), start, to))
        case "body":
            face = face.mapped(Affine(np.eye(2), np.asarray(to) - np.asarray(start)))
        case "centre" | "mark":
            return state
    return state.with_face(handle.face, face)


def reach_px(face: Face, following: Following) -> float:
    """Return how far along the outline neighbours follow, px of the photo; 0 for not at all."""
    return following.reach * face.anchor.spacing_px if following.soft else 0.0


def corners(face: Face) -> Array:
    """Return the corners of the frame round a face, shape (4, 2), clockwise from the top left."""
    left, top, width, height = face.box
    margin = 0.15 * max(width, height)
    x0, x1, y0, y1 = left - margin, left + width + margin, top - margin, top + height + margin
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


# Where the points of a kind lie on a face, px of the photo, shape (N, 2).
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
    """Return what the point under the cursor is called; `count` outline points there are."""
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
    """Return which of the face's points a landmark is: outline, eyes and mouth in turn."""
    first = {"outline": 0, "eye": len(face.outline), "mouth": len(face.outline) + 4}
    return first[handle.kind] + handle.index


def confidence(face: Face, handle: Handle) -> float | None:
    """Return how sure the landmark is, 0 to 1; None where nobody says or it is no landmark."""
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
    """Return the turn and scaling about `pivot` that carries `start` to `to`."""
    before, after = np.asarray(start) - pivot, np.asarray(to) - pivot
    length = max(_LEAST_TURN_PX, float(np.linalg.norm(before)))
    scale = max(_LEAST_TURN_PX, float(np.linalg.norm(after))) / length
    degrees = np.degrees(np.arctan2(after[1], after[0]) - np.arctan2(before[1], before[0]))
    turn = Affine.similarity(scale, float(degrees), (0.0, 0.0))
    return Affine(turn.matrix, pivot - turn(pivot))


def face_at(faces: Sequence[Face], at: Array, margin_px: float) -> int | None:
    """Return the face that a point lies deepest in, by the face's own measure. `at` (2,) px."""
    found, deepest = None, -np.inf
    for index, face in enumerate(faces):
        x, y = at.tolist()
        inside_px = cv2.pointPolygonTest(_rim(face), (x, y), measureDist=True)
        depth = inside_px / face.anchor.spacing_px
        if inside_px >= -margin_px and depth > deepest:
            found, deepest = index, depth
    return found


def _rim(face: Face) -> Array:
    """Return the hull of the landmarks and the forehead, which the outline leaves out."""
    up = face.eye_center - face.mouth_center
    hairline = face.eyes[[0, 3]] + _FOREHEAD * up
    points = np.concatenate([face.points, hairline]).astype(np.float32)
    return np.asarray(cv2.convexHull(points))
