"""Buttons of which one is chosen, told to assistive technology as radio buttons."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QAccessible, QAccessibleActionInterface, QActionGroup
from PySide6.QtWidgets import QAccessibleWidget, QToolButton

from ..accessibility import FOCUS, NOTHING, PRESS, speak

_EXCLUSIVE = QActionGroup.ExclusionPolicy.Exclusive


def tell_choices() -> None:
    """Have tool buttons told as what they are; Qt tells of check boxes, one chosen or any."""
    speak(QToolButton, _spoken)


def _spoken(button: QToolButton) -> SpokenRadio | None:
    return SpokenRadio(button) if button.isCheckable() and _is_choice(button) else None


def _is_choice(button: QToolButton) -> bool:
    """Return whether one of its kind is always chosen: none of them can be let go."""
    group, action = button.group(), button.defaultAction()
    actions = action.actionGroup() if action else None
    if actions is not None and actions.exclusionPolicy() == _EXCLUSIVE:
        return True
    return bool(group) and group.exclusive()


class SpokenRadio(QAccessibleWidget):
    """What a screen reader learns of one of the choices."""

    def __init__(self, button: QToolButton) -> None:
        super().__init__(button, QAccessible.Role.RadioButton)
        self._button, self._actions = button, _RadioActions(button)

    def state(self) -> QAccessible.State:
        """Return what holds of it now."""
        state = super().state()
        state.checkable, state.checked = True, self._button.isChecked()
        return state

    def interface_cast(self, kind: QAccessible.InterfaceType) -> Any:
        """Return what it can be told to do."""
        wanted = kind == QAccessible.InterfaceType.ActionInterface
        return self._actions if wanted else NOTHING


class _RadioActions(QAccessibleActionInterface):
    """What it can be told to do."""

    def __init__(self, button: QToolButton) -> None:
        super().__init__()
        self._button = button

    def actionNames(self) -> list[str]:
        return [PRESS, FOCUS] if self._button.isEnabled() else []

    def keyBindingsForAction(self, name: str) -> list[str]:  # noqa: ARG002
        return []

    def doAction(self, name: str) -> None:
        if name == PRESS:
            self._button.click()
        elif name == FOCUS:
            self._button.setFocus(Qt.FocusReason.OtherFocusReason)
