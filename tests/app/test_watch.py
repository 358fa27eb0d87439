"""The window notices what happens to the file of the open photo, and saves nothing stale."""

import shutil
from collections import Counter

import cv2
import numpy as np
import pytest
from kogao_app.features.strip import _MOST, photos_in
from scenes import textured_photo

from kogao_core.photo import read
from kogao_core.photo.formats.png import made
from kogao_core.projects.edits import sidecar_of
from kogao_core.projects.project import load


def replace(photo, seed=7):
    """Put another picture at the path of a photo, as another program does."""
    fresh = photo.with_name("fresh.png")
    assert cv2.imwrite(str(fresh), textured_photo(seed=seed))
    fresh.replace(photo)


def add_star(photo, stars=4):
    """Change the metadata alone, as exiftool does."""
    data, end = photo.read_bytes(), 33  # of the header
    text = made(b"tEXt", b"Rating\0%d" % stars)
    photo.with_name("fresh.png").write_bytes(data[:end] + text + data[end:])
    photo.with_name("fresh.png").replace(photo)


def noticed(driver, words):
    driver.qtbot.waitUntil(lambda: words in driver.say())


def test_another_picture_is_told_and_saved_only_when_it_was_chosen(opened, photo, tmp_path):
    opened.edit(6.0)
    replace(photo)
    opened.save(tmp_path / "copy.png")
    assert not (tmp_path / "copy.png").exists(), "at the save, before the watch"
    assert "replaced by another picture" in opened.say()
    opened.take_step("Keep the old picture")
    opened.save(tmp_path / "copy.png")
    np.testing.assert_array_equal(read(tmp_path / "copy.png").pixels, opened.shown)
    opened.edit(7.0)
    assert load(sidecar_of(photo)).automatic.recipe.percent == 6.0, "not of this picture"


def test_a_reload_brings_the_new_pixels_and_the_edits(opened, photo, source):
    opened.edit(6.0)
    replace(photo)
    noticed(opened, "replaced by another picture")
    source.faces = []
    opened.take_step("Reload")
    opened.settle()
    noticed(opened, "No face under the outline of: 1")
    np.testing.assert_array_equal(opened.editor.document.photo.pixels, read(photo).pixels)
    assert opened.state.recipe.percent == 6.0
    assert opened.state.faces


def test_a_renamed_photo_is_followed_with_its_edits_and_never_written_over(opened, photo):
    opened.edit(6.0)
    before, now = photo.read_bytes(), photo.with_name("renamed.png")
    photo.rename(now)
    opened.save(now)
    assert "never written over" in opened.say()
    assert now.read_bytes() == before
    opened.qtbot.waitUntil(lambda: opened.editor.document.path == now)
    opened.edit(7.0)
    assert load(sidecar_of(now)).automatic.recipe.percent == 7.0
    assert not opened.window.isWindowModified()


def test_a_renamed_folder_keeps_edits_and_undo_steps(start, photo, tmp_path):
    (folder := tmp_path / "fo").mkdir()
    first = start(shutil.copy(photo, folder / "a.png"))
    first.edit(5.0)
    folder.rename(moved := tmp_path / "fo2")
    first.edit(7.0)
    first.qtbot.waitUntil(lambda: first.editor.document.path.parent == moved)
    first.leave()
    again = start(moved / "a.png")
    assert again.say() == ""
    assert again.state.recipe.percent == 7.0
    assert again.editor.document.undo.count() == 2


def test_a_star_from_another_program_is_carried_along_without_a_word(opened, photo, tmp_path):
    opened.edit(6.0)
    add_star(photo)
    opened.save(tmp_path / "copy.png")
    opened.edit(7.0)
    assert "Saved" in opened.say()
    assert b"Rating" in (tmp_path / "copy.png").read_bytes(), "in the copy, too"
    assert load(sidecar_of(photo)).automatic.recipe.percent == 7.0


@pytest.mark.usefixtures("other")
def test_a_photo_that_is_away_is_told_and_the_strip_stays(opened, photo, storage):
    opened.editor.strip.show_places([photo.parent])
    opened.settle()
    opened.edit(6.0)
    aside = photo.parent / "home" / "aside.part"
    photo.rename(aside)
    noticed(opened, "is gone")
    opened.edit(7.0)
    assert not opened.window.isWindowModified()
    assert opened.editor.document.path == photo
    assert load(sidecar_of(photo)).automatic.recipe.percent == 6.0, "nothing without its photo"
    aside.rename(photo)
    opened.qtbot.waitUntil(lambda: "is gone" not in opened.say())
    assert load(storage.edits.newest(photo)).automatic.recipe.percent == 7.0


def test_no_copy_goes_over_another_photo_of_the_strip(opened, photo, other, tmp_path):
    opened.editor.strip.show_places([photo.parent])
    opened.settle()
    before = other.read_bytes()
    opened.save(other)
    assert "never written over" in opened.say()
    assert other.read_bytes() == before
    opened.save(tmp_path / "mine.png")
    opened.editor.strip.show_places([photo.parent])
    opened.settle()
    opened.edit(9.0)
    opened.save(tmp_path / "mine.png")
    assert "Saved" in opened.say(), "an own result may be replaced"


def test_two_versions_of_the_edits_are_told_and_either_can_be_had(opened, start, photo, storage):
    opened.edit(6.0)
    older = sidecar_of(photo).read_text()
    opened.edit(7.0)
    storage.edits.keep(load(sidecar_of(photo)), photo, beside=False)
    sidecar_of(photo).write_text(older)  # by a tool that syncs folders
    other = start(photo)
    assert "two versions" in other.say()
    shown = other.state.recipe.percent
    other.take_step("Use the older")
    other.settle()
    assert {shown, other.state.recipe.percent} == {6.0, 7.0}


def test_settings_of_the_picture_before_are_offered_faces_and_strokes_are_not(opened, start, photo):
    opened.edit(9.0)
    replace(photo)
    other = start(photo)
    assert "another picture" in other.say()
    assert other.state.recipe.percent == 4.0
    other.take_step("Bring the settings along")
    assert other.state.recipe.percent == 9.0
    assert other.say() == ""


def test_photos_beyond_the_strip_are_counted_and_exported(opened, tmp_path):
    (folder := tmp_path / "many").mkdir()
    for n in range(_MOST + 3):
        (folder / f"{n:05}.jpg").touch()
    opened.editor.strip._listing.drop()
    paths = photos_in([folder])
    assert len(paths) == _MOST + 3
    strip = opened.editor.strip
    strip._fill(([folder], paths, None))
    strip.stop()
    assert "2,000 of 2,003" in opened.say()
    assert strip.photos() == paths


@pytest.mark.parametrize("seed", [0, 1])
def test_a_story_in_the_window(start, photo, other, seed):
    assert not story(start, photo, other, seed, 30)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 100))
def test_a_hundred_stories_in_the_window(start, photo, other, seed):
    assert not story(start, photo, other, seed, 30)


def story(start, photo, other, seed, steps):
    """Tell a random story; return what went wrong. The oracle knows pictures by their pixels."""
    rng, wrong, newest = np.random.default_rng(seed), Counter(), {}
    (folder := photo.parent / "photos").mkdir()
    files = {}  # path: pixels, as bytes
    for number, one in enumerate((photo, other)):
        path = folder / f"{number}.png"
        shutil.copy(one, path)
        files[path] = read(path).pixels.tobytes()
    driver = start(folder / "0.png")
    copies = 0

    def picture():
        return driver.editor.document.photo.pixels.tobytes()

    def rename(path, to):
        if not to.exists():
            path.rename(to)
            files[to] = files.pop(path)

    for _ in range(steps):
        path = sorted(files)[rng.integers(len(files))]
        kind = rng.choice(["edit", "edit", "undo", "save", "rename", "folder", "replace", "star",
                           "open", "open", "kill", "away"])  # fmt: skip
        if kind == "edit":
            driver.edit(float(rng.integers(10, 150)) / 10)
        elif kind == "undo":
            driver.editor.history.undo()
            driver.settle()
        elif kind == "save":
            copies += 1
            file = photo.parent / f"copy{copies}.png"
            driver.editor.document.step(driver.state, "")
            driver.save(file)
            there = files.get(driver.editor.document.path)
            asked = driver.editor.document.photo.stamp is None
            if file.exists() and there not in (None, picture()) and not asked:
                wrong["wrong picture"] += 1
        elif kind == "rename":
            rename(path, path.with_name(f"r{rng.integers(9)}.png"))
        elif kind == "folder":
            to = folder.parent / f"photos{rng.integers(9)}"
            if not to.exists():
                folder.rename(to)
                files = {to / one.name: bytes_ for one, bytes_ in files.items()}
                folder = to
        elif kind == "replace":
            replace(path, int(rng.integers(100, 10**6)))
            files[path] = read(path).pixels.tobytes()
        elif kind == "star":
            add_star(path)
        elif kind == "away":
            aside = folder.parent / "home" / "aside.part"
            path.rename(aside)
            driver.edit(float(rng.integers(10, 150)) / 10)
            aside.rename(path)
        driver.editor.watch.look()
        driver.settle()
        if "replaced" in driver.say():
            driver.take_step(str(rng.choice(["Reload", "Keep the old picture"])))
            driver.settle()
        if kind in ("edit", "away") or driver.editor.document.undo.count():
            newest[picture()] = driver.state.recipe.percent
        if kind in ("open", "kill"):
            if kind == "kill":
                driver.editor.watch.stop()
                driver = start()
            driver.open(path)
            if picture() != files[path]:
                wrong["wrong picture"] += 1
            if driver.state.recipe.percent != newest.get(picture(), 4.0):
                wrong[f"edit lost {driver.state.recipe.percent} {newest.get(picture())}"] += 1
            if driver.say() and ("another" not in driver.say() or picture() in newest):
                wrong[f"false warning: {driver.say()}"] += 1
        for one, pixels in files.items():
            if read(one).pixels.tobytes() != pixels:
                wrong["original changed"] += 1
    return wrong
