"""Manual mode: points by hand against a clock, and both modes side by side."""

import dataclasses

import numpy as np
import pytest
from kogao_app.canvas.handles import position
from kogao_app.features.both import faces_compared
from kogao_app.features.manual import SettingClock
from kogao_app.view_state import Handle
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolButton
from scenes import oval_face

from kogao_core.faces.targets import differences
from kogao_core.projects.interchange import along
from kogao_core.recipe.recipe import Recipe

pytestmark = pytest.mark.usefixtures("one_window")

KEYS, CONTROL, SHIFT = (
    Qt.Key,
    Qt.KeyboardModifier.ControlModifier,
    Qt.KeyboardModifier.ShiftModifier,
)


def at(driver, point):
    return driver.canvas.to_screen(np.asarray(point, float)).toPoint()


def click(driver, point):
    driver.click(at(driver, point))


def mark(driver, source, target):
    """Press on the landmark, drag to the target."""
    driver.press(at(driver, source))
    driver.move(at(driver, target))
    driver.release(at(driver, target))


def mark_face(driver, points=range(0, 21, 5)):
    face = oval_face()
    for corner in (*face.eyes, *face.mouth):
        click(driver, corner)
    middle = face.points.mean(axis=0)
    for index in points:
        mark(driver, face.outline[index], 0.93 * face.outline[index] + 0.07 * middle)
    driver.settle()


@pytest.fixture
def manual(opened):
    button = next(
        b
        for b in opened.window.findChildren(QToolButton)
        if b.defaultAction() is opened.window.actions_by_name["mode-manual"]
    )
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    opened.settle()
    return opened


def test_manual_mode_begins_empty_and_says_what_to_click(manual, pixels):
    assert manual.state.mode == "manual"
    assert manual.state.faces == ()
    assert manual.panel("manual").isVisible()
    assert manual.window.status.hint_text == "Click the left eye, outer corner (1 of 6)"
    np.testing.assert_array_equal(manual.shown, pixels)
    manual.move(QPoint(5, 5))
    assert manual.canvas.viewport().cursor().shape() == Qt.CursorShape.CrossCursor


def test_a_face_is_marked_with_the_mouse_alone(manual, pixels):
    mark_face(manual)
    assert manual.window.status.hint_text.startswith("Press on the outline and drag")
    (face,) = manual.state.faces
    near = 0.75 / manual.canvas.zoom
    np.testing.assert_allclose(face.eyes, oval_face().eyes, atol=near)
    np.testing.assert_allclose(face.outline, oval_face().outline[::5], atol=near)
    assert np.isfinite(face.targets).all()
    assert manual.state.draft == ()
    np.testing.assert_array_equal(manual.shown, manual.rendered(pixels))
    assert (manual.shown != pixels).any()


def test_points_are_set_on_the_original_until_they_are_applied(manual):
    view = manual.editor.view
    mark_face(manual)
    assert view.shows_original
    assert "Ctrl" not in manual.window.status.hint_text
    manual.key(KEYS.Key_Return, CONTROL)
    assert not view.shows_original
    manual.drag(manual.on_screen(Handle("outline", 0, 2)), QPoint(6, 6))
    assert view.shows_original
    assert manual.window.status.hint_text == "Apply (Ctrl+Return) shows the result"
    manual.key(KEYS.Key_Z, CONTROL)
    assert not view.shows_original
    manual.key(KEYS.Key_F2)
    manual.settle()
    manual.drag(manual.on_screen(Handle("outline", 0, 2)), QPoint(6, 6))
    assert not view.shows_original, "a point of a found face stays live"


@pytest.mark.parametrize(("answer", "mode"), [("Automatic", "automatic"), ("so far", "manual")])
def test_a_face_marked_in_part_is_saved_after_a_question_only(manual, tmp_path, answer, mode):
    mark_face(manual, points=range(0, 8, 2))
    spoken = manual.panel("faces").item(0).data(Qt.ItemDataRole.AccessibleTextRole)
    assert spoken == "Face 1, in part, by hand"
    file = tmp_path / "copy.png"
    manual.save(file)
    assert not file.exists()
    manual.answer(answer)
    manual.settle()
    assert file.exists()
    assert manual.state.mode == mode
    assert not manual.editor.view.shows_original


def test_saving_a_whole_face_applies_its_points(manual, tmp_path):
    mark_face(manual)
    manual.save(tmp_path / "copy.png")
    assert (tmp_path / "copy.png").exists()
    assert manual.editor.manual.clock.applied


def test_marks_are_undone_one_by_one(manual):
    mark_face(manual, points=range(0, 8, 2))
    assert len(manual.state.faces[0].outline) == 4
    manual.key(KEYS.Key_Z, CONTROL)
    assert len(manual.state.faces[0].outline) == 3
    manual.key(KEYS.Key_Z, CONTROL)
    assert manual.state.faces == ()
    assert len(manual.state.draft) == 8
    manual.key(KEYS.Key_Z, CONTROL, SHIFT)
    assert len(manual.state.faces) == 1


def test_landmarks_find_their_place_along_the_outline(manual):
    mark_face(manual, points=(10, 0, 20, 5, 15))
    outline = manual.state.faces[0].outline
    apart = np.linalg.norm(oval_face().outline[:, None] - outline, axis=2)
    assert apart.argmin(axis=0).tolist() == [0, 5, 10, 15, 20]


def test_switching_modes_keeps_both_states(manual):
    mark_face(manual)
    by_hand = manual.state.faces
    manual.key(KEYS.Key_F2)
    manual.settle()
    found = manual.state.faces
    assert manual.state.mode == "automatic"
    assert not manual.panel("manual").isVisible()
    assert len(found[0].outline) == 21
    manual.press_key(manual.panel("recipe").percent.slider, KEYS.Key_End)
    manual.key(KEYS.Key_F3)
    manual.settle()
    assert manual.state.faces is by_hand
    assert manual.state.recipe.percent == 4.0
    manual.key(KEYS.Key_F2)
    assert manual.state.faces is found
    assert manual.state.recipe.percent == 15.0


def test_faces_found_late_leave_marks_alone_and_a_choice_is_of_one_mode(manual):
    mark_face(manual)
    by_hand = manual.state.faces
    manual.key(KEYS.Key_F, CONTROL)
    manual.settle()
    assert manual.state.faces is by_hand
    assert len(manual.state.sheet("automatic").faces) == 1
    manual.key(KEYS.Key_F2)
    manual.editor.recipe.choose(0)
    manual.key(KEYS.Key_F3)
    assert manual.editor.view.face is None
    assert manual.panel("recipe").owner.title.text() == "All faces"


def pick(driver, handle):
    driver.key(KEYS.Key_M)
    driver.click(driver.on_screen(handle))
    assert driver.editor.view.selected == handle


def test_delete_removes_the_selected_landmark(manual):
    mark_face(manual)
    before = manual.state.faces[0].outline
    pick(manual, Handle("outline", 0, 2))
    manual.key(KEYS.Key_Delete)
    np.testing.assert_array_equal(manual.state.faces[0].outline, np.delete(before, 2, axis=0))
    assert manual.editor.view.selected is None


def test_the_last_three_landmarks_take_the_face_along(manual):
    mark_face(manual, points=(0, 10, 20))
    pick(manual, Handle("outline", 0, 1))
    manual.key(KEYS.Key_Delete)
    assert manual.state.faces == ()


def test_mirror_puts_the_landmark_on_the_other_side(manual):
    mark_face(manual, points=(0, 4, 10, 20))
    face = manual.state.faces[0]
    pick(manual, Handle("outline", 0, 1))
    manual.key(KEYS.Key_M, SHIFT)
    outline, targets = manual.state.faces[0].outline, manual.state.faces[0].targets
    assert len(outline) == 5
    axis = face.eye_center[0]
    np.testing.assert_allclose(outline[3], [2 * axis - outline[1, 0], outline[1, 1]], atol=2.0)
    np.testing.assert_allclose(targets[3], [2 * axis - targets[1, 0], targets[1, 1]], atol=2.0)
    # A second time the mirrored landmark only takes its place again.
    manual.key(KEYS.Key_M, SHIFT)
    assert len(manual.state.faces[0].outline) == 5


@pytest.mark.parametrize("index", [1, 4])
def test_mirror_side_makes_both_sides_alike(manual, index):
    mark_face(manual, points=(0, 3, 6, 10, 13, 16, 20))
    pick(manual, Handle("outline", 0, index))
    manual.key(KEYS.Key_M, CONTROL)
    face = manual.state.faces[0]
    normal = np.array(
        [face.mouth_center[1] - face.eye_center[1], face.eye_center[0] - face.mouth_center[0]]
    )
    normal /= np.linalg.norm(normal)
    side = (face.outline - face.eye_center) @ normal
    assert len(face.outline) == 7
    alike = [0, 1, 2, 4, 5, 6]  # the chin stays where it was
    np.testing.assert_allclose(side[alike], -side[::-1][alike], atol=1e-9)
    assert (side[:3] < 0).all()


def test_snap_puts_the_target_on_the_line_to_the_centre(manual):
    mark_face(manual)
    pairs = manual.state.pairs[0]
    handle = Handle("target", 0, 2)
    manual.key(KEYS.Key_L)
    pick(manual, handle)
    QTest.keyClick(manual.canvas, KEYS.Key_Down, SHIFT)
    manual.key(KEYS.Key_N, SHIFT)
    moved = position(manual.state, handle)
    way, line = moved - pairs.source_px[2], pairs.center_px - pairs.source_px[2]
    assert abs(way[0] * line[1] - way[1] * line[0]) < 1e-6 * np.linalg.norm(line) ** 2
    assert np.linalg.norm(moved - pairs.target_px[2]) > 1.0


def test_a_press_marks_nothing_without_the_marker_or_once_it_is_given_up(manual):
    manual.press(at(manual, (100, 100)))
    manual.move(at(manual, (110, 100)))
    manual.key(KEYS.Key_Escape)
    manual.release(at(manual, (110, 100)))
    assert manual.state.draft == ()
    manual.key(KEYS.Key_M)
    assert not manual.editor.view.marking
    click(manual, (20, 20))
    assert manual.state.draft == ()


def test_a_brush_puts_the_marker_away_and_back(manual):
    manual.key(KEYS.Key_B)
    assert not manual.editor.view.marking
    manual.key(KEYS.Key_M)
    assert manual.editor.view.marking
    assert not manual.editor.view.brush.paints


# -- the clock -----------------------------------------------------------------------------------


@pytest.mark.usefixtures("qapp")
def test_the_clock_waits_for_the_photo():
    clock = SettingClock()
    clock.want(True)
    assert not clock.running
    clock.show_photo()
    assert clock.running


def test_the_clock_stops_on_apply_and_goes_on_with_the_next_mark(manual, photo):
    clock = manual.editor.manual.clock
    click(manual, (90, 90))
    assert clock.running
    assert manual.panel("manual").note.text() == "setting"
    manual.key(KEYS.Key_F2)
    assert not clock.running
    manual.key(KEYS.Key_F3)
    assert clock.running
    manual.key(KEYS.Key_Return, CONTROL)
    assert not clock.running
    assert manual.panel("manual").note.text() == "applied"
    click(manual, (100, 100))
    assert clock.running
    manual.qtbot.waitUntil(lambda: clock.elapsed_s > 0.0)
    other = photo.with_name("other.png")  # the same one would go on where it was left
    other.write_bytes(photo.read_bytes())
    manual.editor.files.read(other)
    manual.settle()
    assert clock.elapsed_s == 0.0
    assert manual.state.mode == "automatic"


def test_another_window_pauses_the_clock(manual, start):
    clock = manual.editor.manual.clock
    click(manual, (90, 90))
    other = start()
    other.window.activateWindow()
    manual.qtbot.waitUntil(lambda: not manual.window.isActiveWindow())
    assert not clock.running
    manual.window.activateWindow()
    manual.qtbot.waitUntil(lambda: clock.running)


def test_looking_takes_time_and_is_no_change(manual):
    clock = manual.editor.manual.clock
    assert clock.running
    assert clock.looking_s is None
    assert not manual.editor.document.dirty
    click(manual, (90, 90))
    assert clock.looking_s is not None
    assert manual.editor.document.dirty
    manual.key(KEYS.Key_Return, CONTROL)
    manual.key(KEYS.Key_F2)
    manual.key(KEYS.Key_F3)
    assert not clock.running
    assert manual.panel("manual").note.text() == "applied"
    manual.key(KEYS.Key_Z, CONTROL)
    manual.key(KEYS.Key_Z, CONTROL)
    manual.key(KEYS.Key_Z, CONTROL)
    assert manual.state.draft == ()
    assert not manual.window.isWindowModified()
    manual.window.close()
    assert not manual.window.isVisible()


# -- the comparison ------------------------------------------------------------------------------


def test_differences_are_the_distances_from_the_outline(manual):
    mark_face(manual, points=range(21))
    state = manual.state
    ((mine, theirs, apart),) = faces_compared(state)
    hand, found = state.sheet("manual").faces[mine], state.sheet("automatic").faces[theirs]
    between = np.linalg.norm(hand.outline - found.outline, axis=1)
    assert (apart.landmarks_px <= between + 1e-9).all()
    for count in (9, 11, 34):
        outline = along(found.outline, count) + np.array([0.0, 3.0])
        moved = dataclasses.replace(hand, outline=outline, targets=None)
        slid = differences(moved, found, (Recipe(), Recipe()))
        assert slid.landmarks_px.max() < 3.1
        assert slid.landmarks_px[count // 2] == pytest.approx(3.0, abs=0.05), "the chin"
