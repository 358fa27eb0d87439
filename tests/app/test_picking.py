"""Faces are selected where they are seen, and only the selected one's points can be taken."""

from __future__ import annotations

import numpy as np
import pytest
from kogao_app.canvas.handles import face_at, position
from kogao_app.canvas.overlays.overlay import Place, affine
from kogao_app.canvas.overlays.unlisted import badges
from kogao_app.canvas.photo_canvas import GRAB_RADIUS_PX
from kogao_app.view_state import Handle
from PySide6.QtCore import QPoint, Qt
from scenes import oval_face

pytestmark = pytest.mark.usefixtures("one_window")

KEYS = Qt.Key
CHIN, EYE, TARGET = Handle("outline", 1, 10), Handle("eye", 1, 2), Handle("target", 1, 5)
TICK = Handle("centre", 1, 2)
AWAY = QPoint(24, 16)


def on_photo(driver, x, y) -> QPoint:
    return driver.canvas.to_screen(np.array([x, y], float)).toPoint()


def cheek(driver, face) -> QPoint:
    """Bare skin: no mark within reach."""
    points = driver.state.faces[face]
    return on_photo(driver, *(0.5 * points.eyes[0] + 0.5 * points.outline[5]))


def forehead(driver, face) -> QPoint:
    points = driver.state.faces[face]
    up = points.eye_center - points.mouth_center
    return on_photo(driver, *(points.eye_center + 0.9 * up))


def number(driver, face) -> QPoint:
    canvas = driver.canvas
    area = canvas.viewport().rect().toRectF()
    place = Place(affine(canvas._to_screen()), area)
    found = {badge.face: badge for badge in badges(canvas.shown, place, canvas.viewport().font())}
    return found[face].plate.center().toPoint()


PLACES = {
    "chin": lambda driver: driver.on_screen(CHIN),
    "eye": lambda driver: driver.on_screen(EYE),
    "target": lambda driver: driver.on_screen(TARGET),
    "centre tick": lambda driver: driver.on_screen(TICK),
    "skin": lambda driver: cheek(driver, 1),
    "forehead": lambda driver: forehead(driver, 1),
    "number": lambda driver: number(driver, 1),
}


def test_a_click_on_a_face_selects_it_and_changes_nothing(two):
    before = two.state
    for name, place in PLACES.items():
        assert two.editor.view.face is None, name
        two.click(place(two))
        assert two.editor.view.face == 1, name
        assert two.panel("recipe").owner.title.text() == "Face 2", name
        assert two.panel("faces").list.currentRow() == 2, name
        assert two.editor.view.selected is None, name
        assert two.state is before, name
        assert two.editor.document.undo.count() == 0, name
        two.key(Qt.Key.Key_Escape)


@pytest.mark.parametrize("handle", [CHIN, EYE, TARGET])
def test_a_drag_from_a_point_of_a_face_not_selected_pans(two, handle):
    before, at = two.state, two.on_screen(handle)
    two.drag(at, AWAY)
    assert two.state is before
    assert two.editor.view.face is None
    assert two.on_screen(handle) - at == AWAY


def test_the_selected_faces_points_are_dragged_and_no_others(two):
    two.click(cheek(two, 1))
    before, other = two.state.faces, Handle("outline", 0, 10)
    two.drag(two.on_screen(CHIN), QPoint(0, 20))
    assert position(two.state, CHIN)[1] > before[1].outline[10][1] + 5
    two.drag(two.on_screen(other), QPoint(0, 20))
    assert two.state.faces[0] is before[0]
    assert two.editor.view.face == 1


def test_a_click_that_trembles_selects_and_moves_nothing(two):
    place = cheek(two, 0)
    two.press(place)
    two.move(place + QPoint(2, 1))
    two.release(place + QPoint(2, 1))
    assert two.editor.view.face == 0
    assert cheek(two, 0) == place


def test_a_click_beside_all_faces_keeps_the_selection_and_escape_lets_it_go(two):
    two.click(cheek(two, 1))
    two.click(two.on_screen(CHIN))
    two.click(on_photo(two, 235, 20))
    assert two.editor.view.face == 1
    two.key(KEYS.Key_Escape)
    assert (two.editor.view.selected, two.editor.view.face) == (None, 1)
    two.key(KEYS.Key_Escape)
    assert two.editor.view.face is None
    assert two.panel("faces").list.currentRow() == 0


def test_another_face_selected_lets_the_point_of_the_first_go(two):
    two.click(cheek(two, 1))
    two.click(two.on_screen(CHIN))
    assert two.editor.view.selected == CHIN
    two.click(cheek(two, 0))
    assert two.editor.view.selected is None


def test_a_neighbour_is_selected_beside_a_point_of_the_selected_face(two, source):
    source.faces = [oval_face(center=(x, 170), size=0.45) for x in (180, 308)]
    two.key(KEYS.Key_F, Qt.KeyboardModifier.ControlModifier)
    two.settle()
    two.click(cheek(two, 0))
    first, second = two.state.faces
    place = first.outline[18] + (5.0, 0.0)
    assert face_at([second], place, 0.0) == 0
    at = two.canvas.to_screen(place) - two.canvas.to_screen(first.outline[18])
    assert at.x() < GRAB_RADIUS_PX
    two.click(on_photo(two, *place))
    assert two.editor.view.face == 1


def test_faces_that_overlap_are_told_by_which_one_a_place_lies_deeper_in():
    near, far = oval_face(center=(200, 170)), oval_face(center=(260, 170), size=0.4)
    assert face_at([near, far], np.array([180.0, 170.0]), 0.0) == 0
    assert face_at([near, far], np.array([262.0, 170.0]), 0.0) == 1
    assert face_at([near, far], np.array([20.0, 20.0]), 0.0) is None
    rim = near.outline[10] + (0.0, 4.0)
    assert face_at([near, far], rim, 5.0) == 0
    assert face_at([near, far], rim, 3.0) is None


def test_the_cursor_says_what_a_click_does(two):
    shapes = []
    for _ in range(2):
        two.move(cheek(two, 1))
        shapes.append(two.canvas.viewport().cursor().shape())
        two.click(cheek(two, 1))
    assert shapes == [Qt.CursorShape.PointingHandCursor, Qt.CursorShape.ArrowCursor]
