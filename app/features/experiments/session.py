"""Timed trials for table 2: single photos, or guided sessions of many photos."""

from __future__ import annotations

import random
import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from PySide6.QtWidgets import QDialogButtonBox, QLineEdit

from kogao_core.base.wording import system_reason
from kogao_core.faces.face import Face
from kogao_core.lab.experiments import trials
from kogao_core.lab.experiments.trials import Mode, Trial
from kogao_core.lab.subjects import set_by_hand
from kogao_core.photo import READABLE

from ...actions import Item
from ...i18n import tr
from ...theme import GRID_PX
from ...widgets.controls import WholeNumber, column_of, heading, muted_label, named, row_of
from ...widgets.dialogs import Dialog, PathLine
from ...widgets.messages import BarAction
from ..faces import Faces
from ..feature import Context, Feature
from ..files import Files
from ..files.saver import Saver
from ..manual import Manual
from . import TRIALS, Experiments

_PRACTICE: Final = 1
_MOST_PRACTICE: Final = 20
_DIALOG_PX: Final = (520, 320)


@dataclass(frozen=True)
class SessionPhoto:
    """A photo of a session and its position."""

    path: Path
    order: int  # from 1
    practice: bool


class TimingSession(Feature):
    """Guides a person through photos in random order, practice first, and stores each trial."""

    def __init__(
        self,
        context: Context,
        files: Files,
        saver: Saver,
        faces: Faces,
        manual: Manual,
        experiments: Experiments,
    ) -> None:
        super().__init__(context)
        self._files, self._saver, self._faces, self._manual = files, saver, faces, manual
        self._table_2 = experiments.starts["timing"]
        self._file = self.storage.data / TRIALS
        self._trial = ""
        self.person = ""
        self.places: list[SessionPhoto] = []
        self._at: SessionPhoto | None = None
        self.bind(
            Item(
                "experiment-session",
                "Timing &session…",
                "Ctrl+Alt+5",
                "Time manual and automatic work in random order (table 2)",
            ),
            self._ask,
        )
        self.document.opened.connect(self._opened)
        files.unreadable.connect(self._pass_over)
        manual.applied.connect(self._applied)

    def _ask(self) -> None:
        if self._at is None:
            SessionDialog(self).open()
        else:
            self._tell(self._at)

    def begin(self, person: str, folder: Path, practice: int) -> str:
        """Ask about unsaved changes, then start with the photos of a folder.

        Return an error message; empty if the session can start.
        """
        photos = sorted(p for p in folder.glob("*") if p.suffix.lower() in READABLE and p.is_file())
        if len(photos) <= practice:
            return tr("Choose a folder with more photos than practice photos.")
        random.shuffle(photos)
        places = [SessionPhoto(path, n, n <= practice) for n, path in enumerate(photos, start=1)]

        def start() -> None:
            self.person, self.places, self._at = person, places, None
            self.go_on()

        self._saver.guard(start)
        return ""

    def go_on(self) -> None:
        """Open the next photo in manual mode; end the session after the last photo."""
        order = self._at.order if self._at is not None else 0
        if order == len(self.places):
            self.end()
            return
        self._at = self.places[order]
        self._files.read(self._at.path, afresh=True)

    def end(self) -> None:
        """End the session; applied trials are kept."""
        self.places, self._at = [], None
        step = BarAction(tr("Table 2"), self._table_2.trigger)
        self.say(tr("The session is over. All trials are saved for table 2."), step, wrong=False)

    def _opened(self) -> None:
        self._trial = secrets.token_hex(8)
        place = self._at
        if place is None:
            return
        if self.document.path != place.path.absolute():
            self.places, self._at = [], None
            self.say(tr("Opening another photo ended the session."), wrong=False)
            return
        self._manual.switch("manual")
        self._tell(place)

    def _tell(self, place: SessionPhoto) -> None:
        """Show the instructions for a photo until the photo is done."""
        applied, last = self._manual.clock.applied, place.order == len(self.places)
        text = tr(
            "Photo {n} of {all}: set every point of the face, then Apply (Ctrl+Return).",
            n=place.order,
            all=len(self.places),
        )
        if place.practice:
            text = tr("Practice photo, not counted. {text}", text=text)
        steps = [BarAction(tr("End the session"), self.end)]
        if applied:
            text = tr("Trial saved. Correct points and apply again, or open the next photo.")
            steps = steps if last else [BarAction(tr("Next photo"), self.go_on), *steps]

        def applies() -> bool:
            return self._at is place and self._manual.clock.applied == applied

        self.say(text, *steps, wrong=False, applies=applies)

    def _pass_over(self, _: str) -> None:
        if self._at is not None:
            self.go_on()

    def _applied(self) -> None:
        state = self.document.state
        if not self._manual.fresh or not state.active or self.document.path is None:
            return
        clock, found = self._manual.clock, state.sheet("automatic")
        first, *later = clock.applied_s
        corrections = tuple(b - a for a, b in zip(clock.applied_s, later, strict=False))
        try:
            self._keep(
                "manual", state.sheet("manual").active, clock.looking_s or 0.0, first, corrections
            )
            if found.active and self._faces.finding_s is not None:
                self._keep(
                    "automatic", found.active, 0.0, self._faces.finding_s, (),
                    cold=self._faces.finding_was_cold,
                )  # fmt: skip
        except OSError as problem:
            self.say(tr("The trial couldn't be saved ({why}).", why=system_reason(problem)))
            return
        if self._at is not None:
            self._tell(self._at)

    def _keep(
        self,
        mode: Mode,
        faces: Sequence[Face],
        looking_s: float,
        setting_s: float,
        corrections_s: tuple[float, ...],
        *,
        cold: bool = False,
    ) -> None:
        place, image, path = self._at, self.document.image, self.document.path
        assert path is not None
        sheet = self.document.state.sheet(mode)
        trial = Trial(
            self._trial, mode, self.person if place else "", path.name, image.width, image.height,
            place.order if place else 0, place.practice if place else False, cold,
            looking_s, setting_s, corrections_s, set_by_hand(faces, sheet.recipe), trials.now(),
        )  # fmt: skip
        trials.append(self._file, trial)


class SessionDialog(Dialog):
    """Dialog for the person, the folder, and the number of practice photos."""

    def __init__(self, session: TimingSession) -> None:
        title = tr("Timing session")
        super().__init__(title, session.window, _DIALOG_PX)
        self._session = session
        self.person = QLineEdit()
        self.folder = PathLine(tr("Folder of photos"), "")
        self.practice = WholeNumber(0, _MOST_PRACTICE, _PRACTICE)
        who = row_of(named(tr("Person, a &code"), self.person), self.person)
        practice = row_of(named(tr("P&ractice photos"), self.practice), self.practice, None)
        how = tr(
            "The photos are shown in random order. Set all points of each photo by hand. The "
            "clock runs from the first view until Apply. The program finds its own points "
            "meanwhile."
        )
        self.wrong = muted_label("", wraps=True)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        self.start = buttons.addButton(tr("&Begin"), QDialogButtonBox.ButtonRole.AcceptRole)
        buttons.accepted.connect(self._begin)
        buttons.rejected.connect(self.reject)
        controls = who, self.folder, practice, self.wrong, None, buttons
        content = heading(title), muted_label(how, wraps=True), *controls
        column_of(self, *content, margin=4 * GRID_PX, spacing=3 * GRID_PX)

    def _begin(self) -> None:
        folder = Path(self.folder.path)
        person = self.person.text().strip()
        if person and self.folder.path and folder.is_dir():
            why = self._session.begin(person, folder, self.practice.value())
        else:
            why = tr("Enter a code for the person, and choose an existing folder.")
        self.wrong.setText(why)
        if not why:
            self.accept()
