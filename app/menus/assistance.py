"""The Help menu."""

from __future__ import annotations

from ..i18n import tr
from .spec import Spec


def specs() -> tuple[Spec, ...]:
    """Return the entries in their order."""
    menu = tr("&Help")
    return (
        Spec(
            "palette", menu, tr("&Commands…"), "Ctrl+Shift+P", tr("Find every command by its name")
        ),
        Spec("about", menu, tr("&About Kogao"), "F1", tr("Version, paper and licences")),
    )
