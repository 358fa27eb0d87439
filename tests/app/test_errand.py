"""Other programs ask for photos: saving writes over them, and the exit code tells."""

import numpy as np
import pytest
from kogao_app.__main__ import main
from kogao_app.features import errand
from kogao_app.features.preferences import PreferencesDialog
from kogao_app.widgets.controls import Fold
from kogao_app.widgets.form import Form
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox
from timeouts import held_back

from kogao_core.photo import read
from kogao_core.photo.originals import Originals

CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def asked(empty, photo):
    """An editor that another program has started with a photo."""
    empty.editor.errand.begin([photo])
    empty.settle()
    return empty


def test_saving_writes_over_the_photo_and_puts_nothing_beside_it(asked, photo, storage):
    before, beside = photo.read_bytes(), set(photo.parent.iterdir())
    for _ in range(2):
        asked.change_something()
        asked.settle()
        asked.key(Qt.Key.Key_S, CONTROL)
        asked.settle()
        np.testing.assert_array_equal(read(photo).pixels, asked.shown, "from the original again")
        assert set(photo.parent.iterdir()) - beside <= {storage.data.parent}
        assert asked.say().startswith("Saved portrait.png.")
        assert asked.editor.errand.code == 0
    assert Originals(storage.originals).restore(photo)
    assert photo.read_bytes() == before


@pytest.mark.parametrize(
    ("key", "code"), [(Qt.Key.Key_Return, 0), (Qt.Key.Key_Backspace, errand.CANCELLED)]
)
def test_done_saves_and_closes_and_cancel_leaves_the_photo_without_a_question(
    asked, photo, key, code
):
    before = photo.read_bytes()
    asked.change_something()
    asked.settle()
    asked.key(key, CONTROL, SHIFT)
    asked.qtbot.waitUntil(lambda: not asked.window.isVisible())
    assert (photo.read_bytes() != before) == (code == 0)
    assert asked.editor.errand.code == code


def test_done_waits_for_the_faces_that_are_sought(empty, source, photo):
    before = photo.read_bytes()
    gate, source.find = held_back(source.find)
    empty.editor.errand.begin([photo])
    empty.qtbot.waitUntil(lambda: empty.editor.document.photo is not None)
    empty.key(Qt.Key.Key_Return, CONTROL, SHIFT)
    gate.set()
    empty.qtbot.waitUntil(lambda: not empty.window.isVisible())
    assert photo.read_bytes() != before
    assert empty.editor.errand.code == 0


def test_the_bar_says_who_asked_and_offers_to_be_done(asked):
    assert asked.say().startswith("Opened by another program")
    asked.take_step("Done")
    asked.qtbot.waitUntil(lambda: not asked.window.isVisible())
    assert asked.editor.errand.code == 0


def test_leaving_changes_asks_for_no_copy_and_no_project(asked, photo):
    before = photo.read_bytes()
    asked.change_something()
    asked.settle()
    asked.window.close()
    box = asked.dialog(QMessageBox)
    offered = {button.text().replace("&", "") for button in box.buttons()}
    assert "Save" in offered
    assert not offered & {"Save a copy…", "Save project…"}
    box.button(QMessageBox.StandardButton.Discard).click()
    assert not asked.window.isVisible()
    assert photo.read_bytes() == before
    assert asked.editor.errand.code == errand.CANCELLED


def test_what_cant_be_written_over_is_said_when_it_is_opened(empty, photo):
    other = photo.with_suffix(".jpg")
    photo.rename(other)
    empty.editor.errand.begin([other])
    empty.settle()
    assert "is a PNG photo by its content" in empty.say()
    before = other.read_bytes()
    empty.key(Qt.Key.Key_S, CONTROL)
    empty.settle()
    assert "is a PNG photo by its content" in empty.say()
    assert other.read_bytes() == before
    assert empty.editor.errand.code == errand.CANCELLED


def test_several_photos_make_a_film_strip(empty, photo, tmp_path, other):
    empty.editor.errand.begin([photo, other])
    empty.settle()
    assert empty.editor.strip.film.count() == 2
    assert empty.editor.document.path == photo
    empty.key(Qt.Key.Key_3, CONTROL, SHIFT)
    empty.settle()
    assert set(tmp_path.glob("*.xmp")) == set(), "nothing comes to lie beside another's photos"


def test_elsewhere_a_photo_stays_as_it_is(opened, photo):
    before = photo.read_bytes()
    opened.key(Qt.Key.Key_Return, CONTROL, SHIFT)
    opened.save(photo)
    assert opened.window.isVisible()
    assert photo.read_bytes() == before


@pytest.mark.parametrize(
    ("words", "saves", "code"),
    [(["--edit"], True, 0), (["--edit", "--temporary"], True, 0), (["--edit"], False, 6)],
)
def test_the_exit_code_tells_whether_it_was_saved(run_main, photo, storage, words, saves, code):
    before = photo.read_bytes()

    def act(window):
        if "portrait" not in window.windowTitle():
            return False
        if saves:
            window.actions_by_name["done"].trigger()
        else:
            window.close()
        return True

    assert run_main([*words, str(photo)], act) == code
    assert (photo.read_bytes() != before) == saves
    kept = list(storage.originals.glob("*"))
    assert bool(kept) == (saves and "--temporary" not in words)


def test_at_the_first_start_the_window_fits_its_screen(run_main, qapp, photo, storage):
    assert storage
    heights = []

    def look(window):
        heights.append(window.height())
        return window.close()

    assert run_main([str(photo)], look) == 0
    assert heights[0] < qapp.primaryScreen().availableSize().height(), "with its title bar"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--edit"], "--edit needs photos"),
        (["--edit", "a.jpg", "--screenshot", "b.png"], "--edit needs photos"),
        (["--temporary", "a.jpg"], "--temporary needs --edit"),
    ],
)
def test_an_errand_that_makes_no_sense_is_a_wrong_call(words, said, source, capsys):
    with pytest.raises(SystemExit) as ending:
        main(words, source)
    assert ending.value.code == 2
    assert said in capsys.readouterr().err


def test_another_programs_photo_tells_only_what_was_chosen_for_it(empty, start, photo):
    def choose(driver):
        driver.key(Qt.Key.Key_Comma, CONTROL)
        dialog = driver.dialog(PreferencesDialog)
        form = next(f.findChild(Form) for f in dialog.findChildren(Fold) if f.findChild(Form))
        form.show_values({"record": not form.values()["record"]})
        form.show_values({"record": True})
        dialog.close()

    choose(empty)
    empty.window.close()
    driver = start()
    driver.editor.errand.begin([photo])
    driver.settle()
    for is_chosen in (False, True):
        if is_chosen:
            choose(driver)
        driver.change_something()
        driver.settle()
        driver.editor.files.keep()
        driver.settle()
        assert (read(photo).xmp is not None) == is_chosen
