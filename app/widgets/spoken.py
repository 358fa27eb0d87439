"""What a screen reader learns of a slider: its value as it is shown, not the step it stands on."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, Final

from PySide6.QtCore import QObject, Qt
from PySide6.QtGui import (
    QAccessible,
    QAccessibleActionInterface,
    QAccessibleAnnouncementEvent,
    QAccessibleInterface,
    QAccessibleValueInterface,
)
from PySide6.QtWidgets import QAccessibleWidget, QWidget
from shiboken6.Shiboken import VoidPtr

if TYPE_CHECKING:
    from .controls import GestureSlider

Text = QAccessible.Text
# Names that every platform's bridge knows; Qt translates what is said of them.
_INCREASE: Final = "Increase"
_DECREASE: Final = "Decrease"
_FOCUS: Final = "SetFocus"
# What `interface_cast` returns where there is no such interface: PySide crashes over None.
NOTHING: Final = VoidPtr(0)


@cache
def speak_values(kind: type[GestureSlider]) -> None:
    """Tell Qt how sliders of a kind are spoken; it holds for as long as the program runs."""

    def interface(_: str, thing: QObject) -> QAccessibleInterface | None:
        return SpokenSlider(thing) if isinstance(thing, kind) else None

    QAccessible.installFactory(interface)


def announce(widget: QWidget, text: str) -> None:
    """Have a screen reader say something that just happened, after what it is saying now."""
    QAccessible.updateAccessibility(QAccessibleAnnouncementEvent(widget, text))


class SpokenSlider(QAccessibleWidget):
    """A slider in figures and words."""

    def __init__(self, slider: GestureSlider) -> None:
        super().__init__(slider, QAccessible.Role.Slider)
        self._slider = slider
        self._value, self._actions = _Value(slider), _Actions(slider)

    def text(self, kind: QAccessible.Text) -> str:
        """Return its value with the unit, or what any widget says."""
        return self._slider.amount_text() if kind == Text.Value else super().text(kind)

    def interface_cast(self, kind: QAccessible.InterfaceType) -> Any:
        """Return what tells and sets its value, and what it can be told to do."""
        casts = {
            QAccessible.InterfaceType.ValueInterface: self._value,
            QAccessible.InterfaceType.ActionInterface: self._actions,
        }
        return casts.get(kind, NOTHING)


class _Value(QAccessibleValueInterface):
    """Its figure, as it is shown."""

    def __init__(self, slider: GestureSlider) -> None:
        super().__init__()
        self._slider = slider

    def currentValue(self) -> float:
        return self._slider.scale.figure(self._slider.amount())

    def setCurrentValue(self, value: object) -> None:
        self._slider.take_figure(float(str(value)))

    def minimumValue(self) -> float:
        return self._slider.scale.figure(self._slider.scale.value(self._slider.minimum()))

    def maximumValue(self) -> float:
        return self._slider.scale.figure(self._slider.scale.value(self._slider.maximum()))

    def minimumStepSize(self) -> float:
        # Steps of a scale needn't be equal: those at its lower end are the smallest.
        scale, low = self._slider.scale, self._slider.minimum()
        return abs(scale.value(low + 1) - scale.value(low))


class _Actions(QAccessibleActionInterface):
    """What it can be told to do."""

    def __init__(self, slider: GestureSlider) -> None:
        super().__init__()
        self._slider = slider

    def actionNames(self) -> list[str]:
        return [_FOCUS, _INCREASE, _DECREASE] if self._slider.isEnabled() else []

    def keyBindingsForAction(self, name: str) -> list[str]:  # noqa: ARG002
        return []

    def doAction(self, name: str) -> None:
        if name == _FOCUS:
            self._slider.setFocus(Qt.FocusReason.OtherFocusReason)
        elif name in (_INCREASE, _DECREASE):
            step = 1 if name == _INCREASE else -1
            self._slider.take_step(self._slider.value() + step)
