"""Presets: named recipes as files in the user's folder, readable by `--recipe`."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Final
from urllib.parse import unquote

from kogao_core.base import json_reader
from kogao_core.base.atomic import atomic_write
from kogao_core.base.installed import data_folder
from kogao_core.base.language import BadValue, Text
from kogao_core.base.wording import shown
from kogao_core.recipe.recipe import PAPER, Recipe

BUILT_IN: Final[dict[str, Recipe]] = {
    Text("Small face"): Recipe(),
    Text("Slim"): Recipe(percent=3.0, width=-4.0, cheeks_width=-2.0),
    Text("V-line"): Recipe(percent=4.0, jaw_width=-6.0),
    Text("Shorter forehead"): Recipe(percent=4.0, forehead_height=-8.0),
    Text("Subtle"): Recipe(percent=4.0),
    Text("The paper's"): PAPER,
}
ENDING: Final = ".json"
LONGEST_NAME: Final = 60
_MOST_BYTES: Final = 2**20
# Characters not allowed in file names on some system; in file names they are percent-encoded.
_UNFIT: Final = re.compile(r'[<>:"/\\|?*%\x00-\x1f\x7f]|^\.|[. ]$')
_UNPRINTABLE: Final = re.compile("[\x00-\x1f\x7f\ud800-\udfff]")


def user_folder() -> Path:
    """Return the folder of the user's presets, shared with the editor; it may not exist."""
    return data_folder() / "presets"


def read(file: Path) -> Recipe:
    """Return the recipe in a file."""
    data = json_reader.read(file, _MOST_BYTES)
    try:
        values = json_reader.parse(data, _MOST_BYTES).value
        if isinstance(values, dict) and "format" in values:
            raise BadValue("it is no recipe; apply a project with kogao-cli warp --project")
        return Recipe.from_dict(values)
    except ValueError as error:
        raise BadValue(
            "the recipe {file} can't be used: {error}", file=file, error=error
        ) from error


def write(recipe: Recipe, file: Path) -> None:
    """Write a recipe to a file atomically."""
    atomic_write(f"{json.dumps(recipe.to_dict(), indent=1)}\n".encode(), file)


def listed(folder: Path) -> dict[str, Recipe]:
    """Return the presets in a folder, by name; skip unreadable files."""
    found = {}
    for file in sorted(folder.glob(f"*{ENDING}")) if os.path.isdir(folder) else ():
        try:
            # Skip pipes: opening one would block.
            if file.is_file():
                found[name_of(file)] = read(file)
        except (OSError, ValueError):  # no permission; newer version; edited by hand
            continue
    return found


def file_of(folder: Path, name: str) -> Path:
    """Return the file of a preset in a folder."""
    name = name.strip()
    if not name or len(name) > LONGEST_NAME or _UNPRINTABLE.search(name):
        raise BadValue(
            "a preset's name has 1 to {longest_name} letters that print, got {name}",
            longest_name=LONGEST_NAME,
            name=shown(name),
        )
    fit = _UNFIT.sub(lambda letter: f"%{ord(letter[0]):02X}", name)
    return folder / f"{fit}{ENDING}"


def name_of(file: Path) -> str:
    """Return the preset name of a file, decoded as far as possible."""
    return _UNPRINTABLE.sub("?", unquote(file.stem))[:LONGEST_NAME]


def add(folder: Path, name: str, recipe: Recipe) -> None:
    """Save a recipe under a name in a folder; overwrite a preset of the same name."""
    file = file_of(folder, name)
    folder.mkdir(parents=True, exist_ok=True)
    write(recipe, file)


def remove(folder: Path, name: str) -> None:
    """Delete a preset from a folder; ignore a missing preset."""
    for file in folder.glob(f"*{ENDING}"):
        if name_of(file) == name:
            file.unlink(missing_ok=True)
