"""The experiments themselves: measured, and told as tables, pictures and texts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from kogao_core.base.display import reduced, rgb8
from kogao_core.base.geometry import Image
from kogao_core.faces.face import Face, LandmarkSource
from kogao_core.lab import series, stimuli
from kogao_core.lab.experiments import (
    distortion,
    distortion_report,
    domains,
    domains_report,
    lens,
    timing,
    timing_report,
    trials,
)
from kogao_core.lab.methods import comparing, methods_report
from kogao_core.lab.reports.page import files
from kogao_core.lab.reports.report import Made, Report, translated_report
from kogao_core.lab.subjects import Progress, Subject
from kogao_core.photo import READABLE, Photo
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import DOMAINS

from ...i18n import tr, translated
from .dialog import Findings

ONE_RESULT: Final = "one-result"  # the folder, below the photos', of what `brought` writes


@dataclass(frozen=True, eq=False)
class ExperimentTask:
    """What an experiment works on."""

    subject: Subject  # the photo and the faces that are on
    recipe: Recipe  # the photo's choices
    # Makes what finds the faces, for automatic setting; called off the GUI thread.
    source: Callable[[], LandmarkSource]
    trials: Path  # what was set by hand on this machine


@dataclass(frozen=True, eq=False)
class _Found:
    report: Report
    left_out: list[str] = field(default_factory=list)
    pictures: dict[str, list[tuple[str, Image]]] = field(default_factory=dict)


def measured(name: str, task: ExperimentTask, progress: Progress) -> Findings:
    """Return what an experiment finds; `progress` is told how far it is, and ends it by raising."""
    return _told(name, task.subject.name, _RUNS[name](task, progress))


def _told(name: str, photo: str, found: _Found) -> Findings:
    made = Made.now(tr("the editor, {photo}", photo=photo), found.left_out)
    shown = translated_report(found.report)
    return Findings(
        name,
        shown.lead,
        shown.tables,
        found.pictures,
        list(map(translated, found.left_out)),
        {kind: text() for kind, text in files(found.report, made).items()},
    )


def brought(
    folder: Path, recipe: Recipe, source: Callable[[], LandmarkSource], progress: Progress
) -> Findings:
    """Bring the photos of a folder, of one person, to one result, in a folder below."""
    photos = sorted(p for p in folder.iterdir() if p.suffix.lower() in READABLE and p.is_file())
    made, left_out = series.one_result(
        photos, folder / ONE_RESULT, recipe, source(), progress=progress
    )
    return _told("series", folder.name, _Found(series.report(made, recipe), left_out))


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
    seen = [(f"{one.percent:+g} %", rgb8(one.pixels)) for one in row]
    found = _Found(stimuli.report([row], recipe), pictures={tr("Pictures"): seen})
    return _told("stimuli", photo.path.name, found)


def _timing(task: ExperimentTask, progress: Progress) -> _Found:
    known = tuple(trials.read(task.trials)) if task.trials.exists() else ()
    warm_up, repeats = 1, 5
    subject = timing.with_trial(task.subject, known)
    found, left_out = timing.measure(
        subject, task.source(), task.recipe, repeats=repeats, warm_up=warm_up, progress=progress
    )
    around = timing.measure_around(subject, task.source, task.recipe)
    result = timing.TimingResult(
        tuple(found), known, task.recipe, repeats, warm_up, (around,) if around else ()
    )
    return _Found(timing_report.report(result), left_out)


def _domains(task: ExperimentTask, progress: Progress) -> _Found:
    photo = domains.measure(task.subject, task.recipe, repeats=3, progress=progress)
    names = {domain.name: translated(domain.title) for domain in DOMAINS}
    masks = [(names[name], reduced(pixels)) for name, pixels in photo.shown.items()]
    result = domains.DomainsResult((photo,), task.recipe)
    return _Found(domains_report.report(result), pictures={tr("Domains"): masks})


def _distortion(task: ExperimentTask, progress: Progress) -> _Found:
    found = distortion.measure(task.subject, task.recipe, progress=progress)
    result = distortion.DistortionResult(tuple(found), task.recipe)
    return _Found(distortion_report.report(result))


def _lens(task: ExperimentTask, progress: Progress) -> _Found:
    found = lens.measure(task.subject, task.source(), task.recipe, progress=progress)
    seen = lens.shown(task.subject, task.recipe)
    result = lens.LensResult(tuple(found), task.recipe, tuple(seen))
    named = list(zip(map(translated, lens.SHOWN), seen, strict=True))
    return _Found(lens.report(result), pictures={tr("At the edge"): named})


def _methods(task: ExperimentTask, progress: Progress) -> _Found:
    repeats, absent = 2, comparing.missing()
    compared, failed = comparing.measure(
        task.subject, task.recipe, repeats=repeats, progress=progress
    )
    seen = compared.views()
    kinds = {
        "result": tr("Result"),
        "difference": tr("Difference to the photo, amplified"),
        "heat": tr("Displacement"),
    }
    pictures = {
        words: [(translated(one.method.title), one.pictures[kind]) for one in seen.methods]
        for kind, words in kinds.items()
    }
    pictures[kinds["result"]].insert(0, (tr("The photo"), seen.subject.pixels))
    result = comparing.MethodsResult((seen,), task.recipe, repeats)
    return _Found(methods_report.report(result), [*absent, *failed], pictures)


_RUNS: Final[dict[str, Callable[[ExperimentTask, Progress], _Found]]] = {
    "timing": _timing,
    "domains": _domains,
    "distortion": _distortion,
    "lens": _lens,
    "methods": _methods,
}
