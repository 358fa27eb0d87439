"""Scales, choices and labels for the fields of the recipe, and small controls."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Final

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QButtonGroup,
    QCheckBox,
    QLabel,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from kogao_core.additions.lens import STRETCH_SEEN_PERCENT, stretch_percent
from kogao_core.base.language import Text
from kogao_core.base.wording import columns
from kogao_core.recipe.recipe import SETTINGS, SHAPE
from kogao_core.recipe.settings import CENTERS, Alternative, cited

from ...document import DEFAULT, State
from ...i18n import lettered, sentence, tr, translated
from ...theme import GRID_PX
from ...widgets.controls import (
    WholeNumber,
    column_of,
    columns_of,
    muted_label,
    row_of,
    without_gaps,
)
from ...widgets.typed import SliderScale

_LEAST_PX: Final = 3 * GRID_PX
_MANY: Final = 6  # more buttons than these may shrink
_LARGE_PX: Final = 22  # from this height of a line on, buttons need a line of their own
_NONE: Final = "\N{EN DASH}"
_STEPS: Final = 100
_LINE: Final = 40  # maximum text columns of a label; longer texts go to the tooltip
_PER_OCTAVE: Final = 50
_THRESHOLD_STEPS_PER_PX: Final = 64


def percent() -> SliderScale:
    """Return the scale of the warp distance."""
    return SliderScale(
        0,
        150,
        10,
        lambda n: n / 10,
        lambda v: round(v * 10),
        lambda v: tr("{v} % of D", v=_figure(v)),
        least=(SETTINGS["percent"].within or (0.0,))[0],
    )


def signed() -> SliderScale:
    """Return a scale for signed values, with 0 in the middle."""
    return SliderScale(
        -150,
        150,
        10,
        lambda n: n / 10,
        lambda v: round(v * 10),
        lambda v: tr("{v} %", v=f"{'+' if v > 0.0 else ''}{_figure(v)}"),
    )


def lattice() -> SliderScale:
    """Return the scale of the lattice."""
    # Logarithmic, from 0.16: R = 1 in warp distances, as in the paper, is about 0.18 at 4 %.
    return SliderScale(
        round(-2.6 * _PER_OCTAVE),
        2 * _PER_OCTAVE,
        10,
        lambda n: 2.0 ** (n / _PER_OCTAVE),
        lambda v: round(math.log2(v) * _PER_OCTAVE),
        lambda v: tr("R {v:.2f}", v=v),
    )


def threshold() -> SliderScale:
    """Return the scale of the threshold."""
    per_px = _THRESHOLD_STEPS_PER_PX
    return SliderScale(
        0, 2 * per_px, 8, lambda n: n / per_px, lambda v: round(v * per_px), _threshold_text
    )


def _threshold_text(value: float) -> str:
    lossless = value <= DEFAULT.threshold_px
    return tr("{v:.2f} px, lossless", v=value) if lossless else tr("{v:.2f} px", v=value)


def scale(field: str) -> SliderScale:
    """Return the scale of a numeric field: a custom scale, else the field's full range."""
    if field in _SCALES:
        return _SCALES[field]()
    setting = SETTINGS[field]
    low, high = setting.within or (0.0, 1.0)
    step = 1.0 if setting.is_whole or setting.unit == "%" else (high - low) / _STEPS
    made = SliderScale(
        0,
        round((high - low) / step),
        10,
        lambda n: low + n * step,
        lambda v: round((v - low) / step),
        lambda v: tr("{v:.4g} {unit}", v=v, unit=translated(setting.unit)).rstrip(),
    )
    return replace(made, typed=round) if setting.is_whole else made


def title(field: str) -> str:
    """Return the name of a field in everyday words."""
    return translated(_PLAIN.get(field, SETTINGS[field].title))


def label(field: str) -> str:
    """Return the label of a field with mnemonic; short switches include the explanation."""
    setting = SETTINGS[field]
    text = title(field)
    if setting.within is None and not setting.alternatives:
        whole = tr("{title}: {help}", title=text, help=tip(field))
        text = whole if columns(whole) <= _LINE else text
    letter = _LETTERS.get(field, setting.letter)
    return lettered(text, letter) if letter else text


def wording(field: str, *, plain: bool) -> tuple[str, str, SliderScale]:
    """Return label, tooltip and scale of a field, in everyday words or in the paper's units."""
    words, unit = _WORDS.get(field, (SETTINGS[field].help, ""))
    found = scale(field)
    if plain and unit:
        found = replace(found, text=lambda v: translated(unit).format(v=_figure(v)))
    exact = words if plain else SETTINGS[field].help
    return label(field), translated(cited(exact, SETTINGS[field].where)), found


def tip(field: str) -> str:
    """Return the explanation of a field, with the section of the paper."""
    setting = SETTINGS[field]
    return translated(cited(setting.help, setting.where))


def change(field: str, before: object, after: object, *, plain: bool) -> str:
    """Return old and new value of a field; a number with the unit of the sliders."""
    unit = "" if isinstance(after, str) else translated(SETTINGS[field].unit)
    if plain and field == "percent":
        unit = "%"
    values = {"before": _value(field, before), "after": _value(field, after)}
    return tr("{before} → {after} {unit}", unit=unit, **values).rstrip()


def stated(field: str, value: object) -> str:
    """Return a field with value and unit, for captions."""
    unit = translated(SETTINGS[field].unit)
    return f"{translated(SETTINGS[field].title)} {_value(field, value)} {unit}".rstrip()


def _value(field: str, value: object) -> str:
    if isinstance(value, bool):
        return tr("on") if value else tr("off")
    if isinstance(value, float):
        return _figure(value)
    titles = {one.name: translated(one.title) for one in SETTINGS[field].alternatives}
    return titles.get(str(value), str(value))


def _figure(value: float) -> str:
    # At most two decimals are shown and typed. Whole amounts read 4.0, not 4.
    text = f"{value:.2f}"
    return text[:-1] if text.endswith("0") else text


def options(field: str) -> list[tuple[str, str, str]]:
    """Return the choices of a field: (label, tooltip, value) each."""
    return [
        (
            tr("{title}: {help}", title=translated(one.title), help=translated(one.help)),
            help_of(one),
            one.name,
        )
        for one in SETTINGS[field].alternatives
    ]


def help_of(one: Alternative[str]) -> str:
    """Return the explanation of a choice, with the section of the paper."""
    return translated(cited(one.help, one.where))


# Everyday words for the paper's terms, with a letter; explanation and text of a value.
_PLAIN: Final = {"percent": Text("Amount"), "lattice": Text("Falloff")}
_LETTERS: Final = {"percent": "o", "lattice": "l"}
_WORDS: Final = {
    "percent": (
        Text("How much smaller the face gets, in % of D, the face's radius"),
        Text("{v} %"),
    ),
    "lattice": (
        Text("How far the change spreads: left is local, right is soft (the lattice's R)"),
        Text("{v} ×"),  # noqa: RUF001
    ),
}
_SCALES: Final = {
    "percent": percent,
    "lattice": lattice,
    "threshold_px": threshold,
    **dict.fromkeys((name for name in SHAPE if SETTINGS[name].unit and name != "even_out"), signed),
}


class Segments(QWidget):
    """Exclusive buttons in the columns of the sliders: a name, the buttons and a value."""

    # (number: int): the number of a clicked button, from 1.
    chosen = Signal(int)

    def __init__(self, field: str, words: Sequence[str]) -> None:
        super().__init__()
        self.name, self.value = QLabel(label(field)), muted_label()
        self.name.setToolTip(tip(field))
        self.value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.setAccessibleName(title(field))
        self.group = QButtonGroup(self)
        buttons = [QToolButton() for _ in words]
        cells = without_gaps(buttons)
        for number, (button, text) in enumerate(zip(buttons, words, strict=True), 1):
            button.setText(text)
            button.setCheckable(True)
            button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            button.setProperty("snug", "true")
            if len(words) > _MANY:
                button.setMinimumWidth(_LEAST_PX)
            button.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
            button.ensurePolished()
            self.group.addButton(button, number)
            cells.setStretchFactor(button, 1)
        if self.fontMetrics().height() < _LARGE_PX:
            column_of(self, columns_of(self.name, cells, self.value))
        else:
            column_of(self, row_of(self.name, None, self.value), cells)
        # The label's mnemonic only focuses this widget. A button as buddy would be pressed.
        self.name.setBuddy(self)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.show_number(1)
        self.group.idClicked.connect(self.chosen)

    def show_number(self, number: int, *, used: bool = True) -> None:
        """Check a button, or none if the choice has no effect."""
        self.group.setExclusive(used)
        for button in self.group.buttons():
            button.setChecked(used and self.group.id(button) == number)
        self.setFocusProxy(self.group.button(number))


class ScopeChoice(Segments):
    """What gets smaller."""

    def __init__(self) -> None:
        scopes = SETTINGS["scope"].alternatives
        super().__init__("scope", [translated(one.title) for one in scopes])
        self.value.hide()
        self.names = [one.name for one in scopes]
        for button, (words, where, _) in zip(self.group.buttons(), options("scope"), strict=True):
            button.setToolTip(f"{words}\n{where}")


class CenterChoice(Segments):
    """The candidates of figure 7a. With *Head* none is in use; a click switches to *Face only*."""

    def __init__(self) -> None:
        super().__init__("center", [str(number) for number in range(1, len(CENTERS) + 1)])
        for button in self.group.buttons():
            button.setAccessibleName(tr("Centre {n}", n=button.text()))
        self.show_center(1, used=True, plain=False)

    def show_center(self, number: int, *, used: bool, plain: bool) -> None:
        """Show a candidate and its position, in everyday words or as in the paper."""
        self.show_number(number, used=used)
        ends = {1: tr("Mouth"), len(CENTERS): tr("Nose")}
        where = ends.get(number, "") if plain else _ratio(number)
        self.value.setText(where if used else _NONE)
        switch = "" if used else "\n" + tr("Switches Change to Face only")
        for each, button in enumerate(self.group.buttons(), 1):
            button.setToolTip(_center_tip(each) + switch)


def _ratio(number: int) -> str:
    tenths = 10.0 * CENTERS[number - 1].fraction
    return f"{tenths:g} : {10.0 - tenths:g}"


def _center_tip(number: int) -> str:
    words = Text("Distance to the eyes : to the mouth = {share}", share=_ratio(number))
    return translated(cited(words, CENTERS[number - 1].where))


class LensChoice(QWidget):
    """A switch, the focal length, and a note on the stretch of the faces."""

    # (lens: str or float): "off", "auto", or a focal length, mm.
    chosen = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        low, high = SETTINGS["lens"].within or (0.0, 0.0)
        self.switch, self.note = QCheckBox(label("lens")), muted_label(wraps=True)
        # The minimum stands for the focal length in the photo's metadata.
        self.focal = WholeNumber(round(low) - 1, round(high), round(low) - 1)
        self.focal.setSuffix(tr(" mm"))
        self.focal.setKeyboardTracking(False)
        self.focal.setAccessibleName(tr("Focal length (35 mm equivalent)"))
        for control in (self.switch, self.focal):
            flat = tr("Faces on screens and posters lie flat and aren't stretched: switch them off")
            control.setToolTip(f"{tip('lens')}\n{flat}")
        self.switch.toggled.connect(lambda on: self.chosen.emit("auto" if on else "off"))
        self.focal.valueChanged.connect(
            lambda mm: self.chosen.emit("auto" if mm == self.focal.minimum() else float(mm))
        )
        column_of(self, row_of(self.switch, None, self.focal), self.note)

    def show_state(self, state: State, chosen: int | None) -> bool:
        """Show the setting, and the stretch of the selected or the most stretched face.

        Return whether the correction is on or the stretch is visible.
        """
        lens, optics = state.recipe.lens, state.optics
        known = "" if optics.focal_mm is None else f"{optics.focal_mm:.0f}"
        with QSignalBlocker(self.switch), QSignalBlocker(self.focal):
            self.switch.setChecked(lens != "off")
            self.focal.setSpecialValueText(tr("{mm} mm", mm=known or "?"))
            number = self.focal.minimum() if isinstance(lens, str) else round(lens)
            self.focal.setValue(number)
        self.focal.setVisible(lens != "off")
        focal = state.focal_mm
        faces = state.faces if chosen is None else state.faces[chosen : chosen + 1]
        most = max((stretch_percent(f, focal, state.image) for f in faces if focal), default=0.0)
        self.note.setText(_stretched(len(faces), focal, most) if focal else sentence(optics.why))
        self.note.setHidden(not faces or (lens == "off" and most < STRETCH_SEEN_PERCENT))
        return lens != "off" or most >= STRETCH_SEEN_PERCENT


def _stretched(count: int, focal_mm: float, percent: float) -> str:
    """Return a text about the largest stretch of a number of faces."""
    said = {"mm": focal_mm, "percent": percent}
    if count == 1:
        return tr("{mm:.0f} mm lens: this face is stretched by {percent:.1f} %", **said)
    return tr("{mm:.0f} mm lens: faces are stretched by up to {percent:.1f} %", **said)


class OwnerLine(QWidget):
    """Shows which faces the settings apply to, with a button to return to the photo's settings."""

    def __init__(self) -> None:
        super().__init__()
        self.title, self.note = QLabel(), muted_label(wraps=True)
        self.button = QPushButton(tr("Use the photo's"))
        self.button.setToolTip(tr("Forget this face's own settings"))
        self.button.setAccessibleName(tr("Use the photo's settings"))
        self.button.setProperty("quiet", "true")
        row = row_of(self.title, self.note, self.button)
        row.setStretchFactor(self.note, 1)
        column_of(self, row)

    def showEvent(self, event: QShowEvent) -> None:
        """Reserve the height of the styled button, so that widgets below don't jump."""
        self.button.ensurePolished()
        self.setMinimumHeight(self.button.sizeHint().height())
        super().showEvent(event)

    def show_state(self, state: State, chosen: int | None, also: Collection[int]) -> None:
        """Show the edited faces, or which faces have separate settings."""
        own = [index for index, face in enumerate(state.faces) if face.recipe is not None]
        if chosen is None:
            numbers = ", ".join(str(index + 1) for index in own)
            self.title.setText(tr("All faces"))
            self.note.setText(tr("except {numbers}", numbers=numbers) if own else "")
        else:
            numbers = ", ".join(str(index + 1) for index in sorted({chosen, *also}))
            several = tr("Faces {numbers}", numbers=numbers)
            self.title.setText(several if also else tr("Face {n}", n=chosen + 1))
            self.note.setText(tr("own settings") if chosen in own else tr("photo settings"))
        self.button.setVisible(chosen in own or (chosen is None and bool(own)))
