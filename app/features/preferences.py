"""What a user prefers wherever the editor is started: each declared once, and their dialog."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from PySide6.QtCore import QSettings, Signal
from PySide6.QtWidgets import (
    QGridLayout,
    QLabel,
    QLineEdit,
    QWidget,
)

from kogao_core.base.language import Text
from kogao_core.recipe.presets import listed
from kogao_core.recipe.recipe import Recipe

from .. import theme
from ..i18n import bare, language_names, tr, translated
from ..theme import GRID_PX
from ..widgets.controls import ChoiceBox, column_of, muted_label
from ..widgets.dialogs import Dialog, PathLine
from . import presets
from .feature import Context, Feature
from .recipe import RecipeEditing

# A choice between texts, a recipe as JSON, or a folder.
Kind = Literal["choice", "recipe", "folder"]
_SIZE_PX: Final = (520, 0)


@dataclass(frozen=True, slots=True)
class Preference:
    """One of them; it is kept as a text, and an empty one is what the program starts with."""

    name: str  # by which the settings know it
    # What it is called, with its mnemonic, and what it does.
    title: Text
    tip: Text
    kind: Kind = "choice"  # what its text stands for
    # Texts that there are to choose from, and how each reads, the first one first.
    choices: Callable[[], dict[str, str]] = dict


THEME: Final = Preference(
    "theme",
    Text("&Colours of the window"),
    Text("Dark or light greys; as the system shows its own windows at first"),
    choices=lambda: {"": tr("As the system"), "light": tr("Light"), "dark": tr("Dark")},
)
SCALE: Final = Preference(
    "scale",
    Text("&Size of text and controls"),
    Text("Beside what the screen asks for; holds from the next start on"),
    choices=lambda: {
        "": tr("As the screen asks for"),
        **{str(percent): tr("{n} %", n=percent) for percent in (110, 125, 150, 175, 200)},
    },
)
RECIPE: Final = Preference(
    "recipe",
    Text("&Photos start with"),
    Text("The settings of a photo that is opened for the first time"),
    kind="recipe",
)
OPEN_FOLDER: Final = Preference(
    "open-folder",
    Text("&Open from"),
    Text("Where the dialog begins that asks for a photo or a folder"),
    kind="folder",
)
SAVE_FOLDER: Final = Preference(
    "save-folder",
    Text("Save copies &in"),
    Text("Where the dialog begins that asks for the name of a copy"),
    kind="folder",
)
LANGUAGE: Final = Preference(
    "language",
    Text("&Language"),
    Text("Of all words and numbers; holds from the next start on"),
    choices=lambda: {"": tr("As the system"), **language_names()},
)
EDITS: Final = Preference(
    "edits",
    Text("&Edits are kept"),
    Text("By themselves, and never in the photo; where its folder can't be written, in your own"),
    choices=lambda: {
        "": tr("Beside the photo, as PHOTO.kogao.json"),
        "own": tr("In a folder of your own, with nothing beside the photo"),
    },
)
# In the order of the dialog, which is made of them.
PREFERENCES: Final = (LANGUAGE, THEME, SCALE, RECIPE, EDITS, OPEN_FOLDER, SAVE_FOLDER)


def preferred(settings: QSettings, what: Preference) -> str:
    """Return what the user prefers; empty for what the program starts with, or for nonsense."""
    text = str(settings.value(_key(what), ""))
    return text if _is_sound(what, text) else ""


def prefer(settings: QSettings, what: Preference, text: str) -> None:
    """Keep what the user prefers."""
    settings.setValue(_key(what), text)


def recipe(settings: QSettings) -> Recipe:
    """Return what a photo starts with."""
    text = preferred(settings, RECIPE)
    return recipe_in(text) or Recipe()


def folder(settings: QSettings, what: Preference) -> Path | None:
    """Return a preferred folder; None without one, and while its drive is away."""
    text = preferred(settings, what)
    return Path(text) if text and os.path.isdir(text) else None


def recipe_in(text: str) -> Recipe | None:
    """Return the recipe that a text holds; None where there is none that this program knows."""
    try:
        return Recipe.from_dict(json.loads(text))
    except (ValueError, TypeError, RecursionError):
        return None


def recipe_text(of: Recipe) -> str:
    """Return a recipe as a text to keep."""
    return json.dumps(of.to_dict())


def _key(what: Preference) -> str:
    return f"preferences/{what.name}"


def _is_sound(what: Preference, text: str) -> bool:
    if what.kind == "choice":
        return text in what.choices()
    return what.kind == "folder" or recipe_in(text) is not None


class PreferencesDialog(Dialog):
    """A row for each of `PREFERENCES`."""

    changed = Signal()

    def __init__(self, settings: QSettings, recipes: Mapping[str, Recipe], parent: QWidget) -> None:
        super().__init__(tr("Preferences"), parent, _SIZE_PX)
        self._settings, self._recipes = settings, recipes
        self.controls: dict[str, ChoiceBox | QLineEdit] = {}
        rows = QGridLayout()
        rows.setHorizontalSpacing(3 * GRID_PX)
        rows.setVerticalSpacing(2 * GRID_PX)
        rows.setColumnStretch(1, 1)
        for row, what in enumerate(PREFERENCES):
            self._add(what, rows, row)
        column_of(self, rows, None, self.closing(), margin=4 * GRID_PX, spacing=3 * GRID_PX)

    def _add(self, what: Preference, rows: QGridLayout, row: int) -> None:
        words, tip = translated(what.title), translated(what.tip)
        shown = self._folder(what) if what.kind == "folder" else self._choice(what)
        control = shown.line if isinstance(shown, PathLine) else shown
        self.controls[what.name] = control
        control.setToolTip(tip)
        control.setAccessibleName(bare(words))
        control.setAccessibleDescription(tip)
        title = QLabel(words)
        title.setBuddy(control)
        rows.addWidget(title, 2 * row, 0)
        rows.addWidget(shown, 2 * row, 1)
        rows.addWidget(muted_label(tip, wraps=True), 2 * row + 1, 1)

    def _choice(self, what: Preference) -> ChoiceBox:
        box = ChoiceBox()
        now = preferred(self._settings, what)
        known = what.choices() if what.kind == "choice" else _texts(self._recipes, now)
        for text, words in known.items():
            box.addItem(words, text)
        box.setCurrentIndex(max(0, box.findData(now)))
        box.currentIndexChanged.connect(lambda: self._take(what, box.currentData()))
        return box

    def _folder(self, what: Preference) -> PathLine:
        now = preferred(self._settings, what)
        chosen = PathLine(bare(translated(what.title)), now, kind="folder")
        chosen.line.setPlaceholderText(tr("The folder of the open photo"))
        chosen.line.setClearButtonEnabled(True)
        chosen.line.textChanged.connect(lambda: self._take(what, chosen.path))
        return chosen

    def _take(self, what: Preference, text: str) -> None:
        prefer(self._settings, what, text)
        self.changed.emit()


def _texts(recipes: Mapping[str, Recipe], now: str) -> dict[str, str]:
    """Return the recipes there are, by their texts; one kept that has no name any more, too."""
    first = recipe_text(Recipe())
    texts = {recipe_text(recipe): name for name, recipe in recipes.items()}
    found = {"": texts.pop(first, tr("Kogao's own")), **texts}
    kept = recipe_in(now)
    if kept is not None and now not in found:
        found[now] = tr("As chosen before, {p:g} %", p=kept.percent)
    return found


class Preferences(Feature):
    """Shows the dialog, and lets photos start with the preferred settings."""

    changed = Signal()

    def __init__(self, context: Context, editing: RecipeEditing) -> None:
        super().__init__(context)
        self._editing = editing
        self.add_action(
            "preferences",
            tr("Pre&ferences…"),
            "Ctrl+,",
            tr("Language, colours, size, settings to start with, folders"),
            self.ask,
        )
        self.changed.connect(self._follow)
        self._follow()

    def ask(self) -> None:
        """Show the dialog."""
        recipes = presets.built_in() | listed(self.storage.presets)
        dialog = PreferencesDialog(self.settings, recipes, self.window)
        dialog.changed.connect(self.changed)
        dialog.open()

    @property
    def theme(self) -> theme.Choice:
        """The preferred colours of the window."""
        text = preferred(self.settings, THEME)
        return "light" if text == "light" else "dark" if text == "dark" else "system"

    def _follow(self) -> None:
        self._editing.begin_with(recipe(self.settings))
