"""How assistive technology is told: interfaces for what is our own, and announcements.

Every interface of ours belongs to a `QObject` and is made by a factory. Qt then owns it, and ends
it together with its object; one without an object is freed by Python while Qt still holds it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from PySide6.QtCore import QObject, Qt
from PySide6.QtGui import (
    QAccessible,
    QAccessibleActionInterface,
    QAccessibleAnnouncementEvent,
    QAccessibleInterface,
    QActionGroup,
)
from PySide6.QtWidgets import QAccessibleWidget, QToolButton, QWidget
from shiboken6.Shiboken import VoidPtr

# Names of actions that every platform's bridge knows; Qt translates what is said of them.
PRESS: Final = "Press"
FOCUS: Final = "SetFocus"
INCREASE: Final = "Increase"
DECREASE: Final = "Decrease"
# What `interface_cast` returns where there is no such interface: PySide crashes over None.
NOTHING: Final = VoidPtr(0)


# None is for those that Qt tells well enough.
_Interface = Callable[[Any], QAccessibleInterface | None]
_INTERFACES: Final[dict[type[QObject], _Interface]] = {}
_EXCLUSIVE = QActionGroup.ExclusionPolicy.Exclusive


def speak(kind: type[QObject], interface: _Interface) -> None:
    """Tell Qt which interface objects of a kind have; it holds for as long as the program runs."""
    if not _INTERFACES:
        QAccessible.installFactory(_interface)
    _INTERFACES[kind] = interface


def _interface(_: str, thing: QObject) -> QAccessibleInterface | None:
    made = (make for kind, make in _INTERFACES.items() if isinstance(thing, kind))
    return next((make(thing) for make in made), None)


def announce(widget: QWidget, text: str, *, urgent: bool = False) -> None:
    """Have a screen reader say something that just happened."""
    event = QAccessibleAnnouncementEvent(widget, text)
    if urgent:
        event.setPoliteness(QAccessible.AnnouncementPoliteness.Assertive)
    QAccessible.updateAccessibility(event)


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
