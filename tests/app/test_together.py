"""Photos side by side: linked zoom and pan, before and after, from the film strip."""

import cv2
import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAccessible
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolButton
from test_accessibility import of
from test_own_results import click_on
from test_own_results import strip as strip

pytestmark = pytest.mark.usefixtures("one_window")
CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
KEYS, LEFT = Qt.Key, Qt.MouseButton.LeftButton


@pytest.fixture
def together(strip):
    """Three photos side by side: one with edits, one without, a damaged one."""
    strip.edit(6.0)
    click_on(strip, 2, CONTROL)
    click_on(strip, 5, CONTROL)
    strip.key(KEYS.Key_Y, SHIFT)
    strip.settle()
    yield strip
    if (dialog := strip.editor.together.dialog) is not None:
        dialog.reject()


def places(views):
    """The middle and the zoom of each view."""
    middles = [view.to_photo(view.viewport().rect().toRectF().center()) for view in views]
    return np.array([[*middle, view.zoom] for middle, view in zip(middles, views, strict=True)])


def drag(view, by, held=Qt.KeyboardModifier.NoModifier):
    start = view.rect().center()
    QTest.mousePress(view.viewport(), LEFT, held, start)
    QTest.mouseMove(view.viewport(), start + by)
    QTest.mouseRelease(view.viewport(), LEFT, held, start + by)


def test_photos_are_shown_after_and_before_their_edits(together):
    edited, untouched, damaged = together.editor.together.dialog.views
    document = edited.shown.document
    assert "damaged or incomplete" in damaged.toolTip()
    original = together.editor.document.pyramid.levels[0]
    apart, change = (cv2.absdiff(document.pyramid.levels[0], one).mean()
                     for one in (together.shown, original))  # fmt: skip
    assert apart < 0.3 * change
    QTest.keyClick(together.editor.together.dialog, KEYS.Key_F4)
    np.testing.assert_array_equal(document.pyramid.levels[0], original)
    np.testing.assert_array_equal(untouched.shown.document.pyramid.levels[0], original)


def test_each_control_has_a_name_and_a_key(together):
    dialog = together.editor.together.dialog
    buttons = [one for one in dialog.findChildren(QToolButton) if one.isVisible()]
    assert len(buttons) == 5
    for one in buttons:
        assert of(one).text(QAccessible.Text.Name)
        assert one.defaultAction().shortcuts()
        assert one.focusPolicy() == Qt.FocusPolicy.StrongFocus
    assert [of(one).text(QAccessible.Text.Name) for one in dialog.views] == [
        "a.png · 1 face made smaller: 6 %",
        "b.png · no edits",
        "e.png · can't be read",
    ]
    together.press_key(dialog.views[1], KEYS.Key_Return)
    together.settle()
    assert together.editor.document.path.name == "b.png"


def test_wheel_drag_and_keys_move_all(together):
    views = together.editor.together.dialog.views[:2]
    fitted = places(views)
    together.turn_wheel(views[0].viewport(), 2, QPoint(40, 50))
    zoomed = places(views)
    assert (zoomed[:, 2] > 1.5 * fitted[:, 2]).all()
    np.testing.assert_allclose(*zoomed, atol=2.0)  # the columns may differ by a pixel
    drag(views[1], QPoint(30, 20))
    dragged = places(views)
    np.testing.assert_allclose(*dragged, atol=2.0)
    assert (dragged[:, :2] < zoomed[:, :2] - 5.0).all()
    drag(views[1], QPoint(-60, 0), SHIFT)
    alone = places(views) - dragged
    assert alone[0, 0] == 0.0
    assert alone[1, 0] > 20.0
    together.press_key(views[0], KEYS.Key_Left)
    assert (places(views)[:, 0] < (dragged + alone)[:, 0]).all()
    QTest.keyClick(views[0], KEYS.Key_0)
    np.testing.assert_allclose(places(views), fitted)
    QTest.keyClick(views[0], KEYS.Key_F)
    assert places(views)[0, 2] > places(views)[1, 2], "faces are known of the edited photo alone"


def test_a_double_click_opens_the_photo(together):
    dialog = together.editor.together.dialog
    QTest.mouseDClick(dialog.views[1].viewport(), LEFT)
    together.settle()
    assert together.editor.together.dialog is None
    assert together.editor.document.path.name == "b.png"


def test_too_few_photos_are_not_shown_side_by_side(strip):
    strip.key(KEYS.Key_Y, SHIFT)
    assert "Select two to six photos" in strip.say()
