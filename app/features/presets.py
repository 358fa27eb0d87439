"""Recipes with names: those that come with the program, and the user's own, a file each."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QIcon, QPainter, QPen, QPixmap
from PySide6.QtWidgets import QMenu

from kogao_core.faces.face import FOREHEAD_POINTS
from kogao_core.faces.landmarks.sources import template_face
from kogao_core.faces.targets import aim
from kogao_core.recipe import presets
from kogao_core.recipe.recipe import Recipe
from kogao_core.warp.surround import forehead_pairs

from ..i18n import sentence, tr, translated, unwritten
from ..widgets.dialogs import ask_name, ask_path, confirm
from .feature import Context, Feature
from .recipe import RecipeEditing

_PICTURE_PX: Final = 36
_EXAGGERATION: Final = 4.0


def built_in() -> dict[str, Recipe]:
    """Return the recipes that come with the program, by name."""
    return {translated(name): recipe for name, recipe in presets.BUILT_IN.items()}


class Presets(Feature):
    """Rebuilds the preset menu each time the menu opens."""

    def __init__(self, context: Context, recipe: RecipeEditing) -> None:
        super().__init__(context)
        self._recipe = recipe
        self.bind("save-preset", self._ask_name_of_settings)
        self.bind("import-preset", self._ask_files)
        self.bind("export-preset", self._ask_target)
        self.menu = self.window.menus["presets"] = QMenu(tr("Prese&ts"), self.window)
        # A style sheet, not a QProxyStyle: Python could collect the style while Qt uses it.
        self.menu.setStyleSheet(f"QMenu {{ icon-size: {_PICTURE_PX}px; }}")
        self.menu.aboutToShow.connect(self.fill)
        self.fill()

    def fill(self) -> None:
        """List the presets, each with a picture of the outline before and after."""
        mine = presets.listed(self.storage.presets)
        self.menu.clear()
        for recipes in (built_in(), mine):
            for name, recipe in recipes.items():
                text = tr("Preset {name}", name=name)
                use = self.menu.addAction(_picture(recipe, self.menu), name.replace("&", "&&"))
                use.setIconVisibleInMenu(True)
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

    def _keep(self, name: str, recipe: Recipe) -> bool:
        try:
            done = self._try(lambda: presets.add(self.storage.presets, name, recipe))
        except ValueError as error:
            self.say(sentence(error))
            return False
        if done:
            self.say(tr("{name} is among your presets now.", name=name), wrong=False)
        return done

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


def _picture(recipe: Recipe, menu: QMenu) -> QIcon:
    """Return the outline of the mean face before (thin) and after, its change four times as large.

    The forehead is an arch above the outline.
    """
    face = template_face((0.5 * _PICTURE_PX, 0.64 * _PICTURE_PX), 0.6 * _PICTURE_PX)
    turn = np.linspace(np.pi, 2.0 * np.pi, FOREHEAD_POINTS + 2)[1:-1]
    (left, top), half = face.outline[0], 0.3 * _PICTURE_PX
    arch = np.stack([left + half + half * np.cos(turn), top + 1.1 * half * np.sin(turn)], axis=1)
    face = dataclasses.replace(face, forehead=arch)
    pairs = aim(face, recipe)
    before, after = forehead_pairs(face, recipe, pairs)
    before = np.vstack([pairs.source_px[::-1], before if len(before) else arch])
    after = np.vstack([pairs.target_px[::-1], after if len(after) else arch])
    scale = menu.devicePixelRatioF()
    picture = QPixmap(round(scale * _PICTURE_PX), round(scale * _PICTURE_PX))
    picture.setDevicePixelRatio(scale)
    picture.fill(Qt.GlobalColor.transparent)
    with QPainter(picture) as painter:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for places, colour, width in (
            (before, menu.palette().placeholderText().color(), 1.0),
            (before + _EXAGGERATION * (after - before), menu.palette().accent().color(), 2.0),
        ):
            painter.setPen(QPen(colour, width))
            painter.drawPolygon([QPointF(x, y) for x, y in places.tolist()])
    return QIcon(picture)


def _json_filter() -> str:
    return tr("Settings ({patterns})", patterns=f"*{presets.ENDING}")
