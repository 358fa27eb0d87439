"""Recipes with names: those that come with the program, and the user's own, a file each."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QMenu

from kogao_core.recipe import presets
from kogao_core.recipe.recipe import Recipe

from ..i18n import sentence, tr, translated, unwritten
from ..widgets.dialogs import ask_name, ask_path, confirm
from .feature import Context, Feature
from .recipe import RecipeEditing


def built_in() -> dict[str, Recipe]:
    """Return the recipes that come with the program, by name."""
    return {translated(name): recipe for name, recipe in presets.BUILT_IN.items()}


class Presets(Feature):
    """Keeps the menu up with the presets there are."""

    def __init__(self, context: Context, recipe: RecipeEditing) -> None:
        super().__init__(context)
        self._recipe = recipe
        self.add_action(
            "save-preset",
            tr("Save as a &preset…"),
            "Ctrl+Alt+S",
            tr("Keep these settings under a name"),
            self._ask_name,
        )
        self.add_action(
            "import-preset",
            tr("&Import presets…"),
            "Ctrl+Alt+I",
            tr("Take settings in files as presets of your own"),
            self._ask_files,
        )
        self.add_action(
            "export-preset",
            tr("&Export settings…"),
            "Ctrl+Alt+E",
            tr("Write the settings of the photo or of the selected face as a file"),
            self._ask_target,
        )
        self.menu = self.window.menus["presets"] = QMenu(tr("Prese&ts"), self.window)
        self.menu.aboutToShow.connect(self.fill)
        self.fill()

    def fill(self) -> None:
        """List what there is now."""
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
        for name in ("save-preset", "import-preset", "export-preset"):
            self.menu.addAction(self.actions[name])
        self._add_removal(list(mine))

    def _add_removal(self, names: list[str]) -> None:
        menu = QMenu(tr("&Delete a preset"), self.menu)
        menu.setEnabled(bool(names))
        for name in names:
            gone = menu.addAction(name.replace("&", "&&"))
            gone.triggered.connect(lambda _=False, n=name: self._remove(n))
        self.menu.addMenu(menu)

    def _ask_name(self) -> None:
        title, label = tr("Save settings as a preset"), tr("Name of the preset")
        ask_name(self.window, title, label, self._save)

    def _save(self, name: str) -> None:
        if name.strip():
            self._keep(name.strip(), self.document.state.recipe_of(self.view.face))

    def _ask_files(self) -> None:
        ask_path(self.window, tr("Import presets"), self._import, "files", filters=[_json_filter()])

    def _import(self, file: Path) -> None:
        self.window.bar.clear()
        name = presets.name_of(file)
        try:
            keep = partial(self._keep, name, presets.read(file))
        except ValueError as error:
            self.say(sentence(error))
            return
        if name in presets.listed(self.storage.presets):
            text = tr("There is a preset {name} already. Replace it?", name=name)
            confirm(self.window, text, tr("&Replace"), keep)
        else:
            keep()

    def _keep(self, name: str, recipe: Recipe) -> None:
        try:
            done = self._try(lambda: presets.add(self.storage.presets, name, recipe))
        except ValueError as error:
            self.say(sentence(error))
            return
        if done:
            self.say(tr("{name} is among your presets now.", name=name), wrong=False)

    def _ask_target(self) -> None:
        ask_path(
            self.window,
            tr("Export settings"),
            self._export,
            "new",
            filters=[_json_filter()],
            endings=[presets.ENDING],
        )

    def _export(self, file: Path) -> None:
        recipe = self.document.state.recipe_of(self.view.face)
        self._try(lambda: presets.write(recipe, file))

    def _remove(self, name: str) -> None:
        self._try(lambda: presets.remove(self.storage.presets, name))

    def _try(self, act: Callable[[], object]) -> bool:
        """Do something with a file, or say why it can't be done; return whether it was."""
        self.window.bar.clear()
        try:
            act()
        except OSError as error:
            self.say(unwritten(error.filename or self.storage.presets, error))
            return False
        return True


def _json_filter() -> str:
    return tr("Settings ({patterns})", patterns=f"*{presets.ENDING}")
