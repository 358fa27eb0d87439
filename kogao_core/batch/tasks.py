"""Process one photo of a batch, and write the report: one line of JSON per photo."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import KW_ONLY, asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, BinaryIO, Final, Literal

from kogao_core.background.find import BackgroundFinder
from kogao_core.base.atomic import appended
from kogao_core.base.geometry import Image
from kogao_core.base.index import locked, path_hash
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.batch.measures import COLUMNS, measured
from kogao_core.faces.doubt import AllDoubted
from kogao_core.faces.landmarks import networks_are_here, source
from kogao_core.field.protection import NOTHING
from kogao_core.photo import FORMATS, Photo, bits_of, read
from kogao_core.photo.jpeg.coefficients import read_first
from kogao_core.photo.picture import sha256_of
from kogao_core.photo.profiles import for_search
from kogao_core.projects import interchange
from kogao_core.projects.edits import Edits
from kogao_core.projects.project import load
from kogao_core.projects.results import Results, objects_in
from kogao_core.projects.sidecar import Applied, apply, is_resized
from kogao_core.retouch import Output, RetouchJob, draw, retouch, to_file

Status = Literal["done", "skipped", "result", "no face", "failed"]
_CHUNK_BYTES: Final = 1 << 20
# Networks are loaded once in each process.
_sources, _background = cache(source), cache(BackgroundFinder)
_START: Final = b'{"s'  # ource, the first field of a report's line


class _NoFace(Exception):
    """No face was found in the photo."""


@dataclass(frozen=True, slots=True)
class Task:
    """One photo of a batch, as plain values that can be pickled."""

    source: str  # path to read
    output: str  # path to write
    job: RetouchJob  # the same for all photos
    project: str = ""  # project file to apply instead of the recipe, or ""
    edits: str = ""  # the user's folder of edits, which knows earlier names of a picture
    done: str = ""  # `Outcome.key` of an earlier run, or ""
    results: str = ""  # data folder with Kogao's own results to skip; "" processes them again
    points: str = ""  # file of landmarks to use instead of face detection, or ""
    renamed: bool = False  # whether another photo took the name that the output would have
    by_hand: bool = True  # whether faces set by hand make the result, if the project says so


@dataclass(frozen=True, slots=True)
class Outcome:
    """Outcome of one photo: one line of the report."""

    source: str  # as in the task
    output: str  # as in the task
    status: Status  # "skipped": an earlier run made the output; "result": Kogao made the photo
    _: KW_ONLY
    reason: str = ""  # error message, or notes on the result
    key: str = ""  # hash of source, project, output and options
    faces: int = 0  # number of warped faces
    seconds: float = 0.0  # time from reading to writing
    achieved_percent: tuple[float, ...] = ()  # per face, % of D (`kogao_core.field.measures`)
    edit: str = ""  # hash of the applied project
    measures: tuple[dict[str, Any], ...] = ()  # per face (`kogao_core.batch.measures.COLUMNS`)
    doubtful: bool = False  # some faces or points should be checked

    def to_json(self) -> str:
        """Return the line of the report as ASCII: file names may be invalid Unicode."""
        return json.dumps(asdict(self))


def work(task: Task) -> Outcome:
    """Read, detect, render and write one photo. Errors are returned in the outcome."""
    start = time.perf_counter()
    try:
        if task.done and task.done == _key(task):
            if not Path(task.output).exists():
                raise _NoFace
            return Outcome(task.source, task.output, "skipped", key=task.done)
        if task.results and (origin := Results(Path(task.results)).origin(Path(task.source))):
            return Outcome(task.source, task.output, "result", reason=origin.why)
        photo = _read(task)
        rows, note, doubtful = _render(task, photo)
        key = _key(task)
        if not photo.is_as_read:  # the key is of another file than the result
            raise OSError(Text("the photo changed while it was in work; run the batch again"))
        seconds = round(time.perf_counter() - start, 3)
        edit = sha256_of(task.project) if task.project else ""
        achieved = tuple(round(row["achieved_percent"], 3) for row in rows)
        return Outcome(
            task.source,
            task.output,
            "done",
            reason=note,
            key=key,
            faces=len(rows),
            seconds=seconds,
            achieved_percent=achieved,
            edit=edit,
            measures=rows,
            doubtful=doubtful,
        )
    except _NoFace:
        # The next run need not search again; the AAM may find less than the networks.
        key = _key(task) if networks_are_here() else ""
        return Outcome(task.source, task.output, "no face", reason=Text("no face found"), key=key)
    except AllDoubted as doubts:
        return Outcome(task.source, task.output, "no face", reason=doubts.args[0], doubtful=True)
    except Exception as error:  # one bad photo must not stop the batch
        return Outcome(task.source, task.output, "failed", reason=_sentence(error))


def _read(task: Task) -> Photo:
    bits = bits_of(task.output)
    return read(Path(task.source), max_megapixels=task.job.max_megapixels, bits=bits)


def _render(task: Task, photo: Photo) -> tuple[tuple[dict[str, Any], ...], str, bool]:
    output, job = Path(task.output), task.job

    def written(photo: Photo, pixels: Image, coding: int | None) -> str:
        output.parent.mkdir(parents=True, exist_ok=True)
        return to_file(output, force=True)(photo, pixels, coding)

    done = _replayed(task, photo) if task.project else _found(task, photo)
    if photo.jpeg and job.export.coding is None and FORMATS.get(output.suffix.lower()) == "JPEG":
        read_first(photo.path)
    rendering = draw(photo, done, _background(), job.export, threads=1)
    made = retouch(photo, done, rendering, Output(written, job.disclosure, job.export))
    notes = [done.note, *made.notes, rendering.note, made.written]
    rows = measured(task.output, task.source, rendering, done.faces)
    # With a project, the note is about the photo; otherwise the note is about doubtful faces.
    return tuple(rows), Text.joined("; ", notes), bool(done.note) and not task.project


def _found(task: Task, photo: Photo) -> Applied:
    job = task.job
    if task.points:
        faces = interchange.faces_of(photo, Path(task.points))
    else:
        faces = _sources(job.landmarks).find(for_search(photo))
    if not faces:
        raise _NoFace
    chosen = job.chosen(photo, faces)
    return Applied(chosen.faces, job.recipe, NOTHING, chosen.note, others=chosen.others)


def _replayed(task: Task, photo: Photo) -> Applied:
    try:
        project = load(task.project)
        project = project if task.by_hand else replace(project, mode="automatic")
        known = Edits(Path(task.edits)).name_in(project, photo)
        if known != project.original.sha256 and not is_resized(project, photo):
            raise BadFile(Text("it was made from another picture; open it to take over settings"))
        return apply(project, photo.pixels, known)
    except BadFile as error:
        raise BadFile(
            Text("its project {project} can't be used: {error}", project=task.project, error=error)
        ) from error


def _key(task: Task) -> str:
    """Return a hash of files, output included if there, and options; "" if one can't be read."""
    job = task.job
    choices = job.recipe.to_dict(), job.which, job.doubtful, job.landmarks, bool(task.project)
    told = asdict(job.disclosure), asdict(job.export)
    del told[1]["first"]  # as in reports of 1.0.0, as is the next line
    more = [*[""] * bool(task.points), *["automatic"] * (not task.by_hand), *job.people]
    chosen = json.dumps([*choices, *told, *more], sort_keys=True)
    total = hashlib.sha256(chosen.encode())
    made = task.output if Path(task.output).exists() else ""
    files = task.source, task.project, task.points, made
    for path in map(Path, filter(None, files)):
        if not path.is_file():  # reading a pipe would block
            return ""
        try:
            with path.open("rb") as file:
                while chunk := file.read(_CHUNK_BYTES):
                    total.update(chunk)
        except OSError:  # `work` reports the error
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
            "internal error ({kind}: {text}); please report it",
            kind=type(error).__name__,
            text=text,
        )
    return text or type(error).__name__


def record(
    outcomes: Iterable[Outcome], report: Path, results: Results, then: Callable[[Outcome], object]
) -> None:
    """Append each outcome to a new or existing report, and each result to the list of results."""
    if report.is_file():
        with report.open("rb") as file:
            if not _START.startswith(file.read(len(_START))):
                raise FileExistsError(errno.EEXIST, Text("it is no report of a batch"), str(report))
    name = path_hash(report)[:32]
    with ExitStack() as opened:
        try:
            opened.enter_context(locked(results.folder / "locks", name))
        except BlockingIOError:
            busy = Text("another export into this folder is running")
            raise FileExistsError(errno.EAGAIN, busy, str(report)) from None
        except OSError:
            pass  # a user's folder that is read-only holds no lock
        lines, made = opened.enter_context(appended(report)), list[str]()
        for outcome in outcomes:
            lines.write(outcome.to_json().encode() + b"\n")
            lines.flush()
            _check_there(report, lines)
            if outcome.status == "done":
                made.append(outcome.output)
                results.add(Path(outcome.source), Path(outcome.output), outcome.edit)
            then(outcome)
        for output in made:
            Path(output).stat()


def _check_there(report: Path, lines: BinaryIO) -> None:
    """Raise FileNotFoundError if the report or its folder was removed or replaced."""
    if not os.path.samestat(os.fstat(lines.fileno()), report.stat()):
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(report))


def keys_of(report: Path | None) -> dict[str, str]:
    """Return the key of each output of a report, also of those without a face."""
    told = ("done", "skipped", "no face")
    done = (entry for entry in _entries(report) if entry["status"] in told)
    return {entry["output"]: entry["key"] for entry in done}


def outputs_of(report: Path | None) -> dict[str, str]:
    """Return the newest output of each source of a report."""
    return {entry["source"]: entry["output"] for entry in _entries(report)}


def measures_of(report: Path, tasks: Sequence[Task]) -> list[Mapping[str, Any]]:
    """Return the measures of each face of the tasks, from a report, in order."""
    # A skipped photo has its measures in the line of an earlier run.
    latest = {one["output"]: one for one in _entries(report) if one["status"] != "skipped"}
    of_each = (latest.get(task.output, {}).get("measures") for task in tasks)
    rows = (row for rows in of_each if isinstance(rows, list) for row in rows)
    return [row for row in rows if isinstance(row, dict) and COLUMNS.keys() <= row.keys()]


def _entries(report: Path | None) -> Iterator[dict[str, Any]]:
    """Yield the entries of a report; skip damaged lines."""
    if report is None or not report.is_file():
        return
    for entry in objects_in(report):
        if all(isinstance(entry.get(name), str) for name in ("output", "status", "key")):
            yield entry
