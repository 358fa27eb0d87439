"""What the maps, lines and marks over the photo show, pixel by pixel where that can be said."""

from __future__ import annotations

import dataclasses
import importlib
import pkgutil
from pathlib import Path

import cv2
import numpy as np
import pyqtgraph as pg
import pytest
from kogao_app.canvas import overlays
from kogao_app.canvas.overlays import glyphs, unlisted
from kogao_app.canvas.overlays.listed import LISTED, Legend
from kogao_app.canvas.overlays.overlay import Overlay
from kogao_app.i18n import translated
from kogao_app.start import names
from kogao_app.view_state import ViewState
from kogao_app.workspaces import INSPECT
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog
from scenes import oval_face
from test_view import picture

from kogao_core.background.lines import SEEN_DEGREES

pytestmark = pytest.mark.usefixtures("one_window")

ROOT = Path(__file__).parents[2]
KEYS, SHIFT = Qt.Key, Qt.KeyboardModifier.ShiftModifier
SKY, TURNED = (86, 180, 233), glyphs.TURNED.getRgb()[:3]


def declared():
    """Return every class of an overlay that says how it is drawn."""
    for module in pkgutil.iter_modules(overlays.__path__, f"{overlays.__name__}."):
        found = vars(importlib.import_module(module.name)).values()
        for one in found:
            if isinstance(one, type) and issubclass(one, Overlay) and hasattr(one, "height"):
                yield one


def test_every_overlay_that_is_declared_is_drawn_at_a_height_of_its_own(empty):
    heights = {one.height: one for one in declared()}
    assert len(heights) == len(set(declared()))
    drawn = {type(one) for one in unlisted.stack(ViewState(document=empty.editor.document))}
    assert drawn | {unlisted.Loupe} == set(heights.values())
    assert {one for one in drawn if one.key} == set(LISTED)


def test_an_overlay_follows_from_its_declaration(empty):
    page = (ROOT / "docs/inspect.md").read_text(encoding="utf-8")
    for overlay in LISTED:
        action = empty.window.actions_by_name[f"overlay-{overlay.name}"]
        assert action.text() == translated(overlay.title)
        assert action.shortcut().toString() == overlay.key, overlay.name
        first = overlay.name in INSPECT.overlays
        assert action.isChecked() == first == (overlay.name in empty.editor.view.visible)
        assert overlay.name in names()
        assert f"`{overlay.name}`" in page
        swatch = glyphs.swatch(overlay.swatch, 1.0).toImage()
        assert len({swatch.pixel(x, y) for x in range(18) for y in range(18)}) > 1, overlay.name


def hide_marks(driver):
    for key in (KEYS.Key_L, KEYS.Key_T, KEYS.Key_C, KEYS.Key_D):
        driver.key(key)


def pixels_of(driver) -> np.ndarray:
    rows = picture(driver)
    return rows.reshape(rows.shape[0], -1, 3).astype(int)


def at(driver, x, y) -> tuple[int, int]:
    point = driver.canvas.to_screen(np.array([x, y], float)).toPoint()
    return point.y(), point.x()


def looks_like(image, colour, tolerance=24):
    return np.abs(image - np.array(colour)).max(axis=-1) <= tolerance


def rows_and_columns(driver):
    """A grid over the photo, px."""
    height, width = driver.shown.shape[:2]
    return np.arange(0, width, 5.0), np.arange(0, height, 5.0)


def test_the_heat_map_colours_what_moves_and_only_that(opened):
    hide_marks(opened)
    plain = pixels_of(opened)
    opened.key(KEYS.Key_H)
    warm = pixels_of(opened)
    field = opened.editor.view.frame.rendering.field
    xs, ys = rows_and_columns(opened)
    length = np.hypot(*field.on_grid(xs, ys))
    row, column = np.unravel_index(length.argmax(), length.shape)
    hot = at(opened, xs[column], ys[row])
    colours = pg.colormap.get("inferno").map(np.linspace(0.2, 1, 64), mode="byte")[:, :3]
    drawn = warm[hot]
    apart = np.abs(colours.astype(int) - drawn).max(axis=1).min()
    assert np.abs(drawn - plain[hot]).max() > 20
    assert apart < 70, "not a colour of the scale, even with the photo shining through"
    for still in np.argwhere(length == 0.0)[::97]:
        there = at(opened, xs[still[1]], ys[still[0]])
        if there[0] < warm.shape[0] - 120:  # the legend
            np.testing.assert_array_equal(warm[there], plain[there])


def test_the_jacobian_map_is_red_where_pressed_and_blue_where_stretched(opened):
    opened.editor.recipe.set_field("percent", 10.0)
    opened.settle()
    hide_marks(opened)
    plain = pixels_of(opened)
    opened.key(KEYS.Key_K)
    shown = pixels_of(opened) - plain
    xs, ys = rows_and_columns(opened)
    det = opened.editor.view.frame.rendering.field.det_jacobian(xs, ys)
    for index, pressed in ((det.argmax(), True), (det.argmin(), False)):
        row, column = np.unravel_index(index, det.shape)
        red, _, blue = shown[at(opened, xs[column], ys[row])]
        assert (red > blue) == pressed


def test_a_map_stays_with_the_photo_when_it_is_panned(opened):
    hide_marks(opened)
    opened.key(KEYS.Key_H)
    before = pixels_of(opened)
    opened.drag(QPoint(40, 40), QPoint(24, 16))
    after = pixels_of(opened)
    # The legend stays below; samples of the smooth map fall elsewhere by up to 4 px.
    shift = np.abs(after[116:400, 224:584] - before[100:384, 200:560])
    assert np.quantile(shift, 0.99) <= 12


def test_straight_lines_show_their_turn_until_they_are_protected(empty, door):
    path, x = door
    empty.open(path)
    hide_marks(empty)
    slider = empty.panel("recipe").percent.slider
    slider.setFocus()
    for _ in range(4):
        QTest.keyClick(slider, KEYS.Key_PageUp)
    empty.settle()
    assert not empty.editor.view.lines, "nobody looks: nothing is looked for"
    bare = pixels_of(empty)
    empty.key(KEYS.Key_S)
    empty.settle()
    lines = empty.editor.view.lines
    assert lines[0].turn_degrees > SEEN_DEGREES
    drawn = pixels_of(empty)
    new = looks_like(drawn, TURNED) & (drawn != bare).any(axis=-1)
    columns = np.flatnonzero(new.any(axis=0))
    assert abs(np.median(columns) - at(empty, x, 0)[1]) < 12
    empty.key(KEYS.Key_N)
    top = empty.canvas.to_screen(np.array([x, 62.0])).toPoint()
    down = empty.canvas.to_screen(np.array([x, 658.0])).toPoint() - top
    empty.drag(top, down)
    empty.settle()
    assert empty.editor.view.lines[0].turn_degrees < SEEN_DEGREES


def test_unsure_landmarks_are_hollow_and_say_how_sure_they_are(start, source, photo):
    confidence = np.ones(27)
    confidence[[16, 22]] = 0.2
    source.faces = [dataclasses.replace(oval_face(), confidence=confidence)]
    driver = start(photo)
    driver.key(KEYS.Key_T)
    shown, face = pixels_of(driver), driver.state.faces[0]
    for sure, unsure in ((face.points[4], face.points[16]), (face.points[23], face.points[22])):
        assert looks_like(shown[at(driver, *sure)], SKY)
        assert not looks_like(shown[at(driver, *unsure)], SKY)
    bare = pixels_of(driver)
    driver.move(driver.canvas.to_screen(face.points[16]).toPoint())
    assert (pixels_of(driver) != bare).any()


def test_only_one_map_is_on_at_a_time(opened):
    """Two maps would mix their colours."""
    maps = [opened.window.actions_by_name[f"overlay-{name}"] for name in ("heat", "jacobian")]
    for one, other in (maps, maps[::-1]):
        one.setChecked(True)
        assert (one.isChecked(), other.isChecked()) == (True, False)
    maps[1].setChecked(False)
    assert opened.editor.view.switched.isdisjoint({"heat", "jacobian"})


# -- the legend, and the canvas with it as a picture of its own ------------------------------------


def legend(driver):
    return [text for _, text in Legend(driver.editor.view).rows()]


def test_the_legend_lists_what_is_shown_and_there(opened):
    at_first = legend(opened)
    assert at_first[:3] == ["Landmarks", "Targets", "Centre and its candidates"]
    assert [row.partition(":")[0] for row in at_first[3:]] == [
        *("Reduced warp domain", "Lattice cells in reach", "Whole photo"),
    ]
    opened.key(KEYS.Key_D)
    opened.key(KEYS.Key_G)
    opened.key(KEYS.Key_L)
    assert legend(opened) == ["Targets", "Centre and its candidates", "Lattice"]
    opened.key(KEYS.Key_O)
    assert legend(opened) == []
    opened.key(KEYS.Key_O)
    opened.editor.manual.switch("manual")
    assert legend(opened) == ["Lattice"], "there is no face"


def test_the_legend_tells_the_share_of_the_domains(opened):
    counts = opened.editor.view.frame.rendering.pixel_counts
    share = 100 * counts["threshold"] / counts["image"]
    (row,) = [text for text in legend(opened) if text.startswith("Reduced")]
    assert row == f"Reduced warp domain: {share:.1f} %"


def test_a_figure_holds_canvas_legend_caption_and_figures(opened, tmp_path):
    opened.window.actions_by_name["overlay-legend"].setChecked(True)
    opened.key(KEYS.Key_F12)
    bare = picture(opened)
    opened.key(KEYS.Key_F12, SHIFT)
    asked = opened.dialog(QFileDialog)
    assert asked.selectedFiles()[0].endswith("portrait-figure.png")
    asked.close()
    file = tmp_path / "figure.png"
    opened.editor.figure.export(file)
    written = cv2.imread(str(file))[..., ::-1]
    canvas, readings = opened.canvas, opened.panel("readings")
    assert written.shape[0] > canvas.height() + readings.height()
    assert written.shape[1] >= canvas.width()
    left = (written.shape[1] - canvas.width()) // 2
    seen = written[: canvas.height(), left : left + canvas.width()].reshape(canvas.height(), -1)
    changed = np.argwhere((seen != bare).any(axis=1))
    assert changed.size, "the legend is on the figure"
    np.testing.assert_array_equal(picture(opened), bare, "and not on the canvas")
    words = opened.editor.figure.caption()
    assert words.startswith("portrait.png · Warp distance 4.0 % of D · Centre 2")


def test_the_reduced_domain_is_filled_softly_and_says_what_is_computed(opened, monkeypatch):
    hide_marks(opened)
    bare, said = picture(opened), []
    write = glyphs.label

    def label(painter, at, text, **more):
        said.append(text)
        write(painter, at, text, **more)

    monkeypatch.setattr(glyphs, "label", label)
    opened.key(KEYS.Key_D)
    shape = opened.canvas.height(), opened.canvas.width(), 3
    change = np.abs(picture(opened).astype(float) - bare).reshape(shape)
    x, y = opened.canvas.to_screen(opened.state.faces[0].mouth_center).toPoint().toTuple()
    under = change[y - 8 : y + 9, x - 8 : x + 9]
    assert 0.0 < under.mean() <= 0.16 * 255, "the photo stays visible"
    counts = opened.editor.view.full.figures.pixel_counts
    share = 100 * counts["threshold"] / counts["image"]
    assert f"Only these {share:.1f} % are computed" in said
