"""Finished pictures for elsewhere: size, format, colours, names; choices that can be kept."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Final

from PySide6.QtCore import QSettings, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QDialogButtonBox,
    QFormLayout,
    QLineEdit,
    QWidget,
)

from kogao_core.base.language import Text
from kogao_core.photo.export import LONGEST_PX, Export
from kogao_core.photo.formats import WRITTEN

from ..i18n import sentence, tr, translated
from ..theme import GRID_PX
from ..widgets.controls import ChoiceBox, WholeNumber, column_of, muted_label, named, row_of
from ..widgets.dialogs import Dialog, PathLine, ask_name, button, confirm
from .feature import Context, Feature
from .files import Files

_SIZE_PX: Final = (520, 0)
_GROUP: Final = "export"
_BUILT_IN: Final = {
    Text("Full size, as the photo"): Export(),
    Text("2,048 px, sRGB"): Export(2048, ".jpg", 88, True, 50.0),
    Text("1,080 px, sRGB, no metadata"): Export(1080, ".jpg", 82, True, 50.0, metadata=False),
}


def presets(settings: QSettings) -> dict[str, Export]:
    """Return what there is to choose from, by name."""
    return {translated(name): export for name, export in _BUILT_IN.items()} | _own(settings)


def _own(settings: QSettings) -> dict[str, Export]:
    """Return what the user has kept, by name; nothing, if it can't be read."""
    try:
        kept = json.loads(str(settings.value(f"{_GROUP}/presets", "{}")))
        return {name: Export(**fields) for name, fields in kept.items()}
    except (ValueError, TypeError, AttributeError):
        return {}


class ExportDialog(Dialog):
    """Takes the choices and where the picture goes; `taken` has both."""

    taken = Signal(object, object)

    def __init__(self, settings: QSettings, photo: Path, percent: float, parent: QWidget) -> None:
        super().__init__(tr("Export"), parent, _SIZE_PX)
        self._settings, self._photo, self._percent = settings, photo, percent
        self.presets = ChoiceBox()
        self.presets.setToolTip(tr("Choices with a name; a batch offers them, too"))
        self.longest = WholeNumber(0, LONGEST_PX, 0)
        self.longest.setSpecialValueText(tr("as the photo"))
        self.longest.setSuffix(tr(" px"))
        self.longest.setToolTip(tr("A smaller picture is resampled once, together with the warp"))
        self.ending = ChoiceBox()
        self.ending.setToolTip(tr("Of the file"))
        self.ending.addItem(tr("as the photo"), "")
        for form in WRITTEN:
            self.ending.addItem(form.title, form.suffixes[0])
        self.quality = WholeNumber(0, 100, 0)
        self.quality.setSpecialValueText(tr("as the photo"))
        self.quality.setToolTip(tr("Of JPEG and WebP"))
        self.sharpen = WholeNumber(0, 200, 0)
        self.sharpen.setSuffix(tr(" %"))
        self.sharpen.setToolTip(tr("Only where the picture is reduced"))
        self.srgb = QCheckBox(tr("Con&vert to sRGB (8 bits)"))
        self.srgb.setToolTip(tr("Else the photo's colour profile is kept"))
        self.metadata = QCheckBox(tr("Keep &metadata (EXIF, XMP, IPTC)"))
        self.metadata.setToolTip(tr("Else only the colour profile stays"))
        self.name = QLineEdit()
        parts = {"name": "{name}", "n": "{n}", "amount": "{amount}"}
        self.name.setToolTip(
            tr("{name} is the photo's own, {n} counts, {amount} is the amount", **parts)
        )
        self.folder = PathLine(tr("Folder"), str(photo.parent / "kogao"), kind="folder")
        self.folder.line.setToolTip(tr("Made if need be; no photo of yours is ever written over"))
        self.note = muted_label(wraps=True)
        self._lay_out()
        self._offer(str(settings.value(f"{_GROUP}/chosen", "")))
        self.presets.currentTextChanged.connect(self._show)

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.setSpacing(2 * GRID_PX)
        rows = {
            tr("&Longer side"): self.longest,
            tr("&Format"): self.ending,
            tr("&Quality"): self.quality,
            tr("&Sharpen for the size"): self.sharpen,
            tr("&Name"): self.name,
        }
        for text, control in rows.items():
            form.addRow(named(text, control), control)
        self.buttons = self.deciding(self._take)
        self.buttons.button(QDialogButtonBox.StandardButton.Ok).setText(tr("&Export"))
        keep = button(tr("&Keep as…"), self._ask_name)
        keep.setToolTip(tr("Keep these choices under a name"))
        self.remove = button(tr("&Delete"), self._remove)
        self.remove.setToolTip(tr("Forget these choices"))
        offered = row_of(self.presets, keep, self.remove)
        offered.setStretch(0, 1)
        title = named(tr("&Choices"), self.presets)
        more = self.srgb, self.metadata, self.folder, self.note, self.buttons
        column = column_of(
            self, title, offered, form, *more, margin=4 * GRID_PX, spacing=2 * GRID_PX
        )
        column.setStretch(column.count() - 1, 0)

    def _offer(self, chosen: str) -> None:
        self.presets.clear()
        for name, export in presets(self._settings).items():
            self.presets.addItem(name, export)
        self.presets.setCurrentIndex(max(0, self.presets.findText(chosen)))
        self._show()

    def _show(self) -> None:
        export = self.presets.currentData()
        if export is None:
            return
        self.longest.setValue(export.longest_px)
        self.ending.setCurrentIndex(self.ending.findData(export.ending))
        self.quality.setValue(export.quality)
        self.sharpen.setValue(round(export.sharpen))
        self.srgb.setChecked(export.srgb)
        self.metadata.setChecked(export.metadata)
        self.name.setText(export.name)
        self.remove.setEnabled(self.presets.currentText() in _own(self._settings))
        self.note.clear()

    def _chosen(self) -> Export:
        """Return the choices; raises ValueError."""
        return Export(
            self.longest.value(),
            self.ending.currentData(),
            self.quality.value(),
            self.srgb.isChecked(),
            float(self.sharpen.value()),
            self.name.text().strip(),
            self.metadata.isChecked(),
        )

    def _ask_name(self) -> None:
        ask_name(self, tr("Keep these choices"), tr("Name of the choices"), self._keep)

    def _keep(self, name: str) -> None:
        try:
            kept = {**_own(self._settings), name.strip(): self._chosen()}
        except ValueError as problem:
            self.note.setText(sentence(problem))
            return
        if name.strip():
            self._write(kept, name.strip())

    def _remove(self) -> None:
        name = self.presets.currentText()
        self._write({one: it for one, it in _own(self._settings).items() if one != name}, "")

    def _write(self, kept: dict[str, Export], chosen: str) -> None:
        fields = {name: dataclasses.asdict(export) for name, export in kept.items()}
        self._settings.setValue(f"{_GROUP}/presets", json.dumps(fields))
        self._offer(chosen)

    def _take(self) -> None:
        try:
            export, folder = self._chosen(), Path(self.folder.path)
            folder.mkdir(parents=True, exist_ok=True)
        except (ValueError, OSError) as problem:
            self.note.setText(sentence(problem))
            return
        file = folder / export.place(Path(self._photo.name), 1, self._percent)
        self._settings.setValue(f"{_GROUP}/chosen", self.presets.currentText())
        if file.exists():
            text = tr("{name} is there already. Replace it?", name=file.name)
            confirm(self, text, tr("&Replace"), lambda: self._send(export, file))
        else:
            self._send(export, file)

    def _send(self, export: Export, file: Path) -> None:
        self.accept()
        self.taken.emit(export, file)


class Exporting(Feature):
    """Asks how the open photo's result is exported."""

    def __init__(self, context: Context, files: Files) -> None:
        super().__init__(context)
        self._save = files.save
        self.add_action(
            "export",
            tr("E&xport…"),
            "Ctrl+Shift+S",
            tr("Save the result in another size, format or colours, by a name of a pattern"),
            self.ask,
            needs_photo=True,
        )

    def ask(self) -> None:
        """Show the dialog."""
        path = self.document.path
        if path is None:
            return
        percent = self.document.state.recipe.percent
        dialog = ExportDialog(self.settings, path, percent, self.window)
        dialog.taken.connect(lambda export, file: self._save(file, export=export))
        # The name is for the photo that is open now, and for no other.
        self.document.opened.connect(dialog.reject)
        dialog.open()
