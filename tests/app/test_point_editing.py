"""Points in hand: neighbours that follow, both sides at once, a landmark called by a click."""

import numpy as np
import pytest
from few_cases import few_of
from kogao_app.canvas.overlays.overlay import Place, affine
from kogao_app.canvas.overlays.unlisted import FollowingBand
from kogao_app.view_state import Handle
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QImage, QPainter
from PySide6.QtTest import QTest
from scenes import oval_face

from kogao_core.faces.reshape import influence, moved

pytestmark = pytest.mark.usefixtures("one_window")

CHEEK = Handle("outline", 0, 5)
CHEEKS_TARGET = Handle("target", 0, 5)
POINTS = pytest.mark.parametrize("point", [CHEEK, CHEEKS_TARGET])
KEYS = Qt.Key
CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
BY = QPoint(-24, 6)


def control_click(driver, at):
    QTest.mouseClick(driver.canvas.viewport(), Qt.MouseButton.LeftButton, CONTROL, at)


def outline(driver):
    return driver.state.faces[0].outline


def steps(driver):
    return driver.editor.document.undo.count()


def place(driver, at):
    """Return where a point of the photo lies on screen."""
    return driver.canvas.to_screen(np.asarray(at)).toPoint()


def test_neighbours_follow_a_dragged_landmark_and_all_is_one_step(opened):
    before = opened.state.faces[0]
    opened.key(KEYS.Key_Q)
    opened.drag(opened.on_screen(CHEEK), BY)
    opened.settle()
    by = outline(opened)[5] - before.outline[5]
    reach_px = opened.editor.view.following.reach * before.anchor.spacing_px
    followed = influence(before.outline, 5, reach_px)
    assert np.count_nonzero(followed) > 5
    np.testing.assert_allclose(outline(opened) - before.outline, followed[:, None] * by, atol=1e-9)
    assert steps(opened) == 1
    opened.key(KEYS.Key_Z, CONTROL)
    np.testing.assert_array_equal(outline(opened), before.outline)


def test_switched_off_again_a_landmark_moves_alone_to_the_bit(opened):
    before = opened.state.faces[0]
    for _ in range(2):
        opened.key(KEYS.Key_Q)
        opened.key(KEYS.Key_Q, SHIFT)
    opened.drag(opened.on_screen(CHEEK), BY)
    alone = before.with_outline_point(5, outline(opened)[5])
    np.testing.assert_array_equal(outline(opened), alone.outline)


def test_the_wheel_changes_the_reach_of_a_drag_and_keys_do_between_drags(opened):
    opened.key(KEYS.Key_Q)
    at, zoom = opened.on_screen(CHEEK), opened.canvas.zoom
    opened.press(at)
    opened.move(at + BY)
    narrow = outline(opened)
    opened.turn_wheel(opened.canvas.viewport(), 4, at + BY)
    wide = outline(opened)
    assert opened.canvas.zoom == zoom
    assert opened.editor.view.following.reach > 6.0
    np.testing.assert_array_equal(wide[5], narrow[5])
    assert np.abs(wide[10] - narrow[10]).max() > 1.0
    opened.turn_wheel(opened.canvas.viewport(), -4, at + BY)
    np.testing.assert_allclose(outline(opened), narrow, atol=1e-9)
    opened.release(at + BY)
    assert steps(opened) == 1
    reach = opened.editor.view.following.reach
    opened.key(KEYS.Key_BracketRight, CONTROL)
    assert opened.editor.view.following.reach > reach
    assert "landmark spacings" in opened.window.status.hint_text
    opened.turn_wheel(opened.canvas.viewport(), 1, at)
    assert opened.canvas.zoom > zoom, "with nothing in hand the wheel zooms"


def test_without_soft_selection_the_wheel_zooms_during_a_drag(opened):
    at, zoom = opened.on_screen(CHEEK), opened.canvas.zoom
    opened.press(at)
    opened.turn_wheel(opened.canvas.viewport(), 1, at)
    opened.release(at)
    assert opened.canvas.zoom > zoom


def test_arrow_keys_take_the_neighbours_along(opened):
    before = opened.state.faces[0]
    opened.click(opened.on_screen(CHEEK))
    opened.key(KEYS.Key_Q)
    QTest.keyClick(opened.canvas, KEYS.Key_Left, SHIFT)
    reach_px = opened.editor.view.following.reach * before.anchor.spacing_px
    expected = moved(before, 5, before.outline[5] - (10.0, 0.0), reach_px)
    np.testing.assert_allclose(outline(opened), expected.outline, atol=1e-9)


@POINTS
def test_escape_takes_the_neighbours_back_and_a_wheel_brings_nothing_again(opened, point):
    if point is CHEEKS_TARGET:
        take_targets(opened)
    before = opened.state
    opened.key(KEYS.Key_Q)
    at = opened.on_screen(point)
    opened.press(at)
    opened.move(at + BY)
    assert opened.state is not before
    opened.key(KEYS.Key_Escape)
    opened.key(KEYS.Key_BracketRight, CONTROL)
    opened.move(at + 2 * BY)
    opened.release(at + 2 * BY)
    assert opened.state is before
    assert steps(opened) == 0


def test_targets_set_by_hand_and_points_inside_the_face_stay(opened):
    target = Handle("target", 0, 6)
    opened.key(KEYS.Key_L)
    opened.drag(opened.on_screen(target), QPoint(12, -12))
    opened.key(KEYS.Key_L)
    before = opened.state.faces[0]
    opened.key(KEYS.Key_Q)
    opened.drag(opened.on_screen(CHEEK), BY)
    after = opened.state.faces[0]
    assert (after.outline[6] != before.outline[6]).any()
    np.testing.assert_array_equal(after.targets[6], before.targets[6])
    np.testing.assert_array_equal(after.eyes, before.eyes)


def targets(driver):
    return driver.state.pairs[0].target_px


def take_targets(driver):
    """Show targets and no landmarks, so that the mouse finds the former."""
    driver.key(KEYS.Key_L)


def test_a_target_dragged_by_the_mouse_takes_its_neighbours_along_in_one_step(opened):
    take_targets(opened)
    before, face = targets(opened), opened.state.faces[0]
    opened.key(KEYS.Key_Q)
    at = opened.on_screen(CHEEKS_TARGET)
    opened.press(at)
    opened.move(at + BY)
    narrow = targets(opened)
    opened.turn_wheel(opened.canvas.viewport(), 4, at + BY)
    assert np.abs(targets(opened)[10] - narrow[10]).max() > 1.0, "the wheel says how far"
    opened.turn_wheel(opened.canvas.viewport(), -4, at + BY)
    opened.release(at + BY)
    opened.settle()
    by = targets(opened)[5] - before[5]
    assert by[0] < -15.0
    reach_px = opened.editor.view.following.reach * face.anchor.spacing_px
    followed = influence(face.outline, 5, reach_px)
    assert np.count_nonzero(followed) > 5
    np.testing.assert_allclose(targets(opened) - before, followed[:, None] * by, atol=1e-6)
    by_hand = np.isfinite(opened.state.faces[0].targets).all(axis=1)
    np.testing.assert_array_equal(by_hand, followed > 0.0)
    np.testing.assert_array_equal(outline(opened), face.outline)
    assert steps(opened) == 1
    assert opened.editor.document.undo.undoText().startswith("target 6, left ")
    opened.key(KEYS.Key_Z, CONTROL)
    np.testing.assert_array_equal(targets(opened), before)
    assert opened.state.faces[0].targets is None


@POINTS
def test_points_of_both_sides_move_at_once_by_mouse_and_by_arrow_key(opened, point):
    places = outline
    if point is CHEEKS_TARGET:
        take_targets(opened)
        places = targets
    before = places(opened)
    opened.key(KEYS.Key_Q, SHIFT)
    opened.drag(opened.on_screen(point), BY)
    by = places(opened) - before
    np.testing.assert_allclose(by[15], by[5] * (-1.0, 1.0), atol=1e-6)
    assert np.flatnonzero((np.abs(by) > 1e-6).any(axis=1)).tolist() == [5, 15]
    assert steps(opened) == 1
    before = places(opened)
    QTest.keyClick(opened.canvas, KEYS.Key_Left, SHIFT)
    by = places(opened) - before
    np.testing.assert_allclose(by[[5, 15]], [(-10.0, 0.0), (10.0, 0.0)], atol=1e-6)


@pytest.mark.parametrize("by_key", [False, True])
def test_a_click_with_control_or_a_key_calls_the_nearest_landmark(opened, by_key):
    before = opened.state.faces[0]
    there = place(opened, before.outline[5] + np.array([-30.0, 4.0]))
    if by_key:
        opened.move(there)
        opened.key(KEYS.Key_R)
    else:
        control_click(opened, there)
    np.testing.assert_allclose(outline(opened)[5], opened.canvas.to_photo(QPointF(there)))
    assert (np.flatnonzero((outline(opened) != before.outline).any(axis=1)) == [5]).all()
    assert steps(opened) == 1
    assert opened.editor.view.selected == CHEEK


def test_a_click_with_control_and_a_drag_are_one_step(opened):
    there = place(opened, outline(opened)[5] + np.array([-30.0, 4.0]))
    view = opened.canvas.viewport()
    QTest.mousePress(view, Qt.MouseButton.LeftButton, CONTROL, there)
    opened.move(there + BY)
    opened.release(there + BY)
    np.testing.assert_allclose(outline(opened)[5], opened.canvas.to_photo(QPointF(there + BY)))
    assert steps(opened) == 1


def test_neither_far_nor_hidden_landmarks_are_called(opened):
    before = opened.state
    control_click(opened, QPoint(4, 4))
    assert opened.state is before
    assert "No landmark of the selected face is near there" in opened.say()
    assert not opened.canvas.panning
    opened.key(KEYS.Key_L)
    control_click(opened, place(opened, outline(opened)[5]))
    assert opened.state is before


def test_only_the_selected_face_is_called(two):
    there = place(two, two.state.faces[1].outline[5] + np.array([-4.0, 4.0]))
    control_click(two, there)
    assert steps(two) == 0, "with no face selected none is meant"
    two.click(place(two, two.state.faces[1].eye_center))
    assert two.editor.view.face == 1
    control_click(two, there)
    moved_faces = two.state.faces
    np.testing.assert_allclose(moved_faces[1].outline[5], two.canvas.to_photo(QPointF(there)))
    assert steps(two) == 1


def test_with_the_brush_control_paints(opened):
    before = opened.state.faces
    opened.key(KEYS.Key_B)
    control_click(opened, place(opened, outline(opened)[5] + np.array([-20.0, 0.0])))
    assert opened.state.faces == before


@pytest.mark.parametrize("index", few_of((1, 4, 7, 2, 3, 5, 6), 1))
def test_a_wrong_cheek_is_mended_in_two_actions(start, source, photo, index):
    """The source has a cheek wrong: a smooth dent of a tenth of the face's width."""
    right = oval_face()
    inwards = right.middle - right.outline[index]
    dent = 0.1 * right.box[2] * inwards / np.linalg.norm(inwards)
    dented = moved(right, index, right.outline[index] + dent, 4.0 * right.anchor.spacing_px)
    source.faces = [dented]
    driver = start(photo)
    driver.key(KEYS.Key_Q)
    control_click(driver, place(driver, right.outline[index]))
    off = np.linalg.norm(outline(driver) - right.outline, axis=1)
    was = np.linalg.norm(dented.outline - right.outline, axis=1)
    assert off.max() < 0.25 * was.max()
    assert steps(driver) == 1


def band(driver):
    """Return whether the band is drawn."""
    area = driver.canvas.viewport().rect()
    picture = QImage(area.size(), QImage.Format.Format_ARGB32_Premultiplied)
    picture.fill(Qt.GlobalColor.transparent)
    blank, painter = picture.copy(), QPainter(picture)
    seen = Place(affine(driver.canvas._to_screen()), area.toRectF())
    FollowingBand(driver.editor.view).draw(painter, seen)
    painter.end()
    return picture != blank


@POINTS
def test_what_would_follow_is_drawn_before_and_during_a_drag(opened, point):
    if point is CHEEKS_TARGET:
        take_targets(opened)
    at = opened.on_screen(point)
    opened.move(at)
    assert not band(opened)
    opened.key(KEYS.Key_Q)
    assert band(opened)
    plain = opened.canvas.grab().toImage()
    opened.press(at)
    opened.move(at + BY)
    assert band(opened)
    opened.turn_wheel(opened.canvas.viewport(), 3, at + BY)
    assert opened.canvas.grab().toImage() != plain
    opened.release(at + BY)
    opened.key(KEYS.Key_T if point is CHEEKS_TARGET else KEYS.Key_O)
    assert not band(opened), "with targets, or all overlays, hidden"


def test_how_neighbours_follow_is_remembered(start):
    first = start()
    first.key(KEYS.Key_Q)
    first.key(KEYS.Key_BracketRight, CONTROL)
    first.key(KEYS.Key_Q, SHIFT)
    later = start()
    assert later.editor.view.following == first.editor.view.following
    assert later.window.actions_by_name["soft"].isChecked()
    assert later.window.actions_by_name["symmetric"].isChecked()
    assert later.window.actions_by_name["reach-wider"].isEnabled()


@pytest.mark.parametrize(("stored", "reach"), [("1e99", 12.0), ("far", 1.5)])
def test_a_reach_that_is_none_is_brought_within_bounds(storage, start, stored, reach):
    storage.settings().setValue("soft-selection/reach", stored)
    assert start().editor.view.following.reach == reach
