"""Unsaved work outlives a killed program."""

import dataclasses
import json
import os
import shutil
import stat
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import cv2
import numpy as np
import pytest
from kogao_app.document import State
from kogao_app.features.files.history import project_of
from kogao_app.features.recovery import leftovers
from kogao_app.storage import Storage
from kogao_app.view_state import Handle
from PySide6.QtCore import QPoint, Qt
from scenes import textured_photo
from timeouts import LONGEST_S

from kogao_core.photo import read
from kogao_core.projects.project import Original, load, save
from kogao_core.recipe.recipe import Recipe

pytestmark = pytest.mark.usefixtures("unkept")
CONTROL = Qt.KeyboardModifier.ControlModifier

# A program of its own: opens the photo, drags the slider, switches on, waits to be killed.
VICTIM = """
    import sys
    from pathlib import Path
    import numpy as np
    from PySide6.QtCore import Qt, QTimer
    from PySide6.QtTest import QTest
    from PySide6.QtWidgets import QApplication
    from kogao_app.editor import Editor
    from kogao_app.features.files.saver import Saver
    from kogao_app.view_state import Handle
    from kogao_app.storage import Storage
    from scenes import KnownFaces, oval_face

    Saver.keeps = False
    app = QApplication([])
    editor = Editor(app, KnownFaces(oval_face()), Storage.of_user())
    editor.window.show()
    editor.files.read(Path(sys.argv[1]))

    def edit(count):
        slider = editor.recipe.panel.percent.slider
        slider.setFocus()
        QTest.keyClick(slider, Qt.Key.Key_End)
        editor.recipe.choose(0)
        QTest.keyClick(slider, Qt.Key.Key_Home)
        canvas = editor.window.canvas
        canvas.begin("fetch", Handle("outline", 0, 10), np.array([250.0, 300.0]))
        canvas.end(np.array([250.0, 300.0]))
        tell()

    def tell():
        if editor.recovery.busy:
            QTimer.singleShot(10, tell)
        else:
            print("kept", flush=True)

    editor.faces.found.connect(lambda n: QTimer.singleShot(0, lambda: edit(n)))
    app.exec()
"""


def kept(driver):
    """Wait for the recovery file that holds the newest state."""
    recovery = driver.editor.recovery
    driver.qtbot.waitUntil(lambda: recovery.file.exists() and not recovery.busy)
    return recovery.file


def looked(driver):
    """Return a window that has looked for what others left."""
    driver.editor.recovery.look()
    driver.settle()
    return driver


def test_unsaved_changes_are_kept_aside_and_not_beside_the_photo(opened, photo, storage):
    before = sorted(photo.parent.iterdir())
    opened.change_something()
    file = kept(opened)
    assert file.parent == storage.recovery
    if sys.platform != "win32":
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
    project = load(file)
    assert project.automatic.recipe.percent == 5.0
    assert project.original.path == str(photo)
    assert project.original.sha256 == read(photo).picture
    home = {photo.parent / "home"}
    assert set(photo.parent.iterdir()) - home == set(before) - home


def test_nothing_is_kept_without_changes_and_after_an_orderly_end(start, photo, storage):
    driver = start(photo)
    assert not driver.editor.recovery.file.exists()
    driver.change_something()
    file = kept(driver)
    driver.key(Qt.Key.Key_Z, CONTROL)
    driver.qtbot.waitUntil(lambda: not file.exists())
    driver.change_something()
    kept(driver)
    driver.editor.close()
    assert not list(storage.recovery.iterdir())


def test_a_running_programs_work_is_not_offered(opened, start, storage):
    opened.change_something()
    kept(opened)
    assert leftovers(storage.recovery) == []
    other = looked(start())
    assert "ended before" not in other.say()


def test_a_gesture_in_hand_is_not_kept_half_done(opened):
    opened.change_something()
    file = kept(opened)
    at = opened.on_screen(Handle("outline", 0, 10))
    opened.press(at)
    opened.move(at + QPoint(0, 40))
    assert opened.editor.document.in_gesture
    opened.editor.recovery._write()
    opened.qtbot.waitUntil(lambda: not opened.editor.recovery.busy)
    kept_chin = load(file).automatic.faces[0].outline[10]
    opened.key(Qt.Key.Key_Escape)
    np.testing.assert_array_equal(kept_chin, opened.state.faces[0].outline[10])


@pytest.fixture(scope="module")
def victim(tmp_path_factory):
    """Run a program that edits a photo, and kill it without a warning: the photo, its recovery."""
    folder = tmp_path_factory.mktemp("victim")
    photo = folder / "portrait.png"
    assert cv2.imwrite(str(photo), textured_photo()[..., ::-1])
    names = ("XDG_CONFIG_HOME", "XDG_DATA_HOME", "LOCALAPPDATA")
    homes = dict.fromkeys(names, str(folder / "home"))
    environment = {**os.environ, **homes, "PYTHONPATH": str(Path(__file__).parents[1])}
    program = [sys.executable, "-c", textwrap.dedent(VICTIM), str(photo)]
    with subprocess.Popen(program, env=environment, stdout=subprocess.PIPE, text=True) as running:
        said = running.stdout.readline()
        running.kill()
    assert said == "kept\n"
    assert running.returncode != 0
    return photo, Storage.in_folder(folder / "home" / "kogao").recovery


@pytest.fixture
def killed(victim, photo, storage):
    """What that program left, its lock included, as if it had edited the photo of this test."""
    theirs, recovery = victim
    assert theirs.read_bytes() == photo.read_bytes()
    shutil.copytree(recovery, storage.recovery)
    (file,) = storage.recovery.glob("*.json")
    assert file.with_suffix(".lock").exists()
    values = json.loads(file.read_text(encoding="utf-8"))
    assert values["photo"]["path"] == str(theirs)
    values["photo"]["path"] = str(photo)
    file.write_text(json.dumps(values), encoding="utf-8")
    return file


def test_what_a_killed_program_left_is_restored(killed, start, photo, source):
    left = load(killed)
    driver = looked(start())
    assert driver.say() == (
        f"Kogao ended before the changes to portrait.png in {photo.parent} were saved."
    )
    driver.take_step("Restore")
    driver.settle()
    assert driver.editor.document.path == photo
    (face,) = driver.state.faces
    np.testing.assert_array_equal(face.outline, left.automatic.faces[0].outline)
    assert (face.outline[10] != source.faces[0].outline[10]).any()
    assert driver.state.recipe.percent == 15.0
    assert face.recipe.percent == 0.0
    assert driver.window.isWindowModified()
    assert driver.say() == ""
    # The old file goes once this program keeps the same work itself.
    driver.qtbot.waitUntil(lambda: not killed.exists())
    again = load(kept(driver))
    np.testing.assert_array_equal(again.automatic.faces[0].outline, face.outline)


def test_what_a_killed_program_left_can_be_discarded(killed, start):
    driver = looked(start())
    buttons = [button.text() for button in driver.window.bar.buttons]
    assert buttons == ["Discard…", "Restore", "Dismiss"], "a slip beside one can't lose the work"
    driver.take_step("Discard")
    driver.answer("Cancel")
    assert killed.exists()
    driver.take_step("Discard")
    driver.answer("Discard")
    assert not killed.exists()
    assert driver.say() == "The changes to portrait.png are discarded."
    assert driver.editor.document.photo is None


def test_work_that_is_restored_while_the_question_is_open_is_not_discarded(killed, start, photo):
    driver = looked(start())
    driver.take_step("Discard")
    next(one for one in driver.window.bar.buttons if one.text() == "Restore").click()
    driver.qtbot.waitUntil(lambda: driver.editor.document.path == photo)
    driver.answer("Discard")
    driver.settle()
    driver.qtbot.waitUntil(lambda: not killed.exists())
    assert load(kept(driver)).automatic.faces


def test_dismissed_work_is_offered_again(killed, start):
    driver = looked(start())
    driver.take_step("Dismiss")
    driver.editor.close()
    assert killed.exists()
    other = looked(start())
    assert "ended before" in other.say()


@pytest.fixture
def left(photo, storage, tmp_path):
    """Leave three files as crashes do: for a photo that is here, one that is gone, one more."""
    photos = [tmp_path / name for name in ("first.png", "gone.png", "last.png")]
    files = []
    storage.recovery.mkdir(parents=True)
    for age, path in enumerate(photos):
        shutil.copy(photo, path)
        state = dataclasses.replace(State(), recipe=Recipe(percent=5.0 + age))
        file = storage.recovery / f"{age}.json"
        picture = read(path)
        original = Original(str(path), picture.picture, picture.width, picture.height)
        save(project_of(state, original), file)
        os.utime(file, (0, 1000 - age))
        files.append(file)
    photos[1].unlink()
    return files


def test_all_that_several_crashes_left_is_offered_in_turn(left, empty):
    first, gone, last = left
    looked(empty)
    assert "first.png" in empty.say()
    empty.take_step("Restore")
    empty.settle()
    assert empty.state.recipe.percent == 5.0
    assert not first.exists()
    assert "gone.png in " in empty.say()
    empty.take_step("Restore")
    empty.answer("Discard")
    empty.settle()
    assert "gone.png" in empty.say()
    assert empty.state.recipe.percent == 5.0, "the present photo stays"
    empty.take_step("Dismiss")
    assert "last.png in " in empty.say()
    empty.take_step("Dismiss")
    assert "gone.png in " in empty.say(), "it stands until it is answered"
    empty.take_step("Dismiss")
    assert empty.say() == ""
    assert gone.exists()
    assert last.exists()
    assert empty.editor.recovery.file.exists()


def test_the_next_is_offered_after_one_is_discarded_or_dismissed(left, empty):
    looked(empty)
    empty.take_step("Discard")
    empty.answer("Discard")
    assert "gone.png in " in empty.say()
    empty.take_step("Dismiss")
    assert "last.png in " in empty.say()
    assert [file.exists() for file in left] == [False, True, True]


def test_an_old_file_goes_although_its_first_successor_was_never_written(left, empty, monkeypatch):
    gate, written = threading.Event(), []

    def slow(project, path, **named):
        assert gate.wait(LONGEST_S)
        written.append(project.automatic.recipe.percent)
        save(project, path, **named)

    monkeypatch.setattr("kogao_app.features.recovery.save", slow)
    looked(empty)
    empty.take_step("Restore")
    empty.qtbot.waitUntil(lambda: empty.state.recipe.percent == 5.0)
    empty.set("percent", 9.0)
    assert left[0].exists(), "no other file holds the work yet"
    empty.set("percent", 10.0)
    gate.set()
    empty.settle()
    assert 9.0 not in written, "nothing was replaced: this test shows nothing"
    assert load(empty.editor.recovery.file).automatic.recipe.percent == 10.0
    assert not left[0].exists()


def test_work_that_was_restored_and_taken_back_stays(left, empty, monkeypatch):
    gate = threading.Event()

    def slow(*_):
        assert gate.wait(LONGEST_S)
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("kogao_app.features.recovery.save", slow)
    looked(empty)
    empty.take_step("Restore")
    empty.qtbot.waitUntil(lambda: empty.state.recipe.percent == 5.0)
    empty.editor.history.undo()
    gate.set()
    empty.settle()
    assert not empty.window.isWindowModified()
    assert left[0].exists()


def test_strange_files_hide_no_other_and_are_left_alone(left, empty, storage):
    (storage.recovery / "gone.json").symlink_to(storage.recovery / "nowhere")
    strange = storage.recovery / "strange.json"
    strange.write_text(json.dumps({"format": "something else"}))
    looked(empty)
    assert "first.png in " in empty.say()
    for _ in left:
        empty.take_step("Dismiss")
    assert empty.say() == ""
    assert strange.exists()


def test_an_edit_is_kept_at_once_whatever_the_workers_do(opened, photo):
    gate = threading.Event()
    for _ in range(8):
        opened.editor._pools[1].start(lambda: gate.wait(LONGEST_S))
    opened.change_something()
    file = opened.editor.recovery.file
    opened.qtbot.waitUntil(file.exists)
    assert load(file).automatic.recipe.percent == 5.0
    assert load(file).original.sha256 == read(photo).picture
    gate.set()
    opened.settle()


def test_a_full_disk_is_said_once_and_work_is_kept_once_there_is_room(opened, monkeypatch):
    full = threading.Event()
    full.set()

    def write(project, path, **named):
        if full.is_set():
            raise OSError(28, "No space left on device")
        save(project, path, **named)

    monkeypatch.setattr("kogao_app.features.recovery.save", write)
    opened.change_something()
    opened.qtbot.waitUntil(lambda: "No space left" in opened.say())
    opened.take_step("Dismiss")
    opened.change_something()
    opened.settle()
    assert opened.say() == ""
    full.clear()
    opened.qtbot.waitUntil(opened.editor.recovery.file.exists)


def test_restoring_asks_before_other_changes_are_lost(killed, start, photo):
    driver = start(photo)
    driver.change_something()
    looked(driver)
    driver.take_step("Restore")
    driver.answer("Cancel")
    assert driver.state.recipe.percent == 5.0
    assert killed.exists()


@pytest.mark.parametrize("why", ["portrait.png", "another shape"])
def test_a_vanished_photo_or_one_of_another_shape_is_said_and_the_work_stays(
    killed, start, photo, why
):
    photo.unlink()
    if why == "another shape":
        assert cv2.imwrite(str(photo), textured_photo(300, 400)[..., ::-1])
    driver = looked(start())
    driver.take_step("Restore")
    driver.settle()
    assert why in driver.say()
    assert killed.exists()
