"""``kogao-cli warp``: check the options, read, find faces, render, save."""

from __future__ import annotations

import dataclasses
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from math import isfinite
from pathlib import Path
from typing import Any, Final

import click

from kogao_core.background.find import BackgroundFinder, Bends, measure
from kogao_core.base.geometry import Box
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.base.wording import shown
from kogao_core.cli import common, ending, options, reading, summary, words
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import source as landmark_source
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
from kogao_core.photo.originals import Originals
from kogao_core.pipeline import Rendering
from kogao_core.projects import project, sidecar
from kogao_core.projects.results import Results
from kogao_core.projects.sidecar import Applied, apply, sidecar_of
from kogao_core.recipe.recipe import SETTINGS
from kogao_core.retouch import over_itself, retouch, to_file
from kogao_core.warp.limits import OutOfBounds, check_protection
from kogao_core.warp.protection import NOTHING, Protection

# Parameters that a project contains.
_FROM_PROJECT: Final = (
    *SETTINGS,
    *("which", "doubtful", "recipe_file", "landmarks"),
    *("lines", "width_px", "points", "points_map"),
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


@words.command(
    "warp",
    examples=(
        "kogao-cli warp portrait.jpg -o slim.jpg",
        "kogao-cli warp group.jpg -o slim.jpg --face 1,3 --amount 6",
        "kogao-cli warp portrait.jpg -o slim.jpg --amount 0 --jaw-width -5",
    ),
    context_settings={"allow_extra_args": True},  # for a better message
)
@reading.takes_photo
@words.option(
    "-o", "--output", type=click.Path(path_type=Path, allow_dash=True), metavar="FILE",
    help=reading.OUTPUT_HELP,
)  # fmt: skip
@words.option("--in-place", is_flag=True, help="Overwrite IN; undo with kogao-cli restore")
@options.chooses
@words.option("-q", "--quiet", is_flag=True, help="Print only warnings and errors")
@words.option(
    "-v", "--verbose", is_flag=True, excludes=("-q",), help="Print measurements and timings"
)
@reading.takes_point_files
@words.section(
    options.SURROUNDINGS,
    words.option(
        "--protect",
        "lines",
        multiple=True,
        metavar="'X,Y X,Y'",
        callback=_lines,
        help="Keep a line or polyline in place, px of the upright photo; repeatable",
    ),
    words.option(
        "--protect-width",
        "width_px",
        type=common.Number(0.0),
        default=0.0,
        metavar="PX",
        needs="--protect",
        help="Width of the protected lines, 0 or more [0]",
    ),
)
@words.section(
    reading.INPUT,
    words.option(
        "--project",
        "project_file",
        type=click.Path(path_type=Path),
        metavar="FILE",
        help="Apply a project (PHOTO.kogao.json); works for other sizes of the photo, too",
    ),
    reading.takes_results,
)
@words.section(
    options.OUTPUT,
    words.option(
        "--temporary",
        is_flag=True,
        needs="--in-place",
        help="With --in-place: IN is a temporary copy of another program; store no original",
    ),
    words.option(
        "--anyway",
        is_flag=True,
        needs="--in-place",
        help="With --in-place: if the store of originals is full, delete the oldest originals",
    ),
    words.option(
        "--save-project", is_flag=True, help="Save the edits as IN.kogao.json next to the photo"
    ),
    words.option(
        "--evidence",
        "evidence_file",
        type=click.Path(path_type=Path),
        metavar="FILE",
        help="Save displacement, lattices, domains and versions as FILE (.npz)",
    ),
    options.exports,
    common.writes_json,
)
@options.discloses
@words.option("--force", is_flag=True, help="Overwrite an existing output, even IN")
def command(
    source: Path | None,
    sample: bool,
    max_megapixels: float,
    landmarks: str | None,
    output: Path | None,
    in_place: bool,
    temporary: bool,
    anyway: bool,
    which: str,
    doubtful: bool,
    recipe_file: Path | None,
    quiet: bool,
    verbose: bool,
    lines: list[Any],
    width_px: float,
    project_file: Path | None,
    save_project: bool,
    evidence_file: Path | None,
    disclosure: Disclosure,
    export: Export,
    json_file: Path | None,
    results: bool,
    force: bool,
    **choices: Any,
) -> None:
    """Make the faces in a photo smaller and save the result.

    IN - reads the photo from standard input; -o - writes the result to standard output.
    """
    context = click.get_current_context()
    if context.args:
        raise ending.Stop(Text("warp takes one photo; use kogao-cli batch for several photos"))
    if project_file is not None:
        _refuse_choices(context)
    recipe = options.recipe_of(recipe_file, choices)
    is_piped = output == common.STDOUT
    if is_piped and json_file == common.STDOUT:
        raise ending.Stop(Text("-o - and --json - both need standard output; name a file for one"))
    if source == common.STDIN and (in_place or save_project):
        raise ending.Stop(Text("--in-place and --save-project need a file, not standard input"))
    with ExitStack() as stack:
        if source == common.STDIN:
            source = stack.enter_context(common.received())
        path = reading.input_path(source, sample)
        is_searched = project_file is None and reading.point_files()[0] is None
        known = landmark_source(landmarks) if is_searched else None
        to = _checked_output(path, sample, output, in_place, save_project, force, export)
        common.check_report(json_file, force)
        if evidence_file is not None:
            common.check_free(evidence_file, force)
        if not (results or in_place or sample):
            reading.refuse_result(path)
        if save_project:
            _check_project(path, sample, force)
        photo = reading.read_photo(path, max_megapixels, to)
        if is_piped:
            to = stack.enter_context(common.sent(reading.suffix_for(photo)))
        _check_photo(photo, to, in_place, export)
        is_hashed = project_file is not None or save_project or evidence_file is not None
        sha256 = reading.hash_of(path) if is_hashed else ""
        found: list[Face] = []
        if project_file is not None:
            with _usable(project_file):
                edits = apply(project.load(project_file), photo.pixels, sha256)
        else:
            protection = _protection(photo, lines, width_px)
            found = reading.find_faces(photo, landmarks, known)
            chosen = reading.chosen(photo, found, which, doubtful)
            edits = Applied(chosen.faces, recipe, protection, chosen.note, others=chosen.others)
        finder = BackgroundFinder()
        bends = Bends(())

        def look(rendering: Rendering) -> None:
            nonlocal bends
            counts = verbose or json_file is not None
            bends = _measured(photo, rendering, edits, finder, counts=counts)

        originals = None if temporary else Originals.of_user(evicts=anyway)
        write = over_itself(originals) if in_place else to_file(to, force=force, export=export)
        with _writing():
            made = retouch(photo, edits, disclosure, write, finder, look=look, export=export)
        if not (in_place or is_piped):
            Results.of_user().add(path, to)
        file_notes = [made.written]
        if save_project:
            try:
                place = _save_project(photo, sha256, found, edits, project_file)
            except ending.Stop as stop:
                problem = Text("{output} is written, but {reason}", output=to, reason=stop.message)
                raise ending.Stop(problem, stop.code) from stop
            file_notes.append(Text("edits saved to {place}", place=place))
    assert made.rendering is not None
    if evidence_file is not None:
        with ending.writing(evidence_file):
            made.rendering.save_evidence(evidence_file, sha256)
    report = summary.WarpReport(
        photo,
        common.STDOUT if is_piped else to,
        edits.faces,
        made.rendering,
        bends,
        Text.joined("; ", file_notes),
        [*filter(None, (edits.note, *made.notes, made.rendering.note, bends.note))],
    )

    def text() -> str:
        if json_file != common.STDOUT:
            for warning in report.warnings():
                ending.print_warning(warning)
        return "" if quiet else "\n".join([report.headline(), *([report.details()] * verbose)])

    common.tell(report.to_dict, text, json_file, err=is_piped)


def _checked_output(
    path: Path,
    sample: bool,
    output: Path | None,
    in_place: bool,
    save_project: bool,
    force: bool,
    export: Export,
) -> Path:
    """Return the output path. Raises Stop if the path can't be used."""
    if in_place:
        _check_in_place(sample, output, save_project)
        if export.coding is not None:
            raise ending.Stop(
                Text("export options can't be combined with --in-place; save a copy with -o")
            )
        return path
    if output == common.STDOUT:
        if sys.stdout.isatty():
            raise ending.Stop(Text("standard output is a terminal; redirect it or name a file"))
        return Path("stdout.jpg")  # a placeholder until the format of the photo is known
    if output is None:
        raise ending.Stop(Text("no output given; use -o FILE or --in-place"))
    _check_output(path, output, force)
    return output


def _check_output(path: Path, output: Path, force: bool) -> None:
    if output.exists() and path.exists() and output.samefile(path) and not force:
        raise ending.Stop(
            Text(
                "{output} is the input photo; choose another output or use --force",
                output=output,
            )
        )
    with _writing():
        check_output(output, force=True)
    common.check_free(output, force)


def _check_in_place(sample: bool, output: Path | None, save_project: bool) -> None:
    if sample:
        raise ending.Stop(Text("--sample can't be combined with --in-place"))
    if output is not None:
        raise ending.Stop(Text("-o can't be combined with --in-place"))
    if save_project:
        raise ending.Stop(
            Text(
                "--save-project can't be combined with --in-place: the project refers to the "
                "original photo"
            )
        )


def _check_photo(photo: Photo, output: Path, in_place: bool, export: Export) -> None:
    with _writing():
        if in_place:
            check_in_place(photo)
        elif export.coding is None:  # an export has the depth of the format
            check_holds(output, photo.pixels)


def _measured(
    photo: Photo, rendering: Rendering, edits: Applied, finder: BackgroundFinder, *, counts: bool
) -> Bends:
    """Measure everything the report contains, before any file is written.

    `counts`: whether the report contains the pixels of the domains, which are slow to count.
    """
    _ = rendering.residual, rendering.one_to_one, rendering.achieved, rendering.protected_shares
    if counts:
        _ = rendering.pixel_counts
    try:
        return measure(photo.pixels, rendering, edits, finder)
    except Exception as error:  # a failed measurement must not prevent saving
        why = f"{type(error).__name__}: {error}"
        return Bends((), Text("straight lines can't be measured: {why}", why=why))


def _protection(photo: Photo, lines: list[Any], width_px: float) -> Protection:
    protection = NOTHING
    for line in lines:
        protection = protection.with_stroke(line, width_px / 2.0)
    with ending.stopping(OutOfBounds, ending.USAGE):
        check_protection(protection, Box.of(photo.pixels))
    return protection


@contextmanager
def _writing() -> Iterator[None]:
    """Convert errors on writing to `Stop` with the exit code."""
    with (
        ending.stopping(CannotWrite, ending.UNREADABLE),
        ending.stopping(RefusedOutput, ending.USAGE),
    ):
        yield


def _refuse_choices(context: click.Context) -> None:
    """Raise Stop if options are given that the project contains."""
    for parameter in context.command.params:
        if parameter.name in _FROM_PROJECT and words.is_given(parameter, context):
            raise ending.Stop(
                Text("{option} can't be combined with --project", option=parameter.opts[0])
            )


def _check_project(photo: Path, sample: bool, force: bool) -> None:
    """Raise Stop if no project can be written next to the photo."""
    if sample:
        raise ending.Stop(Text("--sample can't be combined with --save-project"))
    place = sidecar_of(photo)
    common.check_free(place, force)
    if place.parent.is_dir() and not os.access(place.parent, os.W_OK | os.X_OK):
        raise ending.Stop(
            Text(
                "folder {folder} isn't writable; omit --save-project or copy the photo",
                folder=place.parent,
            ),
            ending.UNREADABLE,
        )


def _save_project(
    photo: Photo, sha256: str, found: Sequence[Face], edits: Applied, file: Path | None
) -> Path:
    """Write the edits next to the photo. Raises Stop."""
    original = sidecar.original(photo.path, sha256, photo.pixels)
    if file is not None:
        with _usable(file):
            kept = project.load(file).at_size(photo.width, photo.height)
        kept = dataclasses.replace(kept, original=original)
    else:
        chosen = {id(face) for face in edits.faces}
        off = frozenset(n for n, face in enumerate(found) if id(face) not in chosen)
        sheet = project.Sheet(tuple(found), off, edits.recipe)
        kept = project.Project(original, "automatic", sheet, None, edits.protection, edits.loose)
    place = sidecar_of(photo.path)
    with ending.writing(place):
        project.save(kept, place)
    return place


@contextmanager
def _usable(file: Path) -> Iterator[None]:
    """Convert errors of a project to `Stop`."""
    try:
        yield
    except BadFile as error:
        raise ending.Stop(
            Text("can't use project {file}: {error}", file=file, error=error)
        ) from error
