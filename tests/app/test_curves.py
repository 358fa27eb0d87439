"""Curves on the face: a drag moves the slider of the same name."""

import numpy as np
import pytest
from kogao_app.canvas.overlays.curves import curves
from PySide6.QtCore import QPoint, Qt
from scenes import KnownFaces, oval_face

pytestmark = pytest.mark.usefixtures("one_window")
FIELDS = ("chin_length", "jaw_width", "cheeks_width", "width", "forehead_height")


@pytest.fixture
def source():
    return KnownFaces(oval_face(center=(239.5, 210.0), size=0.45, forehead=True))


@pytest.fixture
def retouch(start, photo):
    driver = start(photo, workspace="retouch")
    driver.canvas.zoom_to(1.6, driver.canvas.rect().center().toPointF())
    driver.settle()
    # The marks of a face appear when the pointer comes to it.
    driver.move(driver.canvas.to_screen(driver.state.faces[0].middle).toPoint())
    return driver


def grip(driver, field):
    """A place on a curve, on the screen, that is far from every dot; and 5 % further out."""
    dots = driver.state.faces[0].points
    found = [one for one in curves(driver.state, 0) if one.field == field]
    places = [(at, at + 5 * step) for one in found for at, step in zip(one.points_px, one.steps_px)]  # noqa: B905
    far = max(places, key=lambda place: np.hypot(*(dots - place[0]).T).min())
    return [driver.canvas.to_screen(at).toPoint() for at in far]


@pytest.mark.parametrize("field", FIELDS)
def test_a_drag_moves_the_slider_of_the_same_name_as_one_step(retouch, field):
    before = retouch.state
    at, out = grip(retouch, field)
    retouch.move(at)
    assert retouch.editor.view.shaping == field
    retouch.press(at)
    retouch.move(at + (out - at) / 2)
    assert retouch.editor.document.in_gesture
    retouch.move(out)
    retouch.release(out)
    recipe = retouch.state.recipe
    assert getattr(recipe, field) == pytest.approx(5.0, abs=1.5)
    assert all(getattr(recipe, one) == 0.0 for one in FIELDS if one != field)
    slider = retouch.panel("recipe").sliders[field].slider
    assert slider.amount() == getattr(recipe, field)
    assert retouch.editor.document.undo.count() == 1
    retouch.editor.document.undo.undo()
    assert retouch.state == before


def test_a_drag_ends_at_the_limit_of_the_slider_and_escape_takes_it_back(retouch):
    at, _ = grip(retouch, "chin_length")
    retouch.move(at)
    retouch.press(at)
    retouch.move(at - QPoint(0, 90))
    assert retouch.state.recipe.chin_length == -15.0
    retouch.key(Qt.Key.Key_Escape)
    retouch.release(at)
    assert retouch.state.recipe.chin_length == 0.0
    assert not retouch.editor.document.undo.count()


def test_a_dot_wins_over_a_curve_and_a_switch_puts_all_curves_away(retouch):
    dot = retouch.canvas.to_screen(retouch.state.faces[0].outline[10]).toPoint()
    retouch.move(dot)
    assert retouch.editor.view.shaping is None
    assert retouch.editor.view.hovered is not None
    at, _ = grip(retouch, "jaw_width")
    retouch.key(Qt.Key.Key_U)
    retouch.move(at)
    assert retouch.editor.view.shaping is None
    retouch.drag(at, QPoint(8, 0))
    assert retouch.state.recipe.jaw_width == 0.0


def test_curves_rest_unless_the_whole_face_is_in_view(retouch):
    at, _ = grip(retouch, "chin_length")
    retouch.canvas.zoom_to(6.0, at.toPointF())
    retouch.move(grip(retouch, "chin_length")[0])
    assert retouch.editor.view.shaping is None
