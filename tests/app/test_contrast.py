"""Text and marks stand out from their ground: by WCAG 4.5 : 1 and 3 : 1 at least."""

from __future__ import annotations

import numpy as np
import pytest
from kogao_app import theme
from kogao_app.canvas.overlays import glyphs
from PySide6.QtCore import QLineF, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QPainter
from PySide6.QtWidgets import (
    QCheckBox,
    QPushButton,
    QRadioButton,
    QSlider,
    QTabBar,
    QVBoxLayout,
    QWidget,
)

THEMES = {"dark": theme.DARK, "light": theme.LIGHT}
TEXT, MARK = 4.5, 3.0
# Colour of the text, and the grounds on which the style sheet and the palette write it.
WRITTEN = {
    "text": ("canvas", "window", "raised", "line"),
    "muted": ("window", "raised"),
    "warning": ("window", "raised"),
    "accent": ("window",),
    "on_accent": ("accent", "muted"),
}
# Ground of a focused control, and of what fills a slider.
RINGED = ("window", "raised")
MARKS = {
    "landmark": lambda painter, at: glyphs.dot(painter, at, glyphs.LANDMARK),
    "unsure landmark": lambda painter, at: glyphs.hollow(painter, at, glyphs.LANDMARK),
    "corner": lambda painter, at: glyphs.diamond(painter, at, glyphs.LANDMARK),
    "target": lambda painter, at: glyphs.ring(painter, at, glyphs.TARGET),
    "centre": lambda painter, at: glyphs.cross(painter, at, glyphs.CENTRE),
    "fold": lambda painter, at: glyphs.warning(painter, at),
    "selected face": lambda painter, at: glyphs.polyline(
        painter, [at - QPointF(15, 12), at, at + QPointF(15, 13)], glyphs.HALO, 2.2, dotted=False
    ),
    "centre line": lambda painter, at: glyphs.lines(
        painter, [QLineF(at - QPointF(15, 12), at + QPointF(15, 13))], glyphs.CENTRE, 1.4
    ),
    "label": lambda painter, at: glyphs.label(painter, at - QPointF(9, 0), "3"),
}


def luminance(srgb):
    """Relative luminance of sRGB colours, 0 to 255, last axis RGB."""
    share = np.asarray(srgb, dtype=float)[..., :3] / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return linear @ (0.2126, 0.7152, 0.0722)


def contrast(one, other):
    """WCAG's contrast ratio of sRGB colours, 1 to 21."""
    light = np.stack(np.broadcast_arrays(luminance(one), luminance(other)))
    return (light.max(axis=0) + 0.05) / (light.min(axis=0) + 0.05)


def rgb(name):
    return QColor(name).getRgb()[:3]


def pixels_of(picture):
    picture = picture.convertToFormat(QImage.Format.Format_RGBX8888)
    rows = np.frombuffer(picture.constBits(), np.uint8).reshape(picture.height(), -1, 4)
    return rows[:, : picture.width(), :3].copy()


@pytest.mark.parametrize("name", THEMES)
@pytest.mark.parametrize(("ink", "ground"), [(i, g) for i in WRITTEN for g in WRITTEN[i]])
def test_text_is_read_on_every_ground(name, ink, ground):
    colours = THEMES[name]
    assert contrast(rgb(getattr(colours, ink)), rgb(getattr(colours, ground))) >= TEXT


@pytest.mark.parametrize("name", THEMES)
@pytest.mark.parametrize("ground", RINGED)
def test_the_ring_of_the_focus_is_seen(name, ground):
    colours = THEMES[name]
    assert contrast(rgb(colours.accent), rgb(getattr(colours, ground))) >= MARK


@pytest.mark.parametrize("name", THEMES)
@pytest.mark.parametrize("checked", [False, True])
@pytest.mark.parametrize("kind", [QCheckBox, QRadioButton, QSlider])
def test_what_is_set_is_seen_without_its_words(qapp, qtbot, name, kind, checked):
    colours = theme.apply(qapp, name)
    widget = kind(Qt.Orientation.Horizontal) if kind is QSlider else kind()
    qtbot.addWidget(widget)
    if kind is QSlider:
        widget.setValue(50 * checked)
    else:
        widget.setChecked(checked)
    drawn = pixels_of(widget.grab().toImage())
    assert contrast(drawn, rgb(colours.window)).max() >= MARK


@pytest.mark.parametrize("name", THEMES)
@pytest.mark.parametrize("checked", [False, True])
@pytest.mark.parametrize("kind", [QCheckBox, QRadioButton])
def test_a_switch_shows_that_it_has_the_focus(qapp, qtbot, name, checked, kind):
    theme.apply(qapp, name)
    widget, other = kind("on"), QPushButton("elsewhere")
    widget.setChecked(checked)
    window = QWidget()
    qtbot.addWidget(window)
    column = QVBoxLayout(window)
    column.addWidget(widget)
    column.addWidget(other)
    with qtbot.waitActive(window):
        window.show()
        window.activateWindow()
    looks = []
    for focused in (other, widget):
        focused.setFocus()
        looks.append(pixels_of(widget.grab().toImage()))
    assert contrast(*looks).max() >= MARK


def takes_tab(widget):
    """Whether Tab gets to a widget, and it has its own looks."""
    reached = widget.focusPolicy() & Qt.FocusPolicy.TabFocus and widget.focusProxy() is None
    seen = widget.isVisible() and widget.isEnabled()
    return reached and seen and widget.objectName() != "qt_scrollarea_viewport"


@pytest.mark.parametrize("name", THEMES)
def test_whatever_takes_the_focus_shows_it(qapp, two, name):
    two.window.activateWindow()
    two.qtbot.waitUntil(two.window.isActiveWindow)
    theme.apply(qapp, name)
    reached = [widget for widget in two.window.findChildren(QWidget) if takes_tab(widget)]
    assert two.canvas in reached
    assert two.panel("faces").list in reached
    assert any(isinstance(one, QTabBar) for one in reached)
    slider = two.panel("recipe").percent.slider
    dim = []
    for widget in reached:
        looks = []
        for focused in (two.panel("recipe").lattice.slider if widget is slider else slider, widget):
            focused.setFocus(Qt.FocusReason.TabFocusReason)
            looks.append(pixels_of(widget.grab().toImage()))
        if contrast(*looks).max() < MARK:
            dim.append((type(widget).__name__, widget.accessibleName()))
    assert dim == []


@pytest.mark.usefixtures("qapp")
@pytest.mark.parametrize("name", MARKS)
def test_a_mark_is_seen_on_any_grey(name):
    for level in range(0, 256, 5):
        picture = QImage(40, 40, QImage.Format.Format_RGB32)
        picture.fill(QColor(level, level, level))
        painter = QPainter(picture)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        MARKS[name](painter, QPointF(20, 20))
        painter.end()
        drawn = pixels_of(picture)
        assert contrast(drawn, (level,) * 3).max() >= MARK, f"on grey {level}"
