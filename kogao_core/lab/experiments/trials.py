"""Trials for table 2: landmarks of one photo, set by a person or found by the program.

A file has one line of JSON per trial and mode. A correction after *Apply* appends a longer line;
the last line of a trial counts::

    {"version": 2, "trial": "9f1c…", "mode": "manual", "photo": "a.jpg", "width": 960,
     "height": 720, "cold": false, "looking_s": 6.1, "setting_s": 22.8, "corrections_s": [2.2],
     "faces": [{"outline": [[…], …], …}], "at": "2026-…"}

Files are append-only. Readers ignore an incomplete last line, left by a killed program.
"""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, Final, Literal, get_args

from kogao_core.base.atomic import appended
from kogao_core.base.json_reader import BadFile, Node, parse
from kogao_core.base.language import Text
from kogao_core.faces.face import Face
from kogao_core.projects.json import MOST_FACES, face_dict
from kogao_core.projects.json import faces as faces_of

VERSION: Final = 2
Mode = Literal["manual", "automatic"]
_LONGEST_S: Final = 86_400.0
_MOST_PX: Final = 1_000_000
_MOST_TRIALS: Final = 100_000
_MOST_BYTES: Final = 2**21  # limit of a line


@dataclass(frozen=True, eq=False, kw_only=True)
class Trial:
    """One trial: the landmarks of one photo, and times."""

    trial: str  # name; of lines with the same name and mode the last counts
    mode: Mode
    photo: str  # file name without folder
    # Size of the photo, px.
    width: int
    height: int
    cold: bool  # automatic setting: whether the time contains loading the networks
    looking_s: float  # from the first view to the first point, s
    setting_s: float  # from the first view to Apply, s
    corrections_s: tuple[float, ...]  # from each change after Apply to the next Apply, s
    # With all targets, px of the photo; in files relative to the longer side.
    faces: tuple[Face, ...]
    at: str  # time, ISO 8601 with time zone

    @property
    def total_s(self) -> float:
        """Setting time with corrections, s."""
        return self.setting_s + sum(self.corrections_s)

    @property
    def landmarks(self) -> int:
        return sum(len(face.outline) for face in self.faces)


def now() -> str:
    """Return the current time in the format of trials."""
    return datetime.now().astimezone().isoformat(timespec="seconds")


def append(path: Path, trial: Trial) -> None:
    """Append a trial to a file; create the file if missing."""
    values = {field.name: getattr(trial, field.name) for field in dataclasses.fields(Trial)}
    values["faces"] = [face_dict(face, max(trial.width, trial.height)) for face in trial.faces]
    with appended(path) as file:
        file.write(json.dumps({"version": VERSION, **values}, ensure_ascii=False).encode() + b"\n")
        file.flush()
        os.fsync(file.fileno())


def read(path: Path) -> list[Trial]:
    """Return the trials of a file, oldest first, with the last line of each. Raises BadFile."""
    found: dict[tuple[str, str], Trial] = {}
    lines = path.read_bytes().split(b"\n")
    for number, line in enumerate(lines, start=1):
        try:
            node = parse(line.strip() or b"{}", _MOST_BYTES)
            if node.value and node.field("practice").value is not True:
                trial = _trial(node)
                found[trial.trial, trial.mode] = trial
        except BadFile as error:
            if _was_cut_off(line):
                continue
            raise BadFile(
                "line {number} of {path} is not a trial: {error}",
                number=number,
                path=path,
                error=error,
            ) from None
    return list(found.values())


def _was_cut_off(line: bytes) -> bool:
    return line.startswith(b"{") and not line.rstrip().endswith(b"}")


def _trial(node: Node) -> Trial:
    # Former versions stored the fields of a guided session, too.
    former = ("person", "order", "practice")
    node.only({"version", *former, *(field.name for field in dataclasses.fields(Trial))})
    node.field("version").whole(VERSION, VERSION)
    mode: Any = node.field("mode").text(20, get_args(Mode))
    size = node.field("width").whole(1, _MOST_PX), node.field("height").whole(1, _MOST_PX)
    faces = faces_of(node.field("faces").items(MOST_FACES), max(size))
    if not faces:
        node.field("faces").refuse(Text("must hold a face"))
    return Trial(
        trial=node.field("trial").text(64),
        mode=mode,
        photo=node.field("photo").text(1024),
        width=size[0],
        height=size[1],
        cold=node.field("cold").flag(),
        looking_s=node.field("looking_s").number(0.0, _LONGEST_S),
        setting_s=node.field("setting_s").number(0.0, _LONGEST_S),
        corrections_s=tuple(
            one.number(0.0, _LONGEST_S) for one in node.field("corrections_s").items(_MOST_TRIALS)
        ),
        faces=faces,
        at=_time(node.field("at")),
    )


def _time(node: Node) -> str:
    text = node.text(40)
    try:
        datetime.fromisoformat(text)
    except ValueError:
        node.refuse("must be a time such as 2026-11-21T15:04:13+00:00")
    return text
