"""The desktop's colour scheme where Qt doesn't know it: sway, Hyprland, COSMIC, LXQt."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import SLOT, QObject, Signal, Slot
from PySide6.QtDBus import QDBus, QDBusConnection, QDBusMessage, QDBusVariant

_PATH: Final = "/org/freedesktop/portal/desktop"
_SETTINGS: Final = "org.freedesktop.portal.Settings"
_SETTING: Final = ["org.freedesktop.appearance", "color-scheme"]
_LIGHT: Final = 2
_PATIENCE_MS: Final = 500


class Portal(QObject):
    """Follows the settings portal; without a portal, the scheme isn't light."""

    # (): the colour scheme has changed.
    changed = Signal()

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self.is_light = False
        bus = QDBusConnection.sessionBus()
        slot = SLOT("hear(QDBusMessage)")  # the stub asks for bytes, which PySide 6.11 refuses
        bus.connect("", _PATH, _SETTINGS, "SettingChanged", self, slot)  # type: ignore[call-overload]
        ask = QDBusMessage.createMethodCall(
            "org.freedesktop.portal.Desktop", _PATH, _SETTINGS, "Read"
        )
        ask.setArguments(_SETTING)
        self._take(bus.call(ask, QDBus.CallMode.Block, _PATIENCE_MS).arguments()[:1])

    @Slot(QDBusMessage)
    def hear(self, told: QDBusMessage) -> None:
        """Follow a changed setting."""
        if told.arguments()[:2] == _SETTING:
            self._take(told.arguments()[2:])
            self.changed.emit()

    def _take(self, values: list[object]) -> None:
        for value in values:
            while isinstance(value, QDBusVariant):  # older portals wrap the answer twice
                value = value.variant()
            self.is_light = value == _LIGHT
