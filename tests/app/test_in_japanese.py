"""The window in Japanese: nothing is cut, a letter leads to one place, and none stands idle."""

from __future__ import annotations

from functools import partial

import pytest
from kogao_app.workspaces import WORKSPACES
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QLabel, QMenu, QToolBar, QToolButton
from test_mnemonics import doubled, letters_of
from test_nothing_is_cut import LEAST, needed_tools_are_seen, nothing_is_cut

from kogao_core.base import language


@pytest.fixture(autouse=True)
def japanese(spoken):  # noqa: ARG001
    language.use_language("ja")


def test_a_letter_leads_to_one_place(two, dialogs):
    texts = letters_of(two.window)
    letters = {QKeySequence.mnemonic(text).toString() for text in texts}
    assert letters >= {f"Alt+{letter}" for letter in "FEVAMTXHSWLUIDRNB"}
    assert doubled(texts) == {}
    for menu in two.window.findChildren(QMenu):
        assert doubled(one.text() for one in menu.actions()) == {}, menu.title()
    for dialog in dialogs:
        assert doubled(letters_of(dialog)) == {}, dialog.windowTitle()


def test_what_has_no_letter_shows_none(two):
    """A toolbar has no letters, and a screen reader spells none."""
    two.window.resize(1600, 900)
    (bar,) = two.window.findChildren(QToolBar)
    buttons = [one for one in bar.findChildren(QToolButton) if one.defaultAction()]
    assert {"開く", "手動"} <= {one.text() for one in buttons}
    shown = [one.text() for one in buttons]
    shown += [one.accessibleName() for one in two.window.findChildren(QToolButton)]
    buddies = filter(None, (one.buddy() for one in two.window.findChildren(QLabel)))
    shown += [one.accessibleName() for one in buddies]
    assert [text for text in shown if "(" in text] == []


def test_no_text_is_cut_in_the_least_window(start, photo):
    driver = start(photo, workspace="retouch")
    for name in WORKSPACES:
        driver.window.actions_by_name[f"workspace-{name}"].trigger()
        driver.unfold()
        driver.settle()
        driver.window.resize(*LEAST)
        driver.qtbot.waitUntil(partial(nothing_is_cut, driver.window, LEAST, name))


@pytest.mark.parametrize("share", [1.0, 2.0])
def test_the_least_window_shows_the_tools_that_are_needed(start, photo, text_size, share):
    text_size(share)
    driver = start(photo, workspace="retouch")
    needed_tools_are_seen(driver)
