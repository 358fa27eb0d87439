"""Setting times of manual work, as table 2 counts them: one line of JSON for each session.

A line is written when somebody has set a photo's landmarks and targets by hand and applies them::

    {"version": 1, "photo": "anna.jpg", "width": 960, "height": 720, "faces": 1, "landmarks": 21,
     "setting_s": 74.2, "at": "2026-11-21T15:04:13+00:00"}

Lines are only ever added, whole; a last line that was cut off when a program was killed is left
out on reading.
"""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Final

from kogao_core.base.atomic import appended
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile, Node, parse

VERSION: Final = 1
_LONGEST_S: Final = 86_400.0
_MOST_PX: Final = 1_000_000
_MOST_POINTS: Final = 100_000
_MOST_BYTES: Final = 4096  # of a line


@dataclass(frozen=True, slots=True)
class SettingTime:
    """One photo set by hand."""

    photo: str  # name of its file, without the folder
    # Its size, px.
    width: int
    height: int
    # Faces that were set, and all outline landmarks of theirs.
    faces: int
    landmarks: int
    setting_s: float  # time on the setting clock when it was applied, s
    at: str  # when, ISO 8601 with the time zone

    @staticmethod
    def now(
        photo: str, size: tuple[int, int], landmarks: list[int], setting_s: float
    ) -> SettingTime:
        """Return a session that ends now; `size` is (width, height), `landmarks` one per face."""
        at = datetime.now().astimezone().isoformat(timespec="seconds")
        return SettingTime(photo, *size, len(landmarks), sum(landmarks), setting_s, at)


def append(path: Path, setting_time: SettingTime) -> None:
    """Add a session to a file, which is made if need be."""
    values = {"version": VERSION, **dataclasses.asdict(setting_time)}
    with appended(path) as file:
        file.write(json.dumps(values, ensure_ascii=False).encode() + b"\n")
        file.flush()
        os.fsync(file.fileno())


def read(path: Path) -> list[SettingTime]:
    """Return the sessions of a file, oldest first. Raises BadFile."""
    found = []
    lines = path.read_bytes().split(b"\n")
    for number, line in enumerate(lines, start=1):
        try:
            if line.strip():
                found.append(_setting_time(parse(line, _MOST_BYTES)))
        except BadFile as error:
            if _was_cut_off(line):
                continue
            raise BadFile(
                Text(
                    "line {number} of {path} is no session: {error}",
                    number=number,
                    path=path,
                    error=error,
                )
            ) from None
    return found


def _was_cut_off(line: bytes) -> bool:
    return line.startswith(b"{") and not line.rstrip().endswith(b"}")


def _setting_time(node: Node) -> SettingTime:
    names = [field.name for field in dataclasses.fields(SettingTime)]
    node.only({"version", *names})
    node.field("version").whole(VERSION, VERSION)
    return SettingTime(
        node.field("photo").text(1024),
        node.field("width").whole(1, _MOST_PX),
        node.field("height").whole(1, _MOST_PX),
        node.field("faces").whole(1, _MOST_POINTS),
        node.field("landmarks").whole(1, _MOST_POINTS),
        node.field("setting_s").number(0.0, _LONGEST_S),
        _time(node.field("at")),
    )


def _time(node: Node) -> str:
    text = node.text(40)
    try:
        datetime.fromisoformat(text)
    except ValueError:
        node.refuse("must be a time such as 2026-11-21T15:04:13+00:00")
    return text
