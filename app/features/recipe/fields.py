"""The fields of the recipe: their scales, their choices, what they do; and small controls of it."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace
from typing import Final

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QButtonGroup,
    QCheckBox,
    QHBoxLayout,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from kogao_core.base.language import Text
from kogao_core.base.wording import columns
from kogao_core.recipe.recipe import SETTINGS, SHAPE, ZONES
from kogao_core.recipe.settings import CENTERS, Alternative, cited
from kogao_core.warp.lens import STRETCH_SEEN_PERCENT, stretch_percent

from ...document import DEFAULT, State
from ...i18n import lettered, sentence, tr, translated
from ...theme import GRID_PX
from ...widgets.controls import WholeNumber, column_of, heading, muted_label, row_of
from ...widgets.typed import SliderScale

_LEAST_PX: Final = 3 * GRID_PX
_STEPS: Final = 100
_LINE: Final = 40  # columns of text that fit beside the photo; tooltips say the rest
_PER_OCTAVE: Final = 50
_THRESHOLD_STEPS_PER_PX: Final = 64


def percent() -> SliderScale:
    """Return the slider of the warp distance."""
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
    """Return the slider of what goes either way, 0 in its middle."""
    return SliderScale(
        -150,
        150,
        10,
        lambda n: n / 10,
        lambda v: round(v * 10),
        lambda v: tr("{v} %", v=f"{'+' if v > 0.0 else ''}{_figure(v)}"),
    )


def lattice() -> SliderScale:
    """Return the slider of the lattice."""
    # Twice as coarse is as far to the right as twice as fine is to the left.
    return SliderScale(
        -2 * _PER_OCTAVE,
        2 * _PER_OCTAVE,
        10,
        lambda n: 2.0 ** (n / _PER_OCTAVE),
        lambda v: round(math.log2(v) * _PER_OCTAVE),
        lambda v: tr("R {v:.2f}", v=v),
    )


def threshold() -> SliderScale:
    """Return the slider of the threshold."""
    per_px = _THRESHOLD_STEPS_PER_PX
    return SliderScale(
        0, 2 * per_px, 8, lambda n: n / per_px, lambda v: round(v * per_px), _threshold_text
    )


def _threshold_text(value: float) -> str:
    lossless = value <= DEFAULT.threshold_px
    return tr("{v:.2f} px, lossless", v=value) if lossless else tr("{v:.2f} px", v=value)


def scale(field: str) -> SliderScale:
    """Return the slider of a number of the recipe: over all its range, unless it has its own."""
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


def title(field: str, *, plain: bool = False) -> str:
    """Return what a field is called, in everyday words or in the paper's."""
    return translated(_PLAIN.get(field, SETTINGS[field].title) if plain else SETTINGS[field].title)


def label(field: str) -> str:
    """Return what a field is called, and a switch what it does where that fits; its mnemonic."""
    setting = SETTINGS[field]
    text = title(field)
    if setting.within is None and not setting.alternatives:
        whole = tr("{title}: {help}", title=text, help=tip(field))
        text = whole if columns(whole) <= _LINE else text
    return lettered(text, letter) if (letter := SETTINGS[field].letter) else text


def amount() -> tuple[str, str, SliderScale]:
    """Return what the warp distance is called in everyday words, what it does, and its texts."""
    words = Text("How much smaller the face gets, in % of D, the face's radius")
    scale = replace(percent(), text=lambda v: tr("{v} %", v=_figure(v)))
    tip = translated(cited(words, SETTINGS["percent"].where))
    return lettered(title("percent", plain=True), SETTINGS["head_follows"].letter), tip, scale


def falloff() -> tuple[str, str, SliderScale]:
    """Return what the lattice is called in everyday words, what it does, and its texts."""
    words = Text("How far the change spreads: left is local, right is soft (the lattice's R)")
    scale = replace(lattice(), text=lambda v: tr("{v:.2f} ×", v=v))  # noqa: RUF001
    tip = translated(cited(words, SETTINGS["lattice"].where))
    return lettered(title("lattice", plain=True), SETTINGS["lattice"].letter.lower()), tip, scale


def follows(*, plain: bool) -> tuple[str, str, SliderScale]:
    """Return what the slider below that is called, what it does, and its texts."""
    # Beside everyday words it has the letter of the paper's.
    letter = SETTINGS["percent" if plain else "head_follows"].letter.lower()
    return lettered(title("head_follows"), letter), tip("head_follows"), scale("head_follows")


def tip(field: str) -> str:
    """Return what a field of the recipe does, and where the paper has it."""
    setting = SETTINGS[field]
    return translated(cited(setting.help, setting.where))


def change(field: str, before: object, after: object) -> str:
    """Return how a field of the recipe has changed, in words: its values and their unit."""
    unit = translated(SETTINGS[field].unit)
    values = {"before": _value(field, before), "after": _value(field, after)}
    return tr("{before} → {after} {unit}", unit=unit, **values).rstrip()


def stated(field: str, value: object) -> str:
    """Return a field of the recipe with its value and unit, as a caption tells it."""
    unit = translated(SETTINGS[field].unit)
    return f"{title(field)} {_value(field, value)} {unit}".rstrip()


def _value(field: str, value: object) -> str:
    if isinstance(value, bool):
        return tr("on") if value else tr("off")
    if isinstance(value, float):
        return _figure(value)
    titles = {one.name: translated(one.title) for one in SETTINGS[field].alternatives}
    return titles.get(str(value), str(value))


def _figure(value: float) -> str:
    # Hundredths are the finest that is shown and typed; amounts read 4.0, not 4.
    text = f"{value:.2f}"
    return text[:-1] if text.endswith("0") else text


def options(field: str) -> list[tuple[str, str, str]]:
    """Return the choices of a field: what they are called, where they are from, their values."""
    return [
        (
            tr("{title}: {help}", title=translated(one.title), help=translated(one.help)),
            help_of(one),
            one.name,
        )
        for one in SETTINGS[field].alternatives
    ]


def help_of(one: Alternative[str]) -> str:
    """Return what one of the choices is, and where the paper has it."""
    return translated(cited(one.help, one.where))


# What the paper's terms are to a retoucher.
_PLAIN: Final = {
    "percent": Text("Amount"),
    "center": Text("Direction"),
    "lattice": Text("Falloff"),
}
# They have folds or a switch of their own, into which one letter leads each.
FOLDED_PARTS: Final = ("zones", *ZONES, *SHAPE, "lens_amount")
_SCALES: Final = {
    "percent": percent,
    "lattice": lattice,
    "threshold_px": threshold,
    **dict.fromkeys(SHAPE, signed),
}


class CenterChoice(QWidget):
    """A row of buttons: the candidates of figure 7a."""

    chosen = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        self._name = heading("")
        self._name.setToolTip(tip("center"))
        row = QHBoxLayout()
        row.setSpacing(GRID_PX // 4)
        column_of(self, self._name, row)
        self.group = QButtonGroup(self)
        for number in range(1, len(CENTERS) + 1):
            button = QToolButton()
            button.setText(str(number))
            button.setCheckable(True)
            button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            button.setProperty("segment", "true")
            button.setProperty("snug", "true")
            # As wide as it likes while there is room, narrower where there are many.
            button.setMinimumWidth(_LEAST_PX)
            button.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
            button.setAccessibleName(tr("Centre {n}", n=number))
            button.setToolTip(_center_tip(number))
            self.group.addButton(button, number)
            row.addWidget(button)
        # A button as buddy would be pressed by the letter, which only leads here.
        self._name.setBuddy(self)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.show_words(plain=False)
        self.show_number(1)
        self.group.idClicked.connect(self.chosen)

    def show_words(self, *, plain: bool) -> None:
        """Name the candidates by where they lie, or by their numbers in the paper."""
        letter = SETTINGS["center"].letter.lower() if plain else SETTINGS["center"].letter
        self._name.setText(lettered(title("center", plain=plain), letter))
        for number, where in ((1, tr("Mouth")), (len(CENTERS), tr("Nose"))):
            self.group.button(number).setText(where if plain else str(number))

    def show_number(self, number: int) -> None:
        """Show which candidate is chosen."""
        self.group.button(number).setChecked(True)
        self.setFocusProxy(self.group.button(number))


def _center_tip(number: int) -> str:
    candidate = CENTERS[number - 1]
    tenths = 10.0 * candidate.fraction
    share = f"{tenths:g} : {10.0 - tenths:g}"
    words = Text("Distance to the eyes : to the mouth = {share}", share=share)
    return translated(cited(words, candidate.where))


class LensChoice(QWidget):
    """A switch, the focal length, and what they are about: how far the lens stretched whom."""

    chosen = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        low, high = SETTINGS["lens"].within or (0.0, 0.0)
        self.switch, self.note = QCheckBox(label("lens")), muted_label(wraps=True)
        # Below the least there is what the photo tells.
        self.focal = WholeNumber(round(low) - 1, round(high), round(low) - 1)
        self.focal.setSuffix(tr(" mm"))
        self.focal.setKeyboardTracking(False)
        self.focal.setAccessibleName(tr("Focal length, as 35-mm film would need it"))
        for control in (self.switch, self.focal):
            flat = tr("Faces on screens and posters lie flat and aren't stretched: switch them off")
            control.setToolTip(f"{tip('lens')}\n{flat}")
        self.switch.toggled.connect(lambda on: self.chosen.emit("auto" if on else "off"))
        self.focal.valueChanged.connect(
            lambda mm: self.chosen.emit("auto" if mm == self.focal.minimum() else float(mm))
        )
        column_of(self, row_of(self.switch, None, self.focal), self.note)

    def show_state(self, state: State, chosen: int | None) -> bool:
        """Show what is chosen, and how far the lens stretched a face, or the one it did most.

        Result: whether that is worth a look.
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
    """Return how far a lens stretched so many faces at most."""
    said = {"mm": focal_mm, "percent": percent}
    if count == 1:
        return tr("{mm:.0f} mm: this face is {percent:.1f} % longer outwards", **said)
    return tr("{mm:.0f} mm: faces are up to {percent:.1f} % longer outwards", **said)


class OwnerLine(QWidget):
    """Says whose settings these are; the button leads back to the photo's."""

    def __init__(self) -> None:
        super().__init__()
        self.title, self.note = heading(""), muted_label(wraps=True)
        self.button = QPushButton(tr("Use the photo's"))
        self.button.setToolTip(tr("Forget this face's own settings"))
        self.button.setAccessibleName(tr("Use the photo's settings"))
        row = row_of(self.title, self.note, self.button)
        row.setStretchFactor(self.note, 1)
        column_of(self, row)

    def showEvent(self, event: QShowEvent) -> None:
        """Nothing below may jump when the button comes and goes: keep its height, as dressed."""
        self.button.ensurePolished()
        self.setMinimumHeight(self.button.sizeHint().height())
        super().showEvent(event)

    def show_state(self, state: State, chosen: int | None, also: Collection[int]) -> None:
        """Show whose settings are edited and which faces have their own."""
        own = [index for index, face in enumerate(state.faces) if face.recipe is not None]
        if chosen is None:
            numbers = ", ".join(str(index + 1) for index in own)
            self.title.setText(tr("All faces"))
            self.note.setText(tr("but {numbers}", numbers=numbers) if own else "")
        else:
            numbers = ", ".join(str(index + 1) for index in sorted({chosen, *also}))
            several = tr("Faces {numbers}", numbers=numbers)
            self.title.setText(several if also else tr("Face {n}", n=chosen + 1))
            self.note.setText(tr("its own") if chosen in own else tr("as the photo"))
        self.button.setVisible(chosen in own or (chosen is None and bool(own)))
