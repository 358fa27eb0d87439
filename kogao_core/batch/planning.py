"""Which photos a batch works on and where their results go: in one folder and nowhere else."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from kogao_core.base.atomic import is_aside
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.batch.tasks import Task, keys_of
from kogao_core.photo.disclosure.disclosing import NO_DISCLOSURE, Disclosure
from kogao_core.photo.export import AS_IT_IS, Export
from kogao_core.photo.formats import READABLE
from kogao_core.projects.interchange import file_for
from kogao_core.projects.project import load
from kogao_core.projects.results import Results
from kogao_core.projects.sidecar import kept, sheet_of
from kogao_core.recipe.recipe import Recipe


class NothingToDo(ValueError):
    """The inputs can't be worked on; the message says why."""


def plan(
    inputs: Sequence[Path],
    folder: Path,
    recipe: Recipe,
    *,
    which: str = "all",
    max_megapixels: float = 300.0,
    landmarks: str | None = None,
    projects: bool = False,
    suffix: str = ".jpg",
    disclosure: Disclosure = NO_DISCLOSURE,
    report: Path | None = None,
    doubtful: bool = False,
    edits: Path | None = None,
    results: Results | None = None,
    export: Export = AS_IT_IS,
    points: Path | None = None,
    points_map: str | None = None,
) -> list[Task]:
    """Return the tasks for files and folders; a folder's photos keep their place in it.

    `points` is a file of landmarks, or a folder of them by the photos' names, `edits` the user's
    own folder of projects that don't lie beside their photos; what `results` lists isn't worked on
    again. Result: in the order of the inputs; `run` does them. Raises NothingToDo, BadFile.
    """
    found: dict[Path, Path] = {}
    for path in inputs:
        for photo, place in _photos(path, folder):
            percent = _percent(photo, recipe, projects, edits)
            output = folder / export.place(place, len(found) + 1, percent, suffix)
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
    choices = recipe.to_dict(), which, max_megapixels, landmarks
    return [
        Task(
            str(photo),
            str(output),
            *choices,
            project=str(kept(photo, edits) or "") if projects else "",
            disclosure=disclosure,
            done=keys.get(str(output), ""),
            doubtful=doubtful,
            results=str(results.file) if results else "",
            export=export,
            points="" if points is None else str(file_for(photo, points)),
            points_map=points_map,
        )
        for output, photo in found.items()
    ]


def check_free(tasks: Sequence[Task]) -> None:
    """Check that none of the outputs exists, before a first run into a folder.

    Raises NothingToDo.
    """
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
    """Refuse outputs that are photos of the batch, or that links lead out of the folder."""
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
    return Path(os.path.realpath(path))  # unlike `resolve`, at ease with links in a circle


def _percent(photo: Path, recipe: Recipe, projects: bool, edits: Path | None) -> float:
    """Return the amount that a name tells: that of a photo's project, if that is done."""
    project = kept(photo, edits) if projects else None
    try:
        return sheet_of(load(project)).recipe.percent if project else recipe.percent
    except BadFile:  # it fails by name once it is to be done
        return recipe.percent


def _photos(path: Path, folder: Path) -> Iterator[tuple[Path, Path]]:
    """Yield photos and their places below the output folder.

    Pipes and links to nothing whose names are those of photos are among them: they fail by name.
    """
    if path.is_dir():
        for below in sorted(path.rglob("*")):
            mine = below.is_relative_to(folder) and not path.is_relative_to(folder)
            named = below.suffix.lower() in READABLE and not is_aside(below)
            if named and not below.is_dir() and not mine:
                yield below, below.relative_to(path)
    elif os.path.lexists(path):
        yield path, Path(path.name)
    else:
        raise NothingToDo(Text("{path} doesn't exist", path=path))
