"""``kogao-cli warp``: read, find, render, write; everything is checked before work begins."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import isfinite
from pathlib import Path
from typing import Any, Final

import click

from kogao_core.background.find import BackgroundFinder, Bends, measure
from kogao_core.base.geometry import Box
from kogao_core.base.language import Text
from kogao_core.base.originals import Originals
from kogao_core.base.strict import BadFile
from kogao_core.base.wording import shown
from kogao_core.cli import common, ending, options, reading, summary, words
from kogao_core.faces.face import Face
from kogao_core.photo import (
    CannotWrite,
    Photo,
    RefusedOutput,
    check_holds,
    check_in_place,
    check_output,
)
from kogao_core.photo.disclosure.disclosing import Disclosure
from kogao_core.photo.export import Export
from kogao_core.pipeline import Rendering
from kogao_core.projects import project, sidecar
from kogao_core.projects.results import Results
from kogao_core.projects.sidecar import Applied, apply, sidecar_of
from kogao_core.recipe.recipe import SETTINGS
from kogao_core.retouch import over_itself, retouch, to_file
from kogao_core.warp.limits import OutOfBounds, check_protection
from kogao_core.warp.protection import NOTHING, Protection

# What a project says itself.
_FROM_PROJECT: Final = (
    *SETTINGS,
    *("which", "doubtful", "recipe_file", "landmarks"),
    *("lines", "width_px", "feather_px", "points", "points_map"),
)


def _lines(_: click.Context, __: click.Parameter, values: Sequence[str]) -> list[Any]:
    lines = [_corners(value) for value in values]
    for value, line in zip(values, lines, strict=True):
        if not line or any(len(corner) != 2 or not all(map(isfinite, corner)) for corner in line):
            raise words.bad_value(
                Text("{value} is not a list such as '10,20 10,400'.", value=shown(value))
            )
    return lines


def _corners(value: str) -> list[list[float]]:
    try:
        return [[float(part) for part in corner.split(",")] for corner in value.split()]
    except ValueError:
        return []


@words.command("warp")
@reading.takes_photo
@words.option(
    "-o", "--output", type=click.Path(path_type=Path), metavar="FILE",
    help=reading.OUTPUT_HELP,
)  # fmt: skip
@words.option(
    "--in-place", is_flag=True,
    help="Write over IN itself, as a file of the same kind; kogao-cli restore brings it back.",
)  # fmt: skip
@words.option(
    "--temporary", is_flag=True, needs="--in-place",
    help="With --in-place: IN is a copy that another program made for this; keep no original.",
)  # fmt: skip
@options.chooses
@reading.takes_point_files
@words.option(
    "--protect", "lines", multiple=True, metavar="'X,Y X,Y'", callback=_lines,
    help="A line, or more corners, that must not move, px of the upright photo; repeatable.",
)  # fmt: skip
@words.option(
    "--protect-width", "width_px", type=common.Number(0.0), default=0.0, metavar="PX",
    needs="--protect", help="Width of the protected lines [0: the line alone].",
)  # fmt: skip
@words.option(
    "--protect-feather", "feather_px", type=common.Number(0.0), default=0.0, metavar="PX",
    needs="--protect",
    help="Keep the lines' very bytes and let the move fade in over PX beside them [0: don't].",
)  # fmt: skip
@words.option(
    "--project", "project_file", type=click.Path(path_type=Path), metavar="FILE",
    help="Do what a project says (PHOTO.kogao.json, also of another size of the photo).",
)  # fmt: skip
@words.option(
    "--save-project", is_flag=True,
    help="Keep what was done as IN.kogao.json beside the photo, for the editor and for batches.",
)  # fmt: skip
@options.discloses
@options.exports
@common.writes_json
@reading.takes_results
@words.option("--force", is_flag=True, help="Replace an existing output, even IN itself.")
def command(
    source: Path | None,
    sample: bool,
    max_megapixels: float,
    landmarks: str | None,
    output: Path | None,
    in_place: bool,
    temporary: bool,
    which: str,
    doubtful: bool,
    recipe_file: Path | None,
    lines: list[Any],
    width_px: float,
    feather_px: float,
    project_file: Path | None,
    save_project: bool,
    disclosure: Disclosure,
    export: Export,
    json_file: Path | None,
    results: bool,
    force: bool,
    **choices: Any,
) -> None:
    """Make the faces in the photo IN smaller and write the result to OUTPUT, or over IN itself."""
    if project_file is not None:
        _refuse_choices(click.get_current_context())
    recipe = options.recipe_of(recipe_file, choices)
    path = reading.input_path(source, sample)
    is_searched = project_file is None and reading.point_files()[0] is None
    known = reading.landmark_source(landmarks) if is_searched else None
    to = _checked_output(path, sample, output, in_place, save_project, force, export)
    common.check_report(json_file, force)
    if not (results or in_place or sample):
        reading.refuse_result(path)
    if save_project:
        _check_project(path, sample, force)
    photo = reading.read_photo(path, max_megapixels, to)
    _check_photo(photo, to, in_place, export)
    sha256 = reading.hash_of(path) if project_file is not None or save_project else ""
    found: list[Face] = []
    if project_file is not None:
        with _usable(project_file):
            done = apply(project.load(project_file), photo.pixels, sha256)
    else:
        protection = _protection(photo, lines, width_px, feather_px)
        found = reading.find_faces(photo, landmarks, known)
        chosen = reading.chosen(photo, found, which, doubtful)
        done = Applied(chosen.faces, recipe, protection, chosen.note, others=chosen.others)
    finder = BackgroundFinder()
    bends, note = Bends(()), ""

    def look(rendering: Rendering) -> None:
        nonlocal bends, note
        bends, note = _measured(photo, rendering, done, finder), rendering.note

    originals = None if temporary else Originals.of_user()
    write = over_itself(originals) if in_place else to_file(to, force=force, export=export)
    with _writing():
        made = retouch(photo, done, disclosure, write, finder, look=look, export=export)
    if not in_place:
        Results.of_user().add(path, to)
    written = Text.joined("; ", [made.written, made.undisclosed])
    notes = list(filter(None, [done.note, made.lens, note, written, bends.note]))
    if save_project:
        place = _save_project(photo, sha256, found, done, project_file)
        notes.append(Text("the project is {place}", place=place))
    assert made.rendering is not None
    told = photo, to, done.faces, made.rendering, bends, notes
    common.tell(lambda: summary.as_json(*told), lambda: summary.as_text(*told), json_file)


def _checked_output(
    path: Path,
    sample: bool,
    output: Path | None,
    in_place: bool,
    save_project: bool,
    force: bool,
    export: Export,
) -> Path:
    """Return where the result goes, or stop where it may not go there."""
    if in_place:
        _check_in_place(sample, output, save_project)
        if export.coding is not None:
            raise ending.Stop(
                Text("size, quality and colours are those of copies; leave out --in-place")
            )
        return path
    if output is None:
        raise ending.Stop(Text("name an output with -o, or use --in-place"))
    _check_output(path, output, force)
    return output


def _check_output(path: Path, output: Path, force: bool) -> None:
    if output.exists() and path.exists() and output.samefile(path) and not force:
        raise ending.Stop(
            Text(
                "{output} is the photo itself; choose another output, or --force to replace it",
                output=output,
            )
        )
    with _writing():
        check_output(output, force=True)
    common.check_free(output, force)


def _check_in_place(sample: bool, output: Path | None, save_project: bool) -> None:
    if sample:
        raise ending.Stop(Text("the sample isn't written over; copy it to a folder first"))
    if output is not None:
        raise ending.Stop(Text("--in-place writes over IN; leave out -o"))
    if save_project:
        raise ending.Stop(
            Text(
                "a project is about the photo as it was, which --in-place replaces; "
                "leave out --save-project"
            )
        )


def _check_photo(photo: Photo, output: Path, in_place: bool, export: Export) -> None:
    with _writing():
        if in_place:
            check_in_place(photo)
        elif export.coding is None:  # else its depth follows the format
            check_holds(output, photo.pixels)


def _measured(photo: Photo, rendering: Rendering, done: Applied, finder: BackgroundFinder) -> Bends:
    """Measure what the summary tells, while nothing is written yet."""
    _ = rendering.pixel_counts, rendering.residual, rendering.one_to_one, rendering.achieved
    try:
        return measure(photo.pixels, rendering, done, finder)
    except Exception as error:  # pixels may be any numbers; a photo isn't refused for a figure
        why = f"{type(error).__name__}: {error}"
        return Bends((), Text("the straight lines couldn't be measured ({why})", why=why))


def _protection(photo: Photo, lines: list[Any], width_px: float, feather_px: float) -> Protection:
    protection = NOTHING
    for line in lines:
        protection = protection.with_stroke(line, width_px / 2.0, feather_px)
    with ending.stopping(OutOfBounds, ending.USAGE):
        check_protection(protection, Box.of(photo.pixels))
    return protection


@contextmanager
def _writing() -> Iterator[None]:
    """Stop where a photo can't be written, by what is in the way."""
    with (
        ending.stopping(CannotWrite, ending.UNREADABLE),
        ending.stopping(RefusedOutput, ending.USAGE),
    ):
        yield


def _refuse_choices(context: click.Context) -> None:
    """Stop when choices are given beside a project, which holds all of them."""
    for parameter in context.command.params:
        if parameter.name in _FROM_PROJECT and words.is_given(parameter, context):
            raise ending.Stop(
                Text("--project holds every choice; leave out {option}", option=parameter.opts[0])
            )


def _check_project(photo: Path, sample: bool, force: bool) -> None:
    """Stop when no project may be written beside a photo."""
    if sample:
        raise ending.Stop(Text("the sample keeps no project; copy it to a folder first"))
    place = sidecar_of(photo)
    common.check_free(place, force)
    if place.parent.is_dir() and not os.access(place.parent, os.W_OK | os.X_OK):
        raise ending.Stop(
            Text(
                "the folder {folder} isn't writable, so no project can be kept "
                "beside the photo; leave out --save-project or copy the photo",
                folder=place.parent,
            ),
            ending.UNREADABLE,
        )


def _save_project(
    photo: Photo, sha256: str, found: Sequence[Face], done: Applied, file: Path | None
) -> Path:
    """Write what was done beside the photo, or stop."""
    original = sidecar.original(photo.path, sha256, photo.pixels)
    if file is not None:
        with _usable(file):
            kept = project.load(file).at_size(photo.width, photo.height)
        kept = dataclasses.replace(kept, original=original)
    else:
        chosen = {id(face) for face in done.faces}
        off = frozenset(n for n, face in enumerate(found) if id(face) not in chosen)
        sheet = project.Sheet(tuple(found), off, done.recipe)
        kept = project.Project(original, "automatic", sheet, None, done.protection, done.loose)
    place = sidecar_of(photo.path)
    with ending.writing(place):
        project.save(kept, place)
    return place


@contextmanager
def _usable(file: Path) -> Iterator[None]:
    """Stop where a project can't be read, or is none of the photo."""
    try:
        yield
    except BadFile as error:
        raise ending.Stop(
            Text("the project {file} can't be used: {error}", file=file, error=error)
        ) from error
