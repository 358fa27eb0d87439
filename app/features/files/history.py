"""Convert states to projects; store the undo steps of a photo in the user's folder."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any, Final
from weakref import WeakKeyDictionary

from kogao_core.base import json_reader
from kogao_core.base.atomic import atomic_write
from kogao_core.base.json_reader import BadFile
from kogao_core.projects.project import Original, Project, from_node, to_dict
from kogao_core.projects.sidecar import own_place

from ...document import State, UndoSteps

MOST_BYTES: Final = 1 << 19
"""Size limit of a photo's undo file; the oldest steps are deleted first."""
_LONGEST: Final = 200
TOGETHER: Final = threading.Lock()
"""Locked while the project and the undo steps of a photo are read or written together."""
# States are immutable, so each is serialised once. Only the thread for edits uses this cache.
_lines: Final[WeakKeyDictionary[State, str]] = WeakKeyDictionary()
Size = tuple[int, int]
"""Width and height of a photo, px, upright."""


def write(path: Path, size_px: Size, store: Path, steps: UndoSteps) -> None:
    """Write the newest undo steps of a photo. Raises OSError."""
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
    atomic_write(text.encode(), _place(path, store), private=True)


def read(path: Path, size_px: Size, store: Path, state: State) -> UndoSteps | None:
    """Return the undo steps that led to a state; None if the file leads to another state."""
    try:
        top = json_reader.parse(
            json_reader.read(_place(path, store), 2 * MOST_BYTES), 2 * MOST_BYTES
        )
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


def _place(path: Path, store: Path) -> Path:
    return own_place(path, store).with_suffix(".steps")


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
