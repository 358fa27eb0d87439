"""The batch dialog: a corrupt photo, stopping, going on, closing; once with real processes."""

from __future__ import annotations

import json
import shutil
import threading
from pathlib import Path

import cv2
import numpy as np
import pytest
from kogao_app.features.batch import dialog as views
from PySide6.QtCore import QMimeData, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from responsiveness import Responsiveness
from timeouts import LONGEST_S

from kogao_core import batch, photo
from kogao_core.batch import workers
from kogao_core.recipe.recipe import Recipe

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


def drop_on(widget, *paths):
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    at, copy = QPointF(60, 60), Qt.DropAction.CopyAction
    held = (data, LEFT, Qt.KeyboardModifier.NoModifier)
    QApplication.sendEvent(widget, QDragEnterEvent(at.toPoint(), copy, *held))
    QApplication.sendEvent(widget, QDropEvent(at, copy, *held))


def asked(driver, *paths):
    """Open the dialog by its key and drop photos on it."""
    driver.key(Qt.Key.Key_B, Qt.KeyboardModifier.ControlModifier)
    box = driver.dialog(views.BatchDialog)
    drop_on(box.form, *paths)
    return box


def click(button):
    assert button.isEnabled()
    QTest.mouseClick(button, LEFT)


def finish(driver):
    driver.qtbot.waitUntil(lambda: not driver.editor.batch.busy)


def lines(folder):
    text = (folder / "kogao-batch.jsonl").read_text(encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()]


def test_a_folder_dropped_on_the_line_for_results_is_its_path(empty, folder, tmp_path):
    box = asked(empty, folder)
    drop_on(box.form.folder, tmp_path)
    assert box.form.folder.text() == str(tmp_path)
    assert box.form.paths == [folder]


def test_good_photos_are_done_and_the_bad_one_is_named(empty, folder, tmp_path, monkeypatch):
    box = asked(empty, folder)
    assert box.form.folder.text() == str(folder / "kogao")
    assert not box.report.isEnabled()
    box.form.folder.setText(str(tmp_path / "out"))
    box.form.settings.setCurrentIndex(box.form.settings.findText("Clear, 6 %"))
    box.form.jobs.setValue(1)
    click(box.go)
    assert box.go.text() == "S&top"
    finish(empty)
    assert box.note.text() == "Ended: 3 of 3 · 2 done · 1 failed"
    assert box.bad.count() == 1
    assert "broken.jpg" in box.bad.item(0).text()
    report = {Path(line["source"]).name: line for line in lines(tmp_path / "out")}
    assert {name: line["status"] for name, line in report.items()} == {
        "a.jpg": "done",
        "b.jpg": "done",
        "broken.jpg": "failed",
    }
    # The very bytes that the command line's task writes.
    (task,) = batch.plan([folder / "a.jpg"], tmp_path / "alone", Recipe(percent=6.0))
    assert batch.work(task).status == "done"
    alone = (tmp_path / "alone" / "a.jpg").read_bytes()
    assert alone == (tmp_path / "out" / "a.jpg").read_bytes()

    opened = []
    monkeypatch.setattr(views.QDesktopServices, "openUrl", lambda url: opened.append(url))
    click(box.report)
    assert opened == [QUrl.fromLocalFile(str(tmp_path / "out" / "kogao-batch.jsonl"))]

    click(box.go)
    finish(empty)
    assert box.note.text() == "Ended: 3 of 3 · 2 done before · 1 failed"


@pytest.mark.usefixtures("in_process")
def test_a_project_beside_a_photo_is_done_if_wanted(opened, photo, tmp_path):
    opened.editor.recipe.set_field("percent", 9.0)
    opened.editor.document.commit()
    opened.settle()
    opened.editor.projects.save()
    opened.settle()
    box = asked(opened, photo)
    assert "9 %" in box.form.settings.itemText(0)
    box.form.folder.setText(str(tmp_path / "out"))
    box.form.settings.setCurrentIndex(1)
    box.form.jobs.setValue(1)
    click(box.go)
    finish(opened)
    assert "1 done" in box.note.text(), box.bad.item(0).text()
    result = cv2.imread(str(tmp_path / "out" / photo.name))[..., ::-1]
    np.testing.assert_array_equal(result, opened.shown)


def test_what_nobody_may_replace_is_refused(empty, folder, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "b.jpg").write_bytes(b"mine")
    box = asked(empty, folder)
    box.form.folder.setText(str(out))
    click(box.go)
    finish(empty)
    assert "b.jpg; choose another folder" in box.note.text()
    assert (out / "b.jpg").read_bytes() == b"mine"
    (tmp_path / "file").write_bytes(b"mine")
    box.form.folder.setText(str(tmp_path / "file" / "in it"))
    click(box.go)
    finish(empty)
    assert "can't be written to" in box.note.text()
    box.form.inputs.selectAll()
    box.form.remove_selected()
    assert not box.go.isEnabled()


@pytest.fixture
def many(tmp_path, small_portrait):
    inputs = tmp_path / "many"
    inputs.mkdir()
    for k in range(40):
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
def test_a_stopped_batch_goes_on_and_closing_asks(empty, many, tmp_path, few_at_a_time):
    out = tmp_path / "out"
    box = asked(empty, many)
    box.form.folder.setText(str(out))
    box.form.jobs.setValue(1)
    click(box.go)
    few_at_a_time.release(2)
    empty.qtbot.waitUntil(lambda: box.progress.value() >= 2)
    assert "left" in box.note.text()
    click(box.go)
    few_at_a_time.release(2)  # those that were handed out
    finish(empty)
    assert box.note.text().startswith("Stopped: ")
    done = len(list(out.glob("*.jpg")))
    assert 2 <= done < 40
    assert box.go.text() == "Res&ume"

    click(box.go)
    few_at_a_time.release(done + 1)
    empty.qtbot.waitUntil(lambda: box.progress.value() > done)
    empty.window.close()
    assert empty.window.isVisible()
    empty.answer("Cancel")
    assert empty.editor.batch.busy
    empty.window.close()
    empty.answer("Stop and close")
    few_at_a_time.release(2)
    empty.qtbot.waitUntil(lambda: not empty.window.isVisible())
    assert not empty.editor.batch.busy
    assert not box.isVisible()
    statuses = [line["status"] for line in lines(out)]
    assert statuses.count("skipped") == done
    written = sorted(out.glob("*.jpg"))
    assert done < len(written) < 40
    assert all(photo.read(path).pixels.shape == (300, 300, 3) for path in written)
    assert not list(out.rglob("*.partial"))


@pytest.mark.usefixtures("in_process")
def test_the_window_answers_while_a_batch_runs(empty, folder, tmp_path, monkeypatch):
    window = Responsiveness()
    monkeypatch.setattr(batch, "plan", window.delayed("planning", batch.plan))
    monkeypatch.setattr(batch, "run", window.delayed_items("running", batch.run))
    box = asked(empty, folder)
    box.form.folder.setText(str(tmp_path / "out"))
    box.form.jobs.setValue(1)
    click(box.go)
    finish(empty)
    assert "3 of 3" in box.note.text()
    assert window.answered == {"planning", "running"}
    assert window.stalled == set()
