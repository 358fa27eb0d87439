"""Convert states to projects; serialise the undo steps of a photo."""

from __future__ import annotations

import json
from typing import Any, Final
from weakref import WeakKeyDictionary

from kogao_core.base import json_reader
from kogao_core.base.json_reader import BadFile
from kogao_core.projects.edits import Edits, SavedEdits
from kogao_core.projects.project import Original, Project, from_node, to_dict

from ...document import State, UndoSteps

MOST_BYTES: Final = 1 << 26
"""Size limit of a photo's undo steps; the oldest steps are deleted first."""
_LONGEST: Final = 200
# States are immutable, so each is serialised once. Only the thread for edits uses this cache.
_lines: Final[WeakKeyDictionary[State, str]] = WeakKeyDictionary()
Size = tuple[int, int]
"""Width and height of a photo, px, upright."""


def packed(steps: UndoSteps, size_px: Size) -> bytes:
    """Return the newest undo steps of a photo, serialised."""
    lines = [_line(state, size_px) for state in steps.states]
    first, last, size = 0, len(lines) - 1, sum(map(len, lines))
    while size > MOST_BYTES and first < last:
        if first < steps.index:
            size, first = size - len(lines[first]), first + 1
        else:
            size, last = size - len(lines[last]), last - 1
    texts = json.dumps(steps.texts[first:last])
    states = ",\n".join(lines[first : last + 1])
    text = f'{{"index": {steps.index - first}, "texts": {texts}, "states": [{states}]}}'
    return text.encode()


def find(edits: Edits, saved: SavedEdits, project: Project) -> UndoSteps | None:
    """Return the undo steps that led to saved edits; None if none of the stored steps does."""
    size_px = project.original.width, project.original.height
    found = (unpacked(one, size_px, state_of(project)) for one in edits.steps_of(saved, project))
    return next(filter(None, found), None)


def unpacked(data: bytes, size_px: Size, state: State) -> UndoSteps | None:
    """Return the undo steps that led to a state; None if they lead to another state."""
    try:
        top = json_reader.parse(data, 2 * MOST_BYTES)
        nodes = top.field("states").items(MOST_BYTES)
        index = top.field("index").whole(0, len(nodes) - 1)
        texts = tuple(node.text(_LONGEST) for node in top.field("texts").items(len(nodes)))
        if nodes[index].value != _values(state, size_px) or len(texts) != len(nodes) - 1:
            return None
        states = [state_of(from_node(node)) for node in nodes]
    except (BadFile, IndexError):
        return None
    states[index] = state
    return UndoSteps(tuple(states), texts, index)


def _line(state: State, size_px: Size) -> str:
    if state not in _lines:
        _lines[state] = json.dumps(_values(state, size_px))
    return _lines[state]


def _values(state: State, size_px: Size) -> dict[str, Any]:
    # Neither the photo's path nor the program's version is part of a state.
    return {**to_dict(project_of(state, Original("", "", *size_px))), "program": ""}


def project_of(state: State, original: Original) -> Project:
    """Return the project that stores a state; landmarks of an incomplete face are left out."""
    visited = state.mode == "manual" or state.kept is not None
    return Project(
        original,
        state.mode,
        state.sheet("automatic"),
        state.sheet("manual") if visited else None,
        state.protection,
        state.loose,
        state.brushwork,
    )


def state_of(project: Project) -> State:
    """Return the state that a project stores, px of its photo."""
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
