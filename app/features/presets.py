"""Presets: named recipes, built in or saved by the user. Each saved preset is a JSON file."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtWidgets import QMenu

from kogao_core.recipe import presets
from kogao_core.recipe.recipe import Recipe

from ..i18n import sentence, tr, translated, unwritten
from ..widgets.dialogs import ask_name, open_path
from .feature import Context, Feature
from .recipe import RecipeEditing


def built_in() -> dict[str, Recipe]:
    """Return the built-in recipes by name."""
    return {translated(name): recipe for name, recipe in presets.BUILT_IN.items()}


class Presets(Feature):
    """Rebuilds the preset menu each time the menu opens."""

    def __init__(self, context: Context, recipe: RecipeEditing) -> None:
        super().__init__(context)
        self._recipe = recipe
        self.bind("save-preset", self._ask_name_of_settings)
        self.bind("preset-folder", self._show_folder)
        self.menu = self.window.menus["presets"] = QMenu(tr("Prese&ts"), self.window)
        self.menu.aboutToShow.connect(self.fill)
        self.fill()

    def fill(self) -> None:
        mine = presets.listed(self.storage.presets)
        self.menu.clear()
        for recipes in (built_in(), mine):
            for name, recipe in recipes.items():
                text = tr("Preset {name}", name=name)
                use = self.menu.addAction(name.replace("&", "&&"))
                use.setEnabled(self.document.photo is not None)
                use.triggered.connect(lambda _=False, r=recipe, t=text: self._recipe.use(r, t))
            if recipes:
                self.menu.addSeparator()
        for name in ("save-preset", "preset-folder"):
            self.menu.addAction(self.actions[name])
        self._add_removal(list(mine))

    def _add_removal(self, names: list[str]) -> None:
        menu = QMenu(tr("&Delete a preset"), self.menu)
        menu.setEnabled(bool(names))
        for name in names:
            gone = menu.addAction(name.replace("&", "&&"))
            gone.triggered.connect(lambda _=False, n=name: self._remove(n))
        self.menu.addMenu(menu)

    def _ask_name_of_settings(self) -> None:
        self.ask_name(self.document.state.recipe_of(self.view.face))

    def ask_name(self, recipe: Recipe, saved: Callable[[], object] = lambda: None) -> None:
        """Save a recipe under the name that the user enters, then call `saved`."""
        title, label = tr("Save settings as a preset"), tr("Name of the preset")
        save = partial(self._save, recipe, saved)
        ask_name(self.window, title, label, lambda name: save(name.strip()))

    def _save(self, recipe: Recipe, saved: Callable[[], object], name: str) -> None:
        if name and self._keep(name, recipe):
            saved()

    def _show_folder(self) -> None:
        """Open the folder of the user's presets: copy a file there to add a preset."""
        if self._try(lambda: self.storage.presets.mkdir(parents=True, exist_ok=True)):
            open_path(self.storage.presets)

    def _keep(self, name: str, recipe: Recipe) -> bool:
        try:
            done = self._try(lambda: presets.add(self.storage.presets, name, recipe))
        except ValueError as error:
            self.say(sentence(error))
            return False
        if done:
            self.say(tr("{name} is among your presets now.", name=name), wrong=False)
        return done

    def _remove(self, name: str) -> None:
        self._try(lambda: presets.remove(self.storage.presets, name))

    def _try(self, act: Callable[[], object]) -> bool:
        """Call `act`; show a message and return False if a file can't be written."""
        self.window.bar.clear()
        try:
            act()
        except OSError as error:
            self.say(unwritten(error.filename or self.storage.presets, error))
            return False
        return True
