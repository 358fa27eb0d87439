"""The experiments themselves: measured, and told as tables, pictures and texts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Final

from kogao_core.faces.face import Face, LandmarkSource
from kogao_core.lab import series, stimuli
from kogao_core.lab.experiments.experiment import Experiment, ExperimentOption, Work
from kogao_core.lab.reports.report import Made, Report, files, translated_report
from kogao_core.lab.subjects import Progress, Subject
from kogao_core.photo import READABLE, Photo
from kogao_core.recipe.recipe import Recipe

from ...i18n import tr, translated
from .dialog import Findings

ONE_RESULT: Final = "one-result"  # the folder, below the photos', of what `brought` writes


def measured(
    experiment: Experiment,
    subject: Subject,
    recipe: Recipe,
    new_source: Callable[[], LandmarkSource],
    data: Path,
    progress: Progress,
) -> Findings:
    """Return what an experiment finds; `progress` is told how far it is, and ends it by raising.

    `new_source` makes what finds the faces, and is called off the GUI thread; `data` is the folder
    of what the editor keeps.
    """
    left_out: list[str] = []
    work = Work(
        [subject],
        recipe,
        cache(new_source),
        new_source,
        {one.key: chosen(one, data) for one in experiment.options},
        progress,
        left_out.append,
        left_out.append,
        lambda _: None,
    )
    return _told(experiment.name, subject.name, experiment.run(work), left_out)


def chosen(option: ExperimentOption, data: Path) -> object:
    """Return what the window takes for an option, which nobody is asked for there."""
    if option.read is None:
        return option.default if option.in_window is None else option.in_window
    kept = data / f"{option.name}.jsonl"
    return option.read(kept) if kept.exists() else ()


def _told(name: str, photo: str, report: Report, left_out: Sequence[str] = ()) -> Findings:
    made = Made.now(tr("the editor, {photo}", photo=photo), left_out)
    shown = translated_report(report)
    return Findings(
        name,
        shown.lead,
        shown.tables,
        shown.gallery,
        list(map(translated, left_out)),
        {kind: text() for kind, text in files(report, made).items()},
    )


def brought(
    folder: Path, recipe: Recipe, source: Callable[[], LandmarkSource], progress: Progress
) -> Findings:
    """Bring the photos of a folder, of one person, to one result, in a folder below."""
    photos = sorted(p for p in folder.iterdir() if p.suffix.lower() in READABLE and p.is_file())
    made, left_out = series.one_result(
        photos, folder / ONE_RESULT, recipe, source(), progress=progress
    )
    return _told("series", folder.name, series.report(made, recipe), left_out)


def dosed(
    photo: Photo,
    faces: Sequence[Face],
    recipe: Recipe,
    percents: tuple[float, ...],
    folder: Path,
    progress: Progress,
) -> Findings:
    """Make a photo's faces at several doses, alike and without targets of their own."""
    alike = tuple(replace(face, recipe=None, targets=None) for face in faces)
    wanted = stimuli.Wanted(percents, recipe)
    row = stimuli.written(stimuli.Posed(photo, alike), wanted, folder, progress=progress)
    stimuli.finish([row], folder)
    return _told("stimuli", photo.path.name, stimuli.report([row], recipe))
