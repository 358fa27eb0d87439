"""The photos opened last."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from PySide6.QtCore import QSettings

from .i18n import tr

_KEY: Final = "recent"
_MOST: Final = 10


def paths(settings: QSettings) -> list[Path]:
    """Return the photos opened last, newest first."""
    stored = settings.value(_KEY)
    names = stored if isinstance(stored, list) else [stored]
    return [Path(name) for name in names if isinstance(name, str) and name][:_MOST]


def there(settings: QSettings) -> list[Path]:
    """Return those of them that are there now; a drive that is away may come back."""
    return [path for path in paths(settings) if path.is_file()]


def titles(photos: Sequence[Path]) -> list[str]:
    """Return the photos' names, with as much of the folder as tells equal names apart."""
    return [_title(photo, [one for one in photos if one != photo]) for photo in photos]


def _title(photo: Path, others: Sequence[Path]) -> str:
    named_alike = [other.parent for other in others if other.name == photo.name]
    if not named_alike:
        return photo.name
    folder = photo.parent
    enough = folder.name not in [other.name for other in named_alike]
    shown = folder.name if enough else str(folder)
    return tr("{name} – {folder}", name=photo.name, folder=shown)  # noqa: RUF001


def add(settings: QSettings, path: Path) -> None:
    """Put a photo at the top of the list."""
    others = [other for other in paths(settings) if other != path]
    settings.setValue(_KEY, [str(p) for p in (path, *others)][:_MOST])


def clear(settings: QSettings) -> None:
    """Forget all of them."""
    settings.remove(_KEY)
