"""The work of ``kogao-cli warp``: read, find faces, render, save."""

from __future__ import annotations

import dataclasses
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

from kogao_core.additions.limits import OutOfBounds, check_protection
from kogao_core.background import find
from kogao_core.background.find import BackgroundFinder, MeasuredLines
from kogao_core.base.geometry import Box, Line
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.cli import common, ending, reading, summary
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import source as landmark_source
from kogao_core.field.mask import read_mask
from kogao_core.field.protection import NOTHING, Protection
from kogao_core.photo import (
    CannotWrite,
    Photo,
    RefusedOutput,
    UnreadablePhoto,
    bits_of,
    check_holds,
    check_in_place,
    check_output,
)
from kogao_core.photo.export import Export
from kogao_core.photo.originals import Originals
from kogao_core.pipeline import Rendering, measure
from kogao_core.projects import project, sidecar
from kogao_core.projects.edits import Edits, sidecar_of
from kogao_core.projects.results import Results
from kogao_core.projects.sidecar import Applied, apply
from kogao_core.recipe.recipe import Recipe
from kogao_core.retouch import Output, RetouchJob, draw, over_itself, retouch, to_file


@dataclass(frozen=True, kw_only=True)
class WarpOptions:
    """The options of `warp` beside its settings and its job (`RetouchJob`)."""

    output: Path | None
    in_place: bool
    sample: bool
    project_file: Path | None
    points: Path | None
    lines: Sequence[Line | Path]
    width_px: float
    save_project: bool
    evidence_file: Path | None
    json_file: Path | None
    results: bool
    temporary: bool
    anyway: bool
    force: bool
    quiet: bool
    verbose: bool

    @property
    def is_piped(self) -> bool:
        """Whether the result goes to standard output."""
        return self.output == common.STDOUT


@dataclass(frozen=True, kw_only=True)
class WarpOrder:
    """A photo, its edits and the files to write. All options are checked."""

    photo: Photo
    found: Sequence[Face]  # all faces of the photo; empty with a project
    edits: Applied
    output: Output
    path: Path  # the file to write


def warp(
    given: SimpleNamespace,
    path: Path,
    recipe: Recipe,
    files: ExitStack,
    early: Future[Photo] | None,
) -> None:
    """Warp the photo at `path`, which is already being read if `early` is given.

    `files` deletes temporary files.
    """
    job = reading.job_of(given, recipe)
    names = [field.name for field in dataclasses.fields(WarpOptions)]
    options = WarpOptions(**{name: getattr(given, name) for name in names})
    order = _checked(options, job, path, files, early)
    report = _written(options, order)
    files.close()
    if options.evidence_file is not None:
        with ending.writing(options.evidence_file):
            report.rendering.save_evidence(options.evidence_file, order.photo.sha256)
    _tell(options, report)


def _checked(
    options: WarpOptions,
    job: RetouchJob,
    path: Path,
    files: ExitStack,
    early: Future[Photo] | None,
) -> WarpOrder:
    """Check the options, read the photo and find the faces. Raises Stop before anything is made."""
    is_searched = options.project_file is None and options.points is None
    source = landmark_source(job.landmarks) if is_searched else None
    output = _checked_output(path, options, job.export)
    common.check_report(options.json_file, options.force)
    if options.evidence_file is not None:
        common.check_free(options.evidence_file, options.force)
    if not (options.results or options.in_place or options.sample):
        reading.refuse_result(path)
    if options.save_project:
        _check_project(path, options)
    bits = 8 if output is None else bits_of(output)
    photo = reading.read_photo(path, job.max_megapixels, bits, early)
    if output is None:
        output = files.enter_context(common.sent(reading.suffix_for(photo)))
    _check_photo(photo, output, options.in_place, job.export)
    found: list[Face] = []
    if options.project_file is not None:
        with _usable(options.project_file):
            made_before = project.load(options.project_file)
            edits = apply(made_before, photo.pixels, Edits.of_user().name_in(made_before, photo))
    else:
        protection = _protection(photo, options.lines, options.width_px)
        found = reading.find_faces(photo, job.landmarks, options.points, source)
        chosen = reading.chosen(photo, found, job)
        found = chosen.every
        edits = Applied(chosen.faces, job.recipe, protection, chosen.note, others=chosen.others)
    originals = None if options.temporary else Originals.of_user(evicts=options.anyway)
    write = over_itself(originals) if options.in_place else to_file(output, force=options.force)
    return WarpOrder(
        photo=photo, found=found, edits=edits,
        output=Output(write, job.disclosure, job.export), path=output,
    )  # fmt: skip


def _written(options: WarpOptions, order: WarpOrder) -> summary.WarpReport:
    """Render, measure and write the photo, and its project. Raises Stop."""
    photo, edits, finder = order.photo, order.edits, BackgroundFinder()
    with _writing():
        rendering = draw(photo, edits, finder, order.output.export)
        # Measure before any file is written.
        counts = options.verbose or options.json_file is not None
        measurement = measure(rendering, counts=counts)
        lines = _measured_lines(photo, rendering, edits, finder)
        made = retouch(photo, edits, rendering, order.output)
    if not (options.in_place or options.is_piped):
        Results.of_user().add(photo.path, order.path)
    file_notes = [made.written]
    if options.save_project:
        try:
            place = _save_project(order, options.project_file)
        except ending.Stop as stop:
            problem = Text(
                "{output} is written, but {reason}", output=order.path, reason=stop.message
            )
            raise ending.Stop(problem, stop.code) from stop
        file_notes.append(Text("edits saved to {place}", place=place))
    return summary.WarpReport(
        photo=photo,
        output=Path(common.STDOUT) if options.is_piped else order.path,
        faces=edits.faces,
        rendering=rendering,
        measurement=measurement,
        lines=lines,
        file_note=Text.joined("; ", file_notes),
        notes=[*filter(None, (edits.note, *made.notes, rendering.note, lines.note))],
    )


def _tell(options: WarpOptions, report: summary.WarpReport) -> None:
    """Print the report, or write it as JSON."""

    def text() -> str:
        if options.json_file != common.STDOUT:
            for warning in report.warnings():
                ending.print_message("warning: {problem}", problem=warning)
        if options.quiet:
            return ""
        # The details count pixels, which takes longer than the warp.
        details = [report.details()] if options.verbose else []
        return "\n".join([report.headline(), *details])

    common.tell(report.to_dict, text, options.json_file, err=options.is_piped)


def _checked_output(path: Path, options: WarpOptions, export: Export) -> Path | None:
    """Return the output path, None for standard output. Raises Stop if it can't be used."""
    if options.in_place:
        _check_in_place(options)
        if export.coding is not None:
            raise ending.Stop(
                "export options can't be combined with --in-place; save a copy with -o"
            )
        return path
    if options.output == common.STDOUT:
        if sys.stdout.isatty():
            raise ending.Stop("standard output is a terminal; redirect it or name a file")
        return None
    output: Path | None = options.output
    if output is None:
        raise ending.Stop("no output given; use -o FILE or --in-place")
    if os.path.exists(output) and path.exists() and output.samefile(path):
        raise ending.Stop(
            "{output} is the input photo; choose another output or use --in-place", output=output
        )
    with _writing():
        check_output(output, force=True)
    common.check_free(output, options.force)
    return output


def _check_in_place(options: WarpOptions) -> None:
    if options.sample:
        raise ending.Stop("--sample can't be combined with --in-place")
    if options.output is not None:
        raise ending.Stop("-o can't be combined with --in-place")
    if options.save_project:
        raise ending.Stop(
            "--save-project can't be combined with --in-place: the project refers to the "
            "original photo"
        )


def _check_photo(photo: Photo, output: Path, in_place: bool, export: Export) -> None:
    with _writing():
        if in_place:
            check_in_place(photo)
        elif export.coding is None:  # an export has the depth of the format
            check_holds(output, photo.pixels)


def _measured_lines(
    photo: Photo, rendering: Rendering, edits: Applied, finder: BackgroundFinder
) -> MeasuredLines:
    try:
        return find.measure(photo.pixels, rendering, edits, finder)
    except Exception as error:  # a failed measurement must not prevent saving
        why = f"{type(error).__name__}: {error}"
        return MeasuredLines((), Text("straight lines can't be measured: {why}", why=why))


def _protection(photo: Photo, lines: Sequence[Line | Path], width_px: float) -> Protection:
    protection = NOTHING
    for line in lines:
        if isinstance(line, Path):
            with (
                ending.stopping(UnreadablePhoto, ending.UNREADABLE),
                ending.stopping(ValueError, ending.USAGE),
            ):
                protection = protection.with_mask(read_mask(line, photo.width, photo.height))
        else:
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


def _check_project(photo: Path, options: WarpOptions) -> None:
    """Raise Stop if no project can be written next to the photo."""
    if options.sample:
        raise ending.Stop("--sample can't be combined with --save-project")
    place = sidecar_of(photo)
    common.check_free(place, options.force)
    if place.parent.is_dir() and not os.access(place.parent, os.W_OK | os.X_OK):
        raise ending.Stop(
            "folder {folder} isn't writable; omit --save-project or copy the photo",
            ending.UNREADABLE,
            folder=place.parent,
        )


def _save_project(order: WarpOrder, file: Path | None) -> Path:
    """Write the edits next to the photo. Raises Stop."""
    photo, edits = order.photo, order.edits
    original = sidecar.original(photo)
    if file is not None:
        with _usable(file):
            kept = project.load(file).at_size(photo.width, photo.height)
        kept = dataclasses.replace(kept, original=original)
    else:
        chosen = {id(face) for face in edits.faces}
        off = frozenset(n for n, face in enumerate(order.found) if id(face) not in chosen)
        sheet = project.Sheet(tuple(order.found), off, edits.recipe)
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
        raise ending.Stop("can't use project {file}: {error}", file=file, error=error) from error
