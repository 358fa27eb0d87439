"""What saved pictures tell about themselves: nothing, unless the user wants it; remembered."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QSettings, Qt, Signal
from PySide6.QtWidgets import QCheckBox, QDialog, QDialogButtonBox, QLineEdit, QWidget

from kogao_core.photo import CannotDisclose
from kogao_core.photo.disclosure import Disclosure
from kogao_core.photo.label import LONGEST, check_label

from ...actions import Spec
from ...i18n import tr
from ...theme import GRID_PX
from ...widgets.controls import column_of, muted_label
from ..feature import Context, Feature

_RECORD: Final = "saving/record"
_LABELLED: Final = "saving/labelled"


def disclosure(settings: QSettings) -> Disclosure:
    """Return what saved pictures are to tell."""
    record = bool(settings.value(_RECORD, False, bool))
    return Disclosure(record, label(settings) if is_labelled(settings) else "")


def label(settings: QSettings) -> str:
    """Return the text of the label, whether it is wanted or not."""
    return str(settings.value(_LABEL, tr("Retouched"), str))[:LONGEST]


def is_labelled(settings: QSettings) -> bool:
    """Return whether pictures get a label."""
    return bool(settings.value(_LABELLED, False, bool))


def remember(settings: QSettings, *, record: bool, labelled: bool, label: str) -> None:
    """Keep the choices for this time and later."""
    settings.setValue(_RECORD, record)
    settings.setValue(_LABELLED, labelled)
    settings.setValue(_LABEL, label[:LONGEST])


def words(what: Disclosure) -> str:
    """Return what pictures tell, as a line for the user; empty for nothing."""
    parts = []
    if what.record:
        parts.append(tr("an edit record"))
    if what.label:
        parts.append(tr("the label “{label}”", label=what.label))
    return tr("Results carry {what} (Save options).", what=" + ".join(parts)) if parts else ""


class SavingDialog(QDialog):
    """Two choices, both off at first: an edit record, and a label on the picture.

    Parameters
    ----------
    now : Disclosure
        What is disclosed at present.
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


_LABEL: Final = "saving/label"


class SaveOptions(Feature):
    """Asks what saved copies tell of themselves, and keeps the answer."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.add_actions(
            Spec(
                "save-options",
                tr("Save opt&ions…"),
                "Ctrl+Alt+O",
                tr("What saved pictures tell of themselves"),
                self.ask,
            )
        )

    @property
    def current(self) -> Disclosure:
        """What saved pictures tell of themselves."""
        return disclosure(self.settings)

    def ask(self) -> None:
        """Show the dialog."""
        dialog = SavingDialog(self.current, label(self.settings), self.window)
        dialog.chosen.connect(self._take)
        dialog.open()

    def _take(self, record: bool, labelled: bool, label: str) -> None:
        remember(self.settings, record=record, labelled=labelled, label=label)
