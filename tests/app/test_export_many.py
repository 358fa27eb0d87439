"""Export of several photos: a corrupt photo, stopping, continuing, closing."""

import dataclasses
import json
import shutil
import threading
from pathlib import Path

import cv2
import numpy as np
import pytest
from kogao_app.features.batch import report_of
from kogao_app.features.export import ExportDialog
from kogao_app.widgets import dialogs
from PIL import Image
from PySide6.QtCore import Qt, QUrl
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialogButtonBox, QMessageBox
from responsiveness import Responsiveness
from timeouts import LONGEST_S

from kogao_core import batch, photo
from kogao_core.batch import workers
from kogao_core.projects.edits import sidecar_of
from kogao_core.projects.project import load, save
from kogao_core.recipe.recipe import Recipe
from kogao_core.retouch import RetouchJob

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def folder(tmp_path, small_portrait):
    """Two portraits and a file cut short."""
    inputs = tmp_path / "in"
    inputs.mkdir()
    for name in ("a.jpg", "b.jpg"):
        shutil.copy(small_portrait, inputs / name)
    (inputs / "broken.jpg").write_bytes(small_portrait.read_bytes()[:3000])
    return inputs


@pytest.fixture
def strip(start, folder):
    """An editor with the photos of the folder in its strip."""
    driver = start()
    driver.editor.strip.show_places([folder])
    driver.settle()
    return driver


def export(driver, out, recipe="", *, photos=-1, ending=""):
    """Export all photos, or another choice of the dialog, into a folder."""
    driver.window.actions_by_name["export"].trigger()
    dialog = driver.dialog(ExportDialog)
    dialog.photos.setCurrentIndex(photos % dialog.photos.count())
    dialog.form.show_values({"folder": str(out), "ending": ending})
    box = dialog.form.controls["recipe"]
    if recipe:
        box.setCurrentIndex(box.findText(recipe))
    dialog.buttons.button(QDialogButtonBox.StandardButton.Ok).click()
    return dialog


def finish(driver):
    driver.qtbot.waitUntil(lambda: not driver.editor.batch.busy)


def lines(driver, folder):
    assert not (folder / "kogao-batch.jsonl").exists(), "the report is not among the pictures"
    text = report_of(folder, driver.editor.strip.storage).read_text(encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()]


def test_good_photos_are_exported_and_the_bad_one_is_named(strip, folder, tmp_path, monkeypatch):
    out, opened = tmp_path / "out", []
    monkeypatch.setattr(dialogs.QDesktopServices, "openUrl", opened.append)
    strip.open(folder / "a.jpg")
    (folder / "a.jpg.kogao.json").unlink(missing_ok=True)
    export(strip, out, "Subtle")
    finish(strip)
    assert strip.say().startswith("Export finished: 2 done · 1 failed. ")
    assert "broken.jpg" in strip.say()
    report = {Path(line["source"]).name: line["status"] for line in lines(strip, out)}
    assert report == {"a.jpg": "done", "b.jpg": "done", "broken.jpg": "failed"}
    # The same bytes as from the command line.
    (task,) = batch.plan([folder / "b.jpg"], tmp_path / "alone", RetouchJob(Recipe(percent=4.0)))
    assert batch.work(task).status == "done"
    assert (tmp_path / "alone" / "b.jpg").read_bytes() == (out / "b.jpg").read_bytes()
    strip.take_step("Open folder")
    assert opened == [QUrl.fromLocalFile(str(out))]
    export(strip, out, "Subtle")
    finish(strip)
    assert strip.say().startswith("Export finished: 2 done before · 1 failed. ")


@pytest.mark.usefixtures("in_process")
def test_a_message_spells_a_file_name_as_it_is(strip, folder, tmp_path):
    cv2.imwrite(str(folder / "broken.jpg"), np.full((90, 120, 3), 127, np.uint8))
    export(strip, tmp_path / "out", "Subtle")
    finish(strip)
    assert " broken.jpg: " in strip.say()


@pytest.mark.usefixtures("in_process")
def test_the_newest_edits_of_the_open_photo_are_exported(start, photo, tmp_path):
    photo.with_name("z.png").write_bytes(photo.read_bytes()[:99])
    driver = start(photo)
    driver.editor.strip.show_places([photo.parent])
    driver.settle()
    driver.set("percent", 9.0)
    export(driver, tmp_path / "out", "Subtle")
    driver.settle()
    finish(driver)
    result = cv2.imread(str(tmp_path / "out" / photo.name))[..., ::-1]
    np.testing.assert_array_equal(result, driver.shown)


@pytest.mark.usefixtures("in_process")
def test_existing_files_of_others_are_not_replaced(strip, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "b.jpg").write_bytes(b"mine")
    export(strip, out)
    finish(strip)
    assert "b.jpg; choose another folder" in strip.say()
    assert (out / "b.jpg").read_bytes() == b"mine"
    (tmp_path / "file").write_bytes(b"mine")
    dialog = export(strip, tmp_path / "file" / "in it")
    assert dialog.isVisible()
    assert dialog.note.text()


@pytest.fixture
def many(tmp_path, small_portrait):
    inputs = tmp_path / "many"
    inputs.mkdir()
    for k in range(20):
        shutil.copy(small_portrait, inputs / f"{k:02}.jpg")
    return inputs


@pytest.fixture
def few_at_a_time(monkeypatch):
    """What lets a batch work on so many more photos; it works on all of them after the test."""
    more, work = threading.Semaphore(0), workers.work

    def held(task):
        assert more.acquire(timeout=LONGEST_S)
        return work(task)

    monkeypatch.setattr(workers, "work", held)
    yield more
    more.release(100)


@pytest.mark.usefixtures("in_process")
def test_a_stopped_export_continues_and_closing_asks(start, many, tmp_path, few_at_a_time, read):  # noqa: ARG001
    out = tmp_path / "out"
    driver = start()
    driver.editor.strip.show_places([many])
    driver.settle()
    running, panel = driver.editor.batch, driver.editor.strip.panel
    export(driver, out)
    few_at_a_time.release(2)
    driver.qtbot.waitUntil(lambda: running._progress.finished >= 2)
    assert panel.line.text().endswith("of 20")
    QTest.mouseClick(panel.halt, LEFT)
    few_at_a_time.release(8)  # those that were handed out
    finish(driver)
    assert driver.say().startswith("Export stopped: ")
    assert (panel.line.text(), panel.halt.isVisible()) == ("", False)
    done = len(list(out.glob("*.jpg")))
    assert 2 <= done < 20

    export(driver, out)
    few_at_a_time.release(done + 1)
    driver.qtbot.waitUntil(lambda: running._progress.finished > done)
    driver.window.close()
    assert driver.window.isVisible()
    driver.answer("Cancel")
    assert running.busy
    driver.window.close()
    driver.answer("Stop and close")
    few_at_a_time.release(8)
    driver.qtbot.waitUntil(lambda: not driver.window.isVisible())
    assert not running.busy
    statuses = [line["status"] for line in lines(driver, out)]
    assert statuses.count("skipped") == done
    written = sorted(out.glob("*.jpg"))
    assert done < len(written) < 20
    assert all(photo.read(path).pixels.shape == (300, 300, 3) for path in written)
    assert not list(out.rglob("*.partial"))


@pytest.mark.usefixtures("in_process")
def test_the_window_answers_during_an_export(strip, tmp_path, monkeypatch):
    window = Responsiveness()
    monkeypatch.setattr(batch, "plan", window.delayed("planning", batch.plan))
    monkeypatch.setattr(batch, "run", window.delayed_items("running", batch.run))
    export(strip, tmp_path / "out")
    finish(strip)
    assert "2 done · 1 failed" in strip.say()
    assert window.answered == {"planning", "running"}
    assert window.stalled == set()


def test_a_pair_is_exported_after_the_plan_was_shown(strip, folder, tmp_path):
    (folder / "broken.jpg").unlink()
    Image.open(folder / "a.jpg").save(folder / "a.png")
    shutil.copy(folder / "b.jpg", folder / "c.JPG ")
    strip.editor.strip.show_places([folder])
    strip.settle()
    out = tmp_path / "out"
    export(strip, out, ending=".jpg")
    box = strip.dialog(QMessageBox)
    assert "a.png → a.png.jpg" in box.informativeText() + box.detailedText()
    assert not list(out.iterdir())
    strip.answer("Export")
    finish(strip)
    assert {one.name for one in out.iterdir()} == {"a.jpg", "a.png.jpg", "b.jpg", "c.jpg"}
    export(strip, out, ending=".jpg")
    strip.answer("Cancel")
    strip.settle()


def test_faces_marked_in_part_are_asked_about_before_an_export(strip, folder, tmp_path):
    strip.open(folder / "a.jpg")
    strip.edit(6.0)
    made = load(sidecar_of(folder / "a.jpg"))
    export(strip, tmp_path / "found")
    finish(strip)
    strip.open(folder / "b.jpg")
    (face,) = made.automatic.faces
    half = dataclasses.replace(
        face, outline=face.outline[:9], source="manual", confidence=None, forehead=None
    )
    sheet = dataclasses.replace(made.automatic, faces=(half,))
    save(dataclasses.replace(made, mode="manual", manual=sheet), sidecar_of(folder / "a.jpg"))
    for answer in ("Automatic", "so far"):
        export(strip, tmp_path / answer)
        assert "in part: a.jpg" in strip.dialog(QMessageBox).informativeText()
        strip.answer(answer)
        finish(strip)
    found, automatic, so_far = (
        (tmp_path / one / "a.jpg").read_bytes() for one in ("found", "Automatic", "so far")
    )
    assert automatic == found
    assert so_far != found
