"""Plan a batch: collect the photos and choose an output path inside one folder for each."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from kogao_core.base.atomic import is_temporary
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.batch.tasks import Task, keys_of
from kogao_core.photo.formats import READABLE
from kogao_core.projects.interchange import file_for
from kogao_core.projects.project import load
from kogao_core.projects.results import Results
from kogao_core.projects.sidecar import kept, sheet_of
from kogao_core.recipe.recipe import Recipe
from kogao_core.retouch import RetouchJob


class NothingToDo(ValueError):
    """The inputs can't be processed; the message says why."""


def plan(
    inputs: Sequence[Path],
    folder: Path,
    job: RetouchJob,
    *,
    projects: bool = False,
    suffix: str = ".jpg",
    report: Path | None = None,
    edits: Path | None = None,
    results: Results | None = None,
    points: Path | None = None,
) -> list[Task]:
    """Return the tasks for files and folders, in order. Subfolders are kept in the output.

    `points`: file of landmarks, or folder with one file per photo name. `edits`: the user's folder
    of projects that are not stored next to their photos. `results`: list of photos that Kogao made
    and that are skipped. Raises NothingToDo, BadFile.
    """
    found: dict[Path, Path] = {}
    for path in inputs:
        for photo, place in _photos(path, folder):
            percent = _percent(photo, job.recipe, projects, edits)
            output = folder / job.export.place(place, len(found) + 1, percent, suffix)
            if found.setdefault(output, photo) != photo:
                raise NothingToDo(
                    Text(
                        "{found} and {photo} would both become {output}; work on "
                        "their folders one by one",
                        found=found[output],
                        photo=photo,
                        output=output,
                    )
                )
    if not found:
        raise NothingToDo(Text("no photos there; name files or folders that hold some"))
    _check_places(found, folder)
    keys = keys_of(report)
    return [
        Task(
            str(photo),
            str(output),
            job,
            project=str(kept(photo, edits) or "") if projects else "",
            done=keys.get(str(output), ""),
            results=str(results.folder) if results else "",
            points="" if points is None else str(file_for(photo, points)),
        )
        for output, photo in found.items()
    ]


def check_free(tasks: Sequence[Task]) -> None:
    """Check that no output exists, before a first run into a folder. Raises NothingToDo."""
    taken = [task.output for task in tasks if Path(task.output).exists()]
    if taken:
        count = Text.counted(len(taken), "a file exists", "{n} files exist")
        raise NothingToDo(
            Text(
                "{count} where results would go, such as {taken}; choose another folder",
                count=count,
                taken=taken[0],
            )
        )


def _check_places(found: Mapping[Path, Path], folder: Path) -> None:
    """Refuse outputs that would overwrite a source photo or follow a link out of the folder."""
    home = _real(folder)
    sources = {_real(photo) for photo in found.values()}
    for output in found:
        place = _real(output)
        if place in sources:
            raise NothingToDo(
                Text(
                    "{output} is a photo to work on and would be written over; "
                    "choose another folder",
                    output=output,
                )
            )
        if not place.is_relative_to(home):
            raise NothingToDo(
                Text(
                    "a link leads {output} out of {folder}; remove the link",
                    output=output,
                    folder=folder,
                )
            )


def _real(path: Path) -> Path:
    return Path(os.path.realpath(path))  # unlike `resolve`, accepts circular links


def _percent(photo: Path, recipe: Recipe, projects: bool, edits: Path | None) -> float:
    """Return the Amount for the file name: from the photo's project, or from the recipe."""
    project = kept(photo, edits) if projects else None
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
            named = below.suffix.lower() in READABLE and not is_temporary(below)
            if named and not below.is_dir() and not mine:
                yield below, below.relative_to(path)
    elif os.path.lexists(path):
        yield path, Path(path.name)
    else:
        raise NothingToDo(Text("{path} doesn't exist; check the name and the folder", path=path))
