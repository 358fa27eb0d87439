"""Plan a batch: collect the photos and choose an output path inside one folder for each."""

from __future__ import annotations

import itertools
import os
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from kogao_core.base.atomic import is_temporary
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import BadValue, Text
from kogao_core.batch.tasks import Task, keys_of, outputs_of
from kogao_core.photo.formats import READABLE, suffix_of
from kogao_core.projects.edits import Edits
from kogao_core.projects.interchange import file_for
from kogao_core.projects.project import load
from kogao_core.projects.results import Results
from kogao_core.projects.sidecar import has_partial, sheet_of
from kogao_core.recipe.recipe import Recipe
from kogao_core.retouch import RetouchJob


class NothingToDo(BadValue):
    """The inputs can't be processed; the message says why."""


def plan(
    inputs: Sequence[Path],
    folder: Path,
    job: RetouchJob,
    *,
    suffix: str = ".jpg",
    report: Path | None = None,
    edits: Edits | None = None,
    results: Results | None = None,
    points: Path | None = None,
) -> list[Task]:
    """Return the tasks for files and folders, in order. Subfolders are kept in the output.

    `points`: file of landmarks, or folder with one file per photo name. `edits`: the
    saved edits to apply, if any. `results`: the photos that Kogao made and that are skipped. Two
    names that are one on a drive without case get a second name. Raises NothingToDo, BadFile.
    """
    wanted = list[tuple[Path, Path, Path, Path | None]]()
    photos = [one for path in inputs for one in _photos(path, folder)]
    numbers = job.export.numbers([photo for photo, _ in photos], outputs_of(report))
    for (photo, place), number in zip(photos, numbers, strict=True):
        project = edits.newest(photo) if edits else None
        percent = _percent(project, job.recipe)
        output = folder / job.export.place(place, number, percent, suffix)
        wanted.append((photo, place, output, project))
    found = _named(wanted)
    if not found:
        raise NothingToDo("no photos there; name files or folders that hold some")
    _check_places(found, folder)
    keys = keys_of(report)
    return [
        Task(
            str(photo),
            str(output),
            job,
            project=str(project or ""),
            edits=str(edits.folder) if edits else "",
            done=keys.get(str(output), ""),
            results=str(results.folder) if results else "",
            points="" if points is None else str(file_for(photo, points)),
            renamed=output != plain,
        )
        for (photo, _, plain, project), output in zip(wanted, found, strict=True)
    ]


def _named(wanted: Sequence[tuple[Path, Path, Path, Path | None]]) -> dict[Path, Path]:
    """Return the photo of each output; outputs that would be one file get different names.

    A photo with the output's name keeps it; IMG_1.heic beside IMG_1.jpg becomes IMG_1.heic.jpg.
    Raises NothingToDo for photos of different folders.
    """
    keeps = {_folded(output): photo for photo, place, output, _ in reversed(wanted)
             if place.name == output.name}  # fmt: skip
    found, taken = dict[Path, Path](), dict[str, Path]()
    for photo, place, output, _ in wanted:
        other = taken.get(_folded(output), photo)
        if output in found and _folded(other.with_suffix("")) != _folded(photo.with_suffix("")):
            raise NothingToDo(
                "{found} and {photo} would both become {output}; work on their folders one by one",
                found=other,
                photo=photo,
                output=output,
            )
        numbers = (output.with_stem(f"{output.stem}-{n}") for n in itertools.count(2))
        names = itertools.chain(
            (output, output.with_name(place.name.rstrip() + output.suffix)), numbers
        )
        name = next(
            one for one in names
            if _folded(one) not in taken and keeps.get(_folded(one), photo) == photo
        )  # fmt: skip
        found[name] = taken[_folded(name)] = photo
    return found


def _folded(path: Path) -> str:
    """Return a path as drives without case compare it."""
    return unicodedata.normalize("NFC", str(path)).casefold()


def outdated(tasks: Sequence[Task]) -> int:
    """Return the number of edits of an older version that may look different now."""
    count = 0
    for task in tasks:
        with suppress(BadFile):  # the task reports the error later
            count += bool(task.project) and load(task.project).looks_different
    return count


def partial(tasks: Sequence[Task]) -> list[Task]:
    """Return the tasks whose edits have a face that is marked only in part."""
    found = []
    for task in tasks:
        with suppress(BadFile):  # the task reports the error later
            if task.project and has_partial(load(task.project)):
                found.append(task)
    return found


def check_free(tasks: Sequence[Task]) -> None:
    """Check that no output exists, before a first run into a folder. Raises NothingToDo."""
    taken = [task.output for task in tasks if Path(task.output).exists()]
    if taken:
        count = Text.counted(len(taken), "a file exists", "{n} files exist")
        raise NothingToDo(
            "{count} where results would go, such as {taken}; choose another folder",
            count=count,
            taken=taken[0],
        )


def _check_places(found: Mapping[Path, Path], folder: Path) -> None:
    """Refuse outputs that would overwrite a source photo or follow a link out of the folder."""
    home = _real(folder)
    sources = {_real(photo) for photo in found.values()}
    for output in found:
        place = _real(output)
        if place in sources:
            raise NothingToDo(
                "{output} is a photo to work on and would be written over; choose another folder",
                output=output,
            )
        if not place.is_relative_to(home):
            raise NothingToDo(
                "a link leads {output} out of {folder}; remove the link",
                output=output,
                folder=folder,
            )


def _real(path: Path) -> Path:
    return Path(os.path.realpath(path))  # unlike `resolve`, accepts circular links


def _percent(project: Path | None, recipe: Recipe) -> float:
    """Return the Amount for the file name: from the photo's project, or from the recipe."""
    try:
        return sheet_of(load(project)).recipe.percent if project else recipe.percent
    except BadFile:  # the task reports the error later
        return recipe.percent


def _photos(path: Path, folder: Path) -> Iterator[tuple[Path, Path]]:
    """Yield each photo and its path relative to the output folder.

    Pipes and broken links with a photo's extension are included: their tasks report the error.
    """
    if path.is_dir():
        for below in sorted(path.rglob("*")):
            mine = below.is_relative_to(folder) and not path.is_relative_to(folder)
            named = suffix_of(below) in READABLE and not is_temporary(below)
            if named and not below.is_dir() and not mine:
                yield below, below.relative_to(path)
    elif os.path.lexists(path):
        yield path, Path(path.name)
    else:
        raise NothingToDo("{path} doesn't exist; check the name and the folder", path=path)
