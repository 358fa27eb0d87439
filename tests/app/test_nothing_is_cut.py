"""Nothing is cut: every workspace, panel and dialog, in both themes, at two sizes of text."""

from functools import partial

import pytest
from kogao_app import theme
from kogao_app.widgets.controls import ChoiceBox, WholeNumber
from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractScrollArea,
    QAbstractSlider,
    QAbstractSpinBox,
    QCheckBox,
    QComboBox,
    QHeaderView,
    QLabel,
    QLineEdit,
    QListView,
    QPushButton,
    QScrollArea,
    QScrollBar,
    QStyle,
    QStyleOptionComboBox,
    QTabBar,
    QToolBar,
    QToolButton,
    QWidget,
)

from kogao_core.recipe.recipe import SHAPE

LEAST = (1024, 700)
TWICE = (800, 500)
# Pixels in the domains of a large photo.
COUNTS = {"image": 12_166_656, "control-points": 1_168_992, "threshold": 917_844}
# A theme has colours of its own, not sizes: each is seen with some of these.
in_sizes = pytest.mark.parametrize(("share", "dress"), [(1.0, theme.DARK), (2.0, theme.LIGHT)])
CONTROLS = (
    *(QAbstractButton, QAbstractSlider, QAbstractSpinBox),
    *(QComboBox, QLineEdit, QListView, QTabBar),
)


def visible(root, kinds):
    return [one for kind in kinds for one in root.findChildren(kind) if one.isVisible()]


def controls(window):
    """What can be pressed, moved or typed in, but for menus."""
    every = {one for one in visible(window, CONTROLS) if not isinstance(one, QScrollBar)}
    inner = {one for one in every if one.objectName().startswith("qt_")}
    bare = {one for one in every if one.visibleRegion().isEmpty()}
    return every - inner - bare


def cut(root):
    """Labels and buttons whose text needs more room than they have."""
    found = []
    for widget in visible(root, (QLabel, QPushButton, QToolButton, QCheckBox)):
        text = widget.text()
        if not text or widget.property("elides") or widget.objectName().startswith("qt_"):
            continue
        wraps = isinstance(widget, QLabel) and widget.wordWrap()
        needed = widget.minimumSizeHint() if wraps else widget.sizeHint()
        high = widget.heightForWidth(widget.width()) if wraps else needed.height()
        if isinstance(widget, QLabel) and not wraps:
            needed = widget.minimumSizeHint()
        if needed.width() > widget.width() + 1 or high > widget.height() + 1:
            found.append((type(widget).__name__, text, needed.toTuple(), widget.size().toTuple()))
    heads = (part for head in visible(root, (QHeaderView,)) for part in cut_in(head))
    return [*found, *heads, *(one for one in visible(root, (QScrollArea,)) if hides(one))]


def hides(area):
    """Whether what an area holds is wider than the area, which doesn't scroll that way."""
    held = area.horizontalScrollBarPolicy() == Qt.ScrollBarPolicy.ScrollBarAlwaysOff
    return held and area.widget().width() > area.viewport().width()


def cut_in(head):
    """Titles of a table's columns that need more room than they have."""
    titles = [str(head.model().headerData(n, head.orientation())) for n in range(head.count())]
    needed = map(head.sectionSizeHint, range(head.count()))
    given = map(head.sectionSize, range(head.count()))
    return [one for one in zip(titles, needed, given, strict=True) if one[1] > one[2]]


def overlapping(root):
    """Neighbours in one parent that lie over each other."""
    found = []
    for parent in {one.parentWidget() for one in visible(root, (QLabel, *CONTROLS))}:
        if parent is None or isinstance(parent, QAbstractScrollArea) or parent.layout() is None:
            continue
        near = [
            one
            for one in parent.findChildren(
                QWidget, options=Qt.FindChildOption.FindDirectChildrenOnly
            )
            if one.isVisible() and parent.layout().indexOf(one) >= 0
        ]
        for place, one in enumerate(near):
            for other in near[place + 1 :]:
                if one.geometry().intersects(other.geometry()) and not _stacked(parent, one, other):
                    found.append((one, other))
    return found


def _stacked(parent, one, other):
    """What the window lays over its canvas lies there on purpose."""
    return parent is parent.window().centralWidget() or not (one.width() and other.width())


def told(root):
    return [*cut(root), *overlapping(root)]


@pytest.fixture
def look(monkeypatch):
    """Dress the window in a theme, whatever the system says."""
    return lambda wanted: monkeypatch.setattr(theme, "current", lambda *_: wanted)


def nothing_is_cut(window, size, where):
    assert window.size().toTuple() == size, where
    assert told(window) == [], where


def fit_into(driver, size, where):
    """Give the window a size, and wait until nothing in it is cut."""
    driver.window.resize(*size)
    driver.qtbot.waitUntil(partial(nothing_is_cut, driver.window, size, where))


def arrangements(driver):
    """Show each workspace by hand and automatic with all groups open, and yield their names."""
    for name in driver.workspaces():
        driver.unfold()
        for mode in ("manual", "automatic"):
            driver.window.actions_by_name[f"mode-{mode}"].trigger()
            driver.settle()
            yield name, mode


@in_sizes
def test_no_text_is_cut_in_the_least_window(start, photo, text_size, look, share, dress):
    look(dress)
    text_size(share)
    driver = start(photo, workspace="retouch")
    for where in arrangements(driver):
        readings = driver.panel("readings")
        readings.domains.show_counts(COUNTS, "threshold")
        readings.timings.show_laps(dict.fromkeys(readings.timings.rows, 12345.6))
        for size in ((1280, 800), LEAST):
            fit_into(driver, size, where)


def test_a_small_screen_at_twice_the_size_shows_the_whole_window(start, photo):
    """A screen of 1600 by 1000 at 200 % has half as many px to lay out."""
    driver = start(photo)
    for workspace in driver.workspaces():
        driver.unfold()
        driver.settle()
        fit_into(driver, TWICE, workspace)
        assert driver.window.statusBar().geometry().bottom() < TWICE[1]


@in_sizes
def test_no_text_of_a_dialog_is_cut(request, text_size, look, share, dress):
    look(dress)
    text_size(share)
    for dialog in request.getfixturevalue("dialogs"):
        assert (dialog.windowTitle(), told(dialog)) == (dialog.windowTitle(), [])
        assert dialog.width() <= LEAST[0]
        assert dialog.height() <= dialog.screen().availableSize().height()


def test_a_choice_that_is_cut_ends_in_dots(qtbot):
    whole, short = ChoiceBox(), ChoiceBox()
    for box in (whole, short):
        qtbot.addWidget(box)
        box.setFixedWidth(120)
    whole.addItem("Threshold: pixels that move")
    option = QStyleOptionComboBox()
    whole.initStyleOption(option)
    field = QStyle.SubControl.SC_ComboBoxEditField
    room = whole.style().subControlRect(QStyle.ComplexControl.CC_ComboBox, option, field, whole)
    end = Qt.TextElideMode.ElideRight
    short.addItem(whole.fontMetrics().elidedText(whole.currentText(), end, room.width()))
    assert short.currentText().endswith("…")
    assert whole.grab().toImage() == short.grab().toImage()
    assert whole.currentText() == "Threshold: pixels that move"


# What a hand may need at any moment; the rest has its key and its place in a menu.
OFTEN = {"open", "save", "undo", "redo", "mode-automatic", "mode-manual", "hold-original"}


def tools_of(driver):
    """The toolbar's buttons behind the switch, from the left, by their names."""
    bar = driver.window.findChild(QToolBar)
    names = {action: name for name, action in driver.window.actions_by_name.items()}
    there = [action for action in bar.actions()[1:] if not action.isSeparator()]
    return {names.get(one, "hold-original"): bar.widgetForAction(one) for one in there}


def worded(button):
    return button.toolButtonStyle() == Qt.ToolButtonStyle.ToolButtonTextBesideIcon


def nothing_needed_is_hidden(driver, workspace):
    """Words go before tools do, and of those the last ones."""
    assert driver.window.width() == LEAST[0], workspace
    there = tools_of(driver)
    shown = [name for name, button in there.items() if button.isVisible()]
    assert list(there)[: len(shown)] == shown, workspace
    assert OFTEN & there.keys() <= set(shown), workspace
    assert len(shown) == len(there) or not any(map(worded, there.values())), workspace


def needed_tools_are_seen(driver):
    """Wait in the least window of every workspace until nothing needed is hidden."""
    for name in driver.workspaces():
        driver.window.resize(*LEAST)
        driver.qtbot.waitUntil(partial(nothing_needed_is_hidden, driver, name))


@pytest.mark.parametrize("share", [1.0, 2.0])
def test_the_least_window_shows_the_tools_that_are_needed(start, photo, text_size, share):
    text_size(share)
    driver = start(photo, workspace="retouch")
    needed_tools_are_seen(driver)


def test_no_word_goes_that_has_room(start):
    driver = start(workspace="retouch")
    driver.window.resize(*LEAST)
    driver.qtbot.waitUntil(lambda: driver.window.width() == LEAST[0])
    driver.window.actions_by_name["workspace-compare"].trigger()
    driver.settle()
    assert [name for name, one in tools_of(driver).items() if worded(one)][:2] == ["open", "save"]


def test_retouch_has_few_controls(start, photo):
    driver = start(workspace="retouch")
    driver.window.resize(1280, 800)
    driver.open(photo)
    fold = driver.panel("recipe").shape
    shape = {one for one in controls(driver.window) if fold.isAncestorOf(one)}
    assert len(shape) <= 1 + 2 * len(SHAPE), "its title; a slider and a figure each"
    shown = controls(driver.window) - shape
    assert len(shown) <= 26, sorted(one.accessibleName() or one.text() for one in shown)
    driver.editor.manual.switch("manual")
    driver.settle()
    more = {one.text() for one in controls(driver.window) - shown - shape}
    assert more == {"Tools", "Back to automatic"}, "points by hand add no more than they need"


def test_every_control_and_its_label_have_a_tooltip(start, photo):
    driver = start(photo)
    driver.key(Qt.Key.Key_F3)
    for workspace in driver.workspaces():
        driver.unfold()
        labels = [one for one in visible(driver.window, (QLabel,)) if one.buddy() is not None]
        silent = [one for one in (*labels, *controls(driver.window)) if not one.toolTip()]
        named = [one.accessibleName() or getattr(one, "text", str)() for one in silent]
        assert (workspace, named) == (workspace, [])


def test_every_tool_but_the_well_known_ones_has_a_word_in_a_wide_window(start):
    driver = start(workspace="retouch")
    driver.window.resize(*LEAST)
    driver.qtbot.waitUntil(lambda: not worded(tools_of(driver)["compare-side"]))
    driver.window.resize(1600, 700)
    known = {"undo", "redo", "fit"}
    tools = tools_of(driver)
    named = {name for name, button in tools.items() if name not in known}
    driver.qtbot.waitUntil(lambda: {name for name, it in tools.items() if worded(it)} == named)


def test_the_text_of_a_spin_box_has_room_above_and_below(qapp, qtbot):
    theme.apply(qapp, "dark")
    box = WholeNumber(0, 100, 0)
    qtbot.addWidget(box)
    box.resize(box.sizeHint())
    box.show()
    # Glyphs of another font, such as Japanese ones, are higher than the font's line.
    assert box.lineEdit().height() >= box.fontMetrics().height() + 2
