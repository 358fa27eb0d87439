"""What the oracle of `interleaving` goes by: an unreliable disk, and books of the user's work."""

from __future__ import annotations

import contextlib
import json
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from kogao_app.features import files, recovery

from kogao_core.projects import edits

_SLOW_S = 0.3
POINT = 10

# What the oracle knows work by: percent, one point of the outline, strokes.
Sign = tuple[float, tuple[float, ...] | None, int]


class Disk:
    """What the editor reads and writes with; each kind of file is quick, slow, full or dead."""

    kinds = ("copy", "project", "recovery", "photo")

    def __init__(self) -> None:
        self.mode = dict.fromkeys(self.kinds, "quick")
        self.open = threading.Event()
        self.open.set()

    def do(self, kind: str, call: Callable, *args, **named):
        """Call a function of this kind as this disk does it."""
        if self.mode[kind] == "slow":
            self.open.wait(_SLOW_S)
        if self.mode[kind] in ("full", "dead"):
            raise OSError(28, "No space left on device")
        return call(*args, **named)


@contextlib.contextmanager
def through(disks: list[Disk]) -> Iterator[None]:
    """Lead all files through the newest disk."""

    def led(kind: str, call: Callable, *args, **named):
        return disks[-1].do(kind, call, *args, **named)

    with pytest.MonkeyPatch.context() as patch:
        for module, name, kind in (
            *((files, "save_copy", "copy"), (edits, "save", "project")),
            *((recovery, "save", "recovery"), (files, "open_photo", "photo")),
        ):
            patch.setattr(module, name, partial(led, kind, getattr(module, name)))
        yield


def sign_of(state) -> Sign:
    """Return what is known of a state."""
    sheet = state.sheet("automatic")
    faces = sheet.faces
    point = tuple(faces[0].outline[POINT].round(3).tolist()) if faces else None
    return round(sheet.recipe.percent, 4), point, len(state.protection.strokes)


def sign_in(file: Path) -> tuple[str, Sign] | None:
    """Return the photo's name and what a project file holds, read as plain JSON."""
    try:
        values = json.loads(file.read_text())
    except (OSError, ValueError):
        return None
    sheet, unit = values["automatic"], values["unit_px"]
    faces = sheet["faces"]
    point = None
    if faces:
        point = tuple(np.round(np.multiply(faces[0]["outline"][POINT], unit), 3).tolist())
    strokes = len(values["protection"]["strokes"])
    name = Path(values["photo"]["path"]).name
    return name, (round(sheet["recipe"]["percent"], 4), point, strokes)


class Lost(AssertionError):
    """Something that the user made is nowhere."""


@dataclass
class Books:
    """What the user did to the open photo, and what earlier crashes still owe."""

    name: str = ""  # file name of the photo; empty while none is open
    states: list = field(default_factory=list)  # before the first undo step, and after each
    at: int = 0  # state that undo and redo have led to
    afresh: bool = True  # `states[0]` came from the photo alone and can be made again
    discarded: Sign | None = None  # work that the user has said may be lost
    # Photo and work that crashes have left, not restored or discarded yet.
    owed: list[tuple[str, Sign]] = field(default_factory=list)

    @property
    def work(self) -> Sign:
        """What there is now."""
        return sign_of(self.states[self.at])

    def begin(self, name: str, states: Sequence[object], at: int) -> None:
        """Note that another photo is open, with what undo and redo lead to."""
        self.name, self.states, self.at = name, list(states), at
        self.discarded = None

    def push(self, state: object) -> None:
        """Note an edit."""
        if state is not self.states[self.at]:
            self.states[self.at + 1 :] = [state]
            self.at += 1
