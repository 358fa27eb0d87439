"""A letter leads to one place: in each menu, and with Alt in each window."""

from collections import defaultdict

import pytest
from kogao_app.actions import call
from kogao_app.i18n import bare, lettered
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QLabel,
    QMainWindow,
    QMenu,
    QMenuBar,
    QWidget,
)

pytestmark = pytest.mark.usefixtures("one_window")


def doubled(texts):
    """The letters that more than one text is called by."""
    called = defaultdict(list)
    for text in texts:
        called[QKeySequence.mnemonic(text).toString()].append(text)
    return {letter: those for letter, those in called.items() if letter and len(those) > 1}


def letters_of(window):
    """The texts in a window that a letter may be underlined in, folded away or not."""
    texts = []
    for widget in window.findChildren(QWidget):
        if widget.window() is not window or not widget.isEnabled():
            continue
        if isinstance(widget, QAbstractButton) or (isinstance(widget, QLabel) and widget.buddy()):
            texts.append(widget.text())
        elif isinstance(widget, QMenuBar):
            texts += [action.text() for action in widget.actions()]
    return texts


def test_a_letter_with_alt_leads_to_one_place_of_the_window(two):
    texts = letters_of(two.window)
    assert {"F&ace", "Lattice &unit", "Si&ze"} <= set(texts)
    assert doubled(texts) == {}


def test_a_letter_leads_to_one_entry_of_a_menu(two):
    menus = two.window.findChildren(QMenu)
    assert {"&File", "F&ace", "Face", "Prese&ts"} <= {menu.title() for menu in menus}
    found = {menu.title(): doubled(one.text() for one in menu.actions()) for menu in menus}
    assert {title: those for title, those in found.items() if those} == {}


def test_a_letter_with_alt_leads_to_one_place_of_a_dialog(dialogs):
    kinds = {type(one).__name__ for one in dialogs}
    assert kinds >= {"ExportDialog", "PreferencesDialog", "QMessageBox"}
    for dialog in dialogs:
        assert (dialog.windowTitle(), doubled(letters_of(dialog))) == (dialog.windowTitle(), {})


@pytest.mark.usefixtures("opened")
def test_every_menu_goes_with_its_window():
    tops = [one for one in QApplication.topLevelWidgets() if isinstance(one, QMenu)]
    assert [menu.title() for menu in tops if menu.parent() is None] == []


def test_a_letter_behind_the_word_is_on_no_button_and_in_no_name(qtbot):
    window = QMainWindow()
    qtbot.addWidget(window)
    action = QAction(window)
    call(action, "開く(&O)…")
    bar = window.addToolBar("buttons")
    bar.addAction(action)
    button = bar.widgetForAction(action)
    assert (button.text(), action.text()) == ("開く", "開く(&O)…")
    call(action, "写真を開く(&O)…")
    assert (button.text(), action.text()) == ("写真を開く", "写真を開く(&O)…")
    assert bare("&Save a copy…") == "Save a copy…"


def test_a_letter_that_a_text_lacks_stands_behind_it():
    assert [lettered("Fit", "i"), lettered("あてはめ", "i")] == ["F&it", "あてはめ(&I)"]


def test_a_button_keeps_the_shorter_text_that_its_action_has(opened):
    hide = opened.window.actions_by_name["hide-overlays"]
    assert (hide.text(), hide.iconText()) == ("Hide all o&verlays", "Hide overlays")
    hide.trigger()
    assert hide.iconText() == "Hide overlays"
