"""The window in another language: every word of it is translated, and longer words fit."""

import re

import pytest
from kogao_app.features.experiments.dialog import ExperimentDialog
from kogao_app.widgets.dialogs import Dialog
from PIL import Image
from pseudolocale import pseudo
from PySide6.QtGui import QAccessible, QKeySequence
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QComboBox,
    QFileDialog,
    QGroupBox,
    QLabel,
    QLineEdit,
    QMenu,
    QTabBar,
    QToolBar,
    QToolButton,
    QWidget,
)
from systems import needs_own_names
from test_mnemonics import doubled, letters_of
from test_nothing_is_cut import LEAST, arrangements, fit_into, needed_tools_are_seen, told

from kogao_core.base import language
from kogao_core.projects.edits import sidecar_of

in_pseudolocale = pytest.mark.usefixtures("one_window", "pseudolocale")
in_japanese = pytest.mark.usefixtures("japanese")

WORD = re.compile(r"[A-Za-z]{2,}")
TAG = re.compile(r"<[^<>]*>")
# Behind what an action does, or alone beside the name of an overlay.
KEYS = re.compile(r" \([A-Z][\w+]*[^\w\s]?\)$|^Shift\+[A-Z]$")
# Its own catalogues have them.
QTS = {"Cancel", "Close", "Discard", "Show Details...", "Scroll Left", "Scroll Right"}


# What shows a text or several, and the method that returns it.
TEXTS = {QLabel: "text", QAbstractButton: "text", QAbstractSpinBox: "text", QGroupBox: "title"}
TEXTS |= {QLineEdit: "placeholderText"}
LISTS = {QComboBox: "itemText", QTabBar: "tabText"}
ABOUT = ("toolTip", "accessibleName", "accessibleDescription", "windowTitle", "statusTip")


def texts(root):
    """Every text of a window and of what lies in it, by what shows it."""
    for widget in (root, *root.findChildren(QWidget)):
        if widget.objectName().startswith("qt_"):
            continue
        names = [*ABOUT, *(name for kind, name in TEXTS.items() if isinstance(widget, kind))]
        said = [getattr(widget, name)() for name in names]
        for name in (name for kind, name in LISTS.items() if isinstance(widget, kind)):
            said += [getattr(widget, name)(n) for n in range(widget.count())]
        for text in filter(None, said):
            yield type(widget).__name__, text
    for menu in root.findChildren(QMenu):
        for action in menu.actions():
            for text in filter(None, (action.text(), action.toolTip(), action.statusTip())):
                yield menu.title(), text


def plain(root, names=()):
    """Texts with words that nobody translated, but for names of files, keys and Qt's own."""
    found = set()
    for kind, text in texts(root):
        bare = TAG.sub(" ", text.replace("&", ""))
        for name in names:
            bare = bare.replace(name, " ")
        if WORD.search(KEYS.sub(" ", bare)) and bare not in QTS:
            found.add((kind, text))
    return found


@in_pseudolocale
def test_every_word_of_the_window_is_translated_and_longer_ones_fit(start, photo):
    driver = start(photo, workspace="retouch")
    names = (str(photo), str(photo.parent), photo.parent.name, photo.name, "Kogao")
    for where in arrangements(driver):
        fit_into(driver, LEAST, where)
        assert plain(driver.window, names) == set(), where


@in_pseudolocale
def test_every_word_of_a_dialog_is_translated_and_longer_ones_fit(dialogs, photo):
    for dialog in dialogs:
        if isinstance(dialog, ExperimentDialog):
            continue  # its words are the test's
        assert plain(dialog, (str(photo.parent), photo.name, "Kogao")) == set()
        assert (dialog.windowTitle(), told(dialog)) == (dialog.windowTitle(), [])


@in_pseudolocale
def test_what_qts_catalogues_lack_of_its_dialog_for_files_is_translated(opened):
    opened.editor.files.ask_save()
    asked = opened.dialog(QFileDialog)
    for which in (QFileDialog.DialogLabel.LookIn, QFileDialog.DialogLabel.FileType):
        assert WORD.findall(asked.labelText(which).replace("&", "")) == []


@in_pseudolocale
def test_what_the_core_refuses_is_said_in_the_users_language(start, photo):
    driver = start(workspace="retouch")
    broken = photo.with_name("broken.jpg")
    broken.write_bytes(b"\xff\xd8\xff\xe0 and no more")
    driver.open(broken)
    assert "broken.jpg" in driver.say()
    assert WORD.findall(driver.say().replace(str(broken), "")) == []
    project = sidecar_of(photo)
    project.write_text('{"format": 3}')
    driver.open(photo)
    assert pseudo("The photo starts")[:10] in driver.say()
    assert WORD.findall(driver.say().replace(str(project), "").replace("format", "")) == []


@in_pseudolocale
def test_what_the_core_notes_is_said_in_the_users_language(opened, photo):
    opened.change_something()
    opened.settle()
    with Image.open(photo) as picture:
        smaller = picture.resize((picture.width // 2, picture.height // 2))
    smaller.save(photo)
    opened.open(photo)
    assert pseudo("the project was made at")[1:18] in opened.say()
    assert WORD.findall(opened.say().replace(sidecar_of(photo).name, "")) == []


@pytest.fixture
def japanese(spoken):  # noqa: ARG001
    language.use_language("ja")


@in_japanese
@needs_own_names
def test_a_letter_leads_to_one_place_and_what_has_none_shows_none_in_japanese(two, dialogs):
    """A toolbar has no letters, and a screen reader spells none."""
    texts = letters_of(two.window)
    letters = {QKeySequence.mnemonic(text).toString() for text in texts}
    assert letters >= {f"Alt+{letter}" for letter in "FEVAMTXHSOLUIDRNB"}
    assert doubled(texts) == {}
    for menu in two.window.findChildren(QMenu):
        assert doubled(one.text() for one in menu.actions()) == {}, menu.title()
    for dialog in dialogs:
        assert doubled(letters_of(dialog)) == {}, dialog.windowTitle()
    (bar,) = two.window.findChildren(QToolBar)
    shown = [one.text() for one in bar.findChildren(QToolButton) if one.defaultAction()]
    assert {"開く", "手動"} <= set(shown)
    shown += [one.accessibleName() for one in two.window.findChildren(QToolButton)]
    buddies = filter(None, (one.buddy() for one in two.window.findChildren(QLabel)))
    shown += [one.accessibleName() for one in buddies]
    buddies = [one for one in two.window.findChildren(QLabel) if one.buddy()]
    name = QAccessible.Text.Name
    shown += [QAccessible.queryAccessibleInterface(one).text(name) for one in buddies]
    for parent in (two.window, *(one for one in dialogs if isinstance(one, Dialog))):
        buttons = [one for one in parent.findChildren(QAbstractButton) if one.text()]
        shown += [QAccessible.queryAccessibleInterface(one).text(name) for one in buttons]
    assert [text for text in shown if re.search(r"\([A-Z]\)", text)] == []


@in_japanese
def test_no_text_is_cut_in_the_least_window_in_japanese(start, photo):
    driver = start(photo, workspace="retouch")
    for where in arrangements(driver):
        fit_into(driver, LEAST, where)


@in_japanese
def test_the_least_window_shows_the_tools_that_are_needed_in_japanese(start, photo, text_size):
    text_size(2.0)
    needed_tools_are_seen(start(photo, workspace="retouch"))
