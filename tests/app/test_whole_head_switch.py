"""Whole head in the window: its switch, what the panel says of it, and what the canvas shows."""

import numpy as np
import pytest
from kogao_app.document import State
from kogao_app.render.live import Surface
from kogao_app.render.pyramid import PicturePyramid
from kogao_app.view_state import VisiblePart
from kogao_app.workspaces import RETOUCH
from PySide6.QtCore import Qt
from scenes import KnownFaces, oval_face, textured_photo
from test_view import picture

from kogao_core.base.geometry import Box
from kogao_core.recipe.recipe import Recipe


@pytest.fixture
def source():
    return KnownFaces(oval_face(center=(239.5, 210.0), size=0.45, forehead=True))


def test_its_switch_is_folded_away_at_first_with_the_parts_of_the_face(start, photo):
    driver = start(photo, workspace=RETOUCH.name)
    panel = driver.panel("recipe")
    switch = panel.switches["whole_head"]
    panel.more.button.setChecked(True)
    assert not switch.isVisible()
    panel.zones.button.setChecked(True)
    assert switch.isVisible()
    switch.click()
    assert driver.state.recipe.whole_head


def test_on_the_forehead_follows_and_its_rim_is_shown(opened):
    def at_hairline():
        at = opened.canvas.to_screen(opened.state.faces[0].forehead[6]).toPoint()
        rows = slice(at.y() - 6, at.y() + 10)
        return picture(opened)[rows, 3 * (at.x() - 6) : 3 * (at.x() + 6)]

    def overlay_shows_there():
        shown = at_hairline()
        opened.key(Qt.Key.Key_T)
        hidden = at_hairline()
        opened.key(Qt.Key.Key_T)
        return (shown != hidden).any()

    before, switch = opened.shown.copy(), opened.panel("recipe").switches["whole_head"]
    assert not overlay_shows_there()
    switch.click()
    opened.settle()
    assert (opened.shown != before).any()
    assert overlay_shows_there()
    switch.click()
    opened.settle()
    np.testing.assert_array_equal(opened.shown, before)


def test_the_panel_says_where_it_does_nothing(start, photo, source):
    source.faces = [oval_face()]
    driver = start(photo)
    panel = driver.panel("recipe")
    panel.zones.button.setChecked(True)
    assert not panel.head_note.isVisible()
    panel.switches["whole_head"].click()
    assert panel.head_note.isVisible()
    assert panel.head_note.text().startswith("whole head does nothing for 1 face,")
    panel.switches["whole_head"].click()
    assert not panel.head_note.isVisible()


def test_a_preview_of_a_part_moves_as_the_whole_photo_does(source):
    surface = Surface(PicturePyramid(textured_photo()))
    state = State(faces=tuple(source.faces), recipe=Recipe(percent=8.0, whole_head=True))
    part = VisiblePart(0, Box(90, 110, 390, 340))  # its edge is nearer to the head than the photo's
    near, whole = surface.render(1, state, part), surface.render(2, state)
    points = np.random.default_rng(5).uniform((100, 115), (380, 330), (200, 2))
    np.testing.assert_allclose(
        near.rendering.field.at(near.to_photo.inverse(points)) * near.scale,
        whole.rendering.field.at(points),
        atol=1e-3,
    )
