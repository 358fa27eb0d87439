"""Run experiments on the open photo, and show the results."""

from __future__ import annotations

import threading
from functools import cache, partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QUrl, Signal
from PySide6.QtGui import QAction, QDesktopServices

from kogao_core.base import atomic
from kogao_core.faces.landmarks import source
from kogao_core.lab.experiments import EXPERIMENTS
from kogao_core.lab.experiments.experiment import Experiment, ExperimentOption, Work
from kogao_core.lab.reports.report import Made, files, translated_report
from kogao_core.lab.subjects import Progress, Subject
from kogao_core.recipe.recipe import Recipe

from ...actions import Item
from ...i18n import sentence, tr, translated, unwritten
from ...widgets.dialogs import ask_path
from ..feature import Context, Feature
from ..landmarks import LandmarkSources
from ..readings import differing_from_paper, settings_text
from .dialog import ExperimentDialog, Findings

TRIALS: Final = "trials.jsonl"
_NUMBERS: Final = (1, 2, 3, 4, 6, 7, 9, 0)  # digits of the shortcuts: 5 and 8 are taken


class _Stopped(Exception):
    """The user cancelled the experiment."""


class Experiments(Feature):
    """Runs one experiment at a time."""

    # (done: int, of: int): steps of the experiment; from a worker.
    _progressed = Signal(int, int)

    def __init__(self, context: Context, landmarks: LandmarkSources) -> None:
        super().__init__(context)
        self._landmarks = landmarks
        self._reports = self.storage.data / "reports"
        self._dialog: ExperimentDialog | None = None
        self._enough = threading.Event()
        self._running = self.lane(self._show, self._fail)
        self._progressed.connect(self._show_progress)
        self.starts: dict[str, QAction] = {}
        for one, number in zip(EXPERIMENTS, _NUMBERS, strict=False):
            slot, key = partial(self.start, one), f"Ctrl+Alt+{number}"
            entry, tip = translated(one.entry), translated(one.help)
            command = Item(f"experiment-{one.name}", entry, key, tip)
            self.starts[one.name] = self.bind(command, slot)

    def start(self, experiment: Experiment) -> None:
        """Run an experiment on the active faces of the photo."""
        subject = self._subject()
        if subject is None:
            text = tr("An experiment needs a photo with an active face.")
            self.say(text, applies=lambda: self._subject() is None)
            return
        if self._dialog is not None:
            self._dialog.close()
        recipe, wanted = self.document.state.recipe, self._landmarks.wanted
        title, settings = translated(experiment.title), settings_text(recipe)
        self._dialog = dialog = ExperimentDialog(title, self.window, settings)
        dialog.paper.setEnabled(bool(differing_from_paper(recipe)))
        dialog.paper.clicked.connect(lambda: self._start_as_paper(experiment))
        dialog.finished.connect(lambda _: self._let_go())
        dialog.open()
        self.stop()
        self._enough = enough = threading.Event()

        def progress(done: int, of: int) -> None:
            if enough.is_set():
                raise _Stopped
            self._progressed.emit(done, of)

        data = self.storage.data
        self._running.submit(lambda: measured(experiment, subject, recipe, wanted, data, progress))

    def _start_as_paper(self, experiment: Experiment) -> None:
        self.actions["paper-settings"].trigger()
        self.start(experiment)

    def _subject(self) -> Subject | None:
        photo, state, path = self.document.photo, self.document.state, self.document.path
        if photo is None or path is None or not state.active:
            return None
        return Subject(path.name, photo.pixels, tuple(state.active), file=path)

    def stop(self) -> None:
        """Cancel the experiment after the current run."""
        self._enough.set()
        super().stop()

    def _show_progress(self, done: int, of: int) -> None:
        if self._dialog is not None:
            self._dialog.show_progress(done, of)

    def _show(self, findings: Findings) -> None:
        dialog = self._dialog
        if dialog is not None:
            dialog.show_findings(findings)
            dialog.in_browser.clicked.connect(lambda: self._browse(dialog, findings))
            dialog.to_file.clicked.connect(lambda: self._ask_where(dialog, findings))

    def _fail(self, problem: Exception) -> None:
        if self._dialog is not None:
            self._dialog.show_failure(sentence(problem))

    def _let_go(self) -> None:
        self._dialog = None
        self.stop()

    def _browse(self, dialog: ExperimentDialog, findings: Findings) -> None:
        file = self._reports / f"{findings.name}.html"
        file.parent.mkdir(parents=True, exist_ok=True)
        if _saved(dialog, findings, file):
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(file)))

    def _ask_where(self, dialog: ExperimentDialog, findings: Findings) -> None:
        kinds = {"html": tr("Report"), "json": tr("All figures"), "csv": tr("Table")}
        ask_path(
            dialog,
            tr("Save the report"),
            partial(_saved, dialog, findings),
            "new",
            filters=[f"{words} (*.{kind})" for kind, words in kinds.items()],
            endings=[f".{kind}" for kind in kinds],
            at=Path.home() / f"{findings.name}.html",
        )


def _saved(dialog: ExperimentDialog, findings: Findings, file: Path) -> bool:
    """Write the report; show the reason in the dialog and return False on failure."""
    kind = file.suffix.lower().lstrip(".")
    try:
        atomic.atomic_write(findings.texts.get(kind, findings.texts["html"]).encode(), file)
    except OSError as problem:
        dialog.state.setText(unwritten(file, problem))
        return False
    return True


def measured(
    experiment: Experiment,
    subject: Subject,
    recipe: Recipe,
    landmarks: str | None,
    data: Path,
    progress: Progress,
) -> Findings:
    """Return the results of an experiment; an exception in `progress` cancels the experiment.

    `landmarks` names the landmark source. `data` is the editor's data folder.
    """
    left_out: list[str] = []
    work = Work(
        [subject],
        recipe,
        cache(lambda: source(landmarks)),
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
        list(map(translated, left_out)),
        {kind: text() for kind, text in files(report, made).items()},
    )


def chosen(option: ExperimentOption, data: Path) -> object:
    """Return the value of an option in the window, which shows no form for options."""
    if option.read is None:
        return option.default if option.in_window is None else option.in_window
    kept = data / f"{option.name}.jsonl"
    return option.read(kept) if kept.exists() else ()
