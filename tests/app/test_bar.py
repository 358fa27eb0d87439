"""How long a message over the photo stays."""

from __future__ import annotations

import pytest
from kogao_app.widgets import messages as bar
from kogao_app.widgets.messages import BarAction, Message, MessageBar
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLineEdit, QVBoxLayout, QWidget

CONTROL = Qt.KeyboardModifier.ControlModifier
OFFER = Message("An offer", (BarAction("Take it", lambda: None),), wrong=False, holds=lambda: True)


@pytest.fixture
def read(monkeypatch):
    """Whoever acts has read what stands there."""
    monkeypatch.setattr(bar, "UNREAD_MS", 0)


@pytest.fixture
def alone(qtbot):
    made = MessageBar()
    qtbot.addWidget(made)
    return made


def says(shown):
    return shown.text.text() if shown.isVisible() else ""


def dismiss(shown):
    QTest.mouseClick(shown.buttons[-1], Qt.MouseButton.LeftButton)


@pytest.mark.usefixtures("read")
def test_a_refusal_goes_with_the_next_step(opened, photo):
    opened.editor.files.save(photo)
    assert "never written over" in opened.say()
    opened.change_something()
    assert opened.say() == ""
    opened.editor.files.save(photo)
    assert "never written over" in opened.say()
    opened.key(Qt.Key.Key_Z, CONTROL)
    assert opened.say() == ""


def test_what_came_a_moment_ago_has_not_been_read(opened, photo, monkeypatch):
    monkeypatch.setattr(bar, "UNREAD_MS", 10**9)
    opened.editor.files.save(photo)
    opened.change_something()
    assert "never written over" in opened.say()


def test_a_refusal_goes_when_something_else_is_saved(opened, photo):
    opened.editor.files.save(photo)
    assert "never written over" in opened.say()
    opened.editor.projects.save()
    opened.settle()
    assert opened.say() == ""
    assert photo.with_name("portrait.png.kogao.json").exists()


def test_no_face_goes_when_one_is_found(start, source, photo):
    faces, source.faces = source.faces, []
    driver = start()
    driver.open(photo)
    assert "No face" in driver.say()
    source.faces = faces
    driver.key(Qt.Key.Key_F, CONTROL)
    driver.settle()
    assert driver.say() == ""


def test_only_what_merely_informs_goes_by_itself(qtbot, monkeypatch):
    monkeypatch.setattr(bar, "LINGER_MS", 1)
    stay = (Message("Wrong"), Message("Choose", OFFER.steps, wrong=False), OFFER)
    host = QWidget()
    qtbot.addWidget(host)
    column, elsewhere = QVBoxLayout(host), QLineEdit()
    column.addWidget(elsewhere)
    bars = [MessageBar() for _ in (*stay, "informs")]
    for shown in bars:
        column.addWidget(shown)
    host.show()
    elsewhere.setFocus()
    for shown, message in zip(bars, (*stay, Message("Saved", wrong=False)), strict=True):
        shown.say(message)
    qtbot.waitUntil(lambda: not bars[-1].isVisible())
    assert [says(shown) for shown in bars[:-1]] == ["Wrong", "Choose", "An offer"]


@pytest.mark.usefixtures("read")
@pytest.mark.parametrize("order", [1, -1])
def test_an_offer_waits_behind_an_error_until_it_is_answered(alone, order):
    for message in [OFFER, Message("An error")][::order]:
        alone.say(message)
    assert says(alone) == "An error"
    dismiss(alone)
    assert says(alone) == "An offer"
    alone.move_on()
    alone.clear()
    assert says(alone) == "An offer"
    dismiss(alone)
    assert says(alone) == ""


@pytest.mark.usefixtures("read")
def test_placing_is_explained_for_as_long_as_it_lasts(opened):
    opened.key(Qt.Key.Key_P, CONTROL)
    opened.change_something()
    assert "Drag the frame" in opened.say()
    opened.key(Qt.Key.Key_Z, CONTROL)
    opened.key(Qt.Key.Key_Z, CONTROL)
    assert opened.say() == ""


@pytest.mark.usefixtures("read")
def test_the_welcome_stays_with_the_sample(empty, photo):
    empty.editor.files.welcome()
    empty.settle()
    empty.change_something()
    assert "Warp distance" in empty.say()
    empty.key(Qt.Key.Key_Z, CONTROL)
    empty.open(photo)
    assert empty.say() == ""
