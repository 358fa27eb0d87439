"""Faces appear while the search for more goes on, and what is done to them meanwhile stays."""

import threading

import numpy as np
import pytest
from kogao_app.view_state import Handle
from PySide6.QtCore import QPoint, Qt
from scenes import KnownFaces, oval_face
from timeouts import LONGEST_S

from kogao_core.base.threads import parallel_for
from kogao_core.faces.face import ignored, in_reading_order

KEYS, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier
FACES = [oval_face(center=(x, 170), size=size) for x, size in ((240, 0.4), (390, 0.35), (90, 0.3))]
FROM_THE_LEFT = [2, 0, 1]


class Slow(KnownFaces):
    """Finds a face whenever it is let go on, and returns them all, from the left."""

    def __init__(self):
        super().__init__(*FACES)
        self.goes_on = threading.Semaphore(0)

    def find(self, rgb, on_face=ignored):  # noqa: ARG002
        for face in self.faces:
            assert self.goes_on.acquire(timeout=LONGEST_S)
            on_face(face)
        assert self.goes_on.acquire(timeout=LONGEST_S)
        return in_reading_order(self.faces)


@pytest.fixture
def source():
    return Slow()


class Search:
    """A search under way, and what lets it go on."""

    def __init__(self, driver, source, qtbot):
        self.driver, self.goes_on, self.qtbot = driver, source.goes_on, qtbot

    def finds(self, count):
        """Find so many faces, and return the driver."""
        for _ in range(count):
            self.goes_on.release()
        said = f"{count} so far"
        self.qtbot.waitUntil(lambda: said in self.driver.window.status.hint_text)
        return self.driver

    def ends(self):
        self.goes_on.release(len(FACES) + 1)
        self.driver.settle()


@pytest.fixture
def search(empty, source, photo, qtbot):
    empty.editor.files.open(photo)
    yield Search(empty, source, qtbot)
    source.goes_on.release(100)


def drag_the_chin(driver):
    driver.qtbot.waitUntil(lambda: not driver.editor.live.busy)
    driver.drag(driver.on_screen(Handle("outline", 0, 10)), QPoint(3, 9))


def test_faces_appear_as_they_are_found(search):
    driver = search.finds(1)
    assert driver.state.faces == tuple(FACES[:1])
    assert driver.panel("faces").list.count() == 2
    assert not driver.editor.document.dirty
    search.ends()
    assert driver.state.faces == tuple(FACES[k] for k in FROM_THE_LEFT)
    assert driver.panel("faces").list.count() == 4
    assert driver.editor.document.undo.count() == 0
    assert not driver.editor.document.dirty


def test_the_photo_is_rendered_once_all_faces_are_there(search):
    drawn = search.driver.drawn()
    search.finds(2)
    assert not drawn
    search.ends()
    (frame,) = drawn
    assert frame.whole
    assert len(frame.done.faces) == 3


def test_what_is_done_meanwhile_is_rendered_meanwhile(search):
    driver = search.finds(1)
    drag_the_chin(driver)
    driver.qtbot.waitUntil(lambda: not driver.editor.live.busy)
    assert driver.editor.view.frame.whole
    assert driver.editor.view.frame.done.faces == [driver.state.faces[0]]


def test_thumbnails_follow_their_faces_when_they_are_put_in_order(search):
    driver = search.finds(2)
    panel = driver.panel("faces")
    before = [panel.item(row).icon().cacheKey() for row in range(2)]
    pictures = [picture_of(panel, row) for row in range(2)]
    search.ends()
    assert [panel.item(row).icon().cacheKey() for row in range(2)] != before
    assert picture_of(panel, FROM_THE_LEFT.index(0)) == pictures[0]
    assert picture_of(panel, FROM_THE_LEFT.index(1)) == pictures[1]


def picture_of(panel, row):
    return panel.item(row).icon().pixmap(48, 48).toImage()


def test_a_face_corrected_meanwhile_stays_and_the_rest_join_it(search):
    driver = search.finds(1)
    drag_the_chin(driver)
    corrected = driver.state.faces[0]
    assert corrected is not FACES[0]
    search.ends()
    assert driver.state.faces[0] is corrected
    assert set(driver.state.faces[1:]) == set(FACES[1:])
    assert driver.editor.document.undo.count() == 1
    driver.key(KEYS.Key_Z, CONTROL)
    assert driver.state.faces[0] is FACES[0]
    assert set(driver.state.faces) == set(FACES), "the rest lie below the first undo step"
    driver.qtbot.waitUntil(lambda: not driver.editor.document.dirty)
    driver.editor.document.undo.redo()
    assert driver.state.faces[0] is corrected
    assert len(driver.state.faces) == 3


def test_a_drag_goes_on_while_the_search_ends(search):
    driver = search.finds(1)
    driver.qtbot.waitUntil(lambda: not driver.editor.live.busy)
    start = driver.on_screen(Handle("outline", 0, 10))
    driver.press(start)
    driver.move(start + QPoint(2, 4))
    search.ends()
    driver.move(start + QPoint(3, 9))
    driver.release(start + QPoint(3, 9))
    assert len(driver.state.faces) == 3
    moved = driver.state.faces[0].outline - FACES[0].outline
    np.testing.assert_array_equal(np.flatnonzero(np.abs(moved).max(axis=1)), [10])
    assert driver.editor.document.undo.count() == 1


def test_who_is_deleted_or_placed_meanwhile_is_not_found_once_more(search):
    driver = search.finds(1)
    document = driver.editor.document
    document.step(document.state.without_face(0), "Delete")
    driver.editor.faces.place(oval_face(center=(392, 172), size=0.35))
    driver.editor.faces.end_placing()
    search.ends()
    assert len(driver.state.faces) == 2
    assert FACES[2] in driver.state.faces
    assert FACES[1] not in driver.state.faces


def test_what_an_earlier_search_still_finds_is_nobodys(search, source):
    driver = search.finds(1)
    driver.editor.faces.find()
    assert driver.window.status.hint_text == "Looking for faces…"
    source.goes_on.release(3)
    search.finds(1)
    search.ends()
    assert driver.state.faces == tuple(FACES[k] for k in FROM_THE_LEFT)
    assert driver.editor.document.undo.count() == 0


class Long(KnownFaces):
    """Takes a look whenever it is let go on, and never comes to an end."""

    def __init__(self):
        super().__init__()
        self.looks, self.goes_on = threading.Semaphore(0), threading.Semaphore(0)
        self.over = threading.Event()

    def find(self, rgb, on_face=ignored):  # noqa: ARG002
        try:
            parallel_for(range(1000), lambda: self.look, 1)
        finally:
            self.over.set()

    def look(self, _):
        self.looks.release()
        assert self.goes_on.acquire(timeout=LONGEST_S)


@pytest.fixture
def long(empty, photo):
    """A search that doesn't end by itself; a look of it is under way."""
    source = Long()
    empty.editor.faces.use(source)
    empty.editor.files.open(photo)
    empty.qtbot.waitUntil(lambda: source.looks.acquire(blocking=False))
    yield source
    source.goes_on.release(1000)


def test_another_source_stops_the_search_under_way(empty, long):
    empty.editor.faces.use(KnownFaces(*FACES))
    long.goes_on.release()
    empty.qtbot.waitUntil(lambda: set(empty.state.faces) == set(FACES))
    assert not empty.say()


def test_another_photo_stops_the_search_under_way(empty, long, photo):
    photo.with_name("other.png").write_bytes(photo.read_bytes())
    empty.editor.files.open(photo.with_name("other.png"))
    empty.qtbot.waitUntil(lambda: empty.editor.document.path.name == "other.png")
    long.goes_on.release()
    empty.qtbot.waitUntil(long.over.is_set)


def test_a_window_that_closes_stops_the_search_under_way(empty, long, monkeypatch):
    # Workers are waited for after this.
    monkeypatch.setattr(empty.window, "really_close", long.goes_on.release)
    empty.editor.close()
    assert long.over.is_set()
    assert not long.looks.acquire(blocking=False)
