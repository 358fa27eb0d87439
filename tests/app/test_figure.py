"""The legend on the canvas, and the canvas with it as a picture of its own."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from kogao_app.canvas.overlays.listed import Legend
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog
from test_view import picture

KEYS, SHIFT = Qt.Key, Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def inspected(start, photo):
    return start(photo)


def legend(driver):
    return [text for _, text in Legend(driver.editor.view).rows()]


def test_the_legend_lists_what_is_shown_and_there(inspected):
    assert legend(inspected) == ["Landmarks", "Targets", "Centre and its candidates"]
    inspected.key(KEYS.Key_G)
    inspected.key(KEYS.Key_L)
    assert legend(inspected) == ["Targets", "Centre and its candidates", "Lattice"]
    inspected.key(KEYS.Key_O)
    assert legend(inspected) == []
    inspected.key(KEYS.Key_O)
    inspected.editor.manual.switch("manual")
    assert legend(inspected) == ["Lattice"], "there is no face"


def test_the_legend_tells_the_domains_with_their_pixels(inspected):
    inspected.key(KEYS.Key_D)
    counts = inspected.editor.view.frame.rendering.pixel_counts
    share = 100 * counts["threshold"] / counts["image"]
    (row,) = [text for text in legend(inspected) if text.startswith("Threshold")]
    assert row == f"Threshold: {counts['threshold']:,} px, {share:.1f} %"


def test_a_figure_holds_canvas_legend_caption_and_figures(inspected, tmp_path):
    inspected.key(KEYS.Key_F12)
    bare = picture(inspected)
    inspected.key(KEYS.Key_F12, SHIFT)
    asked = inspected.dialog(QFileDialog)
    assert asked.selectedFiles()[0].endswith("portrait-figure.png")
    asked.close()
    file = tmp_path / "figure.png"
    inspected.editor.figure.export(file)
    written = cv2.imread(str(file))[..., ::-1]
    canvas, readings = inspected.canvas, inspected.panel("readings")
    assert written.shape[0] > canvas.height() + readings.height()
    assert written.shape[1] >= canvas.width()
    left = (written.shape[1] - canvas.width()) // 2
    seen = written[: canvas.height(), left : left + canvas.width()].reshape(canvas.height(), -1)
    changed = np.argwhere((seen != bare).any(axis=1))
    assert changed.size, "the legend is on the figure"
    np.testing.assert_array_equal(picture(inspected), bare, "and not on the canvas")
    words = inspected.editor.figure.caption()
    assert words.startswith("portrait.png · Warp distance 4.0 % of D · Centre 2")
