"""Overlays, the original, zoom and pan, the readings."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from kogao_app.layers import layers
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QImage, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractSlider,
    QApplication,
    QCheckBox,
    QComboBox,
    QListWidget,
    QScrollArea,
)

from kogao_core.domain import pixel_counts
from kogao_core.recipe import LOSSLESS_PX, Recipe


def picture(driver) -> np.ndarray:
    """What the canvas looks like."""
    driver.qtbot.wait(0)
    image = driver.canvas.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine())
    return rows[:, : 3 * image.width()].copy()


@pytest.mark.parametrize("layer", layers(), ids=lambda layer: layer.name)
def test_a_key_toggles_an_overlay_and_its_box(opened, layer):
    box = next(b for b in opened.window.overlays.findChildren(QCheckBox) if b.text() == layer.title)
    was = layer.name in opened.editor.scene.visible
    assert box.isChecked() == was
    before = picture(opened)
    opened.key(Qt.Key[f"Key_{layer.key}"])
    assert (layer.name in opened.editor.scene.visible) != was
    assert box.isChecked() != was
    if layer.name not in ("folds", "straight", "protection"):  # there are none here
        assert (picture(opened) != before).any()
    opened.key(Qt.Key[f"Key_{layer.key}"])
    np.testing.assert_array_equal(picture(opened), before)


def test_folded_cells_are_drawn_and_counted(opened):
    panel = opened.window.recipe
    assert "✓" in panel.one_to_one.text()
    panel.lattice.slider.setFocus()
    QTest.keyClick(panel.lattice.slider, Qt.Key.Key_Home)
    panel.percent.slider.setFocus()
    QTest.keyClick(panel.percent.slider, Qt.Key.Key_End)
    opened.settle()
    assert "held back" in panel.one_to_one.text()
    panel.guard.click()
    opened.settle()
    cells = len(opened.editor.scene.frame.rendering.one_to_one.folded_cells)
    assert cells > 0
    assert f"folds in {cells} cells" in panel.one_to_one.text()
    drawn = picture(opened)
    opened.key(Qt.Key.Key_J)
    assert (picture(opened) != drawn).any()


def test_a_threshold_that_is_not_used_is_told(opened):
    recipe = Recipe(percent=8, lattice=0.5, threshold_px=2.0)
    opened.editor.editing.step(dataclasses.replace(opened.state, recipe=recipe), "")
    opened.settle()
    assert "threshold not used" in opened.window.recipe.one_to_one.text()
    shown = opened.editor.scene.frame.rendering
    assert shown.pixel_counts == pixel_counts(shown.field, shown.domain.image, LOSSLESS_PX)


def test_the_backslash_shows_the_original_while_it_is_held(opened):
    for key in (Qt.Key.Key_L, Qt.Key.Key_T, Qt.Key.Key_C):
        opened.key(key)
    result = picture(opened)
    QTest.keyPress(opened.window, Qt.Key.Key_Backslash)
    original = picture(opened)
    assert (original != result).any()
    QTest.keyRelease(opened.window, Qt.Key.Key_Backslash)
    np.testing.assert_array_equal(picture(opened), result)
    opened.window.faces.item(0).setCheckState(Qt.CheckState.Unchecked)
    opened.settle()
    np.testing.assert_array_equal(picture(opened), original)


def test_at_100_percent_the_screen_shows_the_results_own_pixels(opened):
    for key in (Qt.Key.Key_L, Qt.Key.Key_T, Qt.Key.Key_C, Qt.Key.Key_1):
        opened.key(key)
    assert opened.canvas.zoom == pytest.approx(1.0)
    # The photo's pixels must fall on the screen's for the comparison.
    corner = opened.canvas.to_screen(np.array([-0.5, -0.5]))
    opened.canvas.start_pan(corner)
    opened.canvas.pan_to(QPointF(round(corner.x()), round(corner.y())))
    opened.canvas.end_pan()
    left, top = round(corner.x()), round(corner.y())
    seen = picture(opened).reshape(opened.canvas.height(), opened.canvas.width(), 3)
    height, width = opened.shown.shape[:2]
    assert left >= 0
    assert top >= 0
    np.testing.assert_array_equal(seen[top : top + height, left : left + width], opened.shown)


def test_the_wheel_zooms_at_the_cursor(opened):
    at = QPointF(opened.canvas.width() * 0.3, opened.canvas.height() * 0.6)
    place, zoom = opened.canvas.to_photo(at), opened.canvas.zoom
    event = QWheelEvent(
        at,
        opened.canvas.viewport().mapToGlobal(at),
        QPoint(),
        QPoint(0, 240),
        Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(opened.canvas.viewport(), event)
    assert opened.canvas.zoom == pytest.approx(zoom * 1.25**2)
    np.testing.assert_allclose(opened.canvas.to_photo(at), place, atol=1e-6)
    opened.key(Qt.Key.Key_0)
    assert opened.canvas.zoom == pytest.approx(zoom)


def test_space_and_a_drag_pan_even_over_a_point(opened):
    before = opened.state
    center = before.faces[0].outline[10]
    at = opened.canvas.to_screen(center).toPoint()
    QTest.keyPress(opened.canvas, Qt.Key.Key_Space)
    opened.drag(at, QPoint(25, -15))
    QTest.keyRelease(opened.canvas, Qt.Key.Key_Space)
    assert opened.state is before
    there = opened.canvas.to_screen(center).toPoint() - at
    assert (there.x(), there.y()) == (25, -15)


def test_the_point_under_the_cursor_is_named(opened):
    opened.move(opened.canvas.to_screen(opened.state.faces[0].outline[10]).toPoint())
    assert opened.editor.scene.hovered is not None
    assert opened.window.status.hint_text == "outline 11, chin"


def test_readings_show_the_pipelines_own_numbers(opened, pixels):
    rendering = opened.editor.scene.frame.rendering
    counts = rendering.pixel_counts
    assert counts["image"] == pixels.shape[0] * pixels.shape[1]
    shown = opened.window.readings.domains.texts()
    for name, count in counts.items():
        assert shown[name][0].replace("\u2009", "") == f"{count} px"
    warp = opened.window.readings.timings.texts()["warp"]
    assert warp == f"{rendering.timings_ms['warp']:.1f} ms"


def test_every_control_has_a_name_for_screen_readers(opened):
    kinds = (QAbstractSlider, QComboBox, QListWidget)
    panels = (
        opened.window.recipe,
        opened.window.faces,
        opened.window.overlays,
        opened.window.protect,
    )
    controls = [
        control
        for panel in panels
        for kind in kinds
        for control in panel.findChildren(kind)
        if control.isVisibleTo(panel) and control.objectName() != "qt_scrollarea_vcontainer"
    ]
    named = [c for c in controls if not c.objectName().startswith("qt_") and c.focusPolicy()]
    assert len(named) >= 3
    assert all(control.accessibleName() for control in named)


def test_keys_are_given_once(opened):
    keys = [a.shortcut().toString() for a in opened.window.actions_by_name.values()]
    keys = [key for key in keys if key]
    assert len(keys) == len(set(keys))


def test_the_side_panel_is_never_wider_than_its_place(opened):
    panel, area = opened.window.recipe, opened.window.manual.window().findChild(QScrollArea)
    assert area.isAncestorOf(panel)
    for slider in (panel.lattice.slider, panel.percent.slider):
        slider.setFocus()
        QTest.keyClick(slider, Qt.Key.Key_Home)
    QTest.keyClick(panel.percent.slider, Qt.Key.Key_End)
    opened.settle()
    assert "⚠" in panel.gauge.text.text()
    assert "⚠" in panel.one_to_one.text()
    room = area.width() - area.verticalScrollBar().sizeHint().width()
    assert area.widget().minimumSizeHint().width() <= room
