"""Text and marks stand out from their ground: by WCAG 4.5 : 1 and 3 : 1 at least."""

import sys
from functools import partial

import numpy as np
import pytest
from kogao_app import theme
from kogao_app.canvas.overlays import glyphs
from kogao_app.features.recipe.fields import percent
from kogao_app.widgets import icons
from kogao_app.widgets.sliders import GestureSlider
from PySide6.QtCore import QItemSelectionModel, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QIcon, QImage, QPainter
from PySide6.QtWidgets import (
    QCheckBox,
    QDialogButtonBox,
    QListWidget,
    QMenu,
    QProxyStyle,
    QStyle,
    QTabBar,
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


def _outline(painter, ends, colour, width=1.6, *, dotted=False):
    glyphs.polyline(painter, ends, colour, width, dotted=dotted)


def _line(painter, ends, colour, draw=glyphs.lines, *more):
    draw(painter, [[end.toTuple() for end in ends]], colour, *more)


def _edge(painter, ends, colour):
    glyphs.outlined(painter, glyphs.framed(painter, QRectF(*ends)), colour)


OUTLINES = {
    "outline of a small face": partial(_outline, colour=glyphs.OUTLINE),
    "outline of a face that is off": partial(_outline, colour=glyphs.OUTLINE, dotted=True),
    "selected face": partial(_outline, colour=glyphs.HALO, width=2.2),
}
LINES = {
    "displacement": partial(_line, colour=glyphs.DISPLACEMENT, draw=glyphs.arrow),
    "lattice": partial(_line, colour=glyphs.LATTICE, draw=glyphs.fine_lines),
    "half of the loupe": lambda painter, ends: _line(painter, ends, glyphs.HALO, glyphs.lines, 1.0),
    "centre line": partial(_line, colour=glyphs.CENTRE),
    "way to a target": partial(_line, colour=glyphs.WAY),
    "straight line": partial(_line, colour=glyphs.STRAIGHT),
    "turned line": partial(_line, colour=glyphs.TURNED),
    "divider": partial(_line, colour=glyphs.HALO),
}
# Boxes; these are as flat as a line.
EDGES = {
    "folded cell": partial(_edge, colour=glyphs.TURNED),
    "reduced domain": partial(_edge, colour=glyphs.DOMAIN_EDGES["threshold"][0]),
}
# What is laid over regions.
HATCHES = {"protected": glyphs.protected}
MARKS = {
    "landmark": partial(glyphs.dot, colour=glyphs.LANDMARK),
    "unsure landmark": partial(glyphs.hollow, colour=glyphs.LANDMARK),
    "corner": partial(glyphs.diamond, colour=glyphs.LANDMARK),
    "target": partial(glyphs.ring, colour=glyphs.TARGET),
    "centre": partial(glyphs.cross, colour=glyphs.CENTRE),
    "fold": glyphs.warning,
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
def test_the_ring_of_the_focus_is_seen(name):
    colours = THEMES[name]
    for ground in (colours.window, colours.raised):  # of a control, and of what fills a slider
        assert contrast(rgb(colours.accent), rgb(ground)) >= MARK


@pytest.mark.parametrize("name", THEMES)
@pytest.mark.parametrize("checked", [False, True])
@pytest.mark.parametrize("kind", [QCheckBox, QListWidget, GestureSlider])
def test_what_is_set_is_seen_without_its_words(qapp, qtbot, name, kind, checked):
    colours = theme.apply(qapp, name)
    widget = GestureSlider(percent()) if kind is GestureSlider else kind()
    qtbot.addWidget(widget)
    if kind is GestureSlider:
        widget.setValue(50 * checked)
    elif kind is QListWidget:
        widget.addItem("")
        state = Qt.CheckState.Checked if checked else Qt.CheckState.Unchecked
        widget.item(0).setCheckState(state)
    else:
        widget.setChecked(checked)
    drawn = pixels_of(widget.grab().toImage())
    assert contrast(drawn, rgb(colours.window)).max() >= MARK


@pytest.mark.parametrize("name", THEMES)
def test_what_is_not_filled_is_seen_too(qapp, qtbot, name):
    colours = theme.apply(qapp, name)
    slider = GestureSlider(percent())
    qtbot.addWidget(slider)
    slider.setAutoFillBackground(True)
    drawn = pixels_of(slider.grab().toImage()).reshape(slider.height(), slider.width(), 3)
    empty = drawn[:, -slider.width() // 4 : -slider.width() // 12]
    assert (contrast(empty, rgb(colours.window)).max(axis=0) >= MARK).mean() > 0.7


class WithIcons(QProxyStyle):
    """A style that puts icons on the buttons of dialogs, as that of a plain X does: black ones."""

    def styleHint(self, hint, *more):  # noqa: N802
        if hint == QStyle.StyleHint.SH_DialogButtonBox_ButtonsHaveIcons:
            return 1
        return super().styleHint(hint, *more)


def test_buttons_of_dialogs_have_no_icons_of_others_colours(qapp, qtbot):
    theme.apply(qapp, "dark")
    try:
        qapp.setStyle(WithIcons("Fusion"))
        box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        qtbot.addWidget(box)
        box.ensurePolished()
        assert box.button(QDialogButtonBox.StandardButton.Close).icon().isNull()
    finally:
        qapp.setStyle("Fusion")


def takes_tab(widget):
    """Whether Tab gets to a widget, and it has its own looks."""
    reached = widget.focusPolicy() & Qt.FocusPolicy.TabFocus and widget.focusProxy() is None
    seen = widget.isVisible() and widget.isEnabled()
    return reached and seen and widget.objectName() != "qt_scrollarea_viewport"


@pytest.mark.parametrize("name", THEMES)
def test_whatever_takes_the_focus_shows_it(qapp, two, name):
    two.to_front()
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


@pytest.mark.parametrize("name", THEMES)
def test_the_focus_in_a_list_shows_its_row_and_keeps_the_text(qapp, qtbot, name):
    colours = theme.apply(qapp, name)
    rows = QListWidget()
    qtbot.addWidget(rows)
    rows.addItems(["first", "second"])
    with qtbot.waitActive(rows):
        rows.show()
        rows.activateWindow()
    rows.setFocus(Qt.FocusReason.TabFocusReason)
    looks = []
    for row in (0, 1):  # Ctrl and an arrow key move the focus without the selection
        rows.setCurrentRow(row, QItemSelectionModel.SelectionFlag.NoUpdate)
        picture = rows.viewport().grab(rows.visualItemRect(rows.item(1)))
        looks.append(pixels_of(picture.toImage()))
    assert contrast(*looks).max() >= MARK
    middle = slice(8, -8)
    assert contrast(looks[1][middle, middle], rgb(colours.window)).max() >= TEXT
    assert np.array_equal(looks[0][middle, middle], looks[1][middle, middle])


def worst_on_grey(draw):
    """The least contrast that a mark has with its ground, over all greys."""
    worst = np.inf
    for level in range(0, 256, 5):
        picture = QImage(40, 40, QImage.Format.Format_RGB32)
        picture.fill(QColor(level, level, level))
        painter = QPainter(picture)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        draw(painter)
        painter.end()
        worst = min(worst, contrast(pixels_of(picture), (level,) * 3).max())
    return worst


MIDDLE = QPointF(20, 20)


@pytest.mark.usefixtures("qapp")
@pytest.mark.parametrize("name", MARKS)
def test_a_mark_is_seen_on_any_grey(name):
    assert worst_on_grey(lambda painter: MARKS[name](painter, MIDDLE)) >= MARK


@pytest.mark.usefixtures("qapp")
@pytest.mark.parametrize("name", [*OUTLINES, *LINES])
def test_a_slanted_line_is_seen_on_any_grey(name):
    ends = [MIDDLE - QPointF(15, 13), MIDDLE + QPointF(15, 13)]
    draw = (OUTLINES | LINES)[name]
    assert worst_on_grey(lambda painter: draw(painter, ends)) >= MARK


GREYS = np.arange(0, 256, 5)
STRIPE_PX, BREADTH_PX = 12, 16


def worst_across(draw, ratio, offset_px, *, upright):
    """The least contrast of a straight line, `offset_px` from the middle, over stripes of greys."""
    along = np.repeat(GREYS.astype(np.uint8), STRIPE_PX)
    ground = np.repeat(np.broadcast_to(along, (BREADTH_PX, len(along)))[..., np.newaxis], 4, -1)
    if upright:
        ground = ground.swapaxes(0, 1)
    ground = np.ascontiguousarray(ground)
    height, width = ground.shape[:2]
    picture = QImage(ground.data, width, height, 4 * width, QImage.Format.Format_RGB32)
    picture.setDevicePixelRatio(ratio)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    across = (BREADTH_PX / 2 + offset_px) / ratio
    ends = [QPointF(0, across), QPointF(len(along) / ratio, across)]
    draw(painter, [end.transposed() for end in ends] if upright else ends)
    painter.end()
    drawn = pixels_of(picture).swapaxes(0, 1) if upright else pixels_of(picture)
    ratios = contrast(drawn, along[:, np.newaxis].repeat(3, axis=1))
    return ratios.reshape(BREADTH_PX, -1, STRIPE_PX).max(axis=(0, 2)).min()


@pytest.mark.usefixtures("qapp")
@pytest.mark.parametrize("ratio", [1.0, 1.25, 1.5, 2.0])
@pytest.mark.parametrize("name", [*LINES, *EDGES])
def test_a_level_line_is_seen_wherever_it_lies_between_two_rows(name, ratio):
    draw = (LINES | EDGES)[name]
    for upright in (False, True):
        for tenths in range(10):
            worst = worst_across(draw, ratio, tenths / 10, upright=upright)
            assert worst >= MARK, (tenths, upright)


@pytest.mark.usefixtures("qapp")
@pytest.mark.parametrize("name", HATCHES)
def test_a_hatch_is_seen_on_any_grey(name):
    ground = QRectF(0, 0, 40, 40)
    assert worst_on_grey(lambda painter: painter.fillRect(ground, HATCHES[name]())) >= MARK


@pytest.mark.parametrize("name", THEMES)
def test_an_entry_of_a_menu_looks_as_without_an_icon(qtbot, qapp, name):
    """On the accent an icon fades, and where an entry is checked it hides the mark."""
    theme.apply(qapp, name)

    def shown(drawn):
        menu = QMenu()
        qtbot.addWidget(menu)
        entry = menu.addAction("Undo")
        entry.setIcon(drawn)
        entry.setCheckable(True)
        entry.setChecked(True)
        menu.setActiveAction(entry)
        menu.ensurePolished()
        menu.resize(menu.sizeHint())
        return menu.grab().toImage()

    assert shown(icons.icon("undo", THEMES[name])) == shown(QIcon())


@pytest.mark.parametrize(("code", "lent"), [("ja", True), ("en", False)])
def test_windows_lends_no_chinese_forms_to_japanese(qapp, monkeypatch, code, lent):
    before, sheet = qapp.font(), qapp.styleSheet()
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(theme, "language", lambda: code)
    qapp.setStyleSheet("")
    theme.apply(qapp, "dark")
    assert ("Yu Gothic UI" in qapp.font().families()) == lent
    qapp.setFont(before)
    qapp.setStyleSheet(sheet)
