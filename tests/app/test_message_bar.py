"""How long a message over the photo stays."""

import json
import shutil

import pytest
from kogao_app.widgets import messages as bar
from kogao_app.widgets.messages import BarAction, Message, MessageBar
from PySide6.QtCore import QPoint, QPointF, QRectF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit, QVBoxLayout, QWidget
from scenes import oval_face
from test_typed import type_in

from kogao_core.recipe.recipe import Recipe

pytestmark = pytest.mark.usefixtures("one_window")

CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
ALT = Qt.KeyboardModifier.AltModifier
OFFER = Message(
    "An offer", (BarAction("Take it", lambda: None),), wrong=False, applies=lambda: True
)


@pytest.fixture
def alone(qtbot):
    made = MessageBar()
    qtbot.addWidget(made)
    return made


def says(shown):
    return shown.accessibleDescription() if shown.isVisible() else ""


def dismiss(shown):
    QTest.mouseClick(shown.buttons[-1], Qt.MouseButton.LeftButton)


@pytest.mark.usefixtures("read")
def test_a_refusal_goes_with_the_next_step(opened, photo):
    opened.save(photo)
    assert "never written over" in opened.say()
    opened.change_something()
    assert opened.say() == ""
    opened.save(photo)
    assert "never written over" in opened.say()
    opened.editor.projects.save_to(photo.with_name("other.kogao.json"))
    opened.settle()
    assert opened.say() == ""


def test_what_came_a_moment_ago_goes_once_it_could_be_read(opened, photo, monkeypatch):
    """It is about a save that failed: it doesn't wait for one more step to come."""
    monkeypatch.setattr(bar, "UNREAD_MS", 10**9)
    opened.save(photo)
    opened.change_something()
    assert "never written over" in opened.say()
    opened.window.bar._linger.setInterval(0)  # so long it takes to read, then
    opened.qtbot.waitUntil(lambda: opened.say() == "")


@pytest.fixture
def faceless(start, source, photo):
    source.faces = []
    driver = start(photo)
    assert "No face" in driver.say()
    return driver


@pytest.mark.usefixtures("read")
def test_no_face_stays_while_there_is_none_and_goes_when_one_is_placed(faceless):
    faceless.change_something()
    assert "No face" in faceless.say()
    faceless.key(Qt.Key.Key_P, CONTROL)
    assert "Drag the frame" in faceless.say()
    faceless.key(Qt.Key.Key_Escape)
    assert faceless.say() == ""


def mark(driver):
    driver.key(Qt.Key.Key_F3)
    for _ in range(2):
        driver.press_key(driver.canvas, Qt.Key.Key_Return)
    assert len(driver.state.draft) == 1


def find(driver):
    driver.key(Qt.Key.Key_F, CONTROL)
    driver.settle()


def open_another(driver):
    other = driver.editor.document.path.with_name("other.png")
    shutil.copy(driver.editor.document.path, other)
    driver.open(other)


@pytest.mark.parametrize("act", [mark, find, open_another])
def test_no_face_goes_when_one_is_marked_or_found_and_with_its_photo(faceless, source, act):
    source.faces = [oval_face()]
    act(faceless)
    assert faceless.say() == ""


def test_what_could_not_be_drawn_or_kept_goes_once_it_could(opened, monkeypatch):
    def fail(*_, **__):
        raise MemoryError

    with monkeypatch.context() as broken:
        broken.setattr("kogao_app.render.live.render", fail)
        broken.setattr("kogao_app.features.recovery.save", fail)
        opened.change_something()
        opened.settle()
        told = []
        for _ in range(2):
            told.append(opened.say())
            opened.window.bar.dismiss()
        assert any("can't be redrawn" in text for text in told)
        assert any("can't be kept for a crash" in text for text in told)
        opened.change_something()
        opened.settle()
        assert opened.say() != ""
    opened.change_something()
    opened.qtbot.waitUntil(lambda: opened.say() == "")


def test_an_experiment_that_needs_a_face_says_so_until_there_is_one(opened):
    opened.key(Qt.Key.Key_A, CONTROL, SHIFT)
    opened.key(Qt.Key.Key_1, CONTROL, ALT)
    assert "needs a photo with an active face" in opened.say()
    opened.key(Qt.Key.Key_A, CONTROL)
    assert opened.say() == ""


def test_escape_closes_a_message_and_nothing_else(opened, photo):
    opened.key(Qt.Key.Key_Period, CONTROL)
    opened.save(photo)
    opened.key(Qt.Key.Key_Escape)
    assert opened.say() == ""
    assert opened.editor.view.selected is not None
    opened.key(Qt.Key.Key_Escape)
    assert opened.editor.view.selected is None


def test_a_gesture_is_aborted_before_a_message_is_closed(opened, photo):
    opened.save(photo)
    opened.editor.recipe.set_field("percent", 9.0)
    opened.key(Qt.Key.Key_Escape)
    assert opened.state.recipe.percent == 4.0
    assert "never written over" in opened.say()


def covered(driver):
    """How much of each face the message hides, px of the screen."""
    shown = driver.window.bar
    at = shown.mapTo(driver.window, QPoint()) - driver.canvas.mapTo(driver.window, QPoint())
    plate = QRectF(at.toPointF(), shown.size().toSizeF())
    hidden = []
    for face in driver.state.faces:
        low, high = face.points.min(axis=0), face.points.max(axis=0)
        box = QRectF(driver.canvas.to_screen(low), driver.canvas.to_screen(high))
        both = plate & box
        hidden.append(both.width() * both.height())
    return hidden


@pytest.mark.parametrize("place", [(240, 60), (400, 60)])
def test_a_message_hides_no_face_where_there_is_room_elsewhere(start, source, photo, place):
    source.faces = [oval_face(center=place, size=0.4)]
    driver = start(photo)
    driver.save(photo)
    assert "never written over" in driver.say()
    assert covered(driver) == [0.0]
    driver.window.resize(900, 620)
    driver.qtbot.waitUntil(lambda: covered(driver) == [0.0])
    assert driver.window.bar.geometry().right() <= driver.canvas.parent().width()


def test_a_message_moves_away_from_a_face_that_comes_under_it(opened, photo):
    opened.save(photo)
    for move in ((0, -1), (0, 1)):
        for _ in range(12):
            middle = opened.canvas.viewport().rect().center()
            opened.canvas.start_pan(middle.toPointF())
            opened.canvas.pan_to(middle.toPointF() + QPointF(*move) * 20)
            opened.canvas.end_pan()
            assert sum(covered(opened)) == 0.0


def test_a_message_leaves_what_to_do_next_in_sight(start, photo):
    driver = start(photo, workspace="compare")
    guide = driver.editor.both.guide
    left, top, width, height = driver.state.faces[0].box
    driver.canvas.look_at(QRectF(left, top, width, 2 * height))
    driver.save(photo)
    assert guide.isVisible()
    assert driver.say()
    assert not driver.window.bar.geometry().intersects(guide.geometry())


def test_the_whole_of_a_long_message_is_seen(opened):
    words = "A sentence that is long enough to need several lines. " * 6
    opened.editor.points.say(words.strip())
    text, size = opened.window.bar.text, opened.window.bar.size()
    assert text.text() == words[: words.index(".") + 1], "one sentence at first"
    assert opened.say() == words.strip(), "read as a whole"
    QTest.mouseClick(opened.window.bar.buttons[0], Qt.MouseButton.LeftButton)
    assert text.text() == words.strip()
    assert opened.window.bar.height() > size.height()
    assert text.height() >= text.heightForWidth(text.width())


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


def test_what_could_not_be_written_goes_with_the_next_try(opened, tmp_path):
    opened.editor.figure.export(tmp_path / "nowhere" / "out.png")
    assert "nowhere" in opened.say()
    opened.editor.figure.export(tmp_path / "out.png")
    assert opened.say() == ""


def test_a_clipboard_without_settings_is_forgotten_once_some_are_copied(opened):
    QApplication.clipboard().setText("nothing of ours")
    opened.editor.recipe.paste()
    assert "copy some first" in opened.say()
    opened.editor.recipe.copy()
    assert Recipe.from_dict(json.loads(QApplication.clipboard().text()))
    assert opened.say() == ""
    assert opened.window.status.hint_text == "Settings copied"


@pytest.mark.usefixtures("read")
def test_what_is_no_value_is_forgotten_once_one_is_typed(opened):
    """The value that was there is an answer, too, and so is one that is no step to undo."""
    opened.key(Qt.Key.Key_B)
    sliders = opened.panel("recipe").percent, opened.panel("protect").size_px
    for slider, value in zip(sliders, ("4.0", "33"), strict=True):
        type_in(slider.field, "9999")
        assert " goes from " in opened.say()
        type_in(slider.field, value)
        assert opened.say() == ""


def test_a_message_about_a_photo_ends_with_the_next_photo(opened, tmp_path):
    opened.editor.strip.show_places([tmp_path / "no such folder"])
    opened.settle()
    assert opened.say()
    opened.open(opened.editor.document.path)
    assert opened.say() == ""
