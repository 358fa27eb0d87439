"""What goes along with a face, in the window: its slider, what is said of it, what is shown."""

import numpy as np
import pytest
from kogao_app.document import State
from kogao_app.render.live import Surface, VisiblePart
from kogao_app.render.pictures import PicturePyramid
from kogao_app.workspaces import RETOUCH, WORKSPACES
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from scenes import KnownFaces, oval_face, textured_photo
from test_mnemonics import doubled, letters_of
from test_view import picture

from kogao_core.base.geometry import Box
from kogao_core.recipe.recipe import Recipe


@pytest.fixture
def source():
    return KnownFaces(oval_face(center=(239.5, 210.0), size=0.45, forehead=True))


def follows(driver):
    return driver.panel("recipe").sliders["head_follows"]


@pytest.mark.parametrize(
    "workspace", [one.name for one in WORKSPACES.values() if "recipe" in one.panels]
)
def test_it_is_in_sight_below_the_amount_in_every_workspace(start, photo, workspace):
    driver = start(photo, workspace=workspace)
    panel = driver.panel("recipe")
    assert follows(driver).isVisible()
    assert follows(driver).y() > panel.percent.y()
    assert not follows(driver).y() > panel.more.y()
    # One letter each, whatever the words are.
    assert doubled(letters_of(driver.window)) == {}
    assert follows(driver).slider.accessibleName() == "Head follows"
    assert "0 % the face alone" in follows(driver).slider.toolTip()


def test_a_key_leads_to_it_and_a_page_is_one_step_with_a_name(start, photo):
    driver = start(photo, workspace=RETOUCH.name)
    before = driver.state.recipe.head_follows
    QTest.keyClick(driver.window, Qt.Key.Key_W, Qt.KeyboardModifier.AltModifier)
    assert follows(driver).slider.hasFocus()
    driver.press_key(follows(driver).slider, Qt.Key.Key_PageUp)
    assert driver.state.recipe.head_follows == before + 10.0
    step = f"Head follows {before:.1f} → {before + 10.0:.1f} %"
    assert driver.editor.document.undo.undoText() == step
    driver.key(Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert driver.state.recipe.head_follows == before


def test_whether_features_keep_their_shape_is_with_fit_and_quality(start, photo):
    driver = start(photo)
    panel = driver.panel("recipe")
    switch = panel.switches["keep_features"]
    panel.fold.button.setChecked(True)
    assert switch.isVisible()
    before = driver.state.recipe.keep_features
    switch.click()
    assert driver.state.recipe.keep_features is not before
    driver.key(Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert driver.state.recipe.keep_features is before


def test_each_face_may_have_its_own(two):
    recipe, first = two.editor.recipe, two.state.recipe.head_follows
    recipe.choose(1)
    recipe.set_field("head_follows", 100.0)
    two.editor.document.commit()
    assert [two.state.recipe_of(k).head_follows for k in (0, 1)] == [first, 100.0]
    assert follows(two).slider.amount() == 100.0
    recipe.choose(0)
    assert follows(two).slider.amount() == first


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

    def choose(**values):
        for field, value in values.items():
            opened.editor.recipe.set_field(field, value)
            opened.editor.document.commit()
        opened.settle()

    choose(head_follows=0.0, keep_features=False)
    before = opened.shown.copy()
    assert not overlay_shows_there()
    choose(head_follows=100.0)
    assert (opened.shown != before).any()
    assert overlay_shows_there()
    choose(head_follows=0.0)
    np.testing.assert_array_equal(opened.shown, before)


def test_a_face_at_the_photos_edge_is_told_of_while_it_lies_there(start, photo, source):
    source.faces = [oval_face(center=(40.0, 180.0), size=0.4)]
    driver = start(photo)
    panel = driver.panel("recipe")
    driver.settle()
    assert panel.edge_note.isVisible()
    assert panel.edge_note.text().startswith("1 face lies at the photo's edge")
    driver.editor.recipe.set_field("guard", False)
    driver.editor.document.commit()
    driver.settle()
    assert not panel.edge_note.isVisible()


def test_nothing_is_told_of_a_face_that_is_whole_or_left_as_it_is(start, photo, source):
    source.faces = [
        oval_face(center=(40.0, 180.0), size=0.4),
        oval_face(center=(330.0, 180.0), size=0.4),
    ]
    driver = start(photo)
    panel = driver.panel("recipe")
    driver.panel("faces").item(0).setCheckState(Qt.CheckState.Unchecked)
    driver.settle()
    assert not panel.edge_note.isVisible()
    driver.panel("faces").item(1).setCheckState(Qt.CheckState.Unchecked)
    driver.panel("faces").item(0).setCheckState(Qt.CheckState.Checked)
    driver.settle()
    assert panel.edge_note.isVisible()
    driver.panel("faces").item(0).setCheckState(Qt.CheckState.Unchecked)
    driver.settle()
    assert not panel.edge_note.isVisible(), "nothing is made smaller"


def test_a_preview_of_a_part_moves_as_the_whole_photo_does(source):
    surface = Surface(PicturePyramid(textured_photo()))
    recipe = Recipe(percent=8.0, head_follows=100.0)
    state = State(faces=tuple(source.faces), recipe=recipe)
    part = VisiblePart(0, Box(90, 110, 390, 340))  # its edge is nearer to the head than the photo's
    near, whole = surface.render(1, state, part), surface.render(2, state)
    points = np.random.default_rng(5).uniform((100, 115), (380, 330), (200, 2))
    np.testing.assert_allclose(
        near.rendering.field.at(near.to_photo.inverse(points)) * near.scale,
        whole.rendering.field.at(points),
        atol=1e-3,
    )


def test_paper_settings_are_shown_as_what_they_are(opened):
    menu = opened.window.menus["presets"]
    menu.aboutToShow.emit()
    next(one for one in menu.actions() if one.text() == "The paper's").trigger()
    assert follows(opened).slider.amount() == 0.0
    assert not opened.panel("recipe").switches["keep_features"].isChecked()
    assert opened.state.recipe.face_alone
