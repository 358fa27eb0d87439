"""The paper's experiments on the photo that is open; each is one call, off the GUI thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal

from kogao_core.experiments import (
    distortion,
    distortion_report,
    domains,
    domains_report,
    sessions,
    timing,
    timing_report,
)
from kogao_core.experiments.methods import comparing, telling
from kogao_core.experiments.report import Made, Table, reduced
from kogao_core.experiments.subjects import Subject, Told
from kogao_core.experiments.telling import texts
from kogao_core.face import LandmarkSource
from kogao_core.geometry import Image
from kogao_core.recipe import Recipe

from .i18n import tr

ExperimentName = Literal["timing", "domains", "distortion", "methods"]
_REPEATS: Final = {"timing": 5, "domains": 3, "methods": 2}


@dataclass(frozen=True, eq=False)
class Task:
    """What an experiment works on.

    Parameters
    ----------
    subject : Subject
        The photo and the faces that are on.
    recipe : Recipe
        The photo's choices.
    source : callable
        Makes what finds the faces, for automatic setting; called off the GUI thread.
    sessions : Path
        Setting times of manual work on this machine.
    """

    subject: Subject
    recipe: Recipe
    source: Callable[[], LandmarkSource]
    sessions: Path


@dataclass(frozen=True, eq=False)
class Outcome:
    """What an experiment found.

    Parameters
    ----------
    name : str
        Which one.
    lead : str
        What it asks, in a sentence.
    tables : list of Table
        Its figures.
    pictures : dict of str to list of (str, array)
        By kind: captions and RGB pictures of one size, to look at in one place.
    left_out : list of str
        What couldn't be measured, and why.
    texts : dict of str to str
        The report by kind of file: html, json and csv.
    """

    name: ExperimentName
    lead: str
    tables: list[Table]
    pictures: dict[str, list[tuple[str, Image]]] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    texts: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class _Found:
    result: object
    left_out: list[str] = field(default_factory=list)
    pictures: dict[str, list[tuple[str, Image]]] = field(default_factory=dict)


def title(name: ExperimentName) -> str:
    """Return what an experiment is called."""
    return {
        "timing": tr("Setting and computing time (table 2)"),
        "domains": tr("Reduced domains (figures 14 and 15)"),
        "distortion": tr("Distortion beside table 1"),
        "methods": tr("Methods side by side"),
    }[name]


def run(name: ExperimentName, task: Task, told: Told) -> Outcome:
    """Run an experiment; `told` hears how far it is, and ends it by raising."""
    return _outcome(name, task, _RUNS[name](task, told))


def _outcome(name: ExperimentName, task: Task, found: _Found) -> Outcome:
    made = Made.now(tr("the editor, {photo}", photo=task.subject.name), found.left_out)
    tells = _TELLING[name]
    return Outcome(
        name,
        tells.LEAD,
        tells.tables(found.result),
        found.pictures,
        found.left_out,
        {kind: text() for kind, text in texts(found.result, tells, made).items()},
    )


def _timing(task: Task, told: Told) -> _Found:
    known = tuple(sessions.read(task.sessions)) if task.sessions.exists() else ()
    warm_up, repeats = 1, _REPEATS["timing"]
    found, left_out = timing.measure(
        task.subject, task.source(), task.recipe, repeats=repeats, warm_up=warm_up, told=told
    )
    return _Found(timing.Result(tuple(found), known, task.recipe, repeats, warm_up), left_out)


def _domains(task: Task, told: Told) -> _Found:
    photo = domains.measure(task.subject, task.recipe, repeats=_REPEATS["domains"], told=told)
    names = {
        "image": tr("Whole image"),
        "control-points": tr("Control points"),
        "threshold": tr("Threshold"),
    }
    masks = [(names[name], reduced(pixels)) for name, pixels in photo.shown.items()]
    result = domains.Result((photo,), task.recipe)
    return _Found(result, pictures={tr("Domains"): masks})


def _distortion(task: Task, told: Told) -> _Found:
    found = distortion.measure(task.subject, task.recipe, told=told)
    return _Found(distortion.Result(tuple(found), task.recipe))


def _methods(task: Task, told: Told) -> _Found:
    repeats, absent = _REPEATS["methods"], comparing.missing()
    compared, failed = comparing.measure(task.subject, task.recipe, repeats=repeats, told=told)
    seen = compared.views()
    kinds = {
        "result": tr("Result"),
        "difference": tr("Difference to the photo, amplified"),
        "heat": tr("Displacement"),
    }
    pictures = {
        words: [(one.method.title, one.pictures[kind]) for one in seen.methods]
        for kind, words in kinds.items()
    }
    pictures[kinds["result"]].insert(0, (tr("The photo"), seen.subject.pixels))
    result = comparing.Result((seen,), task.recipe, repeats)
    return _Found(result, [*absent, *failed], pictures)


_RUNS: Final[dict[ExperimentName, Callable[[Task, Told], _Found]]] = {
    "timing": _timing,
    "domains": _domains,
    "distortion": _distortion,
    "methods": _methods,
}
_TELLING: Final[dict[ExperimentName, Any]] = {
    "timing": timing_report,
    "domains": domains_report,
    "distortion": distortion_report,
    "methods": telling,
}
