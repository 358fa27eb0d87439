"""The dialog of what a user prefers; each choice holds at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from PySide6.QtCore import QSettings, Signal
from PySide6.QtWidgets import (
    QGridLayout,
    QLabel,
    QLineEdit,
    QWidget,
)

from kogao_core.recipe.presets import listed
from kogao_core.recipe.recipe import Recipe

from .. import preferences, theme
from ..i18n import bare, tr, translated
from ..preferences import PREFERENCES, Preference
from ..theme import GRID_PX
from ..widgets.controls import ChoiceBox, column_of, muted_label
from ..widgets.dialogs import Dialog, PathLine
from . import presets
from .feature import Context, Feature
from .recipe import RecipeEditing

_SIZE_PX: Final = (520, 0)


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
        now = preferences.preferred(self._settings, what)
        known = what.choices() if what.kind == "choice" else _texts(self._recipes, now)
        for text, words in known.items():
            box.addItem(words, text)
        box.setCurrentIndex(max(0, box.findData(now)))
        box.currentIndexChanged.connect(lambda: self._take(what, box.currentData()))
        return box

    def _folder(self, what: Preference) -> PathLine:
        now = preferences.preferred(self._settings, what)
        chosen = PathLine(bare(translated(what.title)), now, kind="folder")
        chosen.line.setPlaceholderText(tr("The folder of the open photo"))
        chosen.line.setClearButtonEnabled(True)
        chosen.line.textChanged.connect(lambda: self._take(what, chosen.path))
        return chosen

    def _take(self, what: Preference, text: str) -> None:
        preferences.prefer(self._settings, what, text)
        self.changed.emit()


def _texts(recipes: Mapping[str, Recipe], now: str) -> dict[str, str]:
    """Return the recipes there are, by their texts; one kept that has no name any more, too."""
    first = preferences.recipe_text(Recipe())
    texts = {preferences.recipe_text(recipe): name for name, recipe in recipes.items()}
    found = {"": texts.pop(first, tr("Kogao's own")), **texts}
    kept = preferences.recipe_in(now)
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
        text = preferences.preferred(self.settings, preferences.THEME)
        return "light" if text == "light" else "dark" if text == "dark" else "system"

    def _follow(self) -> None:
        self._editing.begin_with(preferences.recipe(self.settings))
