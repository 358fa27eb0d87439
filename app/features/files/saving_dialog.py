"""The dialog of what saved pictures tell about themselves."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QDialogButtonBox,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QWidget,
)

from kogao_core.photo import CannotDisclose
from kogao_core.photo.label import LONGEST, check_label
from kogao_core.photo.label_picture import check_picture
from kogao_core.settings import CORNERS, LABEL_SHARE

from ...i18n import sentence, tr, translated
from ...theme import GRID_PX
from ...widgets.controls import ChoiceBox, WholeNumber, column_of, muted_label, named, row_of
from ...widgets.dialogs import Dialog, ask_path, photo_filter
from .told import Told

_SIZE_PX: Final = (460, 0)


class SavingDialog(Dialog):
    """Choices that are off at first: an edit record, a label of text, and one that is a picture.

    Parameters
    ----------
    now : Told
        What is told at present.
    parent : QWidget
        The window.

    Signals
    -------
    chosen(Told)
        What is to be told.
    """

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
        self.note = muted_label()
        self.note.setWordWrap(True)
        self._lay_out()

    def _add_picture(self, now: Told) -> None:
        self.pictured = QCheckBox(tr("Lay a &picture over a corner"))
        self.pictured.setToolTip(tr("Such as the mark that Norway prescribes for advertisements"))
        self.picture = QLineEdit(now.picture)
        self.picture.setAccessibleName(tr("File of the picture"))
        self.choose = QPushButton(tr("Choose…"))
        self.choose.setAccessibleName(tr("Choose the file of the picture"))
        self.choose.setAutoDefault(False)
        self.choose.clicked.connect(self._ask_picture)
        self.corner = ChoiceBox()
        for name, title in CORNERS.items():
            self.corner.addItem(translated(title), name)
        self.corner.setCurrentIndex(self.corner.findData(now.corner))
        self.corner_title = named(tr("&Corner"), self.corner)
        self.share = WholeNumber(1, int(LABEL_SHARE[1]), round(now.percent))
        self.share.setSuffix(tr(" %"))
        self.share.setToolTip(tr("Share of the photo's area; Norway asks for about 7 %"))
        self.share_title = named(tr("&Share of the area"), self.share)
        inside = self.picture, self.choose, self.corner, self.share
        self._bind(self.pictured, now.pictured, *inside)

    def _bind(self, box: QCheckBox, on: bool, *inside: QWidget) -> None:
        """Let controls work only while their box is ticked."""
        box.setChecked(on)
        for widget in inside:
            widget.setEnabled(on)
            box.toggled.connect(widget.setEnabled)

    def _lay_out(self) -> None:
        about = muted_label(
            tr("Saved copies and batches can tell that they were retouched, if you want them to.")
        )
        about.setWordWrap(True)
        kinds = QDialogButtonBox.StandardButton
        self.buttons = QDialogButtonBox(kinds.Ok | kinds.Cancel)
        self.buttons.accepted.connect(self._take)
        self.buttons.rejected.connect(self.reject)
        file = row_of(self.picture, self.choose)
        place = row_of(self.corner_title, self.corner, None, self.share_title, self.share)
        column = column_of(self, margin=4 * GRID_PX, spacing=2 * GRID_PX)
        for part in (about, self.record, self.labelled, self.label, self.pictured, file, place):
            if isinstance(part, QHBoxLayout):
                column.addLayout(part)
            else:
                column.addWidget(part)
        column.addWidget(self.note)
        column.addWidget(self.buttons)

    def _ask_picture(self) -> None:
        at = Path(self.picture.text())
        ask_path(
            self,
            tr("The picture to lay over photos"),
            lambda path: self.picture.setText(str(path)),
            filters=[photo_filter()],
            at=at if at.exists() and at != Path() else None,
        )

    def _take(self) -> None:
        told = Told(
            self.record.isChecked(),
            self.labelled.isChecked(),
            self.label.text(),
            self.pictured.isChecked(),
            self.picture.text().strip(),
            self.corner.currentData(),
            float(self.share.value()),
        )
        wanted = told.disclosure
        try:
            if told.labelled:
                check_label(told.label)
            if wanted.picture is not None:
                check_picture(wanted.picture)
        except CannotDisclose as problem:
            self.note.setText(sentence(problem))
            return
        self.chosen.emit(told)
        self.accept()
