"""What saved pictures tell about themselves: nothing, unless the user wants it; remembered."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Final

from PySide6.QtCore import QSettings, Signal
from PySide6.QtWidgets import QCheckBox, QDialogButtonBox, QLineEdit, QWidget

from kogao_core.photo import CannotDisclose
from kogao_core.photo.disclosure.credentials import Signer, check_signer
from kogao_core.photo.disclosure.disclosing import NO_DISCLOSURE, Disclosure
from kogao_core.photo.disclosure.label import LONGEST, LabelPicture, check_label, check_picture
from kogao_core.recipe.settings import CORNERS, LABEL_CORNER, LABEL_PERCENT, LABEL_SHARE, Corner

from ...i18n import sentence, tr, translated
from ...theme import GRID_PX
from ...widgets.controls import ChoiceBox, WholeNumber, column_of, muted_label, named, row_of
from ...widgets.dialogs import Dialog, PathLine, photo_filter
from ..feature import Context, Feature

_SIZE_PX: Final = (460, 0)
_GROUP: Final = "saving"


class SavingDialog(Dialog):
    """Choices that are off at first: an edit record, labels, and signed content credentials."""

    chosen = Signal(object)

    def __init__(self, now: Told, parent: QWidget) -> None:
        super().__init__(tr("Save options"), parent, _SIZE_PX)
        self.record = QCheckBox(tr("Add an &edit record to the photo's data (XMP)"))
        self.record.setToolTip(tr("That the photo was retouched, when, how and by which program"))
        self.record.setChecked(now.record)
        self.labelled = QCheckBox(tr("Draw a &label into the bottom right corner"))
        self.label = QLineEdit(now.label)
        self.label.setAccessibleName(tr("Text of the label"))
        self.label.setMaxLength(LONGEST)
        self._bind(self.labelled, now.labelled, self.label)
        self._add_picture(now)
        self._add_signer(now)
        self.film = QCheckBox(tr("Keep the &video of a motion photo, with the face as it was"))
        self.film.setToolTip(tr("In JPEGs; it is left out else, and named"))
        self.film.setChecked(now.film)
        self.note = muted_label(wraps=True)
        self._lay_out()

    def _add_picture(self, now: Told) -> None:
        self.pictured = QCheckBox(tr("Lay a &picture over a corner"))
        self.pictured.setToolTip(tr("Such as the mark that Norway prescribes for advertisements"))
        self.picture = PathLine(tr("File of the picture"), now.picture, [photo_filter()])
        self.corner = ChoiceBox()
        for name, title in CORNERS.items():
            self.corner.addItem(translated(title), name)
        self.corner.setCurrentIndex(self.corner.findData(now.corner))
        self.corner_title = named(tr("&Corner"), self.corner)
        self.share = WholeNumber(1, int(LABEL_SHARE[1]), round(now.share))
        self.share.setSuffix(tr(" %"))
        self.share.setToolTip(tr("Share of the photo's area; Norway asks for about 7 %"))
        self.share_title = named(tr("&Share of the area"), self.share)
        self._bind(self.pictured, now.pictured, self.picture, self.corner, self.share)

    def _add_signer(self, now: Told) -> None:
        self.signed = QCheckBox(
            tr("Si&gn content credentials (C2PA) that name the photo as source")
        )
        self.signed.setToolTip(tr("It takes a certificate of your own, and its key"))
        pem = [
            tr("PEM files ({patterns})", patterns="*.pem *.crt *.cer *.key"),
            tr("All files (*)"),
        ]
        self.certificate = PathLine(tr("Certificate"), now.certificate, pem)
        self.key = PathLine(tr("Private key"), now.key, pem)
        self._bind(self.signed, now.signed, self.certificate, self.key)

    def _bind(self, box: QCheckBox, on: bool, *inside: QWidget) -> None:
        """Let controls work only while their box is ticked."""
        box.setChecked(on)
        for widget in inside:
            widget.setEnabled(on)
            box.toggled.connect(widget.setEnabled)

    def _lay_out(self) -> None:
        text = tr(
            "Saved copies and batches can tell that they were retouched, if you want them to."
        )
        about = muted_label(text, wraps=True)
        kinds = QDialogButtonBox.StandardButton
        self.buttons = QDialogButtonBox(kinds.Ok | kinds.Cancel)
        self.buttons.accepted.connect(self._take)
        self.buttons.rejected.connect(self.reject)
        place = row_of(self.corner_title, self.corner, None, self.share_title, self.share)
        column_of(
            self,
            *(about, self.record, self.labelled, self.label, self.pictured, self.picture, place),
            *(self.signed, self.certificate, self.key, self.film, self.note, self.buttons),
            margin=4 * GRID_PX,
            spacing=2 * GRID_PX,
        )

    def _take(self) -> None:
        told = Told(
            self.record.isChecked(),
            self.labelled.isChecked(),
            self.label.text(),
            self.pictured.isChecked(),
            self.picture.path,
            self.corner.currentData(),
            float(self.share.value()),
            self.signed.isChecked(),
            self.certificate.path,
            self.key.path,
            self.film.isChecked(),
        )
        wanted = told.disclosure
        try:
            if told.labelled:
                check_label(told.label)
            if wanted.picture is not None:
                check_picture(wanted.picture)
            if wanted.signer is not None:
                check_signer(wanted.signer)
        except CannotDisclose as problem:
            self.note.setText(sentence(problem))
            return
        self.chosen.emit(told)
        self.accept()


class SaveOptions(Feature):
    """Asks what saved copies tell of themselves, and keeps the answer."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._asked = False
        self.add_action(
            "save-options",
            tr("Save opt&ions…"),
            "Ctrl+Alt+O",
            tr("What saved pictures tell of themselves"),
            self.ask,
        )

    @property
    def current(self) -> Disclosure:
        """What saved copies tell of themselves."""
        return Told.remembered(self.settings).disclosure

    @property
    def in_place(self) -> Disclosure:
        """What a photo tells that is written over: nothing, unless chosen since the start."""
        return self.current if self._asked else NO_DISCLOSURE

    def ask(self) -> None:
        """Show the dialog."""
        dialog = SavingDialog(Told.remembered(self.settings), self.window)
        dialog.chosen.connect(self._take)
        dialog.open()

    def _take(self, told: Told) -> None:
        self._asked = True
        told.remember(self.settings)


@dataclass(frozen=True, slots=True)
class Told:
    """What pictures are to tell, and what the user has entered for the time when they are to."""

    # Whether there is an edit record, a label of text, one that is a picture, and credentials that
    # are signed.
    record: bool = False
    labelled: bool = False
    # The text, and the picture's file.
    label: str = ""
    pictured: bool = False
    picture: str = ""
    corner: Corner = LABEL_CORNER  # where the picture lies
    share: float = LABEL_PERCENT  # how much of the photo's area it takes, %
    signed: bool = False
    # Files that it takes to sign.
    certificate: str = ""
    key: str = ""
    film: bool = False  # whether a motion photo keeps its video

    @staticmethod
    def remembered(settings: QSettings) -> Told:
        """Return what was chosen last; what makes no sense is as at first."""
        first = dataclasses.asdict(Told(label=tr("Retouched")))
        kept: dict[str, Any] = {
            name: settings.value(f"{_GROUP}/{name}", value, type(value))
            for name, value in first.items()
        }
        least, most = LABEL_SHARE
        kept["label"] = kept["label"][:LONGEST]
        kept["share"] = min(max(kept["share"], least), most)
        if kept["corner"] not in CORNERS:
            kept["corner"] = LABEL_CORNER
        return Told(**kept)

    def remember(self, settings: QSettings) -> None:
        """Keep the choices for this time and later."""
        for name, value in dataclasses.asdict(self).items():
            settings.setValue(f"{_GROUP}/{name}", value)

    @property
    def disclosure(self) -> Disclosure:
        """What of it is wanted."""
        laid = LabelPicture(self.picture, self.corner, self.share) if self.pictured else None
        signer = Signer(self.certificate, self.key) if self.signed else None
        label = self.label if self.labelled else ""
        return Disclosure(self.record, label, picture=laid, signer=signer, film=self.film)


def words(what: Disclosure) -> str:
    """Return what pictures tell, as a line for the user; empty for nothing."""
    parts = []
    if what.record:
        parts.append(tr("an edit record"))
    if what.label:
        parts.append(tr("the label “{label}”", label=what.label))
    if what.picture:
        parts.append(tr("a picture as label"))
    if what.signer:
        parts.append(tr("signed content credentials"))
    if what.film:
        parts.append(tr("a motion photo's video"))
    return tr("Results carry {what} (Save options).", what=" + ".join(parts)) if parts else ""
