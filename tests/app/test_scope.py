"""Head or face only, in the window: the control, the notes and the picture."""

import numpy as np
import pytest
from kogao_app.document import State
from kogao_app.pyramid import PicturePyramid
from kogao_app.render.live import Surface, VisiblePart
from kogao_app.workspaces import RETOUCH
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from scenes import KnownFaces, oval_face, textured_photo
from test_mnemonics import doubled, letters_of
from test_view import picture

from kogao_core.base.geometry import Box
from kogao_core.field.protection import Protection
from kogao_core.recipe.recipe import SETTINGS, Recipe


@pytest.fixture
def source():
    return KnownFaces(oval_face(center=(239.5, 210.0), size=0.45, forehead=True))


def scope(driver):
    return driver.panel("recipe").scope


def checked(driver):
    choice = scope(driver)
    return choice.names[choice.group.checkedId() - 1]


def test_it_is_in_sight_below_the_amount_in_every_workspace(start, photo):
    driver = start(photo)
    panel = driver.panel("recipe")
    for _ in driver.workspaces():
        driver.settle()
        assert scope(driver).isVisible()
        assert panel.percent.y() < panel.scope.y() <= panel.more.y()
        assert doubled(letters_of(driver.window)) == {}
    buttons = scope(driver).group.buttons()
    assert [one.text() for one in buttons] == ["Head", "Face only"]
    said = [one.toolTip().partition("\n")[0] for one in buttons]
    assert said == ["Head: with ears and hair", "Face only: as in the paper"]


def test_a_key_leads_to_it_and_a_choice_is_one_step_with_a_name(start, photo):
    driver = start(photo, workspace=RETOUCH.name)
    QTest.keyClick(driver.window, Qt.Key.Key_G, Qt.KeyboardModifier.AltModifier)
    head, face = scope(driver).group.buttons()
    assert head.hasFocus()
    driver.press_key(head, Qt.Key.Key_Right)
    assert face.hasFocus()
    assert driver.state.recipe.scope == "face"
    assert driver.editor.document.undo.undoText() == "Change Head → Face only"
    driver.key(Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert driver.state.recipe.scope == "head"


def test_a_control_is_enabled_while_its_field_counts(start, photo):
    """Each field that needs another one follows it, whichever control it has."""
    driver = start(photo)
    panel = driver.panel("recipe")
    # A centre is always within reach: a click switches to the scope that uses one.
    dependent = [one for one in SETTINGS.values() if one.needs and one.name != "center"]
    assert len(dependent) >= 2
    for scope_name, lens in (("head", "off"), ("face", 26.0), ("head", 26.0)):
        for field, value in (("scope", scope_name), ("lens", lens)):
            driver.set(field, value)
        for setting in dependent:
            counts = setting.counts(driver.state.recipe)
            assert panel.controls[setting.name].isEnabled() == counts, setting.name
        assert panel.centre.isEnabled()


@pytest.mark.parametrize("workspace", ["retouch", "inspect"])
def test_a_click_on_a_centre_uses_it_for_the_face_only_as_one_step(start, photo, workspace):
    driver = start(photo, workspace=workspace)
    panel = driver.panel("recipe")
    before = driver.state
    assert before.recipe.scope == "head"
    assert panel.centre.group.checkedId() == -1, "with the head, no centre is in use"
    assert panel.centre.value.text() == "\N{EN DASH}"
    fourth = panel.centre.group.button(4)
    assert "Face only" in fourth.toolTip()
    QTest.mouseClick(fourth, Qt.MouseButton.LeftButton)
    assert (driver.state.recipe.scope, driver.state.recipe.center) == ("face", 4)
    assert panel.centre.group.checkedId() == 4
    assert panel.centre.value.text() == {"retouch": "Nose", "inspect": "4.7 : 5.3"}[workspace]
    assert "Face only" not in fourth.toolTip()
    assert driver.editor.document.undo.count() == 1
    assert driver.editor.document.undo.undoText() == "Centre Head → Face only"
    driver.editor.document.undo.undo()
    assert driver.state == before
    assert panel.centre.group.checkedId() == -1


def test_each_face_may_have_its_own(two):
    recipe = two.editor.recipe
    recipe.choose(1)
    recipe.set_field("scope", "face")
    two.editor.document.commit()
    assert [two.state.recipe_of(k).scope for k in (0, 1)] == ["head", "face"]
    assert checked(two) == "face"
    recipe.choose(0)
    assert checked(two) == "head"


def test_the_rim_of_a_forehead_that_follows_is_shown(opened):
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

    def choose(value):
        opened.show("scope", value)

    choose("face")
    before = opened.shown.copy()
    assert not overlay_shows_there()
    choose("head")
    assert (opened.shown != before).any()
    assert overlay_shows_there()
    choose("face")
    np.testing.assert_array_equal(opened.shown, before)


def test_a_face_at_the_photos_edge_is_told_of_unless_it_is_left_as_it_is(start, photo, source):
    source.faces = [oval_face(center=(x, 180.0), size=0.4) for x in (40.0, 330.0)]
    driver = start(photo)
    note, rows = driver.panel("recipe").edge_note, driver.panel("faces")
    assert note.isVisible()
    assert note.text().startswith("1 face lies at the photo's edge")
    rows.item(0).setCheckState(Qt.CheckState.Unchecked)
    driver.settle()
    assert not note.isVisible(), "the other one is whole"
    rows.item(1).setCheckState(Qt.CheckState.Unchecked)
    driver.settle()
    assert not note.isVisible(), "nothing is made smaller"
    rows.item(0).setCheckState(Qt.CheckState.Checked)
    driver.settle()
    assert note.isVisible()
    driver.show("guard", False)
    assert not note.isVisible()


def test_a_preview_of_a_part_moves_as_the_whole_photo_does(source):
    surface = Surface(PicturePyramid(textured_photo()))
    held = Protection().with_stroke([(330.0, 180.0), (330.0, 260.0)], 8.0)
    state = State(faces=tuple(source.faces), recipe=Recipe(percent=8.0), protection=held)
    part = VisiblePart(0, Box(90, 110, 390, 340))  # its edge is nearer to the head than the photo's
    near, whole = surface.render(1, state, part), surface.render(2, state)
    anywhere = np.random.default_rng(5).uniform((100, 115), (380, 330), (200, 2))
    moves = {}
    for name, points in (("anywhere", anywhere), ("held", held.strokes[0].points_px)):
        moves[name] = near.rendering.field.at(near.to_photo.inverse(points)) * near.scale
        np.testing.assert_allclose(moves[name], whole.rendering.field.at(points), atol=1e-3)
    assert np.abs(moves["held"]).max() == 0.0
