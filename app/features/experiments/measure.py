"""Run an experiment and return tables, pictures and report files for the window."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

from kogao_core.faces.face import LandmarkSource
from kogao_core.lab.experiments.experiment import Experiment, ExperimentOption, Work
from kogao_core.lab.reports.report import Made, files, translated_report
from kogao_core.lab.subjects import Progress, Subject
from kogao_core.recipe.recipe import Recipe

from ...i18n import tr, translated
from .dialog import Findings


def measured(
    experiment: Experiment,
    subject: Subject,
    recipe: Recipe,
    new_source: Callable[[], LandmarkSource],
    data: Path,
    progress: Progress,
) -> Findings:
    """Return the results of an experiment; an exception in `progress` cancels the experiment.

    `new_source` creates a landmark source, on a worker thread. `data` is the editor's data folder.
    """
    left_out: list[str] = []
    work = Work(
        [subject],
        recipe,
        cache(new_source),
        {one.key: chosen(one, data) for one in experiment.options},
        progress,
        left_out.append,
        lambda _: None,
    )
    report = experiment.run(work)
    made = Made.now(tr("the editor, {photo}", photo=subject.name), left_out)
    shown = translated_report(report)
    return Findings(
        experiment.name,
        shown.lead,
        shown.tables,
        shown.gallery,
        list(map(translated, left_out)),
        {kind: text() for kind, text in files(report, made).items()},
    )


def chosen(option: ExperimentOption, data: Path) -> object:
    """Return the value of an option in the window, which shows no form for options."""
    if option.read is None:
        return option.default if option.in_window is None else option.in_window
    kept = data / f"{option.name}.jsonl"
    return option.read(kept) if kept.exists() else ()
