"""Sliders, keys and points, driven as a user drives them."""

import dataclasses

import numpy as np
import pytest
from kogao_app.canvas.handles import corners, position
from kogao_app.features import preferences
from kogao_app.view_state import Handle
from kogao_app.widgets.sliders import ValueSlider
from PySide6.QtCore import QPoint, QPointF, Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QStyle

from kogao_core.additions.limits import check_faces
from kogao_core.recipe.recipe import Recipe

pytestmark = pytest.mark.usefixtures("one_window")
LEFT, CHIN = Handle("outline", 0, 3), Handle("outline", 0, 10)
KEYS = Qt.Key


def slider(driver):
    return driver.panel("recipe").percent.slider


def test_slider_keys_change_the_result_and_are_one_step_each(opened, pixels):
    slider(opened).setFocus()
    for _ in range(3):
        QTest.keyClick(slider(opened), KEYS.Key_Right)
    QTest.keyClick(slider(opened), KEYS.Key_PageUp)
    opened.settle()
    assert opened.state.recipe.percent == pytest.approx(4.0 + 3 * 0.1 + 1.0)
    np.testing.assert_array_equal(opened.shown, opened.rendered(pixels))
    assert opened.editor.document.undo.count() == 4


def test_a_held_key_is_one_step(opened):
    slider(opened).setFocus()
    for _ in range(5):
        QTest.keyPress(slider(opened), KEYS.Key_Right)
    assert opened.editor.document.in_gesture
    assert opened.editor.document.undo.count() == 0
    QTest.keyRelease(slider(opened), KEYS.Key_Right)
    assert not opened.editor.document.in_gesture
    assert opened.editor.document.undo.count() == 1
    assert opened.editor.document.undo.undoText() == "Amount 4.0 → 4.5 % of D"


def test_a_double_click_brings_what_photos_are_preferred_to_begin_with(opened):
    for one in opened.window.findChildren(ValueSlider):
        assert "A double click brings " in one.slider.toolTip()
    preferred = preferences.recipe_text(Recipe(percent=6.0))
    preferences.prefer(opened.editor.preferences.settings, preferences.RECIPE, preferred)
    opened.editor.preferences.changed.emit()
    amount = opened.panel("recipe").percent
    for steps, clicked in ((2, amount.title), (4, amount.slider)):
        opened.window.actions_by_name["workspace-inspect"].trigger()
        assert "double click brings 6.0 % of D back" in clicked.toolTip()
        opened.window.actions_by_name["workspace-retouch"].trigger()
        assert "double click brings 6.0 % back" in clicked.toolTip()
        opened.press_key(amount.slider, KEYS.Key_End)
        QTest.mouseDClick(clicked, Qt.MouseButton.LeftButton)
        assert opened.state.recipe.percent == 6.0
        assert opened.editor.document.undo.count() == steps


def test_escape_ends_a_slider_gesture_as_if_it_had_not_been(opened):
    slider(opened).setFocus()
    QTest.keyPress(slider(opened), KEYS.Key_End)
    assert opened.state.recipe.percent == 15.0
    opened.key(KEYS.Key_Escape)
    QTest.keyRelease(slider(opened), KEYS.Key_End)
    opened.settle()
    assert opened.state.recipe.percent == 4.0
    assert slider(opened).value() == 40
    assert opened.editor.document.undo.count() == 0


@pytest.mark.parametrize("handle", [LEFT, Handle("mouth", 0, 1)])
def test_a_dragged_landmark_follows_the_mouse_and_is_one_step(opened, pixels, handle):
    before = opened.state
    old = position(before, handle)
    by = QPoint(-18, 24)
    opened.drag(opened.on_screen(handle), by)
    moved = position(opened.state, handle) - old
    scale = opened.canvas.zoom / opened.canvas.devicePixelRatioF()
    np.testing.assert_allclose(moved, np.array([by.x(), by.y()]) / scale, atol=1e-6)
    assert opened.editor.document.undo.count() == 1
    moved_px = np.hypot(by.x(), by.y()) / scale
    assert opened.editor.document.undo.undoText().endswith(f" {moved_px:.1f} px")
    opened.settle()
    np.testing.assert_array_equal(opened.shown, opened.rendered(pixels))
    opened.key(KEYS.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert opened.state is before


def test_a_landmark_cannot_be_dragged_far_out_of_the_photo(opened):
    """A project with one would be refused when it is opened again."""
    canvas, (x, y) = opened.canvas, position(opened.state, LEFT)
    canvas.begin("points", LEFT, np.array([x, y]))
    canvas.move(np.array([-100.0, y]))
    near, far = position(opened.state, LEFT), np.array([x - 1e5, y])
    assert near[0] == -100.0
    canvas.move(far)
    canvas.end(far)
    np.testing.assert_array_equal(position(opened.state, LEFT), near)
    check_faces(opened.state.faces, opened.editor.document.image)


def test_a_dragged_target_stays_until_it_is_made_automatic(opened):
    target = Handle("target", 0, 10)
    automatic = position(opened.state, target)
    # The rings lie close to their dots; with the dots off, none is in the way.
    opened.key(KEYS.Key_L)
    opened.drag(opened.on_screen(target), QPoint(0, -20))
    assert position(opened.state, target)[1] < automatic[1] - 5
    assert np.isfinite(opened.state.faces[0].targets[10]).all()
    opened.key(KEYS.Key_Delete)
    assert opened.state.faces[0].targets is None
    np.testing.assert_array_equal(position(opened.state, target), automatic)
    steps = opened.editor.document.undo.count()
    opened.key(KEYS.Key_Delete)
    assert opened.editor.document.undo.count() == steps, "there was none to take back"


def test_arrows_nudge_the_selected_point(opened):
    at = opened.on_screen(CHIN)
    opened.click(at)
    assert opened.editor.document.undo.count() == 0
    old = position(opened.state, CHIN)
    QTest.keyClick(opened.canvas, KEYS.Key_Right)
    QTest.keyClick(opened.canvas, KEYS.Key_Up, Qt.KeyboardModifier.ShiftModifier)
    np.testing.assert_allclose(position(opened.state, CHIN) - old, [1.0, -10.0])
    assert opened.editor.document.undo.count() == 2


def test_a_handle_is_taken_from_twelve_pixels_away_but_not_from_far(opened):
    at = opened.on_screen(CHIN)
    assert opened.canvas.handle_at(QPointF(at + QPoint(0, 11))) == CHIN
    assert opened.canvas.handle_at(QPointF(at + QPoint(0, 40))) is None


def test_centre_buttons_lattice_and_choices_reach_the_recipe_and_the_history(opened, pixels):
    panel = opened.panel("recipe")
    opened.press_key(panel.scope.group.button(1), KEYS.Key_Right)
    QTest.mouseClick(panel.centre.group.button(4), Qt.MouseButton.LeftButton)
    opened.press_key(panel.lattice.slider, KEYS.Key_End)
    QTest.mouseClick(panel.fold.button, Qt.MouseButton.LeftButton)
    opened.press_key(panel.choices["fit"], KEYS.Key_Up)
    QTest.keyClick(panel.sliders["threshold_px"].slider, KEYS.Key_End)
    panel.switches["guard"].click()
    opened.settle()
    wanted = Recipe(
        percent=4.0, scope="face", center=4, lattice=4.0, fit="approximation", threshold_px=2.0,
        guard=False,
    )  # fmt: skip
    assert opened.state.recipe == wanted
    np.testing.assert_array_equal(opened.shown, opened.rendered(pixels))
    stack = opened.editor.document.undo
    assert [stack.text(row) for row in range(stack.count())] == [
        "Change Head → Face only",
        "Centre 2 → 4",
        "Falloff 1.0 → 4.0",
        "Fit Exact → Approximation",
        "Threshold 0.02 → 2.0 px",
        "Guard on → off",
    ]


def test_a_template_is_moved_turned_and_sized_as_a_whole(opened):
    opened.key(KEYS.Key_P, Qt.KeyboardModifier.ControlModifier)
    face = opened.editor.view.placing
    assert face == 1
    before = opened.state.faces[face]
    # Only the frame, so that no single point of the face below is in the way.
    for key in (KEYS.Key_L, KEYS.Key_T, KEYS.Key_C, KEYS.Key_D):
        opened.key(key)
    middle = opened.canvas.to_screen(corners(before).mean(axis=0)).toPoint()
    opened.drag(middle, QPoint(30, -20))
    moved = opened.state.faces[face]
    shift = moved.points - before.points
    np.testing.assert_allclose(shift, np.broadcast_to(shift[0], shift.shape), atol=1e-9)
    assert shift[0, 0] > 5
    assert shift[0, 1] < -5
    corner = opened.canvas.to_screen(corners(moved)[2]).toPoint()
    opened.drag(corner, QPoint(40, 40))
    assert opened.state.faces[face].anchor.spacing_px > 1.1 * moved.anchor.spacing_px
    np.testing.assert_allclose(
        np.linalg.norm(np.diff(opened.state.faces[face].outline, axis=0), axis=1).mean()
        / opened.state.faces[face].anchor.spacing_px,
        1.0,
    )
    opened.take_step("It fits")
    assert opened.editor.view.placing is None


def test_previews_are_bilinear_and_rests_are_as_asked_for(opened):
    frames = opened.drawn()
    opened.pause_never()
    opened.editor.recipe.set_field("percent", 4.1)
    opened.qtbot.waitUntil(lambda: bool(frames))
    opened.editor.document.commit()
    opened.settle()
    assert frames[0].rendering.recipe.interpolation == "bilinear"
    assert frames[-1].rendering.recipe == opened.state.recipe
    assert frames[-1].rendering.recipe.interpolation == "cubic"
    assert dataclasses.replace(frames[0].rendering.recipe, interpolation="cubic") == Recipe(
        percent=4.1
    )


def test_a_double_click_beside_the_handle_is_one_step(opened):
    handle = slider(opened)
    opened.press_key(handle, KEYS.Key_PageUp)
    before = opened.state.recipe.percent
    far = QPoint(handle.width() - 8, handle.height() // 2)
    QTest.mouseClick(handle, Qt.MouseButton.LeftButton, pos=far)
    assert opened.state.recipe.percent > before
    QTest.mouseDClick(handle, Qt.MouseButton.LeftButton, pos=far)
    assert opened.state.recipe.percent == 4.0
    opened.key(KEYS.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert opened.state.recipe.percent == before


def test_a_click_beside_the_handle_is_a_step_after_a_moment(opened):
    handle = slider(opened)
    far = QPoint(handle.width() - 8, handle.height() // 2)
    QTest.mouseClick(handle, Qt.MouseButton.LeftButton, pos=far)
    opened.qtbot.waitUntil(lambda: opened.editor.document.undo.count() == 1)


def test_a_press_in_the_groove_brings_the_handle_there_to_be_dragged_on(opened):
    handle = slider(opened)
    x, y = round(0.8 * handle.width()), handle.height() // 2
    QTest.mousePress(handle, Qt.MouseButton.LeftButton, pos=QPoint(x, y))
    assert opened.state.recipe.percent == pytest.approx(0.8 * 15.0, abs=0.4)
    QTest.mouseMove(handle, QPoint(x - 40, y))
    assert opened.editor.document.in_gesture
    assert opened.state.recipe.percent < 0.8 * 15.0 - 1.0
    QTest.mouseRelease(handle, Qt.MouseButton.LeftButton, pos=QPoint(x - 40, y))
    assert opened.editor.document.undo.count() == 1


def test_neither_a_press_on_the_handle_nor_a_double_click_at_the_default_moves_it(opened):
    handle = slider(opened)
    x = 6 + QStyle.sliderPositionFromValue(0, 150, handle.value(), handle.width() - 12)
    for beside in (-4, 0, 4):
        QTest.mouseClick(handle, Qt.MouseButton.LeftButton, pos=QPoint(x + beside, 10))
    QTest.mouseDClick(handle, Qt.MouseButton.LeftButton, pos=QPoint(x, 10))
    assert not any(timer.isActive() for timer in handle.findChildren(QTimer)), "nothing is to come"
    opened.settle()
    assert opened.state.recipe.percent == 4.0
    assert opened.editor.document.undo.count() == 0
