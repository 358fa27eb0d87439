"""Every message over the photo has an end: a condition, a time, or the next try."""

from __future__ import annotations

import ast
import json

import pytest
from modules import ROOT, tree
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from test_typed import type_in

from kogao_core.recipe.recipe import Recipe

APP, KEYS, CONTROL = ROOT / "app", Qt.Key, Qt.KeyboardModifier.ControlModifier
# What is said of an action, by the functions that say it, and what else ends it than the next step
# of the document. "try" is another try at the same thing, which begins with a clean bar; "open" is
# another photo; "own" a message of its own about how the next one went.
ENDS = {
    "features/batch._end": "try",
    "features/batch._refuse": "try",
    "features/sync._not_synced": "try",
    "features/sync.start": "try",
    "editor.admit": "open",
    "features/commands._copy_report": "time",
    "features/experiments/evidence._fail": "try",
    "features/experiments/evidence.compare": "try",
    "features/experiments/session._applied": "open",
    "features/experiments/session._opened": "open",
    "features/experiments/session.end": "open",
    "features/files/__init__._not_opened": "try",
    "features/files/__init__._not_written": "try",
    "features/files/__init__._refuse": "try",
    "features/files/__init__._show": "open",
    "features/files/__init__._written": "try",
    "features/readings.export": "try",
    "features/help.open": "try",
    "features/landmarks._tell_of_fallback": "open",
    "features/landmarks.export_file": "try",
    "features/landmarks.import_file": "try",
    "features/points.fetch": "open",
    "features/presets._import": "try",
    "features/presets._keep": "try",
    "features/presets._try": "try",
    "features/projects._ask_replace": "try",
    "features/projects._not_written": "try",
    "features/projects.__init__": "try",
    "features/projects._take_up": "open",
    "features/experiments/rating._browse": "try",
    "features/experiments/rating.open": "try",
    "features/recipe/__init__.paste": "try",
    "features/recovery._discard": "time",
    "features/recovery._not_checked": "open",
    "features/recovery._not_looked": "open",
    "features/recovery._warn": "open",
    "features/strip/__init__._fill": "try",
    "features/strip/__init__._not_rated": "try",
    "features/strip/__init__._show_strip": "open",
    "features/strip/__init__.show_places": "try",
    "features/overlays._show": "time",
    "features/retouch._apply": "try",
    "features/retouch._save": "try",
}


def said():
    """Yield where something is said, whether a condition ends it, and whether time does."""
    for path in sorted(APP.rglob("*.py")):
        for function in (n for n in ast.walk(tree(path)) if isinstance(n, ast.FunctionDef)):
            for call in (n for n in ast.walk(function) if isinstance(n, ast.Call)):
                named = isinstance(call.func, ast.Attribute) and call.func.attr == "say"
                made = isinstance(call.func, ast.Name) and call.func.id == "Message"
                feature = path.name != "feature.py"
                if feature and (made or (named and not _takes_message(call))):
                    words = {key.arg: key.value for key in call.keywords}
                    informs = isinstance(words.get("wrong"), ast.Constant)
                    timed = informs and len(call.args) == 1 and "applies" not in words
                    where = path.relative_to(APP).with_suffix("").as_posix()
                    yield f"{where}.{function.name}", "applies" in words, timed


def _takes_message(call):
    return any(isinstance(one, ast.Call) and _name(one) == "Message" for one in call.args)


def _name(call):
    return getattr(call.func, "id", "")


def test_every_message_tells_what_ends_it():
    found = list(said())
    without = {where for where, held, _ in found if not held}
    assert without == set(ENDS)
    timed = {where for where, _, timed in found if timed}
    assert {where for where, end in ENDS.items() if end == "time"} <= timed


def figure(driver, path):
    driver.editor.figure.export(path)


def landmarks(driver, path):
    driver.editor.exchange.export_file(path.with_suffix(".json"))


def settings(driver, path):
    driver.window.actions_by_name["export-preset"].trigger()
    driver.choose_path(path.with_suffix(".json"))


@pytest.mark.parametrize("export", [figure, landmarks, settings])
def test_what_could_not_be_written_goes_with_the_next_try(opened, tmp_path, export):
    export(opened, tmp_path / "nowhere" / "out.png")
    assert "nowhere" in opened.say()
    export(opened, tmp_path / "out.png")
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


def test_modes_that_could_not_be_compared_are_said_where_they_lie_side_by_side(opened, monkeypatch):
    def fail(*_, **__):
        raise MemoryError

    with monkeypatch.context() as broken:
        broken.setattr("kogao_app.features.both.faces_compared", fail)
        opened.window.actions_by_name["workspace-compare"].trigger()
        opened.settle()
    assert "can't be compared" in opened.say()
    opened.window.actions_by_name["workspace-retouch"].trigger()
    assert opened.say() == ""
    opened.window.actions_by_name["workspace-compare"].trigger()
    opened.settle()
    assert opened.say() == ""


def test_a_background_that_could_not_be_measured_is_said_while_it_is_wanted(opened, monkeypatch):
    def fail(*_, **__):
        raise MemoryError

    monkeypatch.setattr("kogao_app.features.overlays.look", fail)
    opened.key(KEYS.Key_S)
    opened.settle()
    assert "can't be measured" in opened.say()
    opened.change_something()
    opened.settle()
    assert "can't be measured" in opened.say(), "it has been tried again"
    opened.key(KEYS.Key_S)
    assert opened.say() == ""
