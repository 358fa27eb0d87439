"""Accessibility: custom interfaces and announcements.

A factory makes each interface for a `QObject`. Qt then owns the interface and deletes the
interface with the object. Python would free an interface without an object too early.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final

from PySide6.QtCore import QObject, Qt
from PySide6.QtGui import (
    QAccessible,
    QAccessibleActionInterface,
    QAccessibleAnnouncementEvent,
    QAccessibleInterface,
    QActionGroup,
)
from PySide6.QtWidgets import QAccessibleWidget, QLabel, QToolButton, QWidget
from shiboken6.Shiboken import VoidPtr

from .i18n import bare

# Action names known to every platform's bridge; Qt translates the descriptions.
PRESS: Final = "Press"
FOCUS: Final = "SetFocus"
INCREASE: Final = "Increase"
DECREASE: Final = "Decrease"
# Return value of `interface_cast` without an interface: None crashes PySide.
NOTHING: Final = VoidPtr(0)


# None: Qt's own interface is sufficient.
_Interface = Callable[[Any], QAccessibleInterface | None]
_INTERFACES: Final[dict[type[QObject], _Interface]] = {}
_EXCLUSIVE = QActionGroup.ExclusionPolicy.Exclusive


def speak(kind: type[QObject], interface: _Interface) -> None:
    """Register the accessible interface of a class, for the lifetime of the program."""
    if not _INTERFACES:
        QAccessible.installFactory(_interface)
    _INTERFACES[kind] = interface


def _interface(_: str, thing: QObject) -> QAccessibleInterface | None:
    made = (make for kind, make in _INTERFACES.items() if isinstance(thing, kind))
    return next((make(thing) for make in made), None)


class Actions(QAccessibleActionInterface):
    """The actions of an accessible object: functions by name."""

    def __init__(self, now: Callable[[], Mapping[str, Callable[[], object]]]) -> None:
        super().__init__()
        self._now = now

    def actionNames(self) -> list[str]:
        return list(self._now())

    def keyBindingsForAction(self, name: str) -> list[str]:  # noqa: ARG002
        """Return no keys: screen readers read the keys of menus."""
        return []

    def doAction(self, name: str) -> None:
        if name in self._now():
            self._now()[name]()


def actions_of(widget: QWidget, acts: Mapping[str, Callable[[], object]]) -> Actions:
    """Return the actions of a widget while enabled, and the action that sets the focus."""
    focus = partial(widget.setFocus, Qt.FocusReason.OtherFocusReason)
    return Actions(lambda: {**acts, FOCUS: focus} if widget.isEnabled() else {})


def announce(widget: QWidget, text: str, *, urgent: bool = False) -> None:
    """Send an announcement to screen readers."""
    event = QAccessibleAnnouncementEvent(widget, text)
    if urgent:
        event.setPoliteness(QAccessible.AnnouncementPoliteness.Assertive)
    QAccessible.updateAccessibility(event)


def tell_choices() -> None:
    """Expose exclusive tool buttons as radio buttons; Qt exposes these as check boxes.

    Labels lose the letter for Alt, which Qt leaves in Japanese names: ``顔(S)``.
    """
    speak(QToolButton, _spoken)
    speak(QLabel, lambda label: SpokenLabel(label) if label.buddy() else None)


def _spoken(button: QToolButton) -> SpokenRadio | None:
    return SpokenRadio(button) if button.isCheckable() and _is_choice(button) else None


def _is_choice(button: QToolButton) -> bool:
    """Return whether the button belongs to a group with exactly one checked button."""
    group, action = button.group(), button.defaultAction()
    actions = action.actionGroup() if action else None
    if actions is not None and actions.exclusionPolicy() == _EXCLUSIVE:
        return True
    return bool(group) and group.exclusive()


class SpokenLabel(QAccessibleWidget):
    """Accessible label of a control."""

    def __init__(self, label: QLabel) -> None:
        super().__init__(label, QAccessible.Role.StaticText)
        self._label = label

    def text(self, kind: QAccessible.Text) -> str:
        """Return the name without the letter for Alt, or another text of the base class."""
        name = kind == QAccessible.Text.Name
        return bare(self._label.text()) if name else super().text(kind)


class SpokenRadio(QAccessibleWidget):
    """Accessible radio button."""

    def __init__(self, button: QToolButton) -> None:
        super().__init__(button, QAccessible.Role.RadioButton)
        self._button, self._actions = button, actions_of(button, {PRESS: button.click})

    def state(self) -> QAccessible.State:
        state = super().state()
        state.checkable, state.checked = True, self._button.isChecked()
        return state

    def interface_cast(self, kind: QAccessible.InterfaceType) -> Any:
        wanted = kind == QAccessible.InterfaceType.ActionInterface
        return self._actions if wanted else NOTHING
