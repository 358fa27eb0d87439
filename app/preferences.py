"""What a user prefers wherever the editor is started: each preference declared once, here."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from PySide6.QtCore import QSettings

from kogao_core.base.language import Text
from kogao_core.recipe.recipe import Recipe

from .i18n import language_names, tr

# A choice between texts, a recipe as JSON, or a folder.
Kind = Literal["choice", "recipe", "folder"]


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
