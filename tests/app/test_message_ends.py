"""Messages over the photo end with the next try, with a condition, or with another photo."""

from __future__ import annotations

import json

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from test_typed import type_in

from kogao_core.recipe.recipe import Recipe

KEYS = Qt.Key


def test_what_could_not_be_written_goes_with_the_next_try(opened, tmp_path):
    opened.editor.figure.export(tmp_path / "nowhere" / "out.png")
    assert "nowhere" in opened.say()
    opened.editor.figure.export(tmp_path / "out.png")
    assert opened.say() == ""


def test_a_clipboard_without_settings_is_forgotten_once_some_are_copied(opened):
    QApplication.clipboard().setText("nothing of ours")
    opened.editor.recipe.paste()
    assert "copy some first" in opened.say()
    opened.editor.recipe.copy()
    assert Recipe.from_dict(json.loads(QApplication.clipboard().text()))
    assert opened.say() == ""
    assert opened.window.status.hint_text == "Settings copied"


@pytest.mark.usefixtures("read")
@pytest.mark.parametrize(("panel", "value"), [("recipe", "4.0"), ("protect", "33")])
def test_what_is_no_value_is_forgotten_once_one_is_typed(opened, panel, value):
    """The value that was there is an answer, too, and so is one that is no step to undo."""
    opened.key(KEYS.Key_B)
    slider = {"recipe": "percent", "protect": "size_px"}[panel]
    field = getattr(opened.panel(panel), slider).field
    type_in(field, "9999")
    assert " goes from " in opened.say()
    type_in(field, value)
    assert opened.say() == ""


@pytest.mark.parametrize("folder", ["no such folder", "empty"])
def test_every_message_about_a_photo_ends_with_the_next_photo(opened, tmp_path, folder):
    """No message of one photo stays over another photo."""
    (tmp_path / "empty").mkdir()
    opened.editor.strip.show_places([tmp_path / folder])
    opened.settle()
    assert opened.say()
    opened.open(opened.editor.document.path)
    assert opened.say() == ""
