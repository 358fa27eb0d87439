"""Export of one photo, the selected photos or all: size, format, name, and presets."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Final

from PySide6.QtCore import QSettings, Signal
from PySide6.QtWidgets import QDialogButtonBox, QWidget

from kogao_core import batch
from kogao_core.base.language import Text
from kogao_core.photo.export import AS_IT_IS, Export
from kogao_core.photo.formats import WRITTEN
from kogao_core.recipe.export import EXPORT_SETTINGS, ExportSetting
from kogao_core.recipe.presets import listed
from kogao_core.recipe.recipe import Recipe
from kogao_core.retouch import RetouchJob

from ..i18n import sentence, tr, translated
from ..storage import Storage
from ..theme import GRID_PX
from ..widgets.controls import ChoiceBox, column_of, muted_label, named, row_of
from ..widgets.dialogs import Dialog, ask_name, button, confirm
from ..widgets.form import Form, FormField, Kind
from . import presets as recipes
from .batch import Batch, Order, report_of
from .disclosure import SaveOptions
from .feature import Context, Feature
from .files import Files
from .strip import Strip

_SIZE_PX: Final = (520, 0)
_GROUP: Final = "export"
_BUILT_IN: Final = {
    Text("Full size"): Export(),
    Text("2,048 px, sRGB"): Export(2048, ".jpg", 88, True, 50.0),
    Text("1,080 px, sRGB, no metadata"): Export(1080, ".jpg", 82, True, 50.0, metadata=False),
}
_LAST: Final = ""  # key of the settings of the last export; no preset has this name
_KINDS: Final[dict[type, Kind]] = {bool: "check", int: "number", float: "number", str: "text"}


def _row(setting: ExportSetting) -> FormField:
    """Return the row of the dialog for a field of `Export`."""
    default = getattr(AS_IT_IS, setting.name)
    row: dict[str, Any] = {"title": setting.title, "tip": setting.tip, "unit": setting.unit}
    row |= {"limits": (0, setting.most), "lowest": setting.lowest}
    kind = _KINDS[type(default)] if setting.name != "ending" else "choice"
    return FormField(setting.name, kind=kind, choices=_formats, **row)


def _formats() -> dict[str, str]:
    return {
        "": tr("same as photo"),
        **{form.suffixes[0]: form.title for form in WRITTEN},
    }


FIELDS: Final = (
    *sorted(map(_row, EXPORT_SETTINGS.values()), key=lambda row: row.kind == "check"),
    FormField("folder", "F&older", "Created if necessary", "folder"),
    FormField("recipe", "Photos without &edits", "Settings for photos never opened"),
    FormField("doubtful", "Include doubtful f&aces", "Unsure, cut off or hidden", "check"),
)


def presets(settings: QSettings) -> dict[str, Export]:
    """Return the built-in and the user's presets by name, in English if built-in."""
    return _BUILT_IN | _own(settings)


def _own(settings: QSettings) -> dict[str, Export]:
    """Return the user's presets by name, without presets that this version can't read."""
    own = {}
    for name, fields in _stored(settings).items():
        with suppress(ValueError, TypeError):
            own[name] = Export(**fields)
    return own


def _stored(settings: QSettings) -> dict[str, Any]:
    """Return the fields of the user's presets by name; empty if the text is damaged."""
    try:
        stored = json.loads(str(settings.value(f"{_GROUP}/presets", "{}")))
    except ValueError:
        return {}
    return stored if isinstance(stored, dict) else {}


class ExportDialog(Dialog):
    """Dialog that asks for photos, export settings and a folder.

    `photos`: choices of photos by label; the first is the open photo. `selected`: index of the
    initial choice. `recipes`: settings by name, for photos without edits. `percent`: Amount of the
    open photo, for its file name.
    """

    # (export: Export, file: Path): export the open photo to a file.
    one = Signal(object, object)
    # (order: Order): export several photos.
    many = Signal(object)

    def __init__(
        self,
        settings: QSettings,
        storage: Storage,
        photos: Mapping[str, Sequence[Path]],
        selected: int,
        recipes: Mapping[str, Recipe],
        percent: float,
        parent: QWidget,
    ) -> None:
        super().__init__(tr("Export"), parent, _SIZE_PX)
        self._settings, self._storage = settings, storage
        self._photos, self._percent = list(photos.values()), percent
        self._recipes = list(recipes.values())
        self.photos, self.presets = ChoiceBox(), ChoiceBox()
        self.photos.addItems(list(photos))
        offered = {"recipe": lambda: dict(enumerate(recipes))}
        fields = [replace(it, choices=offered.get(it.name, it.choices)) for it in FIELDS]
        self.form = Form(fields, {"folder": str(self._photos[0][0].parent / "kogao")})
        self.note = muted_label(wraps=True)
        self.remove = button(tr("&Delete"), self._remove)
        self._lay_out()
        self._offer(str(settings.value(f"{_GROUP}/chosen", "")))
        self.presets.currentIndexChanged.connect(self._show)
        self.photos.currentIndexChanged.connect(self._show_photos)
        self.photos.setCurrentIndex(selected)
        self._show_photos()

    def _lay_out(self) -> None:
        self.buttons = self.deciding(self._take)
        export = self.buttons.button(QDialogButtonBox.StandardButton.Ok)
        export.setText(tr("E&xport"))
        export.setDefault(True)
        self.form.changed.connect(self._compare)
        offered = row_of(self.presets, button(tr("Save p&reset…"), self._ask_name), self.remove)
        offered.setStretch(0, 1)
        column_of(
            self,
            *(named(tr("&Photos"), self.photos), self.photos),
            *(named(tr("Prese&t"), self.presets), offered),
            *(self.form, self.note, self.buttons),
            margin=4 * GRID_PX,
            spacing=2 * GRID_PX,
        )

    def _show_photos(self) -> None:
        for name in ("recipe", "doubtful"):
            self.form.controls[name].setEnabled(self.photos.currentIndex() > 0)

    def _offer(self, chosen: str) -> None:
        self.presets.clear()
        for name in presets(self._settings):
            self.presets.addItem(translated(name) or tr("Last used"), name)
        self.presets.setCurrentIndex(max(0, self.presets.findData(chosen)))
        self._show()

    def _show(self) -> None:
        name = self.presets.currentData()
        if name is not None:  # None: the list is being filled
            self.form.show_values(dataclasses.asdict(presets(self._settings)[name]))
            self.remove.setEnabled(name in _own(self._settings))
            self.note.clear()
            self._compare()

    def _compare(self) -> None:
        """Mark a preset that the settings no longer match; the first number needs {n}."""
        self.form.controls["first"].setEnabled("{n}" in self.form.values()["name"])
        row, name = self.presets.currentIndex(), self.presets.currentData()
        with suppress(ValueError):
            found = presets(self._settings)
            title = translated(next(one for one in found if one == name)) or tr("Last used")
            same = self._export() == found[name]
            text = title if same else tr("{preset} (changed)", preset=title)
            self.presets.setItemText(row, text)

    def _export(self) -> Export:
        """Return the settings; raises ValueError."""
        values, defaults = self.form.values(), dataclasses.asdict(AS_IT_IS)
        return Export(**{name: type(default)(values[name]) for name, default in defaults.items()})

    def _ask_name(self) -> None:
        ask_name(self, tr("Save preset"), tr("Preset name"), self.keep)

    def keep(self, name: str) -> None:
        """Save the settings as a preset."""
        try:
            export = self._export()
        except ValueError as problem:
            self.note.setText(sentence(problem))
            return
        if name.strip():
            self._write(name.strip(), export)

    def _remove(self) -> None:
        self._write(self.presets.currentData(), None)

    def _write(self, name: str, export: Export | None) -> None:
        """Save or remove a preset. Presets of other versions stay."""
        stored = _stored(self._settings)
        stored.pop(name, None)
        if export is not None:
            stored[name] = dataclasses.asdict(export)
        self._settings.setValue(f"{_GROUP}/presets", json.dumps(stored))
        self._offer("" if export is None else name)

    def _take(self) -> None:
        photos = self._photos[self.photos.currentIndex()]
        try:
            export, values = self._export(), self.form.values()
            folder = Path(values["folder"])
            folder.mkdir(parents=True, exist_ok=True)
        except (ValueError, OSError) as problem:
            self.note.setText(sentence(problem))
            return
        name = self.presets.currentData()
        if export != presets(self._settings)[name]:
            name = _LAST
            self._write(name, export)
        self._settings.setValue(f"{_GROUP}/chosen", name)
        report = report_of(folder, self._storage)
        (number,) = export.numbers(photos[:1], batch.outputs_of(report))
        file = folder / export.place(Path(photos[0].name), number, self._percent)
        if self.photos.currentIndex():
            recipe, doubtful = self._recipes[values["recipe"]], values["doubtful"]
            self.accept()
            job = RetouchJob(recipe, doubtful=doubtful, export=export)
            self.many.emit(Order(tuple(photos), folder, report, job))
        elif file.exists():
            text = tr("{name} is there already. Replace it?", name=file.name)
            confirm(self, text, tr("&Replace"), lambda: self._send(export, file))
        else:
            self._send(export, file)

    def _send(self, export: Export, file: Path) -> None:
        self.accept()
        self.one.emit(export, file)


class Exporting(Feature):
    """Shows the dialog and starts the export."""

    def __init__(
        self, context: Context, files: Files, strip: Strip, batch: Batch, options: SaveOptions
    ) -> None:
        super().__init__(context)
        self._files, self._strip, self._batch, self._options = files, strip, batch, options
        strip.film.addAction(self.bind("export", self.ask))

    def ask(self) -> None:
        """Show the dialog; at the first export, ask about the edit record before."""
        if self.document.path is not None:
            self._options.ask_once(partial(self._show, self.document.path))

    def _show(self, path: Path) -> None:
        now = self.document.state.recipe
        chosen, every = self._strip.chosen(), self._strip.photos()
        photos = {tr("This photo ({name})", name=path.name): [path]}
        # One at a time: a running export has the worker processes.
        several = not self._batch.busy
        if several and len(chosen) > 1:
            photos[tr("Selected photos ({n})", n=len(chosen))] = chosen
        selected = len(photos) - 1
        if several and len(every) > 1:
            photos[tr("All photos of the strip ({n})", n=len(every))] = every
        current = tr("Current settings: {what}", what=translated(now.amount))
        offered = {current: now} | recipes.built_in() | listed(self.storage.presets)
        dialog = ExportDialog(
            *(self.settings, self.storage, photos, selected, offered, now.percent, self.window)
        )
        dialog.one.connect(lambda export, file: self._files.save(file, export=export))
        dialog.many.connect(self._batch.start)
        # The file name belongs to the photo that is open now.
        self.document.opened.connect(dialog.reject)
        dialog.open()
