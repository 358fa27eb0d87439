"""The open photo exported: the choices, what is kept of them, and what the file is."""

import json

import numpy as np
import pytest
from kogao_app.features import export as exporting
from PIL import Image
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialogButtonBox, QFileDialog, QMessageBox

from kogao_core.base import language
from kogao_core.photo.export import Export
from kogao_core.recipe.export import EXPORT_SETTINGS

pytestmark = pytest.mark.usefixtures("one_window")

KEYS = Qt.Key
CTRL_SHIFT = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def dialog(opened):
    opened.key(KEYS.Key_S, CTRL_SHIFT)
    return opened.dialog(exporting.ExportDialog)


def agree(dialog):
    dialog.buttons.button(QDialogButtonBox.StandardButton.Ok).click()


def test_a_preset_and_enter_export_a_smaller_picture(opened, dialog, photo):
    dialog.presets.setCurrentIndex(dialog.presets.findText("1,080 px, sRGB, no metadata"))
    dialog.form.show_values(
        {"longest_px": 240, "sharpen": 0, "ending": ".png", "name": "{name}-{n}-{amount}"}
    )
    agree(dialog)
    opened.settle()
    with Image.open(photo.parent / "kogao" / f"{photo.stem}-001-4.png") as made:
        assert (max(made.size), made.format) == (240, "PNG")
        assert "exif" not in made.info
        small = np.asarray(made, int)
    high, wide = small.shape[:2]
    mean = opened.shown[..., :3].reshape(high, 2, wide, 2, 3).mean(axis=(1, 3))
    assert np.abs(small - mean).mean() < 2, "it is the result that is on screen"
    assert not opened.window.isWindowModified()


def test_a_saved_preset_is_offered_again_and_can_be_deleted(opened, dialog):
    dialog.form.show_values({"longest_px": 1234, "srgb": True})
    dialog.keep("For the album")
    chosen = dialog.presets.currentData()
    assert exporting.presets(dialog._settings)[chosen] == Export(1234, srgb=True)
    dialog.reject()
    opened.window.actions_by_name["export"].trigger()
    again = opened.dialog(exporting.ExportDialog)
    again.presets.setCurrentIndex(again.presets.findText("For the album"))
    assert again.form.values()["longest_px"] == 1234
    again.remove.click()
    assert again.presets.findText("For the album") == -1
    assert not again.remove.isEnabled(), "built-in presets can't be deleted"


@pytest.mark.parametrize("name", ["", "a/b", "{date}"])
def test_a_name_that_is_none_gets_a_sentence_and_nothing_is_written(dialog, photo, name):
    dialog.form.show_values({"name": name})
    agree(dialog)
    assert "A name is made of letters" in dialog.note.text()
    assert dialog.isVisible()
    assert not (photo.parent / "kogao").exists()


def test_the_original_is_never_written_over(opened, dialog, photo):
    before = photo.read_bytes()
    dialog.form.show_values({"folder": str(photo.parent)})
    agree(dialog)
    opened.answer("Replace")
    opened.settle()
    assert "never written over" in opened.say()
    assert photo.read_bytes() == before


def test_damaged_choices_of_before_are_as_none(opened):
    opened.editor.exporting.settings.setValue("export/presets", '{"odd": {"quality": 999}}')
    assert "odd" not in exporting.presets(opened.editor.exporting.settings)


def test_a_preset_of_another_version_hides_no_other_and_stays_in_the_file(opened, dialog):
    settings = opened.editor.exporting.settings
    stored = {"Print": {"quality": 90}, "Poster": {"dpi": 300}, "Web": {"srgb": True}}
    settings.setValue("export/presets", json.dumps(stored))
    assert exporting.presets(settings).keys() >= {"Print", "Web"}
    assert "Poster" not in exporting.presets(settings)
    dialog.keep("New one")
    assert json.loads(settings.value("export/presets"))["Poster"] == {"dpi": 300}
    assert exporting.presets(settings).keys() >= {"Print", "Web", "New one"}


def test_a_preset_says_that_it_was_changed_and_the_first_number_needs_a_place(dialog):
    dialog.presets.setCurrentText("2,048 px, sRGB")
    assert not dialog.form.controls["first"].isEnabled(), "no number in the name"
    dialog.form.show_values({"quality": 85, "name": "{name}-{n}"})
    assert dialog.presets.currentText() == "2,048 px, sRGB (changed)"
    assert dialog.form.controls["first"].isEnabled()
    dialog.form.show_values({"quality": 88, "name": "{name}"})
    assert dialog.presets.currentText() == "2,048 px, sRGB"


def test_every_export_option_has_its_row():
    """A forgotten row is told here by its name, before any dialog opens."""
    assert {row.name for row in exporting.FIELDS} >= set(EXPORT_SETTINGS)


@pytest.mark.usefixtures("spoken")
@pytest.mark.parametrize("preset", ["Last used", "2,048 px, sRGB", "Mine"])
def test_the_preset_of_the_last_export_is_offered_in_another_language(opened, dialog, preset):
    if preset == "Mine":
        dialog.keep(preset)
    elif preset == "Last used":
        dialog.form.show_values({"longest_px": 240})
    else:
        dialog.presets.setCurrentText(preset)
    used = dialog.form.values()
    agree(dialog)
    opened.settle()
    language.use_language("ja")
    opened.window.actions_by_name["export"].trigger()
    again = opened.dialog(exporting.ExportDialog)
    assert again.presets.currentText() == language.tr(preset)
    assert again.presets.findText("Last used") == -1
    assert again.form.values() == used


@pytest.mark.parametrize(
    ("action", "words", "recorded"), [("save", "Add record", True), ("export", "Don't add", False)]
)
def test_the_edit_record_is_offered_once(opened, photo, action, words, recorded):
    settings = opened.editor.save_options.settings
    settings.remove("saving/record")
    opened.window.actions_by_name[action].trigger()
    opened.answer("Cancel")
    assert not settings.contains("saving/record"), "the next save asks again"
    opened.window.actions_by_name[action].trigger()
    opened.answer(words)
    asked = opened.dialog(exporting.ExportDialog if action == "export" else QFileDialog)
    if action == "export":
        agree(asked)
        made = photo.parent / "kogao" / photo.name
    else:
        made = photo.with_name("made.png")
        opened.choose_path(made)
    opened.settle()
    assert (b"http://ns.adobe.com/xap/1.0/sType/ResourceEvent#" in made.read_bytes()) is recorded
    opened.window.actions_by_name[action].trigger()
    assert not [box for box in opened.window.findChildren(QMessageBox) if box.isVisible()]
    assert opened.editor.save_options.current.record is recorded
