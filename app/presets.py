"""Recipes with names: those that come with the program, and the user's own."""

from __future__ import annotations

import json
from typing import Any, Final

from PySide6.QtCore import QSettings

from kogao_core.recipe import PAPER, Recipe

from .i18n import tr

_KEY: Final = "presets"
LONGEST_NAME: Final = 60


def built_in() -> dict[str, Recipe]:
    """Return the recipes that come with the program, by name."""
    return {
        tr("Retoucher's, 4 %"): Recipe(),
        tr("Gentle, 2 %"): Recipe(percent=2.0),
        tr("Clear, 6 %"): Recipe(percent=6.0),
        tr("The paper's"): PAPER,
    }


def own(settings: QSettings) -> dict[str, Recipe]:
    """Return the user's recipes by name; what this program can't read is left out."""
    found = {}
    for name, values in _stored(settings).items():
        try:
            found[name[:LONGEST_NAME]] = Recipe.from_dict(values)
        except (ValueError, TypeError):  # written by a newer program, or by hand
            continue
    return found


def add(settings: QSettings, name: str, recipe: Recipe) -> None:
    """Keep a recipe under a name, in place of any other of that name."""
    _store(settings, {**_without(settings, name), name[:LONGEST_NAME]: recipe.to_dict()})


def remove(settings: QSettings, name: str) -> None:
    """Forget a recipe of the user's."""
    _store(settings, _without(settings, name))


def _stored(settings: QSettings) -> dict[str, Any]:
    try:
        stored = json.loads(str(settings.value(_KEY, "{}")))
    except (ValueError, RecursionError):
        return {}
    return stored if isinstance(stored, dict) else {}


def _without(settings: QSettings, name: str) -> dict[str, Any]:
    # Those that can't be read stay: a newer program can.
    stored = _stored(settings)
    return {n: values for n, values in stored.items() if n[:LONGEST_NAME] != name[:LONGEST_NAME]}


def _store(settings: QSettings, stored: dict[str, Any]) -> None:
    settings.setValue(_KEY, json.dumps(stored))
