"""Forms built from a table of fields: titles, tips, controls, reading and writing of values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, Final, Literal

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QLineEdit, QWidget

from kogao_core.base.language import looked_up

from ..i18n import bare
from ..theme import GRID_PX
from .controls import ChoiceBox, WholeNumber
from .dialogs import PathLine

Control = ChoiceBox | QCheckBox | WholeNumber | QLineEdit | PathLine
Kind = Literal["choice", "check", "number", "text", "folder"]


@dataclass(frozen=True, slots=True)
class FormField:
    """One row of a form."""

    name: str  # key of its value
    title: str  # with & before the letter for Alt
    tip: str
    kind: Kind = "choice"
    _: KW_ONLY
    choices: Callable[[], Mapping[Any, str]] = dict  # of a choice: words by value
    limits: tuple[int, int] = (0, 100)  # of a number
    unit: str = ""  # of a number
    lowest: str = ""  # words for the lowest number; of a path or text: the placeholder
    needs: str = ""  # name of the check box that enables the field


class Form(QWidget):
    """Shows a title and a control for each field; `changed` sends the name of a changed field."""

    # (name: str): the user has changed a field.
    changed = Signal(str)

    def __init__(self, fields: Sequence[FormField], values: Mapping[str, Any]) -> None:
        super().__init__()
        self.controls: dict[str, Control] = {}
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(3 * GRID_PX)
        grid.setVerticalSpacing(2 * GRID_PX)
        grid.setColumnStretch(1, 1)
        for row, field in enumerate(fields):
            self._add(field, grid, row)
        self.show_values(values)

    def _add(self, field: FormField, grid: QGridLayout, row: int) -> None:
        words, tip = looked_up(field.title), looked_up(field.tip)
        control = self.controls[field.name] = _MAKERS[field.kind](field)
        shown = control.line if isinstance(control, PathLine) else control
        shown.setToolTip(tip)
        shown.setAccessibleName(bare(words))
        shown.setAccessibleDescription(tip)
        if isinstance(control, QCheckBox):
            grid.addWidget(control, row, 0, 1, 2)
        else:
            title = QLabel(words)
            title.setBuddy(shown)
            grid.addWidget(title, row, 0)
            grid.addWidget(control, row, 1)
        changes = {
            ChoiceBox: "currentIndexChanged",
            QCheckBox: "toggled",
            WholeNumber: "valueChanged",
        }
        signal = getattr(shown, changes.get(type(shown), "textChanged"))
        signal.connect(lambda _: self.changed.emit(field.name))
        if field.needs:
            master = self.controls[field.needs]
            assert isinstance(master, QCheckBox)
            master.toggled.connect(control.setEnabled)
            control.setEnabled(False)

    def values(self) -> dict[str, Any]:
        return {name: self._value(control) for name, control in self.controls.items()}

    def _value(self, control: Control) -> Any:
        if isinstance(control, ChoiceBox):
            return control.currentData()
        if isinstance(control, QCheckBox):
            return control.isChecked()
        if isinstance(control, WholeNumber):
            return control.value()
        return control.path if isinstance(control, PathLine) else control.text().strip()

    def show_values(self, values: Mapping[str, Any]) -> None:
        for name in self.controls.keys() & values.keys():
            control, value = self.controls[name], values[name]
            if isinstance(control, ChoiceBox):
                control.setCurrentIndex(max(0, control.findData(value)))
            elif isinstance(control, QCheckBox):
                control.setChecked(value)
            elif isinstance(control, WholeNumber):
                control.setValue(round(value))
            else:
                (control.line if isinstance(control, PathLine) else control).setText(value)


def _choice(field: FormField) -> Control:
    box = ChoiceBox()
    for value, words in field.choices().items():
        box.addItem(words, value)
    return box


def _number(field: FormField) -> Control:
    box = WholeNumber(*field.limits, field.limits[0])
    box.setSuffix(looked_up(field.unit))
    box.setSpecialValueText(looked_up(field.lowest))
    return box


def _folder(field: FormField) -> Control:
    row = PathLine(bare(looked_up(field.title)), "")
    row.line.setClearButtonEnabled(True)
    if field.lowest:
        row.line.setPlaceholderText(looked_up(field.lowest))
    return row


_MAKERS: Final[dict[Kind, Callable[[FormField], Control]]] = {
    "choice": _choice,
    "number": _number,
    "check": lambda field: QCheckBox(looked_up(field.title)),
    "text": lambda _: QLineEdit(),
    "folder": _folder,
}
