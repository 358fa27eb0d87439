"""The photos opened last."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from PySide6.QtCore import QSettings

_KEY: Final = "recent"
_MOST: Final = 10


def paths(settings: QSettings) -> list[Path]:
    """Return the photos opened last, newest first."""
    stored = settings.value(_KEY)
    names = stored if isinstance(stored, list) else [stored]
    return [Path(name) for name in names if isinstance(name, str) and name][:_MOST]


def add(settings: QSettings, path: Path) -> None:
    """Put a photo at the top of the list."""
    others = [other for other in paths(settings) if other != path]
    settings.setValue(_KEY, [str(p) for p in (path, *others)][:_MOST])


def clear(settings: QSettings) -> None:
    """Forget all of them."""
    settings.remove(_KEY)
