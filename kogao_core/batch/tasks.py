"""One photo of a batch, what became of it, and the report: a line of JSON for each, once done."""

from __future__ import annotations

import errno
import hashlib
import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Final, Literal

from kogao_core.background.find import BackgroundFinder
from kogao_core.base.atomic import appended
from kogao_core.base.geometry import Box, Image
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.batch.measures import COLUMNS, measured
from kogao_core.faces.doubt import AllDoubted, choose
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import CHOICES, source
from kogao_core.photo import Photo, bits_of, read
from kogao_core.photo.disclosure.disclosing import NO_DISCLOSURE, Disclosure
from kogao_core.photo.export import AS_IT_IS, Export
from kogao_core.photo.writing import Sign
from kogao_core.pipeline import Rendering
from kogao_core.projects import interchange
from kogao_core.projects.project import load, sha256_of
from kogao_core.projects.results import Results, objects_in
from kogao_core.projects.sidecar import Applied, apply
from kogao_core.recipe.recipe import Recipe
from kogao_core.retouch import retouch, to_file
from kogao_core.warp.protection import NOTHING

Status = Literal["done", "skipped", "result", "no face", "failed"]
_CHUNK_BYTES: Final = 1 << 20
# Networks are loaded once in each process.
_sources, _background = cache(source), cache(BackgroundFinder)
_START: Final = b'{"s'  # ource, the first field of a report's line


class _NoFace(Exception):
    """There is no face in the photo."""


@dataclass(frozen=True, slots=True)
class Task:
    """One photo of a batch, as plain values that travel to other processes and machines."""

    # Where to read and where to write.
    source: str
    output: str
    recipe: Mapping[str, Any]  # `Recipe.to_dict`
    which: str = "all"  # faces to work on: all, largest, or numbers
    max_megapixels: float = 300.0  # refuse larger photos
    landmarks: str | None = None  # where they come from, see `landmarks.source`
    project: str = ""  # a project file to do instead, or ""
    disclosure: Disclosure = NO_DISCLOSURE  # what results disclose of their retouching
    # What an earlier run wrote for the same source and choices (`Outcome.key`), or "".
    done: str = ""
    doubtful: bool = False  # whether doubtful faces are worked on, too
    # The list by which results are known that aren't worked on again, or "" to do so.
    results: str = ""
    export: Export = AS_IT_IS  # size, quality, colours and the like of results
    points: str = ""  # a file of landmarks to take instead of looking for faces, or ""
    points_map: str | None = None  # which of its points are which, see `interchange.template`

    def rooted(self) -> Task:
        """Return a task that names the same files in whatever folder a worker was started."""
        told, model = self.disclosure, self.landmarks
        is_file = model is not None and model not in {choice.name for choice in CHOICES}
        if told.picture is not None:
            told = replace(told, picture=replace(told.picture, file=_rooted(told.picture.file)))
        if told.signer is not None:
            files = _rooted(told.signer.certificate), _rooted(told.signer.key)
            told = replace(told, signer=replace(told.signer, certificate=files[0], key=files[1]))
        return replace(
            self,
            source=_rooted(self.source),
            output=_rooted(self.output),
            project=_rooted(self.project),
            points=_rooted(self.points),
            results=_rooted(self.results),
            landmarks=_rooted(model) if model and is_file else model,
            disclosure=replace(told, font=_rooted(told.font) if told.font else None),
        )


def _rooted(path: str) -> str:
    return str(Path.cwd() / path) if path else path


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one photo: a line of the report."""

    # As in the task.
    source: str
    output: str
    status: Status  # skipped photos were done by an earlier run; results by this program before
    # A sentence where something went wrong; else what is worth knowing of the result.
    reason: str = ""
    key: str = ""  # hash of the bytes of source, project and output, and of the choices
    faces: int = 0  # how many were worked on
    seconds: float = 0.0  # time from reading to written
    # How far each face came towards its centre, % of D (`kogao_core.warp.measures`).
    achieved_percent: tuple[float, ...] = ()
    edit: str = ""  # hash of the project that was done
    # What each face measures (`kogao_core.batch.measures.COLUMNS`).
    measures: tuple[dict[str, Any], ...] = ()
    doubtful: bool = False  # whether faces or points of it had better be looked at

    def to_json(self) -> str:
        """Return the line of the report."""
        return json.dumps(asdict(self))  # in ASCII: names of files may be no text at all


def work(task: Task) -> Outcome:
    """Read, find, render and write one photo; whatever goes wrong ends up in the outcome."""
    start = time.perf_counter()
    try:
        if task.done and task.done == _key(task):
            return Outcome(task.source, task.output, "skipped", key=task.done)
        if task.results and (origin := Results(Path(task.results)).origin(Path(task.source))):
            return Outcome(task.source, task.output, "result", origin.why)
        rows, note, doubtful = _render(task)
        seconds = round(time.perf_counter() - start, 3)
        edit = sha256_of(task.project) if task.project else ""
        achieved = tuple(round(row["achieved_percent"], 3) for row in rows)
        return Outcome(
            task.source, task.output, "done", note, _key(task), len(rows), seconds, achieved, edit,
            rows, doubtful,
        )  # fmt: skip
    except _NoFace:
        return Outcome(task.source, task.output, "no face", Text("no face found"))
    except AllDoubted as doubts:
        return Outcome(task.source, task.output, "no face", doubts.args[0], doubtful=True)
    except Exception as error:  # one photo must not take the others with it
        return Outcome(task.source, task.output, "failed", _sentence(error))


def _render(task: Task) -> tuple[tuple[dict[str, Any], ...], str, bool]:
    output, seen = Path(task.output), list[Rendering]()

    def written(photo: Photo, pixels: Image, sign: Sign | None) -> str:
        output.parent.mkdir(parents=True, exist_ok=True)
        return to_file(output, force=True, export=task.export)(photo, pixels, sign)

    photo = read(Path(task.source), max_megapixels=task.max_megapixels, bits=bits_of(output))
    done = _replayed(task, photo) if task.project else _found(task, photo)
    made = retouch(
        photo, done, task.disclosure, written, _background(),
        look=seen.append, threads=1, export=task.export,
    )  # fmt: skip
    (rendering,) = seen
    notes = [done.note, made.lens, rendering.note, made.written, made.undisclosed]
    rows = measured(task.output, task.source, rendering, done.faces)
    # Of a project, a note is about the photo; of a search, about doubts.
    return tuple(rows), Text.joined("; ", notes), bool(done.note) and not task.project


def _found(task: Task, photo: Photo) -> Applied:
    faces = _given(task, photo) if task.points else _sources(task.landmarks).find(photo.pixels)
    if not faces:
        raise _NoFace
    chosen = choose(faces, task.which, Box.of(photo.pixels), doubtful=task.doubtful)
    recipe = Recipe.from_dict(task.recipe)
    return Applied(chosen.faces, recipe, NOTHING, chosen.note, others=chosen.others)


def _given(task: Task, photo: Photo) -> list[Face]:
    mapping = None if task.points_map is None else interchange.template(task.points_map)
    faces = interchange.read(Path(task.points), mapping)
    interchange.check_inside(faces, Box.of(photo.pixels))
    return faces


def _replayed(task: Task, photo: Photo) -> Applied:
    try:
        return apply(load(task.project), photo.pixels, sha256_of(task.source))
    except BadFile as error:
        raise BadFile(
            Text("its project {project} can't be used: {error}", project=task.project, error=error)
        ) from error


def _key(task: Task) -> str:
    """Return the hash of files and choices; empty while one of the files can't be read."""
    choices = task.recipe, task.which, task.doubtful, task.landmarks, bool(task.project)
    told = asdict(task.disclosure), asdict(task.export)
    points = [task.points_map or ""] * bool(task.points)
    chosen = json.dumps([*choices, *told, *points], sort_keys=True)
    total = hashlib.sha256(chosen.encode())
    label = task.disclosure.picture
    files = task.source, task.project, task.points, task.output, label.file if label else ""
    for path in map(Path, filter(None, files)):
        if not path.is_file():  # a pipe would be waited for
            return ""
        try:
            with path.open("rb") as file:
                while chunk := file.read(_CHUNK_BYTES):
                    total.update(chunk)
        except OSError:  # whoever reads it finds a sentence
            return ""
        total.update(b"\0next\0")
    return total.hexdigest()


def _sentence(error: Exception) -> str:
    said = str(error)
    if isinstance(said, Text):
        return said
    text = " ".join(said.split())
    if isinstance(error, MemoryError):
        return Text("there isn't enough memory for this photo; work on fewer at a time")
    built_in = type(error).__module__ == "builtins"
    if built_in and not isinstance(error, OSError | ValueError | RuntimeError):
        return Text(
            "an error in the program itself ({kind}: {text}); please report it",
            kind=type(error).__name__,
            text=text,
        )
    return text or type(error).__name__


def record(
    outcomes: Iterable[Outcome],
    report: Path,
    results: Results,
    then: Callable[[Outcome], object],
) -> None:
    """Add every outcome to a report, which is made or gone on with, and results to their list."""
    if report.is_file():
        with report.open("rb") as file:
            if not _START.startswith(file.read(len(_START))):
                raise FileExistsError(errno.EEXIST, Text("it is no report of a batch"), str(report))
    with appended(report) as lines:
        for outcome in outcomes:
            lines.write(outcome.to_json().encode() + b"\n")
            lines.flush()
            if outcome.status == "done":
                results.add(Path(outcome.source), Path(outcome.output), outcome.edit)
            then(outcome)


def keys_of(report: Path | None) -> dict[str, str]:
    """Return the keys of what a report lists as done, by output."""
    done = (entry for entry in _entries(report) if entry["status"] in ("done", "skipped"))
    return {entry["output"]: entry["key"] for entry in done}


def measures_of(report: Path, tasks: Sequence[Task]) -> list[Mapping[str, Any]]:
    """Return what a report says of each face of the tasks' results, in their order."""
    # Of what was done before and skipped now, the line before tells.
    latest = {one["output"]: one for one in _entries(report) if one["status"] != "skipped"}
    of_each = (latest.get(task.output, {}).get("measures") for task in tasks)
    rows = (row for rows in of_each if isinstance(rows, list) for row in rows)
    return [row for row in rows if isinstance(row, dict) and COLUMNS.keys() <= row.keys()]


def _entries(report: Path | None) -> Iterator[dict[str, Any]]:
    """Yield the lines of a report; damaged ones don't count."""
    if report is None or not report.is_file():
        return
    for entry in objects_in(report):
        if all(isinstance(entry.get(name), str) for name in ("output", "status", "key")):
            yield entry
