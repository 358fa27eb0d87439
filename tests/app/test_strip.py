"""Stars, marks, order and choice on the film strip."""

import dataclasses
from unittest.mock import Mock

import cv2
import numpy as np
import pytest
from kogao_app.features.preferences import EDITS, prefer
from kogao_app.features.strip import facts
from kogao_app.features.strip.facts import Sample, thumbnail
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from scenes import oval_face
from test_own_results import click_on, marks
from test_own_results import strip as strip

from kogao_core.background.find import BackgroundFinder
from kogao_core.background.holding import NOTHING_HELD
from kogao_core.background.people import PersonLook, PersonMask
from kogao_core.base.geometry import Affine
from kogao_core.photo.metadata.rating import REJECTED
from kogao_core.projects.project import Original, Project, Sheet
from kogao_core.recipe.recipe import Recipe

pytestmark = pytest.mark.usefixtures("one_window")


SHIFT, CONTROL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier
KEYS = Qt.Key


def shown(driver):
    film = driver.editor.strip.film
    items = [film.item(row) for row in range(film.count())]
    return [item.text() for item in items if not item.isHidden()]


def choose(box, words):
    box.setCurrentIndex(box.findText(words))


def rate(photo, stars, label=""):
    """Write stars and a label next to a photo, as other programs do."""
    rated = f'<rdf:Description xmp:Rating="{stars}" xmp:Label="{label}"/>'
    photo.with_name(f"{photo.name}.xmp").write_text(rated)


def test_select_all_selects_photos_while_the_strip_has_the_focus(strip):
    film = strip.editor.strip.film
    click_on(strip, 2)
    strip.press_key(film, KEYS.Key_A, CONTROL)
    assert len(film.selectedItems()) == film.count() > 1


def test_the_strip_is_sorted_and_filtered_by_stars_and_what_was_done(strip, tmp_path):
    folder, panel = tmp_path / "in", strip.editor.strip.panel
    for name, stars in (("b", 3), ("c", REJECTED), ("d", 5)):
        rate(folder / f"{name}.png", stars, "Red" if name == "d" else "")
    strip.editor.strip.show_places([folder])
    strip.settle()
    panel.order.setCurrentIndex(1)
    everything = ["d.png", "b.png", "a.png", "a_kogao.png", "e.png", "c.png"]
    assert shown(strip) == everything
    assert panel.film.currentItem().text() == "a.png"
    assert [marks(strip)[f"{name}.png"] for name in "bcd"] == ["★★★", "rejected", "★★★★★, red"]
    choose(panel.choice, "★★★ or more")
    assert shown(strip) == ["d.png", "b.png"]
    assert panel.line.text() == "2 of 6 shown"
    assert strip.editor.strip.photos() == [folder / "d.png", folder / "b.png"], "to be batched"
    click_on(strip, 0)
    strip.editor.strip.film.step(1)
    strip.settle()
    assert strip.editor.document.path.name == "b.png"
    rate(folder / "b.png", 1)
    strip.editor.strip.look_again(folder / "b.png")
    strip.settle()
    assert shown(strip) == ["d.png"]
    strip.editor.strip.film.step(-1)
    strip.settle()
    assert strip.editor.document.path.name == "d.png", "from where it would stand"
    choose(panel.choice, "Rejected")
    assert shown(strip) == ["c.png"]
    choose(panel.choice, "Untouched")
    assert set(shown(strip)) == {"a.png", "b.png", "c.png", "d.png", "e.png"}
    panel.order.setCurrentIndex(0)
    strip.editor.strip.show_places([folder])
    strip.settle()
    assert shown(strip) == sorted(everything), "another folder shows all it has"


def test_a_copy_saved_over_a_photo_of_the_strip_gets_a_new_thumbnail(strip):
    film = strip.editor.strip.film
    (item,) = (one for row in range(film.count()) if "_kogao" in (one := film.item(row)).text())
    before = item.icon().cacheKey()
    strip.save(film.path(film.row(item)))
    assert item.icon().cacheKey() != before


def test_a_stopped_strip_looks_for_no_thumbnail(strip, monkeypatch):
    """Its list may be deleted before a queued call arrives."""
    feature = strip.editor.strip
    monkeypatch.setattr(feature.film, "next_of", Mock(side_effect=RuntimeError("deleted")))
    monkeypatch.setattr(feature, "_undrawn", {})
    feature._draw()


def test_keys_open_what_chooses_photos(strip):
    panel = strip.editor.strip.panel
    strip.window.activateWindow()
    for key, box in ((KEYS.Key_F, panel.choice), (KEYS.Key_D, panel.order)):
        strip.key(key, CONTROL, SHIFT)
        assert box.view().isVisible()
        assert box.accessibleName()
        QTest.keyClick(box.view(), KEYS.Key_Escape)


def pixels(image):
    image = image.convertToFormat(image.Format.Format_RGBA8888)
    return np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1).astype(int)


@pytest.mark.parametrize("own", [False, True])
def test_a_thumbnail_shows_the_edits(strip, own):
    editor = strip.editor
    if own:
        prefer(editor.strip.settings, EDITS, "own")
    path, film = editor.document.path, editor.strip.film
    before, icon = pixels(thumbnail(path).picture), film.item(0).icon().cacheKey()
    strip.edit(6.0)
    edited = pixels(thumbnail(path, edits=editor.strip.storage.edits).picture)
    assert edited.shape == before.shape
    apart = np.abs(edited - before)
    assert apart.max() > 20
    assert np.median(apart) <= 2, "it is the same photo"
    # On a busy machine the strip hears of the kept edit after the window has settled.
    strip.qtbot.waitUntil(lambda: film.item(0).icon().cacheKey() != icon)


@pytest.mark.parametrize("holds", [True, False])
def test_a_line_that_turns_is_a_reason_to_check(tmp_path, monkeypatch, holds):
    """Such a result was not to check before; what holds lines is taken away here."""
    if not holds:
        monkeypatch.setattr(facts, "held_of", lambda *_: NOTHING_HELD)
    face, photo = oval_face(800, 600, size=0.5), np.full((600, 800, 3), 90, np.uint8)
    left, right = int(face.outline[:, 0].min()), int(face.outline[:, 0].max())
    cv2.line(photo, (right + 33, 50), (right + 33, 333), (200, 200, 200), 4, cv2.LINE_AA)
    cv2.imwrite(str(tmp_path / "a.png"), photo)
    opacity = np.zeros((800, 800), np.float32)
    opacity[83:600, left:right] = 1.0
    look = PersonLook(opacity, Affine.similarity(1.0, 0.0, (0.0, 0.0)), 1.0)
    finder = BackgroundFinder(Mock(find=lambda *_: PersonMask((look,), 0, (0,))))
    edits = Sheet((face,), recipe=Recipe(percent=8))
    project = Project(Original("a.png", "", 800, 600), "automatic", edits)
    sample = Sample.of(tmp_path / "a.png", 72, project, 800)
    assert sample.drawn(project).warning == ""
    assert ("straight line" in sample.drawn(project, finder).warning) is not holds


def test_a_key_leads_to_photos_to_check_once_and_says_why(start, encoded, tmp_path, source):
    driver = start()
    folder = tmp_path / "in"
    folder.mkdir()
    for name in ("a.png", "b.png", "c.png"):
        (folder / name).write_bytes(encoded)
    driver.editor.strip.show_places([folder])
    driver.settle()
    source.faces = [dataclasses.replace(oval_face(), score=0.5, source="mesh")]
    click_on(driver, 1)
    driver.set("percent", 5.0)
    click_on(driver, 2)
    driver.set("percent", 5.0)
    source.faces = [oval_face()]
    click_on(driver, 0)
    chip = driver.editor.strip.panel.chips["doubtful"]
    assert "2" in chip.text()
    seen = []
    for _ in range(2):
        driver.key(Qt.Key.Key_Right, CONTROL, Qt.KeyboardModifier.ShiftModifier)
        driver.settle()
        seen.append(driver.editor.document.path.name)
        assert f"To check: {seen[-1]}, face 1" in driver.say().splitlines()[0]
        assert "50 %" in driver.say()
    assert seen == ["b.png", "c.png"]
    assert chip.isHidden(), "both are marked as seen"
    driver.key(Qt.Key.Key_Right, CONTROL, Qt.KeyboardModifier.ShiftModifier)
    assert driver.say() == "No photo of the strip is left to check."
    assert driver.editor.document.path.name == "c.png"


def test_doubtful_faces_are_marked_until_they_are_switched_on(start, encoded, tmp_path, source):
    driver = start()
    folder = tmp_path / "in"
    folder.mkdir()
    for name in ("a.png", "b.png"):
        (folder / name).write_bytes(encoded)
    source.faces = [dataclasses.replace(oval_face(), score=0.5, source="mesh")]
    driver.editor.strip.show_places([folder])
    driver.settle()
    assert driver.state.off == {0}
    assert marks(driver) == {"a.png": "to check", "b.png": ""}
    driver.set("percent", 5.0)
    click_on(driver, 1)
    driver.editor.strip.show_places([folder])
    driver.settle()
    assert marks(driver)["a.png"].startswith("to check, face 1"), "its edits say so"
    click_on(driver, 0)
    driver.editor.faces._all_on()
    driver.settle()
    assert marks(driver)["a.png"] == "edited"
