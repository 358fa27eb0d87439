"""``kogao-cli experiment``: the paper's tables and figures, one command each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import click

from kogao_core.base.assets import AssetMissing
from kogao_core.base.geometry import Image
from kogao_core.base.language import Text, tr
from kogao_core.base.strict import BadFile
from kogao_core.cli import common, ending, options, reading, words
from kogao_core.cli.common import ProgressLine
from kogao_core.faces.face import LandmarkSource
from kogao_core.faces.landmarks import ModelRefused
from kogao_core.lab.commands import outputs, pictures, study
from kogao_core.lab.experiments import (
    distortion,
    distortion_report,
    domains,
    domains_report,
    lens,
    timing,
    timing_report,
)
from kogao_core.lab.experiments.trials import Trial, read
from kogao_core.lab.methods import comparing, methods_report
from kogao_core.lab.reports.report import Report
from kogao_core.lab.subjects import Subject
from kogao_core.recipe.recipe import Recipe

# The arguments of every experiment; the command hands them to `Work`.
takes_photos = words.together(
    reading.takes_photos,
    options.chooses_as_the_paper,
    outputs.writes_files,
    words.option(
        "-o", "--output", "folder", type=common.FOLDER, metavar="DIR",
        help="Write all of these, and pictures, into a folder; made if need be.",
    ),
)  # fmt: skip


class Work:
    """One experiment on the command line, from its arguments to its files."""

    def __init__(self, name: str, given: Mapping[str, Any]) -> None:
        self._given = given
        self.recipe = options.paper_recipe_of(given["recipe_file"], given.get("percent"))
        self._paths = reading.input_paths(given["inputs"], given["sample"])
        self.outputs = outputs.Outputs(_files(name, given), given["folder"], given["force"])
        self._left_out: list[str] = []
        self.progress = ProgressLine()
        self._code = 0

    @cached_property
    def source(self) -> LandmarkSource:
        """What finds the faces."""
        return self.new_source()

    def new_source(self) -> LandmarkSource:
        """Return what finds the faces, its networks yet to be loaded."""
        return reading.landmark_source(self._given["landmarks"])

    def subjects(self) -> Iterator[Subject]:
        """Yield the photos that have a face; others are named on stderr and in the report.

        Raises Stop.
        """
        source = self.source
        reading.mention_fallback(self._given["landmarks"])
        stop: ending.Stop | None = None
        found = 0
        for number, path in enumerate(self._paths, start=1):
            try:
                subject = self._subject(path, source)
            except ending.Stop as problem:
                if problem.code == ending.BROKEN:
                    raise
                stop = problem
                if len(self._paths) > 1:
                    self.leave_out(problem.message)
                continue
            self.progress.begin(
                tr("{number} of {total}: {path}", number=number, total=len(self._paths), path=path)
            )
            found += 1
            yield subject
        if not found and stop is not None:
            raise stop
        self.progress.end()

    def name_absent(self, sentence: str) -> None:
        """Note what is missing here, on stderr and in the report."""
        self._left_out.append(sentence)
        ending.print_message(sentence)

    def leave_out(self, sentence: str) -> None:
        """Note a photo that can't be used, and set the exit code; the others go on."""
        self._code = ending.SOME_FAILED
        self.name_absent(sentence)

    def _subject(self, path: Path, source: LandmarkSource) -> Subject:
        photo = reading.read_photo(path, self._given["max_megapixels"])
        known = reading.points_of(photo)
        with ending.stopping((AssetMissing, ModelRefused), ending.BROKEN):
            faces = [face for face, _ in known] if known else source.find(photo.pixels)
        if not faces:
            raise ending.Stop(
                Text("no face in {path}; leave it out or crop closer", path=path), ending.NO_FACE
            )
        chosen = reading.selected(faces, self._given["which"])
        namesakes = [other for other in self._paths if other.name == path.name]
        name = path.name if len(namesakes) == 1 else str(path)
        return Subject(name, photo.pixels, tuple(chosen), file=path)

    def deliver(self, report: Report) -> int:
        """Print the tables, write the files that were asked for, and return the exit code."""
        self.outputs.write(report, self._left_out)
        return self._code


def _files(name: str, given: Mapping[str, Any]) -> dict[str, Path]:
    folder: Path | None = given["folder"]
    files = outputs.asked_for(given)
    if folder is None:
        return files
    return {kind: files.get(kind, folder / f"{name}.{kind}") for kind in outputs.KINDS}


@words.group("experiment")
def command() -> None:
    """Repeat the paper's tables and figures on your own photos."""


@command.command("timing")
@takes_photos
@options.chooses_percent
@words.option(
    "--size", type=click.Choice(["own", "960x720", "both"]), default="both", show_default=True,
    help="The photo's own size, or the paper's (cut to its shape and scaled).",
)  # fmt: skip
@words.option("--repeats", type=click.IntRange(1), default=10, show_default=True)
@words.option("--warm-up", type=click.IntRange(0), default=2, show_default=True)
@words.option(
    "--trials", "trial_files", multiple=True, type=click.Path(path_type=Path), metavar="FILE",
    help="Trials of setting by hand that the editor recorded (JSON lines); repeatable.",
)  # fmt: skip
def timing_command(
    size: str, repeats: int, warm_up: int, trial_files: tuple[Path, ...], **given: Any
) -> int:
    """Table 2: setting and computing time by hand and found, whole and reduced."""
    work = Work("timing", given)
    trials = [trial for file in trial_files for trial in _trials(file)]
    sizes = timing.SIZES if size == "both" else [one for one in timing.SIZES if one == size]
    timings: list[timing.Timing] = []
    around: list[timing.Around] = []
    for subject in work.subjects():
        subject = timing.with_trial(subject, trials)
        found, missing = timing.measure(
            subject, work.source, work.recipe, sizes=sizes, repeats=repeats, warm_up=warm_up,
            progress=work.progress.step,
        )  # fmt: skip
        timings += found
        if (one := timing.measure_around(subject, work.new_source, work.recipe)) is not None:
            around.append(one)
        for sentence in missing:
            work.leave_out(sentence)
    result = timing.TimingResult(
        tuple(timings), tuple(trials), work.recipe, repeats, warm_up, tuple(around)
    )
    return work.deliver(timing_report.report(result))


def _trials(file: Path) -> list[Trial]:
    with (
        ending.refusing(
            lambda reason: Text("{file} can't be read ({reason})", file=file, reason=reason)
        ),
        ending.stopping(BadFile, ending.USAGE),
    ):
        return read(file)


@command.command("domains")
@takes_photos
@options.chooses_percent
@words.option("--repeats", type=click.IntRange(1), default=5, show_default=True)
def domains_command(repeats: int, **given: Any) -> int:
    """Figures 14 and 15: pixels of the domains, and the error of each threshold."""
    work = Work("domains", given)
    photos = []
    for subject in work.subjects():
        found = domains.measure(subject, work.recipe, repeats=repeats, progress=work.progress.step)
        work.outputs.keep(domains_report.pictures(subject.stem, found.masks))
        photos.append(found.without_masks())
    result = domains.DomainsResult(tuple(photos), work.recipe)
    return work.deliver(domains_report.report(result))


@command.command("distortion")
@takes_photos
def distortion_command(**given: Any) -> int:
    """Table 1 and figure 11 beside numbers: area, folds, bent lines, missed targets."""
    work = Work("distortion", given)
    found: list[distortion.Distortion] = []
    for subject in work.subjects():
        found += distortion.measure(subject, work.recipe, progress=work.progress.step)
    result = distortion.DistortionResult(tuple(found), work.recipe)
    return work.deliver(distortion_report.report(result))


@command.command("lens")
@takes_photos
def lens_command(**given: Any) -> int:
    """Bring a face back that a wide lens stretched at the edge: what is left of the truth."""
    work = Work("lens", given)
    recipe = work.recipe if given["recipe_file"] else Recipe()
    found: list[lens.Stretch] = []
    shown: list[Image] = []
    for subject in work.subjects():
        shown = shown or lens.shown(subject, recipe)
        found += lens.measure(subject, work.source, recipe, progress=work.progress.step)
    return work.deliver(lens.report(lens.LensResult(tuple(found), recipe, tuple(shown))))


@command.command("methods")
@takes_photos
@options.chooses_percent
@words.option("--repeats", type=click.IntRange(1), default=3, show_default=True)
def methods_command(repeats: int, **given: Any) -> int:
    """B-splines beside other warps: speed, exactness, folds, domain, pictures."""
    work = Work("methods", given)
    for sentence in comparing.missing():
        work.name_absent(sentence)
    photos = []
    for subject in work.subjects():
        comparison, failed = comparing.measure(
            subject, work.recipe, repeats=repeats, progress=work.progress.step
        )
        for sentence in failed:
            work.leave_out(sentence)
        work.outputs.keep(methods_report.pictures(comparison))
        photos.append(comparison.views())
    result = comparing.MethodsResult(tuple(photos), work.recipe, repeats)
    return work.deliver(methods_report.report(result))


for one in (pictures.figures, pictures.stimuli, pictures.series, study.command):
    command.add_command(one)
