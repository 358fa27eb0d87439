"""The window in another language: every word of it is translated, and longer words fit."""

from __future__ import annotations

import re
from functools import partial

import pytest
from kogao_app.features.experiments.dialog import ExperimentDialog
from kogao_app.workspaces import WORKSPACES
from pseudolocale import pseudo
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
    QWidget,
)
from test_nothing_is_cut import LEAST, nothing_is_cut, told

from kogao_core.projects.sidecar import sidecar_of

pytestmark = pytest.mark.usefixtures("one_window")

WORD = re.compile(r"[A-Za-z]{2,}")
TAG = re.compile(r"<[^<>]*>")
# Behind what an action does, or alone beside the name of an overlay.
KEYS = re.compile(r" \([A-Z][\w+]*[^\w\s]?\)$|^Shift\+[A-Z]$")
# Its own catalogues have them.
QTS = {"Cancel", "Close", "Discard", "Show Details...", "Scroll Left", "Scroll Right"}


def texts(root):
    """Every text of a window and of what lies in it, by what shows it."""
    for widget in (root, *root.findChildren(QWidget)):
        if widget.objectName().startswith("qt_"):
            continue
        said = [widget.toolTip(), widget.accessibleName(), widget.accessibleDescription()]
        said += [widget.windowTitle(), widget.statusTip()]
        if isinstance(widget, QLabel | QAbstractButton):
            said.append(widget.text())
        elif isinstance(widget, QComboBox):
            said += [widget.itemText(n) for n in range(widget.count())]
        elif isinstance(widget, QTabBar):
            said += [widget.tabText(n) for n in range(widget.count())]
        elif isinstance(widget, QGroupBox):
            said.append(widget.title())
        elif isinstance(widget, QLineEdit):
            said.append(widget.placeholderText())
        elif isinstance(widget, QAbstractSpinBox):
            said.append(widget.text())
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


@pytest.mark.usefixtures("pseudolocale")
def test_every_word_of_the_window_is_translated_and_longer_ones_fit(start, photo):
    driver = start(photo, workspace="retouch")
    for name in WORKSPACES:
        driver.window.actions_by_name[f"workspace-{name}"].trigger()
        driver.unfold()
        for mode in ("manual", "automatic"):
            driver.window.actions_by_name[f"mode-{mode}"].trigger()
            driver.settle()
            driver.window.resize(*LEAST)
            driver.qtbot.waitUntil(partial(nothing_is_cut, driver.window, LEAST, (name, mode)))
            assert (
                plain(
                    driver.window,
                    (str(photo), str(photo.parent), photo.parent.name, photo.name, "Kogao"),
                )
                == set()
            ), name


@pytest.mark.usefixtures("pseudolocale")
def test_every_word_of_a_dialog_is_translated_and_longer_ones_fit(dialogs, photo):
    for dialog in dialogs:
        if isinstance(dialog, ExperimentDialog):
            continue  # its words are the test's
        assert plain(dialog, (str(photo.parent), photo.name, "Kogao")) == set()
        assert (dialog.windowTitle(), told(dialog)) == (dialog.windowTitle(), [])


@pytest.mark.usefixtures("pseudolocale")
def test_what_qts_catalogues_lack_of_its_dialog_for_files_is_translated(opened):
    opened.editor.files.ask_save()
    asked = opened.dialog(QFileDialog)
    for which in (QFileDialog.DialogLabel.LookIn, QFileDialog.DialogLabel.FileType):
        assert WORD.findall(asked.labelText(which).replace("&", "")) == []


@pytest.mark.usefixtures("pseudolocale")
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


@pytest.mark.usefixtures("pseudolocale")
def test_what_the_core_notes_is_said_in_the_users_language(opened, photo):
    opened.change_something()
    opened.settle()
    photo.write_bytes(photo.read_bytes() + b"more")
    opened.open(photo)
    assert pseudo("the project was made from")[1:20] in opened.say()
    assert WORD.findall(opened.say().replace(sidecar_of(photo).name, "")) == []
