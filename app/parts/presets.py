"""The menu of presets: recipes with names, for the photo or the chosen face."""

from __future__ import annotations

from PySide6.QtCore import QObject, QSettings
from PySide6.QtWidgets import QInputDialog, QLineEdit, QMenu

from kogao_core.recipe import Recipe

from .. import presets
from ..controllers.choices import Choices
from ..document import Document
from ..i18n import tr
from ..scene import Scene
from ..views.window import Window


class PresetsPart(QObject):
    """Keeps the menu up with the presets there are."""

    def __init__(
        self,
        document: Document,
        scene: Scene,
        choices: Choices,
        window: Window,
        settings: QSettings,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._document, self._scene, self._choices = document, scene, choices
        self._window, self._settings = window, settings
        self.menu = window.presets
        self.menu.aboutToShow.connect(self.fill)
        window.actions_by_name["save-preset"].triggered.connect(self._ask_name)
        self.fill()

    def fill(self) -> None:
        """List what there is now."""
        own = presets.own(self._settings)
        self.menu.clear()
        for name, recipe in (*presets.built_in().items(), *own.items()):
            use = self.menu.addAction(name.replace("&", "&&"))
            use.setEnabled(self._document.photo is not None)
            use.triggered.connect(lambda _=False, n=name, r=recipe: self._use(n, r))
            if recipe is list(presets.built_in().values())[-1] and own:
                self.menu.addSeparator()
        self.menu.addSeparator()
        self.menu.addAction(self._window.actions_by_name["save-preset"])
        self._add_removal(list(own))

    def _add_removal(self, names: list[str]) -> None:
        menu = QMenu(tr("&Delete a preset"), self.menu)
        menu.setEnabled(bool(names))
        for name in names:
            gone = menu.addAction(name.replace("&", "&&"))
            gone.triggered.connect(lambda _=False, n=name: presets.remove(self._settings, n))
        self.menu.addMenu(menu)

    def _use(self, name: str, recipe: Recipe) -> None:
        self._choices.use(recipe, tr("Preset {name}", name=name))

    def _ask_name(self) -> None:
        dialog = QInputDialog(self._window)
        dialog.setWindowTitle(tr("Save settings as a preset"))
        dialog.setLabelText(tr("Name of the preset"))
        dialog.textValueSelected.connect(self._save)
        dialog.open()
        for line in dialog.findChildren(QLineEdit):
            line.setAccessibleName(dialog.labelText())

    def _save(self, name: str) -> None:
        if name.strip():
            recipe = self._document.state.recipe_of(self._scene.face)
            presets.add(self._settings, name.strip(), recipe)
