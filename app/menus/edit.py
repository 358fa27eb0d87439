"""The Edit menu."""

from __future__ import annotations

from ..i18n import tr
from .spec import Spec


def specs() -> tuple[Spec, ...]:
    """Return the entries in their order."""
    menu = tr("&Edit")
    return (
        Spec("undo", menu, tr("&Undo"), "Ctrl+Z", tr("Take the last gesture back")),
        Spec("redo", menu, tr("&Redo"), "Ctrl+Shift+Z", tr("Do it again"), ends_group=True),
        Spec(
            "copy-settings",
            menu,
            tr("&Copy settings"),
            "Ctrl+Shift+C",
            tr("Copy the settings of the photo or of the selected face"),
        ),
        Spec(
            "paste-settings",
            menu,
            tr("&Paste settings"),
            "Ctrl+Shift+V",
            tr("Use the copied settings for this photo or the selected face"),
            ends_group=True,
        ),
        Spec("presets", menu, "", "", ""),
        Spec(
            "save-preset",
            "",
            tr("Save as a &preset…"),
            "Ctrl+Alt+S",
            tr("Keep these settings under a name"),
        ),
        Spec("keys", menu, tr("&Keys…"), "Ctrl+K", tr("Choose other keys"), ends_group=True),
        Spec(
            "abort",
            menu,
            tr("&Abort the gesture"),
            "Escape",
            tr("Leave everything as it was; without a gesture, let the point go, then the face"),
        ),
    )
