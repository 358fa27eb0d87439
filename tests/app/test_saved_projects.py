"""Projects: saved beside the photo, taken up with it, opened by themselves."""

from __future__ import annotations

import json
import os

import cv2
import numpy as np
import pytest
from kogao_app.__main__ import main
from kogao_app.features.files import opening
from kogao_app.view_state import Handle
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog
from scenes import textured_photo
from test_window import drop

from kogao_core.projects.project import load, sha256_of
from kogao_core.projects.sidecar import sidecar_of

KEYS, CONTROL, ALT = Qt.Key, Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.AltModifier


def save_project(driver):
    driver.key(KEYS.Key_P, CONTROL, ALT)
    driver.settle()


@pytest.fixture
def worked(start, photo):
    """A photo with its project beside it: a slider moved, a point dragged, a line protected."""
    driver = start(photo)
    driver.change_something()
    driver.drag(driver.on_screen(Handle("outline", 0, 10)), QPoint(6, 9))
    state = driver.state
    driver.editor.document.step(
        state.__class__(
            state.faces,
            recipe=state.recipe,
            protection=state.protection.with_stroke([(40.0, 20.0), (40.0, 300.0)], 6.0),
        ),
        "Protect",
    )
    driver.settle()
    save_project(driver)
    return driver


def test_a_project_comes_back_with_its_photo(worked, start, photo):
    file = sidecar_of(photo)
    assert not worked.window.isWindowModified()
    project = load(file)
    assert project.original.path == photo.name, "no folder of this machine leaves it"
    assert project.original.sha256 == sha256_of(photo)
    other = start(photo)
    assert "back" in other.say()
    assert not other.window.isWindowModified()
    assert not other.editor.document.undo.canUndo()
    np.testing.assert_array_equal(other.shown, worked.shown)
    other.change_something()
    assert other.window.isWindowModified()
    save_project(other)
    assert load(file).automatic.recipe.percent == other.state.recipe.percent
    assert not other.window.isWindowModified()


def test_zones_are_set_by_key_and_come_back_with_the_project(two, start, photo):
    two.editor.recipe.choose(1)
    panel = two.panel("recipe")
    before = two.shown.copy()
    two.key(KEYS.Key_G, ALT)
    two.qtbot.waitUntil(panel.zones.button.isChecked)
    for field, typed in (("cheeks", "40"), ("left", "150 %"), ("even_out", "75")):
        QTest.keyClick(panel.sliders[field].slider, KEYS.Key_Return)
        QTest.keyClicks(panel.sliders[field].field, typed)
        QTest.keyClick(panel.sliders[field].field, KEYS.Key_Return)
    two.settle()
    own = two.state.faces[1].recipe
    assert (own.cheeks, own.left, own.even_out) == (40.0, 150.0, 75.0)
    assert two.state.faces[0].recipe is None
    assert (two.shown != before).any()
    save_project(two)
    other = start(photo)
    assert other.state.faces[1].recipe == own
    np.testing.assert_array_equal(other.shown, two.shown)


def test_zones_that_are_switched_off_leave_the_picture_of_a_plain_recipe(opened):
    panel = opened.panel("recipe")
    plain = opened.shown.copy()
    panel.sliders["jaw"].edited.emit(20.0)
    opened.settle()
    assert (opened.shown != plain).any()
    panel.switches["zones"].click()
    opened.settle()
    np.testing.assert_array_equal(opened.shown, plain)
    assert not panel.sliders["jaw"].isEnabled()
    assert opened.state.recipe.jaw == 20.0


@pytest.mark.usefixtures("worked")
def test_a_photo_with_a_project_is_read_and_hashed_once(start, photo, monkeypatch):
    calls = []

    def counted(name, call):
        return lambda *args: (calls.append(name), call(*args))[1]

    monkeypatch.setattr(opening, "read", counted("read", opening.read))
    monkeypatch.setattr(opening, "sha256_of", counted("hash", opening.sha256_of))
    os.utime(photo, ns=(1, 1))  # another version than the one that was hashed before
    driver = start(photo)
    assert "back" in driver.say()
    driver.change_something()
    driver.settle()
    save_project(driver)
    assert sorted(calls) == ["hash", "read"]


@pytest.mark.usefixtures("worked")
def test_one_can_start_afresh_and_the_project_stays(start, photo):
    file = sidecar_of(photo)
    before = file.read_bytes()
    other = start(photo)
    other.take_step("Start afresh")
    other.settle()
    assert other.state.recipe.percent == 4.0
    assert other.state.protection.strokes == ()
    save_project(other)
    assert "another project" in other.say()
    assert file.read_bytes() == before
    other.take_step("Replace it")
    other.settle()
    assert load(file).automatic.recipe.percent == 4.0


def test_what_another_window_has_saved_since_is_replaced_only_if_told_to(worked, start, photo):
    file = sidecar_of(photo)
    other = start(photo)
    other.change_something()
    save_project(other)
    save_project(other)
    assert other.say() == "", "its own it writes over"
    theirs = file.read_bytes()
    worked.change_something()
    worked.change_something()
    worked.editor.projects.save()  # its key is the other window's now
    worked.settle()
    assert "changed elsewhere" in worked.say()
    assert file.read_bytes() == theirs
    assert worked.window.isWindowModified()
    worked.take_step("Replace it")
    worked.settle()
    assert load(file).automatic.recipe.percent == worked.state.recipe.percent
    assert not worked.window.isWindowModified()


def test_a_resized_photo_takes_its_project_along_and_says_so(worked, start, photo):
    outline = worked.state.faces[0].outline
    larger = cv2.resize(cv2.imread(str(photo)), None, fx=2, fy=2)
    assert cv2.imwrite(str(photo), larger)
    other = start(photo)
    assert "made at 480 x 360 px" in other.say()
    np.testing.assert_allclose(other.state.faces[0].outline, 2.0 * outline + 0.5)


@pytest.mark.usefixtures("worked")
def test_another_shape_starts_afresh_and_says_why(start, photo):
    before = sidecar_of(photo).read_bytes()
    assert cv2.imwrite(str(photo), textured_photo(300, 400)[..., ::-1])
    other = start(photo)
    assert "another shape" in other.say()
    assert other.state.recipe.percent == 4.0
    assert sidecar_of(photo).read_bytes() == before


def test_a_dropped_project_opens_the_photo_beside_it(worked, empty, photo):
    drop(empty, sidecar_of(photo))
    assert empty.editor.document.path == photo
    np.testing.assert_array_equal(empty.shown, worked.shown)


def test_a_path_inside_a_project_is_never_followed(worked, empty, photo, tmp_path):
    seen = worked.shown.copy()
    worked.editor.close()
    secret = tmp_path / "elsewhere" / "secret.png"
    secret.parent.mkdir()
    photo.rename(secret)
    alone = tmp_path / "moved" / "work.kogao.json"
    alone.parent.mkdir()
    values = json.loads(sidecar_of(photo).read_text())
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
    np.testing.assert_array_equal(empty.shown, seen)
    # It goes back where it came from, although that isn't beside the photo.
    empty.change_something()
    empty.window.actions_by_name["save-project"].trigger()
    empty.settle()
    assert load(alone).automatic.recipe.percent == empty.state.recipe.percent
    assert not sidecar_of(secret).exists()


@pytest.mark.parametrize(
    "text",
    ["nonsense", "[" * 9999, '{"format": "kogao-project", "version": 99}', '{"format": 3}', ""],
)
def test_a_hostile_project_is_one_sentence_and_loses_nothing(start, photo, text):
    file = sidecar_of(photo)
    file.write_text(text)
    driver = start(photo)
    assert driver.say().count("\n") == 0
    assert driver.say().startswith("The photo starts afresh")
    assert len(driver.state.faces) == 1
    driver.change_something()
    save_project(driver)
    assert "another project" in driver.say()
    assert file.read_text() == text
    driver.editor.files.read(file)
    driver.settle()
    assert driver.say()
    assert driver.editor.document.path == photo
    assert driver.window.isWindowModified(), "the open photo and its changes are still here"


def test_closing_can_save_the_project_first(opened, photo):
    opened.change_something()
    opened.window.close()
    opened.answer("Save project")
    opened.qtbot.waitUntil(lambda: not opened.window.isVisible())
    assert load(sidecar_of(photo)).automatic.recipe.percent == 5.0


def test_where_nothing_can_be_written_another_place_is_asked_for(opened, tmp_path, monkeypatch):
    from kogao_app.features import projects

    write = projects.save

    def read_only(project, path):
        if path.parent == tmp_path:
            raise PermissionError(13, "Permission denied", str(path) + ".partial")
        write(project, path)

    monkeypatch.setattr(projects, "save", read_only)
    opened.change_something()
    save_project(opened)
    assert opened.say() == "The project can't be saved there: Permission denied."
    assert opened.window.isWindowModified()
    opened.take_step("another place")
    (tmp_path / "mine").mkdir()
    # A name without the ending gets it, so that no photo can be written over.
    opened.choose_path(tmp_path / "mine" / "portrait.png")
    opened.settle()
    assert [one.name for one in (tmp_path / "mine").iterdir()] == ["portrait.png.kogao.json"]
    assert not opened.window.isWindowModified()


def test_the_built_in_sample_is_never_written_beside(empty):
    empty.editor.files.open_sample()
    empty.settle()
    save_project(empty)
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


def test_the_command_opens_a_project_and_gives_up_without_its_photo(
    worked, photo, tmp_path, source, capsys
):
    worked.editor.close()
    file, picture = sidecar_of(photo), tmp_path / "shot.png"
    assert main([str(file), "--screenshot", str(picture)], source) == 0
    assert picture.is_file()
    photo.unlink()
    assert main([str(file), "--screenshot", str(picture)], source) == 3
    assert "isn't beside it" in capsys.readouterr().err
