"""Many photos through one recipe: in other processes, one bad file never stops the rest."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final, Literal

from kogao_core.face import LandmarkSource
from kogao_core.photo.model import FORMATS
from kogao_core.recipe import Recipe

Status = Literal["done", "skipped", "no face", "failed"]
_CHUNK_BYTES: Final = 1 << 20


class NothingToDo(ValueError):
    """The inputs can't be worked on; the message says why."""


@dataclass(frozen=True, slots=True)
class Task:
    """One photo of a batch, as plain values that travel to other processes and machines.

    Parameters
    ----------
    source, output : str
        Where to read and where to write.
    recipe : dict
        `Recipe.to_dict`.
    which : str
        Faces to work on: all, largest, or numbers.
    max_megapixels : float
        Refuse larger photos.
    landmarks : str, optional
        Where they come from, see `landmarks.source`.
    done : str
        What an earlier run wrote for the same source and choices (`Outcome.key`), or "".
    """

    source: str
    output: str
    recipe: Mapping[str, Any]
    which: str = "all"
    max_megapixels: float = 300.0
    landmarks: str | None = None
    done: str = ""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one photo: a line of the report.

    Parameters
    ----------
    source, output : str
        As in the task.
    status : {"done", "skipped", "no face", "failed"}
        Skipped photos were done by an earlier run.
    reason : str
        A sentence where something went wrong; else what became of the blocks of a JPEG.
    key : str
        Hash of the source's bytes, the choices and the output's bytes.
    faces : int
        How many were worked on.
    seconds : float
        Time from reading to written.
    """

    source: str
    output: str
    status: Status
    reason: str = ""
    key: str = ""
    faces: int = 0
    seconds: float = 0.0

    def to_json(self) -> str:
        """Return the line of the report."""
        return json.dumps(asdict(self), ensure_ascii=False)


def plan(
    inputs: Sequence[Path],
    folder: Path,
    recipe: Recipe,
    *,
    which: str = "all",
    max_megapixels: float = 300.0,
    landmarks: str | None = None,
    report: Path | None = None,
) -> list[Task]:
    """Return the tasks for files and folders; a folder's photos keep their place in it.

    Parameters
    ----------
    inputs : sequence of Path
        Photos, and folders to search for photos.
    folder : Path
        Where outputs go, and nowhere else.
    recipe, which, max_megapixels, landmarks
        See `Task`.
    report : Path, optional
        An earlier run's report: what it lists as done needn't be done again.

    Raises
    ------
    NothingToDo
        If an input doesn't exist, there is no photo, or two would be written to one place.
    """
    found: dict[Path, Path] = {}
    for path in inputs:
        for photo, place in _photos(path, folder):
            output = folder / place
            if found.setdefault(output, photo) != photo:
                raise NothingToDo(
                    f"{found[output]} and {photo} would both become {output}; "
                    "work on their folders one by one"
                )
    if not found:
        raise NothingToDo("no photos there; name files or folders that hold some")
    keys = _keys(report)
    choices = recipe.to_dict(), which, max_megapixels, landmarks
    return [
        Task(str(photo), str(output), *choices, keys.get(str(output), ""))
        for output, photo in found.items()
    ]


def _photos(path: Path, folder: Path) -> Iterator[tuple[Path, Path]]:
    """Yield photos and their places below the output folder."""
    if path.is_file():
        yield path, Path(path.name)
    elif path.is_dir():
        for below in sorted(path.rglob("*")):
            mine = below.is_relative_to(folder) and not path.is_relative_to(folder)
            if below.suffix.lower() in FORMATS and below.is_file() and not mine:
                yield below, below.relative_to(path)
    else:
        raise NothingToDo(f"{path} doesn't exist")


def _keys(report: Path | None) -> dict[str, str]:
    """Return the keys of what a report lists as done, by output; damaged lines don't count."""
    keys: dict[str, str] = {}
    if report is None or not report.exists():
        return keys
    for line in report.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            entry = json.loads(line)
            output, status, key = entry["output"], entry["status"], entry["key"]
        except (ValueError, KeyError, TypeError):
            continue
        if status in ("done", "skipped") and isinstance(output, str) and isinstance(key, str):
            keys[output] = key
    return keys


def work(task: Task) -> Outcome:
    """Read, find, render and write one photo; whatever goes wrong ends up in the outcome."""
    start = time.perf_counter()
    try:
        key = _key(task)
        if key and key == task.done:
            return Outcome(task.source, task.output, "skipped", key=key)
        faces, said = _render(task)
    except Exception as error:  # one photo must not take the others with it
        return Outcome(task.source, task.output, "failed", _sentence(error))
    seconds = round(time.perf_counter() - start, 3)
    if not faces:
        return Outcome(task.source, task.output, "no face", "no face found", seconds=seconds)
    return Outcome(task.source, task.output, "done", said, _key(task), faces, seconds)


def _render(task: Task) -> tuple[int, str]:
    from kogao_core.face import select
    from kogao_core.photo import read, write
    from kogao_core.pipeline import render

    photo = read(Path(task.source), max_megapixels=task.max_megapixels)
    faces = _source(task.landmarks).find(photo.pixels)
    if not faces:
        return 0, ""
    chosen = select(faces, task.which)
    pixels = render(photo.pixels, chosen, Recipe.from_dict(task.recipe), threads=1).pixels
    output = Path(task.output)
    output.parent.mkdir(parents=True, exist_ok=True)
    return len(chosen), write(photo, pixels, output, force=True)


@cache
def _source(wanted: str | None) -> LandmarkSource:
    from kogao_core.landmarks import source

    return source(wanted)


def _key(task: Task) -> str:
    """Return the hash of source, choices and output; empty while one of the files is missing."""
    total = hashlib.sha256(
        json.dumps([task.recipe, task.which, task.landmarks], sort_keys=True).encode()
    )
    for path in (task.source, task.output):
        try:
            with Path(path).open("rb") as file:
                while chunk := file.read(_CHUNK_BYTES):
                    total.update(chunk)
        except FileNotFoundError:
            return ""
        total.update(b"\0next\0")
    return total.hexdigest()


def _sentence(error: Exception) -> str:
    said = " ".join(str(error).split())
    if isinstance(error, MemoryError):
        return "there isn't enough memory for this photo; try fewer --jobs"
    return said or type(error).__name__
