"""What a screen reader learns of a slider: its value as it is shown, not the step it stands on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QAccessible, QAccessibleActionInterface, QAccessibleValueInterface
from PySide6.QtWidgets import QAccessibleWidget

from ..accessibility import DECREASE, FOCUS, INCREASE, NOTHING

if TYPE_CHECKING:
    from .sliders import GestureSlider


class SpokenSlider(QAccessibleWidget):
    """A slider in figures and words."""

    def __init__(self, slider: GestureSlider) -> None:
        super().__init__(slider, QAccessible.Role.Slider)
        self._slider = slider
        self._value, self._actions = _Value(slider), _SliderActions(slider)

    def text(self, kind: QAccessible.Text) -> str:
        """Return its value with the unit, or what any widget says."""
        value = kind == QAccessible.Text.Value
        return self._slider.amount_text() if value else super().text(kind)

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


class _SliderActions(QAccessibleActionInterface):
    """What it can be told to do."""

    def __init__(self, slider: GestureSlider) -> None:
        super().__init__()
        self._slider = slider

    def actionNames(self) -> list[str]:
        return [FOCUS, INCREASE, DECREASE] if self._slider.isEnabled() else []

    def keyBindingsForAction(self, name: str) -> list[str]:  # noqa: ARG002
        return []

    def doAction(self, name: str) -> None:
        if name == FOCUS:
            self._slider.setFocus(Qt.FocusReason.OtherFocusReason)
        elif name in (INCREASE, DECREASE):
            step = 1 if name == INCREASE else -1
            self._slider.take_step(self._slider.value() + step)
