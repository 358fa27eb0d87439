"""The work of ``kogao-cli warp``: read, find faces, render, save."""

from __future__ import annotations

import dataclasses
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from kogao_core.additions.limits import OutOfBounds, check_protection
from kogao_core.background.find import BackgroundFinder, MeasuredLines, measure
from kogao_core.base.geometry import Box
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.cli import common, ending, reading, summary
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import source as landmark_source
from kogao_core.field.protection import NOTHING, Protection
from kogao_core.photo import (
    CannotWrite,
    Photo,
    RefusedOutput,
    check_holds,
    check_in_place,
    check_output,
)
from kogao_core.photo.export import Export
from kogao_core.photo.originals import Originals
from kogao_core.pipeline import Rendering
from kogao_core.projects import project, sidecar
from kogao_core.projects.edits import Edits, sidecar_of
from kogao_core.projects.results import Results
from kogao_core.projects.sidecar import Applied, apply
from kogao_core.recipe.recipe import Recipe
from kogao_core.retouch import over_itself, retouch, to_file


def warp(
    args: SimpleNamespace,
    path: Path,
    recipe: Recipe,
    files: ExitStack,
    early: Future[Photo] | None,
) -> None:
    """Warp the photo at `path`, which is already being read if `early` is given.

    `files` deletes temporary files.
    """
    is_piped = args.output == common.STDOUT
    job = reading.job_of(args, recipe)
    is_searched = args.project_file is None and args.points is None
    known = landmark_source(job.landmarks) if is_searched else None
    to = _checked_output(path, args, job.export)
    common.check_report(args.json_file, args.force)
    if args.evidence_file is not None:
        common.check_free(args.evidence_file, args.force)
    if not (args.results or args.in_place or args.sample):
        reading.refuse_result(path)
    if args.save_project:
        _check_project(path, args)
    photo = reading.read_photo(path, job.max_megapixels, to, early)
    if is_piped:
        to = files.enter_context(common.sent(reading.suffix_for(photo)))
    _check_photo(photo, to, args.in_place, job.export)
    found: list[Face] = []
    if args.project_file is not None:
        with _usable(args.project_file):
            made_before = project.load(args.project_file)
            edits = apply(made_before, photo.pixels, Edits.of_user().name_in(made_before, photo))
    else:
        protection = _protection(photo, args.lines, args.width_px)
        found = reading.find_faces(photo, job.landmarks, args.points, known)
        chosen = reading.chosen(photo, found, job.which, job.doubtful)
        edits = Applied(chosen.faces, job.recipe, protection, chosen.note, others=chosen.others)
    finder = BackgroundFinder()
    lines = MeasuredLines(())

    def look(rendering: Rendering) -> None:
        nonlocal lines
        counts = args.verbose or args.json_file is not None
        lines = _measured(photo, rendering, edits, finder, counts=counts)

    originals = None if args.temporary else Originals.of_user(evicts=args.anyway)
    write = over_itself(originals) if args.in_place else to_file(to, force=args.force)
    with _writing():
        made = retouch(photo, edits, job.disclosure, write, finder, look=look, export=job.export)
    if not (args.in_place or is_piped):
        Results.of_user().add(path, to)
    file_notes = [made.written]
    if args.save_project:
        try:
            place = _save_project(photo, found, edits, args.project_file)
        except ending.Stop as stop:
            problem = Text("{output} is written, but {reason}", output=to, reason=stop.message)
            raise ending.Stop(problem, stop.code) from stop
        file_notes.append(Text("edits saved to {place}", place=place))
    files.close()
    assert made.rendering is not None
    if args.evidence_file is not None:
        with ending.writing(args.evidence_file):
            made.rendering.save_evidence(args.evidence_file, photo.sha256)
    report = summary.WarpReport(
        photo,
        common.STDOUT if is_piped else to,
        edits.faces,
        made.rendering,
        lines,
        Text.joined("; ", file_notes),
        [*filter(None, (edits.note, *made.notes, made.rendering.note, lines.note))],
    )

    def text() -> str:
        if args.json_file != common.STDOUT:
            for warning in report.warnings():
                ending.print_message(Text("warning: {problem}", problem=warning))
        if args.quiet:
            return ""
        # The details count pixels, which takes longer than the warp.
        details = [report.details()] if args.verbose else []
        return "\n".join([report.headline(), *details])

    common.tell(report.to_dict, text, args.json_file, err=is_piped)


def _checked_output(path: Path, args: SimpleNamespace, export: Export) -> Path:
    """Return the output path. Raises Stop if the path can't be used."""
    if args.in_place:
        _check_in_place(args)
        if export.coding is not None:
            raise ending.Stop(
                Text("export options can't be combined with --in-place; save a copy with -o")
            )
        return path
    if args.output == common.STDOUT:
        if sys.stdout.isatty():
            raise ending.Stop(Text("standard output is a terminal; redirect it or name a file"))
        return Path("stdout.jpg")  # a placeholder until the format of the photo is known
    output: Path | None = args.output
    if output is None:
        raise ending.Stop(Text("no output given; use -o FILE or --in-place"))
    if output.exists() and path.exists() and output.samefile(path) and not args.force:
        raise ending.Stop(
            Text(
                "{output} is the input photo; choose another output or use --force",
                output=output,
            )
        )
    with _writing():
        check_output(output, force=True)
    common.check_free(output, args.force)
    return output


def _check_in_place(args: SimpleNamespace) -> None:
    if args.sample:
        raise ending.Stop(Text("--sample can't be combined with --in-place"))
    if args.output is not None:
        raise ending.Stop(Text("-o can't be combined with --in-place"))
    if args.save_project:
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
) -> MeasuredLines:
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
        return MeasuredLines((), Text("straight lines can't be measured: {why}", why=why))


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


def _check_project(photo: Path, args: SimpleNamespace) -> None:
    """Raise Stop if no project can be written next to the photo."""
    if args.sample:
        raise ending.Stop(Text("--sample can't be combined with --save-project"))
    place = sidecar_of(photo)
    common.check_free(place, args.force)
    if place.parent.is_dir() and not os.access(place.parent, os.W_OK | os.X_OK):
        raise ending.Stop(
            Text(
                "folder {folder} isn't writable; omit --save-project or copy the photo",
                folder=place.parent,
            ),
            ending.UNREADABLE,
        )


def _save_project(photo: Photo, found: Sequence[Face], edits: Applied, file: Path | None) -> Path:
    """Write the edits next to the photo. Raises Stop."""
    original = sidecar.original(photo)
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
