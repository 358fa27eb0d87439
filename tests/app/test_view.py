"""Overlays, the original, zoom and pan, the readings."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from kogao_app.canvas.overlays.glyphs import outward_plate, plate
from kogao_app.canvas.overlays.listed import LISTED
from kogao_app.i18n import translated
from kogao_app.view_state import Handle
from PySide6.QtCore import QPoint, QPointF, QRectF, Qt
from PySide6.QtGui import QImage, QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QCheckBox, QLabel
from scenes import ALONE

from kogao_core.paper.domain import pixel_counts
from kogao_core.recipe.recipe import LOSSLESS_PX, PAPER

pytestmark = pytest.mark.usefixtures("one_window")


def picture(driver) -> np.ndarray:
    """What the canvas looks like."""
    driver.qtbot.wait(0)
    image = driver.canvas.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine())
    return rows[:, : 3 * image.width()].copy()


def take(driver, keys):
    """Press keys as an overlay declares them: a letter, or as many more as there are letters."""
    (combination,) = (QKeySequence(keys)[0],)
    driver.key(combination.key(), combination.keyboardModifiers())


def test_a_key_toggles_an_overlay_and_its_box(opened):
    boxes = {box.text(): box for box in opened.panel("overlays").findChildren(QCheckBox)}
    before = picture(opened)
    for layer in LISTED:
        box = boxes[translated(layer.title)]
        was = layer.name in opened.editor.view.visible
        assert box.isChecked() == was, layer.name
        take(opened, layer.key)
        assert (layer.name in opened.editor.view.visible) != was, layer.name
        assert box.isChecked() != was, layer.name
        if layer.name not in ("folds", "straight", "protection", "read"):
            assert (picture(opened) != before).any(), layer.name
        take(opened, layer.key)
        np.testing.assert_array_equal(picture(opened), before, layer.name)


def test_folded_cells_are_drawn_and_counted(opened):
    panel = opened.panel("recipe")
    assert "✓" in panel.one_to_one.text()
    opened.set("scope", "face")
    opened.press_key(panel.lattice.slider, Qt.Key.Key_Home)
    opened.press_key(panel.percent.slider, Qt.Key.Key_End)
    opened.settle()
    assert "reduced" in panel.one_to_one.text()
    panel.switches["guard"].click()
    opened.settle()
    cells = len(opened.editor.view.frame.rendering.one_to_one.folded_cells)
    assert cells > 0
    assert f"folds in {cells} cells" in panel.one_to_one.text()
    drawn = picture(opened)
    opened.key(Qt.Key.Key_J)
    assert (picture(opened) != drawn).any()


def test_a_threshold_that_is_not_used_is_told(opened):
    recipe = dataclasses.replace(ALONE, percent=8, lattice=0.5, threshold_px=2.0)
    opened.editor.document.step(dataclasses.replace(opened.state, recipe=recipe), "")
    opened.settle()
    assert "threshold not used" in opened.panel("recipe").one_to_one.text()
    shown = opened.editor.view.frame.rendering
    assert shown.pixel_counts == pixel_counts(shown.field.lattices, shown.domain.image, LOSSLESS_PX)


def test_at_100_percent_the_screen_shows_the_results_own_pixels(opened):
    for key in (Qt.Key.Key_L, Qt.Key.Key_T, Qt.Key.Key_C, Qt.Key.Key_D, Qt.Key.Key_1):
        opened.key(key)
    assert opened.canvas.zoom == pytest.approx(1.0)
    left, top = opened.align().toTuple()
    seen = picture(opened).reshape(opened.canvas.height(), opened.canvas.width(), 3)
    height, width = opened.shown.shape[:2]
    assert left >= 0
    assert top >= 0
    np.testing.assert_array_equal(seen[top : top + height, left : left + width], opened.shown)


def test_the_wheel_zooms_at_the_cursor(opened):
    at = QPoint(round(opened.canvas.width() * 0.3), round(opened.canvas.height() * 0.6))
    place, zoom = opened.canvas.to_photo(QPointF(at)), opened.canvas.zoom
    opened.turn_wheel(opened.canvas.viewport(), 2, at)
    assert opened.canvas.zoom == pytest.approx(zoom * 1.25**2)
    np.testing.assert_allclose(opened.canvas.to_photo(QPointF(at)), place, atol=1e-6)
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
    assert opened.editor.view.hovered is not None
    assert opened.window.status.hint_text == "outline 11, chin"


def test_one_key_hides_all_overlays_and_brings_the_same_ones_back(opened):
    opened.key(Qt.Key.Key_G)
    before = set(opened.editor.view.visible)
    opened.click(opened.on_screen(Handle("outline", 0, 10)))
    opened.move(QPoint(5, 5))
    marked = picture(opened)
    opened.key(Qt.Key.Key_O)
    hidden = picture(opened)
    assert not opened.editor.view.visible
    boxes = opened.panel("overlays").findChildren(QCheckBox)
    assert not any(box.isChecked() for box in boxes)
    opened.key(Qt.Key.Key_Escape)
    np.testing.assert_array_equal(picture(opened), hidden, "the ring of the point stayed")
    opened.key(Qt.Key.Key_O)
    assert opened.editor.view.visible == before
    opened.click(opened.on_screen(Handle("outline", 0, 10)))
    opened.move(QPoint(6, 6))  # Qt tells of no move to the same place
    np.testing.assert_array_equal(picture(opened), marked)


def test_the_place_of_the_cursor_follows_a_drag(opened):
    at = opened.on_screen(Handle("outline", 0, 10))
    opened.drag(at, QPoint(12, 18))
    x, y = opened.canvas.to_photo((at + QPoint(12, 18)).toPointF())
    texts = [label.text() for label in opened.window.status.findChildren(QLabel)]
    assert f"x {x:.0f}  y {y:.0f}" in texts


def test_the_hint_is_that_of_the_tool_in_hand(two):
    status = two.window.status
    assert status.hint_text.startswith("Click a face")
    two.editor.recipe.choose(0)
    assert status.hint_text == "Drag a point to correct it"
    for key, words in ((Qt.Key.Key_B, "Paint"), (Qt.Key.Key_E, "Erase"), (Qt.Key.Key_A, "Drag a")):
        two.key(key)
        assert status.hint_text.startswith(words)
    two.editor.files.working.emit("Saving…")
    two.move(QPoint(5, 5))
    assert status.hint_text == "Saving…"
    two.editor.files.working.emit("")
    assert status.hint_text == "Drag a point to correct it"


def test_what_was_done_is_said_until_the_next_step(opened, tmp_path):
    status = opened.window.status
    opened.editor.projects.save_to(tmp_path / "one.kogao.json")
    opened.settle()
    assert status.hint_text.startswith("Saved")
    opened.change_something()
    assert status.hint_text == "Drag a point to correct it"
    opened.editor.files.working.emit("Opening…")
    opened.change_something()
    assert status.hint_text == "Opening…", "it goes on"


def test_a_label_lies_within_the_canvas_as_a_whole(qapp):
    area, font = QRectF(0, 0, 300, 200), qapp.font()
    for x, y in ((290, 100), (10, 3), (299, 199), (-5, 100)):
        assert area.contains(plate(font, QPointF(x, y), "right eye, inner corner", within=area))
    free = plate(font, QPointF(20, 100), "right eye, inner corner")
    assert plate(font, QPointF(20, 100), "right eye, inner corner", within=area) == free


def test_the_name_of_a_landmark_hides_no_other(opened):
    middle = opened.canvas.to_screen(opened.state.faces[0].points.mean(axis=0))
    points = [QPointF(opened.on_screen(Handle("outline", 0, index))) for index in range(21)]
    area = opened.canvas.viewport().rect().toRectF()
    for at in points:
        name = outward_plate(opened.canvas.font(), at, middle, "outline 9, left jaw", area)
        assert not any(name.contains(other) for other in points)


def test_nothing_is_read_off_before_something_is_measured(empty, source, photo):
    def cells():
        readings = empty.panel("readings")
        rows = (*readings.domains.rows.values(), *readings.timings.rows.values())
        return {cell.text() for row in rows for cell in row if isinstance(cell, QLabel)}

    seen = []
    empty.editor.document.opened.connect(lambda: seen.append(cells()))
    assert cells() == {"–"}  # noqa: RUF001
    empty.open(photo)
    laps = empty.editor.view.frame.rendering.timings_ms
    assert list(empty.panel("readings").timings.rows) == list(laps)
    measured = cells()
    assert "–" not in measured  # noqa: RUF001
    source.faces = []
    empty.open(photo)
    assert seen == [{"–"}, {"–"}]  # noqa: RUF001
    assert cells() == {"–"}, "without a face nothing is saved by being small"  # noqa: RUF001


def test_a_warp_of_nothing_has_no_lattice_in_warp_distances(opened):
    slider = opened.panel("recipe").percent.slider
    opened.press_key(slider, Qt.Key.Key_Home)
    note = opened.panel("recipe").lattice.note.text()
    assert "– × warp distance" in note  # noqa: RUF001


def test_readings_show_the_pipelines_own_numbers(opened, pixels):
    rendering = opened.editor.view.frame.rendering
    counts = rendering.pixel_counts
    assert counts["image"] == pixels.shape[0] * pixels.shape[1]
    share = counts["threshold"] / counts["image"]
    saving = opened.panel("readings").domains.saving.text()
    assert saving == f"{100 * share:.1f} % computed, {1 / share:.1f} × less"  # noqa: RUF001
    shown = opened.panel("readings").domains.rows
    for name, count in counts.items():
        share = 100 * count / counts["image"]
        assert [cell.text() for cell in shown[name]] == [f"{count:,} px", f"{share:.1f} %"]
    warp = opened.panel("readings").timings.rows["warp"][1].text()
    assert warp == f"{rendering.timings_ms['warp']:.1f} ms"


def test_inspect_shows_the_values_of_the_field_under_the_cursor(opened):
    opened.editor.document.step(opened.state.with_choices(None, percent=6.0), "Amount")
    opened.settle()
    plate, frame = opened.editor.readings.plate, opened.editor.view.frame
    point = np.round(opened.state.faces[0].outline[3])
    opened.editor.view.set(cursor=tuple(point))
    assert plate.isVisible()
    field, grid = frame.rendering.field, frame.rendering.field.lattices[0].grid
    dx, dy = field.at(point[None])[0]
    det = field.det_jacobian(point[:1], point[1:])[0, 0]
    cell = np.floor((point - grid.origin_px) / grid.spacing_px).astype(int)
    lines = plate.text().splitlines()
    assert lines[1] == f"displacement {np.hypot(dx, dy):.2f} px ({dx:+.2f}, {dy:+.2f})"
    assert lines[2:4] == [f"det J {det:.3f}", f"face 1: cell ({cell[0]}, {cell[1]})"]
    assert lines[4:] == ["domain: Reduced warp domain", "threshold T 0.01562 px"]
    opened.editor.view.set(cursor=(1.0, 1.0))
    assert "domain: Whole photo" in plate.text()
    opened.editor.view.set(cursor=None)
    assert not plate.isVisible()


def test_inspect_says_which_settings_differ_from_the_papers_and_sets_those(opened):
    settings = opened.panel("readings").settings
    assert settings.text().startswith("Not the paper's: Fit, Interpolation, Guard")
    opened.editor.document.step(opened.state.with_choices(None, percent=6.0, center=3), "Amount")
    opened.window.actions_by_name["paper-settings"].trigger()
    opened.settle()
    assert settings.text() == "Settings: the paper's"
    assert opened.state.recipe == dataclasses.replace(PAPER, percent=6.0, center=3)
    opened.editor.history.undo()
    opened.settle()
    assert settings.text().startswith("Not the paper's")
