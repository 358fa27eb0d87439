"""Preferences: a table of fields, their storage, and their dialog."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from PySide6.QtCore import QSettings, Signal
from PySide6.QtWidgets import QWidget

from kogao_core.recipe.presets import listed
from kogao_core.recipe.recipe import Recipe

from .. import theme
from ..i18n import language_names, tr
from ..theme import GRID_PX
from ..widgets.controls import Fold, column_of
from ..widgets.dialogs import Dialog
from ..widgets.form import Form, FormField
from . import presets
from .disclosure import SaveOptions
from .feature import Context, Feature
from .recipe import RecipeEditing

_SIZE_PX: Final = (560, 0)
# Each is stored as a text; empty means the default.
THEME: Final = FormField(
    "theme",
    "&Theme",
    "Colours of the window",
    choices=lambda: {"": tr("Follow system"), "light": tr("Light"), "dark": tr("Dark")},
)
SCALE: Final = FormField(
    "scale",
    "&Scale (after a restart)",
    "Size of text and controls, on top of the screen's scaling",
    choices=lambda: {
        "": tr("Follow system"),
        **{str(percent): tr("{n} %", n=percent) for percent in (110, 125, 150, 175, 200)},
    },
)
RECIPE: Final = FormField("recipe", "New &photos start with", "Settings of a new photo")
OPEN_FOLDER: Final = FormField(
    "open-folder",
    "Open from",
    "Starting folder for opening photos",
    "folder",
    lowest="Folder of the open photo",
)
SAVE_FOLDER: Final = FormField(
    "save-folder",
    "Save copies &in",
    "Starting folder for saving copies",
    "folder",
    lowest="Folder of the open photo",
)
LANGUAGE: Final = FormField(
    "language",
    "La&nguage (after a restart)",
    "Language of texts and numbers",
    choices=lambda: {"": tr("Follow system"), **language_names()},
)
EDITS: Final = FormField(
    "edits",
    "Store &edits",
    "Saved automatically",
    choices=lambda: {
        "": tr("Next to the photo, as PHOTO.kogao.json"),
        "own": tr("In Kogao's own folder"),
    },
)
# In the order of the dialog.
PREFERENCES: Final = (LANGUAGE, THEME, SCALE, RECIPE, EDITS, OPEN_FOLDER, SAVE_FOLDER)


def preferred(settings: QSettings, what: FormField) -> str:
    """Return a stored preference; empty for the default or an invalid value."""
    text = str(settings.value(_key(what), ""))
    return text if _is_sound(what, text) else ""


def prefer(settings: QSettings, what: FormField, text: str) -> None:
    """Store a preference."""
    settings.setValue(_key(what), text)


def recipe(settings: QSettings) -> Recipe:
    """Return the settings for new photos."""
    return recipe_in(preferred(settings, RECIPE)) or Recipe()


def folder(settings: QSettings, what: FormField) -> Path | None:
    """Return a preferred folder; None if there is none or it doesn't exist now."""
    text = preferred(settings, what)
    return Path(text) if text and os.path.isdir(text) else None


def recipe_in(text: str) -> Recipe | None:
    """Return the recipe in a text; None if it is invalid."""
    try:
        return Recipe.from_dict(json.loads(text))
    except (ValueError, TypeError, RecursionError):
        return None


def recipe_text(of: Recipe) -> str:
    """Return a recipe as a text for the settings."""
    return json.dumps(of.to_dict())


def _key(what: FormField) -> str:
    return f"preferences/{what.name}"


def _is_sound(what: FormField, text: str) -> bool:
    if what is RECIPE:
        return recipe_in(text) is not None
    return what.kind == "folder" or text in what.choices()


class PreferencesDialog(Dialog):
    """Stores each change at once."""

    # (): a preference has changed, also with each typed letter.
    changed = Signal()

    def __init__(
        self,
        settings: QSettings,
        recipes: Mapping[str, Recipe],
        more: Sequence[QWidget],
        parent: QWidget,
    ) -> None:
        super().__init__(tr("Preferences"), parent, _SIZE_PX)
        now = {what.name: preferred(settings, what) for what in PREFERENCES}
        texts = _texts(recipes, now["recipe"])
        offered = dataclasses.replace(RECIPE, choices=lambda: texts)
        fields = {what.name: what for what in PREFERENCES} | {"recipe": offered}
        self.form = form = Form([*fields.values()], now)

        def take(name: str) -> None:
            prefer(settings, fields[name], form.values()[name])
            self.changed.emit()

        form.changed.connect(take)
        content = self.form, *more, None, self.closing()
        column_of(self, *content, margin=4 * GRID_PX, spacing=3 * GRID_PX)


def _texts(recipes: Mapping[str, Recipe], now: str) -> dict[str, str]:
    """Return names of recipes by their texts, including a stored recipe without a name."""
    first = recipe_text(Recipe())
    texts = {recipe_text(recipe): name for name, recipe in recipes.items()}
    found = {"": texts.pop(first, tr("Default settings")), **texts}
    kept = recipe_in(now)
    if kept is not None and now not in found:
        found[now] = tr("Custom, {p:g} %", p=kept.percent)
    return found


class Preferences(Feature):
    """Shows the dialog and sets the settings for new photos."""

    # (): a preference has changed, also with each typed letter.
    changed = Signal()

    def __init__(self, context: Context, editing: RecipeEditing, options: SaveOptions) -> None:
        super().__init__(context)
        self._editing, self._options = editing, options
        self.bind("preferences", self.ask)
        self.changed.connect(self._follow)
        self._follow()

    def ask(self) -> None:
        recipes = presets.built_in() | listed(self.storage.presets)
        saved = Fold(tr("&Metadata and labels"), self._options.page())
        dialog = PreferencesDialog(self.settings, recipes, [saved], self.window)
        dialog.changed.connect(self.changed)
        dialog.open()

    @property
    def theme(self) -> theme.Choice:
        """The preferred colours of the window."""
        text = preferred(self.settings, THEME)
        return "light" if text == "light" else "dark" if text == "dark" else "system"

    def _follow(self) -> None:
        self._editing.begin_with(recipe(self.settings))
