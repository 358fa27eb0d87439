"""What Kogao has made is shown as such, and nobody is retouched twice unawares."""

import cv2
import numpy as np
import pytest
from kogao_app.features.batch import Order, carry_out, planned, report_of
from kogao_app.features.export import ExportDialog
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from kogao_core.projects.project import load
from kogao_core.retouch import RetouchJob

pytestmark = pytest.mark.usefixtures("one_window")


def copied(driver, path, percent=8.0):
    driver.set("percent", percent)
    driver.save(path)
    return path


def test_a_result_starts_untouched_and_leads_to_its_photo(opened, start, photo, tmp_path):
    copy = copied(opened, tmp_path / "anything.png")
    other = start(copy)
    assert other.say() == "anything.png is Kogao's own result of portrait.png, so it starts at 0 %."
    assert other.state.recipe.percent == 0.0
    np.testing.assert_array_equal(other.shown, cv2.imread(str(copy))[..., ::-1])
    other.take_step("Open portrait.png")
    other.settle()
    assert other.editor.document.path == photo
    assert other.state.recipe.percent == 8.0
    other.open(copy)
    other.edit(3.0)
    other.open(photo)
    other.open(copy)
    assert other.state.recipe.percent == 3.0, "work on a result that was wanted"
    assert "own result" not in other.say()


def test_a_batch_of_a_folder_leaves_results_alone_and_says_so(opened, photo, tmp_path):
    storage = opened.editor.strip.storage
    copied(opened, tmp_path / "copy.png")
    folder, went = tmp_path / "out", []
    report = report_of(folder, storage)
    order = Order((photo, tmp_path / "copy.png"), folder, report, RetouchJob())
    carry_out(planned(order, storage).tasks, order, storage, lambda: False, went.append)
    done, result = sorted(went, key=lambda one: one.status)  # they come as they are ready
    assert (done.status, result.status) == ("done", "result")
    assert "own result of portrait.png" in result.reason
    assert not (folder / "copy.png").exists()
    assert done.edit, "it did what the photo's own edits say"
    assert done.edit in storage.results.edits_of(photo)


def marks(driver):
    strip = driver.editor.strip.film
    return {
        item.text(): (item.data(Qt.ItemDataRole.AccessibleTextRole) or "").partition(", ")[2]
        for item in map(strip.item, range(strip.count()))
    }


@pytest.fixture
def strip(start, photo, encoded, tmp_path):
    """A film strip of four photos, a damaged one and a result."""
    driver = start(photo)
    folder = tmp_path / "in"
    folder.mkdir()
    for name in ("a.png", "a_kogao.png", "b.png", "c.png", "d.png"):
        (folder / name).write_bytes(encoded)
    (folder / "e.png").write_bytes(encoded[:100])
    driver.editor.strip.show_places([folder])
    driver.settle()
    return driver


def at(driver, row):
    panel = driver.editor.strip.film
    panel.scrollToItem(panel.item(row))
    return panel.visualItemRect(panel.item(row)).center()


def click_on(driver, row, held=Qt.KeyboardModifier.NoModifier):
    QTest.mouseClick(
        driver.editor.strip.film.viewport(), Qt.MouseButton.LeftButton, held, pos=at(driver, row)
    )
    driver.settle()


def test_the_strip_tells_what_was_done_to_each_photo(strip, tmp_path):
    strip.edit(6.0)
    assert marks(strip)["a.png"] == "edited"
    strip.save(tmp_path / "copy.png")
    assert marks(strip)["a.png"] == "copy saved"
    strip.edit(7.0)
    assert marks(strip)["a.png"] == "edited", "the copy is of other edits"
    strip.editor.history.undo()
    strip.settle()
    click_on(strip, 5)
    wanted = {"a.png": "copy saved", "a_kogao.png": "result", "e.png": "not done"}
    assert marks(strip) == {**dict.fromkeys(["b.png", "c.png", "d.png"], ""), **wanted}
    strip.editor.strip.show_places([tmp_path / "in"])
    strip.settle()
    assert marks(strip)["a.png"] == "copy saved"


def test_keys_pass_results_over(strip):
    assert strip.editor.document.path.name == "a.png"
    for name in ("b.png", "a.png"):
        strip.editor.strip.film.step(1 if name == "b.png" else -1)
        strip.settle()
        assert strip.editor.document.path.name == name


def test_settings_go_to_those_that_are_chosen_and_to_nobody_else(strip):
    strip.window.actions_by_name["give-settings"].trigger()
    assert "Select other photos" in strip.say()
    click_on(strip, 3)
    strip.edit(3.0)
    click_on(strip, 0)
    strip.set("percent", 8.0)
    click_on(strip, 1, Qt.KeyboardModifier.ControlModifier)
    click_on(strip, 3, Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier)
    assert strip.editor.document.path.name == "a.png", "choosing opens nothing"
    strip.window.actions_by_name["give-settings"].trigger()
    strip.settle()
    folder, edits = strip.editor.document.path.parent, strip.editor.strip.storage.edits
    kept = {name: edits.newest(folder / f"{name}.png") for name in "abcd"}
    kept["result"] = edits.newest(folder / "a_kogao.png")
    held = {name: load(file).automatic for name, file in kept.items() if file}
    assert {name: sheet.recipe.percent for name, sheet in held.items()} == dict.fromkeys("abc", 8.0)
    assert all(len(sheet.faces) == 1 for sheet in held.values())
    assert marks(strip)["b.png"] == "edited"
    click_on(strip, 2)
    assert strip.state.recipe.percent == 8.0


@pytest.mark.parametrize(("chosen", "words"), [((), "This photo (a.png)"), ((2, 3), "Selected")])
def test_the_dialog_offers_what_is_selected_first_and_all_photos_last(strip, chosen, words):
    for row in chosen:
        click_on(strip, row, Qt.KeyboardModifier.ControlModifier)
    strip.window.actions_by_name["export"].trigger()
    dialog = strip.dialog(ExportDialog)
    assert dialog.photos.currentText().startswith(words)
    stems = [[path.stem for path in paths] for paths in dialog._photos]
    assert stems[-1] == list("abcde")
    assert stems[dialog.photos.currentIndex()] == (list("abc") if chosen else ["a"])
