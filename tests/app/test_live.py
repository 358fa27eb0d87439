"""The picture follows the document: first in line, once for each state, and after failures too."""

from __future__ import annotations

import threading

import cv2
import numpy as np
import pytest
from kogao_app.document import State
from kogao_app.pyramid import PicturePyramid
from kogao_app.render.live import Surface
from kogao_app.view_state import Handle, VisiblePart
from kogao_app.workers import Lane
from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QLabel
from scenes import oval_face, textured_photo
from timeouts import LONGEST_S

from kogao_core.base.geometry import Box
from kogao_core.recipe.recipe import Recipe
from kogao_core.resample import blocks as resample

pytestmark = pytest.mark.usefixtures("one_window")


def test_whatever_else_is_under_way_the_picture_comes(opened, pixels):
    """Every other lane is busy, as with an experiment, a copy being saved and a full strip."""
    gate = threading.Event()
    for lane in opened.editor.findChildren(Lane):
        if lane.parent() is not opened.editor.live:
            lane.submit(lambda: gate.wait(LONGEST_S))
            lane.drop()  # what it returns is nothing that the listeners know
    try:
        opened.set("percent", 7.0)
        opened.qtbot.waitUntil(lambda: not opened.editor.live.busy)
        np.testing.assert_array_equal(opened.shown, opened.rendered(pixels))
    finally:
        gate.set()
    opened.settle()


def test_letting_go_of_a_point_draws_the_picture_once_more(opened):
    """The last preview shows it already; only the whole photo is still to come."""
    opened.pause_never()
    at = opened.on_screen(Handle("outline", 0, 9))
    opened.press(at)
    opened.move(at + QPoint(9, 0))
    drawn = opened.drawn()
    opened.qtbot.waitUntil(lambda: bool(drawn))
    drawn.clear()
    opened.release(at + QPoint(9, 0))
    opened.settle()
    assert [frame.whole for frame in drawn] == [True]
    assert drawn[0].rendering.recipe == opened.state.recipe


def surface_of(kind):
    """A surface, and what draws a state on it."""
    made = Surface(PicturePyramid(textured_photo(900, 660)))
    parts = {"full": (), "preview": (VisiblePart(0, Box(60, 30, 780, 630)),)}[kind]
    return made, lambda state: made.render(1, state, *parts)


@pytest.mark.parametrize("kind", ["full", "preview"])
@pytest.mark.parametrize("where", [(resample.Job, "run"), (PicturePyramid, "refresh")])
def test_after_a_failed_rendering_the_picture_and_its_halvings_are_those_of_a_fresh_editor(
    monkeypatch, kind, where
):
    face = oval_face(900, 660)
    states = [State(faces=(face,), recipe=Recipe(percent=p)) for p in (3.0, 5.0, 4.0)]
    failed = State(faces=(oval_face(900, 660, size=0.3),), recipe=Recipe(percent=9.0))
    surface, draw = surface_of(kind)
    for state in states[:2]:  # both buffers are in use
        draw(state)
        surface.shown()
    with monkeypatch.context() as patch:
        patch.setattr(*where, failing_after_some(getattr(*where)))
        with pytest.raises(MemoryError):
            draw(failed)
    for state in (failed, *states):
        _, fresh = surface_of(kind)
        for level, expected in zip(draw(state).levels, fresh(state).levels, strict=True):
            np.testing.assert_array_equal(level, expected)
        surface.shown()


def failing_after_some(method):
    """Return a method that does its work and fails then, from the second call on for blocks."""
    calls = []

    def fail(self, *arguments):
        calls.append(1)
        if isinstance(self, PicturePyramid):
            # Only the first of the boxes is reduced.
            method(self, list(*arguments)[:1])
            raise MemoryError
        if len(calls) > 3:
            raise MemoryError
        method(self, *arguments)

    return fail


def test_a_picture_whose_preview_comes_last_is_settled_too(opened, monkeypatch):
    measured, settled, draw = threading.Event(), [], Surface.render

    def late(surface, revision, state, part=None):
        assert part is None or measured.wait(LONGEST_S)
        return draw(surface, revision, state, part)

    monkeypatch.setattr(Surface, "render", late)
    opened.editor.view.watch(measured.set, "full")
    measured.clear()
    opened.editor.live.settled.connect(lambda: settled.append(opened.editor.view.frame.whole))
    opened.set("percent", 7.0)
    opened.qtbot.waitUntil(lambda: bool(settled))
    assert settled == [True]


def test_readings_are_marked_until_they_are_those_of_the_whole_photo(opened):
    """At the same settings there are never two different figures that both look exact."""
    labels = opened.panel("recipe").one_to_one, opened.panel("recipe").residual
    seen: dict[str, set[tuple[str, str]]] = {}

    def look(*_):
        seen.setdefault(opened.panel("recipe").percent.field.text(), set()).add(
            tuple(label.text() for label in labels)
        )

    opened.editor.view.watch(look, "frame")
    opened.editor.document.watch(look)
    settled = [label.text() for label in labels]
    assert all(settled)
    for percent in (5.0, 6.0, 7.0):
        opened.editor.recipe.set_field("percent", percent)
        assert [label.text() for label in labels] == [f"≈ {text}" for text in settled]
    opened.editor.document.commit()
    opened.settle()
    assert not any(label.text().startswith("≈") for label in labels)
    exact = [{text for text in texts if not text[0].startswith("≈")} for texts in seen.values()]
    assert len(exact[-1]) == 1
    assert all(len(texts) <= 1 for texts in exact)


def test_another_photo_begins_without_readings(opened, photo):
    labels = opened.panel("recipe").one_to_one, opened.panel("recipe").residual

    def readings():
        status = [one.text() for one in opened.window.status.findChildren(QLabel)]
        drawn_in = [text for text in status if text.startswith("drawn in")]
        return drawn_in + [label.text() for label in labels if label.text()]

    seen = []
    opened.editor.document.opened.connect(lambda: seen.append(readings()))
    opened.open(photo)
    assert seen == [[]]
    assert len(readings()) == 3


def test_a_preview_reads_as_the_whole_photo_does(start, source, tmp_path):
    """To what is displayed: of half a photo's pixels, and of the part that is on screen."""
    source.faces = [oval_face(1600, 1200, size=0.5)]
    photo = tmp_path / "large.png"
    assert cv2.imwrite(str(photo), textured_photo(1600, 1200))
    driver = start(photo)
    driver.pause_never()
    panel, seen = driver.panel("recipe"), []

    def look():
        frame = driver.editor.view.frame
        texts = panel.one_to_one.text(), panel.residual.text()
        seen.append((frame.whole, [text.removeprefix("≈ ") for text in texts]))

    driver.editor.view.watch(look, "frame")
    for zoom in (driver.canvas.fit, lambda: driver.canvas.zoom_to(0.8)):
        zoom()
        for percent in (2.0, 12.0):
            seen.clear()
            driver.editor.recipe.set_field("percent", percent)
            driver.qtbot.waitUntil(lambda: bool(seen))
            driver.editor.document.commit()
            driver.settle()
            (_, last), previews = seen[-1], [texts for whole, texts in seen if not whole]
            assert seen[-1][0]
            assert previews
            assert all(texts == last for texts in previews)
