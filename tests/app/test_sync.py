"""Sync settings to selected photos: undo in each, groups of settings, a preview; the strip."""

import dataclasses
import io
import itertools
import threading
from unittest.mock import Mock

import pytest
from few_cases import few_of
from kogao_app.features import files, sync
from kogao_app.features.strip.film import _WARNING as WARNING
from kogao_app.features.sync import groups
from named import HEAD, head_of, mwg
from PIL import Image
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from scenes import oval_face
from test_own_results import click_on
from test_own_results import strip as strip
from timeouts import LONGEST_S, held_back

from kogao_core.projects import edits
from kogao_core.projects.acts import Acts
from kogao_core.projects.edits import sidecar_of
from kogao_core.projects.project import load
from kogao_core.recipe.recipe import SETTINGS, Recipe

pytestmark = pytest.mark.usefixtures("one_window")


def test_sync_is_one_undo_step_in_each_photo_and_counts_those_with_edits(strip):
    for row, percent in ((2, 3.0), (0, 8.0)):
        click_on(strip, row)
        strip.edit(percent)
    click_on(strip, 2, Qt.KeyboardModifier.ControlModifier)
    click_on(strip, 3, Qt.KeyboardModifier.ControlModifier)
    said = []
    strip.editor.sync.did.connect(said.append)
    strip.editor.sync.start()
    strip.settle()
    assert said == ["Settings applied to 2 photos (1 had edits); undo is one step"]
    for row, before in ((2, [3.0, 4.0]), (3, [4.0])):
        click_on(strip, row)
        assert strip.state.recipe.percent == 8.0
        for percent in before:
            strip.editor.history.undo()
            assert strip.state.recipe.percent == percent
        assert not strip.editor.document.undo.canUndo()
        assert len(strip.state.faces) == 1


def test_only_the_groups_of_settings_that_are_checked_are_copied(strip):
    state = strip.editor.document.state.with_choices(None, percent=8.0, jaw_width=-4.0)
    strip.editor.document.step(state, "Settings")
    click_on(strip, 2, Qt.KeyboardModifier.ControlModifier)
    strip.editor.sync._groups["amount"].setChecked(False)
    strip.editor.sync.start()
    strip.settle()
    click_on(strip, 2)
    assert (strip.state.recipe.percent, strip.state.recipe.jaw_width) == (4.0, -4.0)
    strip.editor.sync._groups["amount"].setChecked(True)


def test_every_field_of_a_recipe_is_in_one_group_of_settings():
    names = [name for _, group in groups().values() for name in group]
    assert sorted(names) == sorted(SETTINGS)


def test_selected_thumbnails_follow_the_settings_before_they_are_applied(strip, source):
    film, icons = strip.editor.strip.film, {}

    def changed():
        now = {film.path(row).stem: film.item(row).icon().cacheKey() for row in range(film.count())}
        before = dict(icons)
        icons.update(now)
        return {name for name in now if now[name] != before.get(name)}

    def warned():
        items = map(film.item, range(film.count()))
        return {item.text() for item in items if item.data(WARNING)}

    source.faces = [dataclasses.replace(oval_face(), score=0.5, source="mesh")]
    click_on(strip, 2, Qt.KeyboardModifier.ControlModifier)
    strip.settle()
    changed()
    strip.edit(8.0)
    assert changed() - {"a"} == {"b"}, "only selected photos are drawn again"
    assert warned() == {"b.png"}, "a doubtful face is marked by a ring"
    folder = strip.editor.document.path.parent
    assert not sidecar_of(folder / "b.png").exists(), "nothing is applied yet"
    click_on(strip, 2)
    strip.settle()
    assert "b" in changed(), "the thumbnail shows the saved edits again"
    assert not warned()
    assert strip.editor.document.path.stem == "b"
    assert not strip.editor.strip.panel.sync.isVisible(), "the open photo isn't one of them"


def test_the_next_photo_is_counted_from_the_open_one(strip):
    film = strip.editor.strip.film
    at = film.visualItemRect(film.item(3)).center()
    QTest.mouseClick(film.viewport(), Qt.MouseButton.RightButton, pos=at)
    film.step(1)
    strip.settle()
    assert strip.editor.document.path.name == "b.png"


@pytest.mark.parametrize("late_step", ["synced", "record", "open_photo"])
def test_a_photo_that_is_opened_during_its_sync_gets_the_settings(strip, monkeypatch, late_step):
    """The photo is shown before the sync writes, while it writes, or read before, shown after."""
    document = strip.editor.document
    strip.edit(8.0)
    click_on(strip, 2, Qt.KeyboardModifier.ControlModifier)
    other, read = document.path.with_name("b.png"), threading.Event()
    if late_step == "open_photo":
        gate, late = held_back(lambda opened: opened)
        real = files.open_photo

        def opened(*given):
            made = real(*given)
            read.set()
            return late(made)

        monkeypatch.setattr(files, "open_photo", opened)
        strip.editor.files.open(other)
        assert read.wait(LONGEST_S)
        strip.editor.sync.start()
        strip.qtbot.waitUntil(lambda: not strip.editor.sync.busy)
    else:
        # Between the project and the record with the undo steps, or before both.
        module, name = (sync, "synced") if late_step == "synced" else (edits.lzma, "compress")
        real = getattr(module, name)
        gate, late = held_back(real)

        def held(*given, **named):
            is_early = late_step == "record" and not sidecar_of(other).exists()
            return (real if is_early else late)(*given, **named)

        monkeypatch.setattr(module, name, held)
        strip.editor.sync.start()
        if late_step == "record":
            strip.qtbot.waitUntil(sidecar_of(other).exists)
        strip.editor.files.open(other)
        for _ in range(30):
            if document.path != other:
                strip.qtbot.wait(10)
    gate.set()
    strip.settle()
    assert document.path == other
    assert strip.state.recipe.percent == 8.0
    strip.edit(9.0)
    assert not strip.say()
    click_on(strip, 0)
    click_on(strip, 2)
    for percent in (9.0, 8.0, 4.0):
        assert strip.state.recipe.percent == percent
        strip.editor.history.undo()


def percent_of(path):
    return load(sidecar_of(path)).automatic.recipe.percent if sidecar_of(path).exists() else None


@pytest.fixture
def synced_two(strip):
    """The photos a (open), b and c after a sync of 8 % from a; b had 3 %."""
    for row, percent in ((2, 3.0), (0, 8.0)):
        click_on(strip, row)
        strip.edit(percent)
    for row in (2, 3):
        click_on(strip, row, Qt.KeyboardModifier.ControlModifier)
    strip.editor.sync.start()
    strip.settle()
    folder = strip.editor.document.path.parent
    strip.percents = lambda: [percent_of(folder / f"{one}.png") for one in "bc"]
    return strip


def test_undo_of_a_sync_is_one_step_for_all_photos_and_so_is_redo(synced_two):
    strip, history = synced_two, synced_two.editor.history
    assert strip.percents() == [8.0, 8.0]
    assert strip.state.recipe.percent == 8.0
    history.undo()
    strip.settle()
    assert strip.percents() == [3.0, 4.0]
    assert strip.state.recipe.percent == 8.0, "the open photo's own change is another step"
    history.redo()
    strip.settle()
    assert strip.percents() == [8.0, 8.0]
    click_on(strip, 2)
    click_on(strip, 0)  # the step is found again with the photo
    history.undo()
    strip.settle()
    assert strip.percents() == [3.0, 4.0]


def test_a_photo_edited_since_a_sync_keeps_its_edits_and_is_named(synced_two):
    strip = synced_two
    click_on(strip, 3)
    strip.edit(5.0)
    click_on(strip, 0)
    strip.editor.history.undo()
    strip.settle()
    assert strip.percents() == [3.0, 5.0]
    assert strip.say() == "Newer edits stay as they are: c.png."


LEFT = {"Finish": [8.0, 8.0], "Undo": [3.0, None], "Leave": [8.0, None]}
KILLED = [*(("", one) for one in LEFT), ("note", "Finish"), ("steps", "Undo")]


@pytest.mark.parametrize(
    ("missing", "answer"),
    few_of(dict.fromkeys([*KILLED, *itertools.product(("", "note", "steps"), LEFT)]), len(KILLED)),
)
def test_a_sync_that_was_killed_is_finished_undone_or_left(
    synced_two, monkeypatch, missing, answer
):
    strip, acts = synced_two, synced_two.editor.sync._store
    strip.editor.history.undo()
    strip.settle()
    sidecar_of(strip.editor.document.path.with_name("c.png")).unlink()
    act = acts.begin(strip.editor.document.path, 9, "Apply", {"percent": 8.0}, [
        strip.editor.document.path.with_name(name) for name in ("b.png", "c.png")
    ])  # fmt: skip
    first, real = acts.turn(act, True)[0], Acts.note
    if missing:  # killed between the edits and the record
        monkeypatch.setattr(Acts, "note", lambda *args: len(args) > 3 and real(*args))
    if missing == "steps":  # killed between the edits and their undo steps
        monkeypatch.setattr(edits.lzma, "compress", Mock(side_effect=OSError))
    projects, faces = strip.editor.projects, strip.editor.faces
    sync.synced(first, acts, projects.keeping(first.path), faces.search(), Recipe())
    monkeypatch.undo()
    strip.editor.sync.look()
    assert strip.say().startswith("Settings for several photos: ")
    assert ("1 of 2" in strip.say()) is not bool(missing)
    strip.take_step(answer)
    strip.settle()
    assert strip.percents() == LEFT[answer]
    assert acts.unfinished() is None


def test_auto_sync_applies_each_change_and_undoes_it_with_the_step(strip):
    strip.edit(3.0)
    click_on(strip, 2, Qt.KeyboardModifier.ControlModifier)
    folder = strip.editor.document.path.parent
    strip.editor.sync.auto.setChecked(True)
    strip.edit(8.0)
    assert percent_of(folder / "b.png") == 8.0
    strip.show("lens", 50.0)
    assert load(sidecar_of(folder / "b.png")).automatic.recipe.lens != 50.0, "it isn't ticked"
    for _ in range(2):
        strip.editor.history.undo()
        strip.settle()
    assert strip.state.recipe.percent == 3.0
    assert percent_of(folder / "b.png") == 4.0
    strip.editor.sync.auto.setChecked(False)


@pytest.fixture
def named(start, source, tmp_path, encoded):
    """Five photos of two people; d names nobody, and in e the name lies beside the faces."""
    kate, ann = source.faces = [oval_face(center=(x, 170), size=0.45) for x in (120, 350)]
    picture = Image.open(io.BytesIO(encoded)).convert("RGB")
    both = [("Kate", head_of(kate, picture.size)), ("Zo\u00eb Ann", head_of(ann, picture.size))]
    beside = [("Zo\u00eb Ann", ((0.5, 0.95), (0.1, 0.1)))]
    for name, people in (("a", both), ("b", both), ("c", both), ("d", []), ("e", beside)):
        packet = HEAD.format(mwg(people, picture.size)).encode()
        picture.save(tmp_path / f"{name}.jpg", xmp=packet)
    driver = start(tmp_path / "a.jpg")
    driver.editor.strip.show_places([tmp_path])
    driver.settle()
    return driver


def test_settings_of_one_person_go_to_all_photos_and_back_in_one_step(named, tmp_path):
    def kept(name):
        file = sidecar_of(tmp_path / f"{name}.jpg")
        if not file.exists():
            return None
        sheet = load(file).automatic
        return [face.recipe and face.recipe.percent for face in sheet.faces], set(sheet.off)

    click_on(named, 1)
    named.edit(3.0)
    click_on(named, 0)
    named.editor.recipe.choose(1)
    named.edit(8.0)
    person = named.editor.strip.panel.person
    assert (person.isVisible(), person.text()) == (True, "Zo\u00eb Ann, 3 photos")
    person.click()
    named.settle()
    # Faces of nobody named stay as they are, and those of a photo without edits are off.
    of_two = {"b": ([None, 8.0], set()), "c": ([None, 8.0], {0})}
    assert {name: kept(name) for name in "bc"} == of_two
    assert load(sidecar_of(tmp_path / "b.jpg")).automatic.recipe.percent == 3.0
    assert (kept("d"), kept("e")) == (None, None)
    assert named.say() == "Left alone, since the person's face isn't certain: e.jpg."
    texts = [load(sidecar_of(tmp_path / "a.jpg")), named.editor.document.undo.undoText()]
    assert not any("Ann" in str(one) for one in texts), "no name in edits"
    named.editor.history.undo()
    named.settle()
    assert {name: kept(name) for name in "bc"} == {
        "b": ([None, None], set()),
        "c": ([None] * 2, set()),
    }
    named.editor.history.redo()
    named.settle()
    assert {name: kept(name) for name in "bc"} == of_two
    named.editor.recipe.choose(0)
    assert person.text() == "Kate, 2 photos"
    named.editor.recipe.choose(None)
    assert not person.isVisible()
    named.editor.sync.start_person()
    assert named.say().startswith("Select a face with a name ")
