"""Recipes with names: those that come with the program, and the user's own."""

from __future__ import annotations

import json
from typing import Any, Final

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QInputDialog, QLineEdit, QMenu

from kogao_core.recipe import PAPER, Recipe

from ..actions import Spec
from ..i18n import tr
from .feature import Context, Feature
from .recipe import RecipeEditing

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


class Presets(Feature):
    """Keeps the menu up with the presets there are."""

    def __init__(self, context: Context, recipe: RecipeEditing) -> None:
        super().__init__(context)
        self._recipe = recipe
        self.add_actions(
            Spec(
                "save-preset",
                tr("Save as a &preset…"),
                "Ctrl+Alt+S",
                tr("Keep these settings under a name"),
                self._ask_name,
            )
        )
        self.menu = self.window.menus["presets"] = QMenu(tr("Prese&ts"), self.window)
        self.menu.aboutToShow.connect(self.fill)
        self.fill()

    def fill(self) -> None:
        """List what there is now."""
        mine = own(self.settings)
        self.menu.clear()
        for name, recipe in (*built_in().items(), *mine.items()):
            use = self.menu.addAction(name.replace("&", "&&"))
            use.setEnabled(self.document.photo is not None)
            use.triggered.connect(lambda _=False, n=name, r=recipe: self._use(n, r))
            if recipe is list(built_in().values())[-1] and mine:
                self.menu.addSeparator()
        self.menu.addSeparator()
        self.menu.addAction(self.actions["save-preset"])
        self._add_removal(list(mine))

    def _add_removal(self, names: list[str]) -> None:
        menu = QMenu(tr("&Delete a preset"), self.menu)
        menu.setEnabled(bool(names))
        for name in names:
            gone = menu.addAction(name.replace("&", "&&"))
            gone.triggered.connect(lambda _=False, n=name: remove(self.settings, n))
        self.menu.addMenu(menu)

    def _use(self, name: str, recipe: Recipe) -> None:
        self._recipe.use(recipe, tr("Preset {name}", name=name))

    def _ask_name(self) -> None:
        dialog = QInputDialog(self.window)
        dialog.setWindowTitle(tr("Save settings as a preset"))
        dialog.setLabelText(tr("Name of the preset"))
        dialog.textValueSelected.connect(self._save)
        dialog.open()
        for line in dialog.findChildren(QLineEdit):
            line.setAccessibleName(dialog.labelText())

    def _save(self, name: str) -> None:
        if name.strip():
            recipe = self.document.state.recipe_of(self.view.face)
            add(self.settings, name.strip(), recipe)
