"""The canvas without a mouse: points, marks and strokes by keys alone."""

import re
from functools import reduce
from operator import or_

import numpy as np
import pytest
from kogao_app.features.commands import Palette
from modules import ROOT
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QInputDialog, QWidget
from scenes import oval_face

from kogao_core.photo import read

pytestmark = pytest.mark.usefixtures("one_window")

KEYS, SHIFT = Qt.Key, Qt.KeyboardModifier.ShiftModifier
CONTROL = Qt.KeyboardModifier.ControlModifier


def middle(driver):
    return driver.canvas.to_photo(driver.canvas.viewport().rect().toRectF().center())


def test_keys_select_points_and_arrows_move_them(opened):
    opened.key(KEYS.Key_Period, CONTROL)
    first = opened.editor.view.selected
    assert (first.kind, first.index) == ("outline", 0)
    assert opened.window.status.hint_text.startswith("outline 1")
    opened.key(KEYS.Key_Period, CONTROL)
    before = opened.state.faces[0].outline
    opened.press_key(opened.canvas, KEYS.Key_Left, times=3)
    opened.settle()
    moved = opened.state.faces[0].outline - before
    np.testing.assert_allclose(moved[1], (-3.0, 0.0))
    assert np.count_nonzero(moved) == 1
    opened.key(KEYS.Key_Period, CONTROL, SHIFT)
    opened.key(KEYS.Key_Period, CONTROL, SHIFT)
    assert opened.editor.view.selected.kind == "target", "from the first one round to the last"


def test_the_arrows_move_the_point_wherever_the_keys_went_before(opened):
    slider = opened.panel("recipe").percent.slider
    opened.press_key(slider, KEYS.Key_Right)
    opened.key(KEYS.Key_Period, CONTROL)
    before = opened.state
    for _ in range(2):
        QTest.keyClick(opened.window.focusWidget(), KEYS.Key_Left)
    opened.settle()
    assert opened.state.recipe == before.recipe
    moved = opened.state.faces[0].outline[0] - before.faces[0].outline[0]
    np.testing.assert_allclose(moved, (-2.0, 0.0))


def is_seen(widget):
    """Whether any of it, or of what fills it, is on screen."""
    parts = [widget, *widget.findChildren(QWidget)]
    return any(not part.visibleRegion().isEmpty() for part in parts)


def test_tab_goes_round_through_what_is_seen(opened):
    opened.to_front()
    for name in ("compare", "inspect"):
        opened.window.actions_by_name[f"workspace-{name}"].trigger()
        opened.settle()
    panel = opened.panel("recipe")
    opened.qtbot.waitUntil(lambda: panel.height() >= panel.minimumSizeHint().height())  # laid out
    opened.canvas.setFocus()
    reached, unseen = [], []
    while opened.canvas not in reached:
        QTest.keyClick(opened.window.focusWidget(), KEYS.Key_Tab)
        reached.append(opened.window.focusWidget())
        if not is_seen(reached[-1]):
            unseen.append((type(reached[-1]).__name__, reached[-1].accessibleName()))
        assert len(reached) < 100
    assert len(reached) > 20
    assert unseen == []


def test_a_stroke_is_painted_with_arrows_and_enter(opened):
    opened.key(KEYS.Key_B)
    start = middle(opened)
    opened.press_key(opened.canvas, KEYS.Key_Return)
    opened.press_key(opened.canvas, KEYS.Key_Right, SHIFT, times=2)
    opened.press_key(opened.canvas, KEYS.Key_Down, times=5)
    assert opened.editor.document.in_gesture
    opened.press_key(opened.canvas, KEYS.Key_Return)
    opened.settle()
    (stroke,) = opened.state.protection.strokes
    px = 1.0 / opened.canvas.zoom * opened.canvas.devicePixelRatioF()
    np.testing.assert_allclose(stroke.points_px[0], start, atol=0.1)
    np.testing.assert_allclose(stroke.points_px[-1], start + np.array([80, 20]) * px, atol=0.1)
    assert opened.editor.document.undo.count() == 1
    opened.press_key(opened.canvas, KEYS.Key_Right)
    assert len(opened.state.protection.strokes) == 1, "the brush is lifted"


def test_the_pointer_stays_on_the_canvas(opened):
    opened.key(KEYS.Key_B)
    opened.press_key(opened.canvas, KEYS.Key_Up, SHIFT, times=100)
    opened.press_key(opened.canvas, KEYS.Key_Return, times=2)
    (stroke,) = opened.state.protection.strokes
    assert opened.canvas.to_screen(stroke.points_px[0]).y() == pytest.approx(0.0, abs=0.5)


def test_a_corner_is_marked_by_keys_and_the_hint_goes_on(opened):
    opened.key(KEYS.Key_F3)
    opened.settle()
    assert "1 of 6" in opened.window.status.hint_text
    opened.press_key(opened.canvas, KEYS.Key_Left, times=3)
    opened.press_key(opened.canvas, KEYS.Key_Return, times=2)
    assert len(opened.state.draft) == 1
    assert "2 of 6" in opened.window.status.hint_text
    opened.key(KEYS.Key_F2)
    opened.settle()
    assert opened.window.status.hint_text == "Drag a point to correct it"


def nameless(root):
    """The visible widgets that take the focus, and that a screen reader couldn't name."""
    asked = [w for w in root.findChildren(QWidget) if w.focusPolicy() != Qt.FocusPolicy.NoFocus]
    return [
        widget
        for widget in asked
        if widget.isVisible()
        and widget.focusProxy() is None
        and widget.objectName() != "qt_scrollarea_viewport"
        and not widget.accessibleName()
        and not (isinstance(widget, QAbstractButton) and widget.text())
    ]


def test_whatever_takes_the_focus_has_a_name(opened):
    opened.key(KEYS.Key_F3)
    opened.key(KEYS.Key_B)
    assert nameless(opened.window) == []
    opened.window.actions_by_name["save-preset"].trigger()
    asked = opened.window.findChild(QInputDialog)
    assert nameless(asked) == []


def test_points_are_walked_on_the_selected_face_only(two):
    two.editor.recipe.choose(1)
    for _ in range(60):
        two.key(KEYS.Key_Period, CONTROL)
        assert two.editor.view.selected.face == 1


def test_under_all_faces_no_point_is_walked_and_the_bar_says_what_to_do(two):
    before = two.state
    two.key(KEYS.Key_Period, CONTROL)
    assert two.editor.view.selected is None
    assert two.say().startswith("Select a face first")
    two.press_key(two.canvas, KEYS.Key_Left)
    assert two.state is before
    two.editor.recipe.choose(0)
    assert two.say() == ""
    two.key(KEYS.Key_Period, CONTROL)
    assert two.editor.view.selected.face == 0


def by_keys(driver, key, *held):
    """Press a key where the focus is, as a keyboard does, in a window that is in front."""
    driver.to_front()
    together = reduce(or_, held, Qt.KeyboardModifier.NoModifier)
    QTest.keyClick(driver.window.focusWidget(), key, together)
    driver.settle()


def test_from_the_start_to_a_saved_copy_by_keys_alone(start, source, photo, tmp_path):
    source.faces = [oval_face(center=(x, 170), size=0.45) for x in (120, 350)]
    driver, alt = start(workspace=None), Qt.KeyboardModifier.AltModifier
    by_keys(driver, KEYS.Key_O, CONTROL)
    driver.choose_path(photo)
    driver.settle()
    by_keys(driver, KEYS.Key_S, alt)
    by_keys(driver, KEYS.Key_Down)
    by_keys(driver, KEYS.Key_Down)
    assert driver.editor.view.face == 1
    by_keys(driver, KEYS.Key_O, alt)
    by_keys(driver, KEYS.Key_Return)
    by_keys(driver, KEYS.Key_6)
    by_keys(driver, KEYS.Key_Return)
    assert [driver.state.recipe_of(face).percent for face in (0, 1)] == [4.0, 6.0]
    by_keys(driver, KEYS.Key_S, CONTROL)
    driver.choose_path(tmp_path / "copy")
    driver.settle()
    expected = driver.rendered(read(photo).pixels)
    np.testing.assert_array_equal(read(tmp_path / "copy.png").pixels, expected)
    assert not driver.window.isWindowModified()


def test_every_command_is_in_the_palette_and_its_key_stands_in_the_docs(opened):
    pages = (ROOT / "docs" / f"{name}.md" for name in ("editor", "inspect", "keys"))
    page = "\n".join(one.read_text(encoding="utf-8") for one in pages)
    there = set(re.findall(r"`([^` ]+)`", page))
    words = {"Return": "Enter", "Esc": "Escape", "Del": "Delete"}
    named = opened.window.actions_by_name
    said = {
        name: ["+".join(words.get(k, k) for k in _parts(key.toString())) for key in one.shortcuts()]
        for name, one in named.items()
    }
    assert {name: keys for name, keys in said.items() if keys and keys[0] not in there} == {}
    chords = {key for key in there if re.match(r"(Ctrl|Shift)\+|F\d", key)}
    held = {"F4"}  # shows the original
    assert chords - {key for keys in said.values() for key in keys} == held
    opened.key(KEYS.Key_P, CONTROL, SHIFT)
    listed = set(opened.dialog(Palette)._actions)
    enabled = {name for name, action in named.items() if action.isEnabled() and name != "palette"}
    assert [name for name in enabled if named[name] not in listed] == []


def test_the_menus_stay_short(opened):
    entries = list(_in(opened.window.menuBar().actions()))
    assert len(entries) <= 70, [entry.text() for entry in entries]


def _parts(key):
    return [key] if key in ("", "+") else key.split("+")


def _in(actions):
    for action in actions:
        if action.menu() is None and not action.isSeparator() and action.isVisible():
            yield action
        elif action.menu() is not None:
            yield from _in(action.menu().actions())
