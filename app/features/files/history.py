"""States of a photo as projects, and its undo steps as a file in the user's own folder."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any, Final
from weakref import WeakKeyDictionary

from kogao_core.base import strict
from kogao_core.base.atomic import put
from kogao_core.base.strict import BadFile
from kogao_core.photo import Photo
from kogao_core.projects.project import Original, Project, from_node, to_dict
from kogao_core.projects.sidecar import own_place

from ...document import State, UndoSteps

MOST_BYTES: Final = 1 << 19
"""How much is kept of a photo's steps; the oldest go first."""
_LONGEST: Final = 200
# States don't change; each is put into words once. Only the thread that writes does so.
_words: Final[WeakKeyDictionary[State, str]] = WeakKeyDictionary()


def write(photo: Photo, store: Path, steps: UndoSteps) -> None:
    """Keep the newest undo steps of a photo."""
    lines = [_line(state, photo) for state in steps.states]
    first, last, size = 0, len(lines) - 1, sum(map(len, lines))
    while size > MOST_BYTES and first < last:
        if first < steps.index:
            size, first = size - len(lines[first]), first + 1
        else:
            size, last = size - len(lines[last]), last - 1
    texts = json.dumps(steps.texts[first:last])
    states = ",\n".join(lines[first : last + 1])
    text = f'{{"index": {steps.index - first}, "texts": {texts}, "states": [{states}]}}'
    put(text.encode(), _place(photo, store))


def read(photo: Photo, store: Path, state: State) -> UndoSteps | None:
    """Return the steps that led to a state; None where what is kept leads elsewhere."""
    try:
        top = strict.parse(strict.read(_place(photo, store), 2 * MOST_BYTES), 2 * MOST_BYTES)
        nodes = top.field("states").items(MOST_BYTES)
        index = top.field("index").whole(0, len(nodes) - 1)
        texts = tuple(node.text(_LONGEST) for node in top.field("texts").items(len(nodes)))
        if nodes[index].value != _values(state, photo) or len(texts) != len(nodes) - 1:
            return None
        states = [state_of(from_node(node)) for node in nodes]
    except (BadFile, IndexError):
        return None
    states[index] = state
    return UndoSteps(tuple(states), texts, index)


def _place(photo: Photo, store: Path) -> Path:
    return own_place(photo.path, store).with_suffix(".steps")


def _line(state: State, photo: Photo) -> str:
    if state not in _words:
        _words[state] = json.dumps(_values(state, photo))
    return _words[state]


def _values(state: State, photo: Photo) -> dict[str, Any]:
    # Neither where the photo lies nor which program it was makes it another state.
    return {**to_dict(project_of(state, photo, "")), "program": "", "photo": _size(photo)}


def _size(photo: Photo) -> dict[str, Any]:
    return dataclasses.asdict(Original("", "", photo.width, photo.height))


def project_of(state: State, photo: Photo, sha256: str) -> Project:
    """Return what a file is to hold of a state; points of a face not yet begun are left out."""
    visited = state.mode == "manual" or state.kept is not None
    return Project(
        Original(str(photo.path), sha256, photo.width, photo.height),
        state.mode,
        state.sheet("automatic"),
        state.sheet("manual") if visited else None,
        state.protection,
        state.loose,
        state.brushwork,
    )


def state_of(project: Project) -> State:
    """Return the state that a file describes, px of its photo."""
    here, there = project.automatic, project.manual
    if project.mode == "manual" and there is not None:
        here, there = there, here
    mode = project.mode if there is not None else "automatic"
    return State(
        here.faces,
        here.off,
        here.recipe,
        protection=project.protection,
        loose=project.loose,
        brushwork=project.brushwork,
        mode=mode,
        kept=there,
    )
