"""An eye switches a shape setting or the strokes of a tool off and on, and the value stays."""

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from test_protect import beside_the_cheek, paint

pytestmark = pytest.mark.usefixtures("one_window")


def press(driver, eye):
    driver.settle()
    driver.qtbot.waitUntil(eye.isVisible)
    assert eye.isEnabled()
    QTest.mouseClick(eye, Qt.MouseButton.LeftButton)
    driver.settle()


def test_an_eye_switches_a_slider_off_and_on_as_undo_steps(opened, pixels):
    panel = opened.panel("recipe")
    eye, slider = panel.eyes["jaw_width"], panel.sliders["jaw_width"]
    without = opened.shown.copy()
    assert not eye.isEnabled()
    panel.shape.button.setChecked(True)
    opened.show("jaw_width", -6.0)
    with_it = opened.shown.copy()
    assert eye.accessibleName() == "Switch off: Jaw"
    press(opened, eye)
    np.testing.assert_array_equal(opened.shown, without)
    assert opened.state.recipe.jaw_width == 0.0
    assert eye.accessibleName() == "Switch on: Jaw"
    press(opened, eye)
    assert opened.state.recipe.jaw_width == -6.0
    np.testing.assert_array_equal(opened.shown, with_it)
    np.testing.assert_array_equal(opened.shown, opened.rendered(pixels))
    assert opened.editor.document.undo.count() == 3
    # A new value replaces the kept value.
    press(opened, eye)
    opened.press_key(slider.slider, Qt.Key.Key_Right)
    opened.settle()
    assert opened.state.recipe.jaw_width > 0.0
    assert eye.accessibleName() == "Switch off: Jaw"


def test_each_face_keeps_its_own_value_and_another_photo_none(two, photo):
    panel = two.panel("recipe")
    eye = panel.eyes["jaw_width"]
    panel.shape.button.setChecked(True)
    recipe = two.editor.recipe
    for face, value in ((0, -6.0), (1, 4.0)):
        recipe.choose(face)
        two.set("jaw_width", value)
        press(two, eye)
    for face, value in ((0, -6.0), (1, 4.0)):
        recipe.choose(face)
        press(two, eye)
        assert two.state.recipe_of(face).jaw_width == value
    press(two, eye)
    two.open(photo)
    assert not eye.isEnabled()


@pytest.mark.parametrize(("panel", "key"), [("protect", Qt.Key.Key_B), ("push", Qt.Key.Key_W)])
def test_an_eye_switches_strokes_off_and_on(opened, panel, key):
    free, eye = opened.shown.copy(), opened.panel(panel).eye
    assert not eye.isEnabled()
    if panel == "protect":
        paint(opened, key, QPoint(0, 40))
    else:
        opened.key(key, Qt.KeyboardModifier.ShiftModifier)
        opened.drag(beside_the_cheek(opened), QPoint(20, 0))
        opened.settle()
    drawn = opened.shown.copy()
    assert (drawn != free).any()
    press(opened, eye)
    np.testing.assert_array_equal(opened.shown, free)
    press(opened, eye)
    np.testing.assert_array_equal(opened.shown, drawn)
