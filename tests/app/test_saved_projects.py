"""Projects: saved beside the photo, taken up with it, opened by themselves."""

import dataclasses
import json
import os
import shutil
import stat
import sys

import cv2
import numpy as np
import pytest
from kogao_app.__main__ import main
from kogao_app.document import State
from kogao_app.features import preferences
from kogao_app.features.files import history, opening
from kogao_app.features.files.history import project_of
from kogao_app.view_state import Handle
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QFileDialog, QMessageBox
from scenes import oval_face, textured_photo
from test_window import drop
from timeouts import held_back

from kogao_core.field.protection import Protection
from kogao_core.photo import read, reading
from kogao_core.pipeline import render
from kogao_core.projects import edits, sidecar
from kogao_core.projects.edits import own_place, sidecar_of
from kogao_core.projects.project import load, save
from kogao_core.recipe.recipe import Recipe

KEYS, CONTROL, ALT = Qt.Key, Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.AltModifier


FACE = oval_face()
# A slider moved, a point dragged, a line protected.
EDITED = State(
    (FACE.with_outline_point(10, FACE.outline[10] + (3.0, 5.0)),),
    recipe=Recipe(percent=5.0),
    protection=Protection().with_stroke([(40.0, 20.0), (40.0, 300.0)], 6.0),
)


@pytest.fixture
def project(photo):
    """Put a project beside the photo; return the file."""
    file = sidecar_of(photo)
    save(project_of(EDITED, sidecar.original(read(photo))), file)
    return file


def render_edited(pixels):
    return render(pixels, EDITED.active, EDITED.recipe, protection=EDITED.protection).pixels


@pytest.fixture
def worked(start, photo):
    """An editor that has kept the same edits, each as an undo step."""
    driver = start(photo)
    driver.change_something()
    driver.drag(driver.on_screen(Handle("outline", 0, 10)), QPoint(6, 9))
    after = dataclasses.replace(driver.state, protection=EDITED.protection)
    driver.editor.document.step(after, "Protect")
    driver.settle()
    return driver


def test_a_project_comes_back_with_its_photo_and_reset_is_one_undo_step(worked, start, photo):
    file = sidecar_of(photo)
    assert not worked.window.isWindowModified()
    project = load(file)
    assert project.original.path == photo.name, "no folder of this machine leaves it"
    assert project.original.sha256 == read(photo).picture
    other = start(photo)
    assert other.say() == "", "nothing covers the photo"
    assert not other.window.isWindowModified()
    np.testing.assert_array_equal(other.shown, worked.shown)
    other.change_something()
    other.settle()
    assert load(file).automatic.recipe.percent == other.state.recipe.percent
    assert not other.window.isWindowModified()
    before = other.state
    other.window.actions_by_name["reset-photo"].trigger()
    other.settle()
    assert other.state.recipe == other.editor.document.first_recipe
    assert not other.state.protection.strokes
    found = worked.editor.document.base.faces[0].outline
    np.testing.assert_array_equal(other.state.faces[0].outline, found)
    other.editor.history.undo()
    assert other.state is before


def test_a_photo_with_a_project_is_read_and_hashed_once(worked, start, photo, monkeypatch):
    worked.editor.watch.stop()
    calls = []

    def counted(name, call):
        return lambda *args: (calls.append(name), call(*args))[1]

    monkeypatch.setattr(opening, "read", counted("read", opening.read))
    monkeypatch.setattr(reading, "hashes_of", counted("hash", reading.hashes_of))
    os.utime(photo, ns=(1, 1))  # another version than the one that was hashed before
    driver = start(photo)
    assert driver.editor.document.undo.count()
    driver.change_something()
    driver.settle()
    assert sorted(calls) == ["hash", "read"]


def test_a_renamed_photo_finds_its_edits_and_undo_steps_by_its_content(
    worked, start, photo, storage
):
    renamed = photo.with_name("delivery-001.png")
    photo.rename(renamed)
    said = []
    other = start()
    other.editor.projects.did.connect(said.append)
    other.open(renamed)
    assert said == ["Edits restored: this photo was portrait.png before"]
    np.testing.assert_array_equal(other.shown, worked.shown)
    assert other.editor.document.undo.count() == worked.editor.document.undo.count()
    assert storage.edits.newest(renamed) == sidecar_of(photo), "as for batch and strip"
    before = sidecar_of(photo).read_bytes()
    other.change_something()
    other.settle()
    assert sidecar_of(photo).read_bytes() == before, "another photo may get that name"
    assert storage.edits.newest(renamed) == sidecar_of(renamed)
    os.utime(sidecar_of(photo), (1, 1))
    twice = renamed.rename(photo.with_name("a-second-name.png"))
    assert storage.edits.newest(twice) == sidecar_of(renamed), "the newest edits"


@pytest.mark.usefixtures("worked")
def test_a_photo_moved_without_its_edits_finds_them_but_a_copy_does_not(photo, tmp_path, storage):
    elsewhere = tmp_path / "elsewhere" / "other.png"
    elsewhere.parent.mkdir()
    shutil.copy(photo, elsewhere)
    assert storage.edits.newest(elsewhere) is None, "the original has them"
    photo.unlink()
    assert storage.edits.newest(elsewhere) == sidecar_of(photo)


def test_what_another_window_has_kept_since_is_told_and_chosen_between(worked, start, photo):
    file = sidecar_of(photo)
    other = start(photo)
    other.edit(9.0)
    theirs = file.read_bytes()
    worked.edit(11.0)
    assert "changed elsewhere" in worked.say()
    assert file.read_bytes() == theirs
    worked.qtbot.waitUntil(worked.window.isWindowModified)
    worked.window.close()
    assert "changed elsewhere" in worked.dialog(QMessageBox).informativeText()
    worked.answer("Cancel")
    worked.take_step("Keep mine")
    worked.settle()
    assert worked.state.recipe.percent == load(file).automatic.recipe.percent == 11.0
    assert not worked.window.isWindowModified()
    other.edit(7.0)
    other.take_step("Take theirs")
    other.settle()
    assert other.state.recipe.percent == load(file).automatic.recipe.percent == 11.0
    assert not other.window.isWindowModified()


@pytest.mark.usefixtures("project")
def test_a_resized_photo_takes_its_project_along_and_says_so(start, photo):
    larger = cv2.resize(cv2.imread(str(photo)), None, fx=2, fy=2)
    assert cv2.imwrite(str(photo), larger)
    other = start(photo)
    assert "made at 480 x 360 px" in other.say()
    np.testing.assert_allclose(
        other.state.faces[0].outline, 2.0 * EDITED.faces[0].outline + 0.5, atol=1e-6
    )


def test_another_shape_starts_afresh_and_says_why(start, photo, project):
    before = project.read_bytes()
    assert cv2.imwrite(str(photo), textured_photo(300, 400)[..., ::-1])
    other = start(photo)
    assert "another picture" in other.say()
    assert other.state.recipe.percent == 4.0
    assert project.read_bytes() == before


def test_a_dropped_project_opens_the_photo_beside_it(project, empty, photo, pixels):
    drop(empty, project)
    assert empty.editor.document.path == photo
    np.testing.assert_array_equal(empty.shown, render_edited(pixels))


def test_a_path_inside_a_project_is_never_followed(project, empty, photo, pixels, tmp_path):
    secret = tmp_path / "elsewhere" / "secret.png"
    secret.parent.mkdir()
    photo.rename(secret)
    alone = tmp_path / "moved" / "work.kogao.json"
    alone.parent.mkdir()
    values = json.loads(project.read_text())
    values["photo"]["path"] = str(secret)
    alone.write_text(json.dumps(values))
    empty.editor.files.open(alone)
    empty.settle()
    assert empty.editor.document.photo is None
    asked = empty.dialog(QFileDialog)
    assert "work.kogao.json" in asked.windowTitle()
    empty.choose_path(secret)
    empty.settle()
    assert empty.editor.document.path == secret
    np.testing.assert_array_equal(empty.shown, render_edited(pixels))
    # Edits are kept with the photo, and go into a file only when asked for.
    empty.change_something()
    empty.window.actions_by_name["save-project"].trigger()
    empty.choose_path(alone)
    empty.settle()
    for file in (alone, sidecar_of(secret)):
        assert load(file).automatic.recipe.percent == empty.state.recipe.percent


def test_a_hostile_project_is_one_sentence_and_loses_nothing(start, photo):
    file, text = sidecar_of(photo), "[" * 9999
    file.write_text(text)
    driver = start(photo)
    assert driver.say().count("\n") == 0
    assert driver.say().startswith("The photo starts without its edits")
    assert len(driver.state.faces) == 1
    driver.edit(7.0)
    assert file.read_text() == text
    driver.editor.files.read(file)
    driver.settle()
    assert driver.say()
    assert driver.editor.document.path == photo
    other = start(photo)
    assert other.state.recipe.percent == 7.0, "it was kept elsewhere meanwhile"


@pytest.fixture
def read_only(monkeypatch, tmp_path):
    """The photo's folder can't be written; nor can any other while `full` is among them."""
    write, bad = edits.save, {tmp_path}

    def refuse(project, path, **named):
        if path.parent in bad or None in bad:
            raise PermissionError(13, "Permission denied", str(path) + ".partial")
        write(project, path, **named)

    monkeypatch.setattr(edits, "save", refuse)
    return bad


def test_where_the_folder_cant_be_written_edits_are_kept_in_the_users_own(
    opened, start, photo, storage, read_only
):
    opened.edit(9.0)
    assert "edits saved in Kogao's folder" in opened.window.status.hint_text
    assert not opened.window.isWindowModified()
    assert not sidecar_of(photo).exists()
    assert own_place(photo, storage.edits.folder).exists()
    other = start(photo)
    assert other.state.recipe.percent == 9.0
    read_only.clear()
    other.edit(8.0)
    assert load(sidecar_of(photo)).automatic.recipe.percent == 8.0
    assert storage.edits.newest(photo) == sidecar_of(photo), "the newest one counts"


def test_who_wants_nothing_beside_photos_has_nothing_there(opened, start, photo, storage):
    preferences.prefer(opened.editor.projects.settings, preferences.EDITS, "own")
    opened.edit(9.0)
    assert not sidecar_of(photo).exists()
    if sys.platform != "win32":
        files = list(storage.edits.folder.iterdir())
        assert {one.suffix for one in files} == {".json"}
        assert {stat.S_IMODE(one.stat().st_mode) for one in files if one.is_file()} == {0o600}
    assert start(photo).state.recipe.percent == 9.0
    preferences.prefer(opened.editor.projects.settings, preferences.EDITS, "")
    opened.edit(8.0)
    assert load(sidecar_of(photo)).automatic.recipe.percent == 8.0


def test_where_nothing_at_all_can_be_written_it_is_asked(opened, photo, read_only):
    read_only.add(None)
    opened.edit(9.0)
    assert opened.say() == "The edits can't be kept: Permission denied."
    opened.qtbot.waitUntil(opened.window.isWindowModified)
    opened.window.close()
    opened.answer("Cancel")
    assert opened.window.isVisible()
    read_only.clear()
    opened.leave()
    assert load(sidecar_of(photo)).automatic.recipe.percent == 9.0


def test_another_place_can_be_chosen(opened, tmp_path, read_only):
    read_only.add(None)
    opened.edit(9.0)
    opened.take_step("another place")
    read_only.clear()
    (tmp_path / "mine").mkdir()
    # A name without the ending gets it, so that no photo can be written over.
    opened.choose_path(tmp_path / "mine" / "portrait.png")
    opened.settle()
    (project,) = (tmp_path / "mine").iterdir()
    assert project.name == "portrait.png.kogao.json"
    assert not opened.window.isWindowModified()
    before = project.read_bytes()
    opened.set("percent", 8.0)
    opened.editor.projects.save_to(tmp_path / "mine" / "portrait.png")
    opened.settle()
    assert "another project already" in opened.say(), "the dialog didn't ask about this name"
    assert project.read_bytes() == before


def test_a_photo_that_is_opened_again_while_it_is_changed_has_the_change(opened, photo):
    opened.editor.files.open(photo)
    opened.edit(9.0)
    assert opened.state.recipe.percent == 9.0


def test_undo_and_redo_while_the_next_photo_is_read_are_kept(opened, photo, monkeypatch, other):
    opened.edit(9.0)
    gate, slow = held_back(opening.open_photo)
    monkeypatch.setattr("kogao_app.features.files.open_photo", slow)
    opened.editor.files.open(other)
    opened.editor.history.undo()
    opened.qtbot.waitUntil(lambda: not opened.window.isWindowModified())
    opened.editor.projects._keeping = True  # the next write has to wait
    opened.editor.history.redo()
    opened.editor.projects._keeping = False
    gate.set()
    opened.settle()
    assert opened.editor.document.path == other
    assert load(sidecar_of(photo)).automatic.recipe.percent == 9.0


def test_undo_and_history_come_back(opened, start, photo):
    opened.drag(opened.on_screen(Handle("outline", 0, 10)), QPoint(6, 9))
    for percent in (6.0, 7.0, 8.0):
        opened.set("percent", percent)
    opened.key(KEYS.Key_Z, CONTROL)
    opened.settle()
    before = opened.editor.document.steps.texts
    opened.leave()
    other = start(photo)
    assert other.state.recipe.percent == 7.0
    assert not other.window.isWindowModified()
    assert len(before) == 4
    assert other.editor.document.steps.texts == before
    other.key(KEYS.Key_Z, CONTROL, Qt.KeyboardModifier.ShiftModifier)
    assert other.state.recipe.percent == 8.0
    for _ in range(4):
        other.key(KEYS.Key_Z, CONTROL)
    assert other.state.recipe.percent == 4.0
    moved = opened.editor.document.base.faces[0].outline
    np.testing.assert_array_equal(other.state.faces[0].outline, moved)
    other.settle()
    assert load(sidecar_of(photo)).automatic.recipe.percent == 4.0


def test_steps_that_lead_elsewhere_are_left_out_and_old_ones_go_first(
    opened, start, photo, monkeypatch
):
    monkeypatch.setattr(history, "MOST_BYTES", 12_000)
    for number in range(30):
        opened.set("percent", 5.0 + number / 10)
    opened.settle()
    other = start(photo)
    count = other.editor.document.undo.count()
    assert 1 < count < 30
    assert other.editor.document.undo.text(count - 1).endswith("7.9 % of D")
    values = json.loads(sidecar_of(photo).read_text())
    values["automatic"]["recipe"]["percent"] = 3.0
    sidecar_of(photo).write_text(json.dumps(values))
    third = start(photo)
    assert third.state.recipe.percent == 3.0
    assert not third.editor.document.undo.count()


def test_moving_along_and_closing_ask_nothing_and_lose_nothing(opened, start, photo, other):
    opened.editor.strip.show_places([photo, other])
    opened.settle()
    for path, percent in ((other, 7.0), (photo, 8.0), (other, 9.0), (photo, 8.0)):
        opened.editor.recipe.set_field("percent", percent)  # a gesture in hand
        opened.editor.strip.open(path)
        opened.settle()
        assert opened.editor.document.path == path
        assert not opened.window.findChildren(QMessageBox)
    assert opened.state.recipe.percent == 9.0
    opened.set("percent", 3.0)
    opened.leave()
    assert load(sidecar_of(photo)).automatic.recipe.percent == 3.0
    assert load(sidecar_of(other)).automatic.recipe.percent == 8.0
    assert start(photo).state.recipe.percent == 3.0


def test_a_photo_left_while_its_faces_were_sought_has_them_when_it_comes_back(
    searched, start, photo
):
    driver, gate = searched
    driver.set("percent", 7.0)
    driver.window.close()
    gate.set()
    driver.qtbot.waitUntil(lambda: not driver.window.isVisible())
    other = start(photo)
    assert len(other.state.faces) == 1
    assert other.state.recipe.percent == 7.0


def test_faces_found_after_an_edit_are_kept_with_it(searched, photo):
    driver, gate = searched
    driver.set("percent", 8.0)
    gate.set()
    driver.settle()
    driver.qtbot.waitUntil(lambda: sidecar_of(photo).exists())
    driver.settle()
    assert len(load(sidecar_of(photo)).automatic.faces) == 1
    assert not driver.window.isWindowModified()


def test_points_of_a_face_begun_can_not_be_kept_and_that_is_asked(opened, photo):
    opened.editor.manual.switch("manual")
    opened.click(opened.canvas.to_screen(np.array([90.0, 90.0])).toPoint())
    opened.settle()
    assert sidecar_of(photo).exists()
    opened.qtbot.waitUntil(opened.window.isWindowModified)
    opened.window.close()
    assert "isn't complete" in opened.dialog(QMessageBox).informativeText()
    opened.answer("Discard")
    opened.qtbot.waitUntil(lambda: not opened.window.isVisible())


def test_the_built_in_sample_is_never_written_beside(empty):
    empty.editor.files.open_sample()
    empty.settle()
    empty.key(KEYS.Key_P, CONTROL, ALT)
    asked = empty.dialog(QFileDialog)
    assert asked.selectedFiles()[0].endswith("average.jpg.kogao.json")
    assert not sidecar_of(empty.editor.document.path).exists()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_pipe_in_place_of_a_project_stalls_nothing(start, photo):
    os.mkfifo(sidecar_of(photo))
    driver = start(photo)
    assert len(driver.state.faces) == 1
    driver.editor.files.read(sidecar_of(photo))
    driver.settle()
    assert "not an ordinary file" in driver.say()


@pytest.mark.usefixtures("qapp", "storage")
def test_the_command_opens_a_project_and_gives_up_without_its_photo(
    project, photo, tmp_path, source, capsys
):
    picture = tmp_path / "shot.png"
    assert main([str(project), "--screenshot", str(picture)], source) == 0
    assert picture.is_file()
    photo.unlink()
    assert main([str(project), "--screenshot", str(picture)], source) == 3
    assert "isn't beside it" in capsys.readouterr().err
