"""Faces marked point by point, with the paper's conventional method (section 2)."""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.face import Face
from kogao_core.faces.reshape import MIDDLE, across, reflection, turns

from ...document import CORNERS, Mark, State
from ...i18n import tr
from ...view_state import Handle, ViewState
from ..handles import name
from .gesture import Gesture, PointerEvent

_EYES: Final = 4
FEWEST: Final = 3
# Maximum distance of a new landmark from the face's box, as a fraction of the larger side.
_REACH: Final = 0.5
# A mirrored point replaces a landmark within this distance, in landmark spacings.
_SAME: Final = 0.4


def mark(view: ViewState, event: PointerEvent) -> Gesture:
    """Mark a landmark at the press; the drag sets the target. The landmark is one undo step."""
    document, landmark = view.document, _xy(event)
    document.commit()
    while not event.released:
        before = document.committed
        face = owner(before, view.face, landmark)
        state = marked(before, face, (landmark, _xy(event)))
        document.preview(state, tr("Mark a landmark"))
        event = yield
    document.commit()


def _xy(event: PointerEvent) -> tuple[float, float]:
    x, y = event.point_px.tolist()
    return x, y


def marked(state: State, face: int | None, at: Mark) -> State:
    """Return the state with one more point: a landmark of `face`, or of the unfinished face."""
    if face is not None:
        return state.with_face(face, _with_landmark(state.faces[face], at))
    draft = (*state.draft, at)
    if len(draft) < CORNERS + FEWEST:
        return dataclasses.replace(state, draft=draft)
    return dataclasses.replace(state, draft=(), faces=(*state.faces, _begun(draft)))


def owner(state: State, chosen: int | None, at: tuple[float, float]) -> int | None:
    """Return the face for a new landmark at (x, y); None if a new face starts."""
    if state.draft:
        return None
    if chosen is not None:
        return chosen
    for index, face in enumerate(state.faces):
        left, top, width, height = face.box
        reach = _REACH * max(width, height)
        inside_x = left - reach <= at[0] <= left + width + reach
        if inside_x and top - reach <= at[1] <= top + height + reach:
            return index
    return None


def _begun(draft: tuple[Mark, ...]) -> Face:
    sources = np.array([source for source, _ in draft])
    targets = np.array([target for _, target in draft])
    face = Face(outline=sources[CORNERS:], eyes=sources[:_EYES], mouth=sources[_EYES:CORNERS])
    order = np.argsort(turns(face, face.outline))
    return dataclasses.replace(face, outline=face.outline[order], targets=targets[CORNERS:][order])


def _with_landmark(face: Face, at: Mark) -> Face:
    source, target = at
    before = turns(face, face.outline) < turns(face, np.array([source]))
    where = int(before.sum())
    outline = np.insert(face.outline, where, source, axis=0)
    return _reshaped(face, outline, np.insert(_targets(face), where, target, axis=0))


def _targets(face: Face) -> Array:
    return np.full_like(face.outline, np.nan) if face.targets is None else face.targets


def _reshaped(face: Face, outline: Array, targets: Array) -> Face:
    # The lattice depends on the mean spacing, which has changed: recompute the frame.
    return dataclasses.replace(
        face,
        outline=outline,
        targets=None if np.isnan(targets).all() else targets,
        pinned_anchor=None,
        confidence=None,
    )


def without_landmark(state: State, handle: Handle) -> State:
    """Return the state without a landmark; remove the face if fewer than three would remain."""
    face = state.faces[handle.face]
    if len(face.outline) <= FEWEST:
        return state.without_face(handle.face)
    outline = np.delete(face.outline, handle.index, axis=0)
    targets = np.delete(_targets(face), handle.index, axis=0)
    return state.with_face(handle.face, _reshaped(face, outline, targets))


def mirrored(state: State, handle: Handle) -> State:
    """Return the state with a landmark and target mirrored to the other side of the face."""
    face = state.faces[handle.face]
    mirror, spacing = reflection(face), face.anchor.spacing_px
    source = mirror(face.outline[handle.index])
    target = mirror(state.pairs[handle.face].target_px[handle.index])
    apart = np.linalg.norm(face.outline - source, axis=1)
    apart[handle.index] = np.inf
    nearest = int(np.argmin(apart))
    if apart[nearest] < _SAME * spacing:
        face = face.with_outline_point(nearest, source).with_target(nearest, target)
    else:
        face = _with_landmark(face, (_pair(source), _pair(target)))
    return state.with_face(handle.face, face)


def with_sides_alike(state: State, handle: Handle) -> State:
    """Return the state with one side mirrored; the other side's landmarks are replaced."""
    face, targets = state.faces[handle.face], state.pairs[handle.face].target_px
    mirror, spacing = reflection(face), face.anchor.spacing_px
    side = (face.outline - mirror(face.outline)) @ across(face)
    middle = np.abs(side) < 2.0 * MIDDLE * spacing
    wanted = np.sign(side[handle.index]) or 1.0
    kept = (np.sign(side) == wanted) & ~middle
    outline, aims = face.outline[kept], targets[kept]
    other, other_aims = mirror(outline)[::-1], mirror(aims)[::-1]
    parts = (outline, face.outline[middle], other), (aims, targets[middle], other_aims)
    if wanted > 0.0:  # the outline starts at the left temple and ends at the right temple
        parts = (parts[0][::-1], parts[1][::-1])
    if 2 * kept.sum() + middle.sum() < FEWEST:
        return state
    changed = _reshaped(face, np.concatenate(parts[0]), np.concatenate(parts[1]))
    return state.with_face(handle.face, changed)


def snapped(state: State, handle: Handle) -> State:
    """Return the state with a target moved onto the line from its landmark to the centre."""
    pairs = state.pairs[handle.face]
    source, target = pairs.source_px[handle.index], pairs.target_px[handle.index]
    line = pairs.center_px - source
    share = float((target - source) @ line / max(1e-12, line @ line))
    face = state.faces[handle.face].with_target(handle.index, source + share * line)
    return state.with_face(handle.face, face)


def _pair(point: Array) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def next_hint(state: State) -> str:
    """Return a hint for the next point to mark."""
    done = len(state.draft)
    if state.faces and not done:
        return tr("Press on the outline and drag to the target; drag any point to correct it")
    if done < CORNERS:
        kind, index = ("eye", done) if done < _EYES else ("mouth", done - _EYES)
        what = name(Handle(kind, 0, index), 0)  # type: ignore[arg-type]
        return tr("Click the {what} ({n} of {all})", what=what, n=done + 1, all=CORNERS)
    return tr("Press on the outline, first beside the left eye, and drag to the target")
