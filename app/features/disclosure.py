"""Options for the edit record and the label of saved files: form and storage."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QMessageBox, QWidget

from kogao_core.photo import CannotDisclose
from kogao_core.photo.disclosure.disclosing import NO_DISCLOSURE, Disclosure
from kogao_core.photo.disclosure.label import LONGEST, check_label

from ..i18n import sentence, tr
from ..theme import GRID_PX
from ..widgets.controls import column_of, muted_label
from ..widgets.dialogs import question
from ..widgets.form import Form, FormField
from .feature import Context, Feature

_GROUP: Final = "saving"


FIELDS: Final = (
    FormField(
        "record",
        "Add an edit &record (XMP)",
        "Record that the photo was retouched, when and how",
        "check",
    ),
    FormField("labelled", "Draw a &label", "Write a text into the bottom right corner", "check"),
    FormField("label", "Label te&xt", "Text of the label", "text", needs="labelled"),
    FormField(
        "film",
        "Keep the &video of motion photos",
        "The video shows the face before the retouching; JPEG only",
        "check",
    ),
)


class SaveOptions(Feature):
    """Keeps the options of saved files and offers them as a form."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._changed = False

    @property
    def current(self) -> Disclosure:
        return Told.remembered(self.settings).disclosure

    @property
    def in_place(self) -> Disclosure:
        """Disclosure of a photo saved over itself: none, unless changed since the start."""
        return self.current if self._changed else NO_DISCLOSURE

    def ask_once(self, then: Callable[[], object]) -> None:
        """Offer the edit record before the first save; call `then` after the answer."""
        if self.settings.contains(f"{_GROUP}/record"):
            then()
            return
        buttons = QMessageBox.StandardButton
        box = question(self.window, tr("Add an edit record to saved photos?"))
        box.setInformativeText(
            tr(
                "The record tells other software that a photo was retouched, when and how. Some "
                "laws and platforms ask for one. You can change this in Preferences."
            )
        )
        box.setStandardButtons(buttons.Yes | buttons.No | buttons.Cancel)
        box.button(buttons.Yes).setText(tr("&Add record"))
        box.button(buttons.No).setText(tr("Do&n't add"))
        box.setDefaultButton(buttons.Yes)

        def take(answer: int) -> None:
            if answer != buttons.Cancel:
                self.settings.setValue(f"{_GROUP}/record", answer == buttons.Yes)
                then()

        box.finished.connect(take)
        # The pending save belongs to the open photo.
        self.document.opened.connect(box.reject)
        box.open()

    def page(self) -> QWidget:
        """Return a form that stores each change at once and names invalid options."""
        page, note = QWidget(), muted_label(wraps=True)
        form = Form(FIELDS, dataclasses.asdict(Told.remembered(self.settings)))
        column_of(page, form, note, spacing=2 * GRID_PX)

        def take() -> None:
            self._changed = True
            told = Told(**form.values())
            told.remember(self.settings)
            note.setText(told.problem)

        form.changed.connect(take)
        return page


@dataclass(frozen=True, slots=True)
class Told:
    """The options, including values of fields that are switched off."""

    record: bool = False  # add an edit record
    labelled: bool = False  # draw a label
    label: str = ""
    film: bool = False  # keep the video of motion photos

    @staticmethod
    def remembered(settings: QSettings) -> Told:
        """Return the stored options; replace invalid values by defaults."""
        first = dataclasses.asdict(Told(label=tr("Retouched")))
        kept: dict[str, Any] = {
            name: settings.value(f"{_GROUP}/{name}", value, type(value))
            for name, value in first.items()
        }
        kept["label"] = kept["label"][:LONGEST]
        return Told(**kept)

    def remember(self, settings: QSettings) -> None:
        for name, value in dataclasses.asdict(self).items():
            settings.setValue(f"{_GROUP}/{name}", value)

    @property
    def disclosure(self) -> Disclosure:
        """The options that are switched on."""
        return Disclosure(self.record, self.label if self.labelled else "", film=self.film)

    @property
    def problem(self) -> str:
        """Why these options cannot work, as a sentence; empty if they can."""
        try:
            if self.labelled:
                check_label(self.label)
        except CannotDisclose as problem:
            return sentence(problem)
        return ""
