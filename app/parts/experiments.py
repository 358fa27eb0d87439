"""The Experiments menu's instruments: from an action to a window with a report."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject, QThreadPool, QUrl, Signal
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QFileDialog

from kogao_core import atomic
from kogao_core.experiments import setting_times
from kogao_core.experiments.subjects import Subject
from kogao_core.face import LandmarkSource
from kogao_core.landmarks import source

from .. import actions
from ..controllers.experiments import Experiments
from ..controllers.manual import Manual
from ..document import Document
from ..experiments import ExperimentName, Outcome, Task, title
from ..i18n import sentence, tr
from ..views.bar import Message
from ..views.experiment import ExperimentDialog
from ..views.window import Window
from .landmarks import LandmarksPart

_NAMES: Final[tuple[ExperimentName, ...]] = ("timing", "domains", "distortion", "methods")
SESSIONS: Final = "setting-times.jsonl"


class ExperimentsPart(QObject):
    """Builds the experiments and joins them to the window; keeps the setting times they need.

    Parameters
    ----------
    document : Document
        Whose photo is measured.
    landmarks : LandmarksPart
        Knows which source finds the faces.
    manual : Manual
        Manual mode, whose clock tells the setting time.
    data : Path
        Folder for the setting times, and for the reports that a browser shows.
    window : Window
        The editor's.
    pool : QThreadPool
        Where experiments run.
    parent : QObject
        Owner.

    Signals
    -------
    said(Message)
        For the bar over the canvas.
    """

    said = Signal(object)

    def __init__(
        self,
        document: Document,
        landmarks: LandmarksPart,
        manual: Manual,
        data: Path,
        window: Window,
        pool: QThreadPool,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._document, self._landmarks, self._clock = document, landmarks, manual.clock
        self._sessions, self._reports, self._window = data / SESSIONS, data / "reports", window
        self._dialog: ExperimentDialog | None = None
        self._outcome: Outcome | None = None
        self.experiments = Experiments(pool, self)
        self.experiments.told.connect(self._tell)
        self.experiments.done.connect(self._show)
        self.experiments.failed.connect(self._fail)
        slots: dict[str, Callable[[], object]] = {
            f"experiment-{name}": lambda name=name: self.start(name)  # type: ignore[misc]
            for name in _NAMES
        }
        actions.connect(window.actions_by_name, slots)
        manual.applied.connect(self._record)

    @property
    def busy(self) -> bool:
        """True while an experiment runs."""
        return self.experiments.busy

    def stop(self) -> None:
        """Start nothing more, and end what runs."""
        self.experiments.stop()

    def start(self, name: ExperimentName) -> None:
        """Run an experiment on the photo's faces that are on."""
        task = self._task()
        if task is None:
            self.said.emit(Message(tr("An experiment needs a photo with a face that is on.")))
            return
        if self._dialog is not None:
            self._dialog.close()
        self._dialog = dialog = ExperimentDialog(title(name), self._window)
        dialog.stopped.connect(self._let_go)
        dialog.browse.connect(self._browse)
        dialog.save.connect(self._ask_where)
        dialog.open()
        self.experiments.start(name, task)

    def _record(self) -> None:
        state, path = self._document.state, self._document.path
        if path is None or not state.active or not self._clock.elapsed_s:
            return
        image = self._document.image
        landmarks = [len(face.outline) for face in state.active]
        size = (image.width, image.height)
        session = setting_times.SettingTime.now(path.name, size, landmarks, self._clock.elapsed_s)
        try:
            setting_times.append(self._sessions, session)
        except OSError as problem:
            self.said.emit(
                Message(tr("The setting time wasn't kept ({why}).", why=problem.strerror))
            )

    def _task(self) -> Task | None:
        photo, state, path = self._document.photo, self._document.state, self._document.path
        if photo is None or path is None or not state.active:
            return None
        wanted = self._landmarks.wanted

        def finder() -> LandmarkSource:
            return source(wanted)

        subject = Subject(path.name, photo.pixels, tuple(state.active))
        return Task(subject, state.recipe, finder, self._sessions)

    def _tell(self, done: int, of: int) -> None:
        if self._dialog is not None:
            self._dialog.show_progress(done, of)

    def _show(self, outcome: Outcome) -> None:
        self._outcome = outcome
        if self._dialog is not None:
            self._dialog.show_outcome(outcome)

    def _fail(self, problem: Exception) -> None:
        if self._dialog is not None:
            self._dialog.show_failure(sentence(problem))

    def _let_go(self) -> None:
        self._dialog = self._outcome = None
        self.experiments.stop()

    def _browse(self) -> None:
        if self._outcome is not None:
            file = self._reports / f"{self._outcome.name}.html"
            file.parent.mkdir(parents=True, exist_ok=True)
            if self._save(file):
                QDesktopServices.openUrl(QUrl.fromLocalFile(str(file)))

    def _ask_where(self) -> None:
        if self._outcome is None or self._dialog is None:
            return
        dialog = QFileDialog(self._dialog, tr("Save the report"))
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        kinds = {"html": tr("Report"), "json": tr("All figures"), "csv": tr("Table")}
        dialog.setNameFilters([f"{words} (*.{kind})" for kind, words in kinds.items()])
        dialog.setDefaultSuffix("html")
        dialog.filterSelected.connect(
            lambda chosen: dialog.setDefaultSuffix(chosen.rstrip(")").rpartition(".")[2])
        )
        dialog.selectFile(f"{self._outcome.name}.html")
        dialog.fileSelected.connect(lambda name: self._save(Path(name)))
        dialog.open()

    def _save(self, file: Path) -> bool:
        if self._outcome is None or self._dialog is None:
            return False
        try:
            kind = file.suffix.lower().lstrip(".")
            texts = self._outcome.texts
            atomic.put(texts.get(kind, texts["html"]).encode(), file)
        except OSError as problem:
            self._dialog.state.setText(
                tr("{file} can't be written ({why}).", file=file, why=problem.strerror)
            )
            return False
        return True
