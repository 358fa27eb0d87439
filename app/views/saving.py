"""The dialog for what saved pictures tell about themselves."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QDialog, QDialogButtonBox, QLineEdit, QWidget

from kogao_core.photo import CannotDisclose
from kogao_core.photo.disclosure import Disclosure
from kogao_core.photo.label import LONGEST, check_label

from ..i18n import tr
from ..panels.controls import column_of, muted_label
from ..theme import GRID_PX


class SavingDialog(QDialog):
    """Two choices, both off at first: an edit record, and a label on the picture.

    Parameters
    ----------
    now : Disclosure
        What is told at present.
    label : str
        The text to begin with.
    parent : QWidget
        The window.

    Signals
    -------
    chosen(bool, bool, str)
        Whether there is to be a record, whether a label, and its text.
    """

    chosen = Signal(bool, bool, str)

    def __init__(self, now: Disclosure, label: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Save options"))
        self.record = QCheckBox(tr("Add an &edit record to the photo's data (XMP)"))
        self.record.setToolTip(tr("That the photo was retouched, when, how and by which program"))
        self.record.setChecked(now.record)
        self.labelled = QCheckBox(tr("Draw a &label into the bottom right corner"))
        self.labelled.setChecked(bool(now.label))
        self.label = QLineEdit(now.label or label)
        self.label.setAccessibleName(tr("Text of the label"))
        self.label.setMaxLength(LONGEST)
        self.label.setEnabled(self.labelled.isChecked())
        self.labelled.toggled.connect(self.label.setEnabled)
        self.note = muted_label()
        self.note.setWordWrap(True)
        self._lay_out()

    def _lay_out(self) -> None:
        about = muted_label(
            tr("Saved copies and batches can tell that they were retouched, if you want them to.")
        )
        about.setWordWrap(True)
        kinds = QDialogButtonBox.StandardButton
        self.buttons = QDialogButtonBox(kinds.Ok | kinds.Cancel)
        self.buttons.accepted.connect(self._take)
        self.buttons.rejected.connect(self.reject)
        column = column_of(self, margin=4 * GRID_PX, spacing=2 * GRID_PX)
        for widget in (about, self.record, self.labelled, self.label, self.note, self.buttons):
            column.addWidget(widget)
        self.setMinimumWidth(420)

    def _take(self) -> None:
        if self.labelled.isChecked():
            try:
                check_label(self.label.text())
            except CannotDisclose as problem:
                self.note.setText(str(problem))
                return
        self.chosen.emit(self.record.isChecked(), self.labelled.isChecked(), self.label.text())
        self.accept()
