"""How assistive technology is told: interfaces for what is our own, and announcements.

Every interface of ours belongs to a `QObject` and is made by a factory. Qt then owns it, and ends
it together with its object; one without an object is freed by Python while Qt still holds it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from PySide6.QtCore import QObject
from PySide6.QtGui import QAccessible, QAccessibleAnnouncementEvent, QAccessibleInterface
from PySide6.QtWidgets import QWidget
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
