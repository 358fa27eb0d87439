"""The naturalness gauge says what Table 1 says, of faces that move alone, and warns above 6 %."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from test_gestures import slider

pytestmark = pytest.mark.usefixtures("one_window")

KEYS = Qt.Key


def gauge(driver):
    return driver.panel("recipe").gauge


def move_alone(driver):
    """Let faces move alone, as those of the survey did."""
    for field, value in (("head_follows", 0.0), ("keep_features", False)):
        driver.editor.recipe.set_field(field, value)
        driver.editor.document.commit()


def test_the_papers_choice_reads_zero_and_names_its_source(opened):
    move_alone(opened)
    assert gauge(opened).text.text() == "0.0 % found it unnatural"
    for words in ("Table 1", "32 students", "25 faces", "past the targets by about 13 %"):
        assert words in gauge(opened).toolTip()


def test_it_follows_distance_and_centre_and_warns_above_six_percent(opened):
    move_alone(opened)
    opened.press_key(slider(opened), KEYS.Key_PageUp, times=2)
    assert gauge(opened).text.text() == "5.0 % found it unnatural"
    opened.press_key(slider(opened), KEYS.Key_Right)
    assert gauge(opened).text.text().startswith("⚠")
    assert gauge(opened).text.warns
    opened.press_key(slider(opened), KEYS.Key_Left)
    assert not gauge(opened).text.warns
    QTest.mouseClick(opened.panel("recipe").centre.group.button(4), Qt.MouseButton.LeftButton)
    assert "6.8 %" in gauge(opened).text.text()


def test_beyond_the_table_it_says_at_least_or_at_most(opened):
    move_alone(opened)
    opened.press_key(slider(opened), KEYS.Key_End)
    assert gauge(opened).text.text() == "⚠ ≥ 70 % found it unnatural"
    opened.press_key(slider(opened), KEYS.Key_Home)
    assert gauge(opened).text.text() == "nothing moves"
    opened.press_key(slider(opened), KEYS.Key_PageUp)
    assert gauge(opened).text.text() == "≤ 0.6 % found it unnatural"


def test_of_single_parts_it_says_that_nobody_was_asked(opened):
    move_alone(opened)
    opened.editor.recipe.set_field("percent", 0.0)
    opened.editor.recipe.set_field("jaw_width", -12.0)
    assert gauge(opened).text.text() == "parts move: nobody was asked"
    assert gauge(opened).blocks._percent == 0.0
    opened.editor.recipe.set_field("jaw_width", 0.0)
    assert gauge(opened).text.text() == "nothing moves"


def test_without_an_active_face_there_is_none(opened):
    assert gauge(opened).isVisible()
    opened.panel("faces").item(0).setCheckState(Qt.CheckState.Unchecked)
    assert not gauge(opened).isVisible()


def test_it_tells_of_the_selected_face_and_of_all_faces_the_worst(two):
    move_alone(two)
    recipe = two.editor.recipe
    for face, percent in enumerate((3.0, 7.0)):
        recipe.choose(face)
        recipe.set_field("percent", percent)
        two.editor.document.commit()
    worst = gauge(two).text.text()
    assert worst.startswith("⚠")
    recipe.choose(0)
    assert gauge(two).text.text() == "0.3 % found it unnatural"
    assert not gauge(two).text.warns
    recipe.choose(None)
    assert gauge(two).text.text() == worst
    assert gauge(two).text.warns
    recipe.choose(1)
    two.panel("faces").item(1).setCheckState(Qt.CheckState.Unchecked)
    assert not gauge(two).isVisible(), "it is left as it is"


def test_the_blocks_fill_and_turn_to_the_warning_colour(opened):
    move_alone(opened)
    calm = gauge(opened).blocks.grab().toImage()
    opened.press_key(slider(opened), KEYS.Key_PageUp, times=4)
    alarmed = gauge(opened).blocks.grab().toImage()
    assert alarmed.pixelColor(5, 5).name() == "#d55e00"
    assert calm.pixelColor(5, 5) != alarmed.pixelColor(5, 5)
    assert calm.pixelColor(29, 5) == alarmed.pixelColor(53, 5), "not reached, both empty"


def test_what_was_achieved_stands_under_it_and_the_papers_fit_goes_past(opened):
    move_alone(opened)
    opened.settle()
    recipe = opened.panel("recipe")
    assert recipe.residual.text().startswith("achieved 4.00 % of D\n")
    recipe.choices["fit"].setCurrentIndex(recipe.choices["fit"].findData("approximation"))
    opened.settle()
    (achieved,) = opened.editor.view.frame.rendering.achieved
    assert achieved > 4.2
    assert recipe.residual.text().startswith(f"achieved {achieved:.2f} % of D\n")


def test_where_more_than_the_face_moves_it_says_whose_figure_that_is_and_warns_of_nothing(opened):
    for field, value in (("head_follows", 30.0), ("keep_features", False), ("percent", 8.0)):
        opened.editor.recipe.set_field(field, value)
        opened.editor.document.commit()
    assert gauge(opened).text.text() == "the face alone: 29.4 % found it unnatural"
    assert "nobody was asked about such pictures" in gauge(opened).toolTip()
    assert not gauge(opened).text.property("warn")
    assert gauge(opened).accessibleDescription() == gauge(opened).text.text()
    opened.editor.recipe.set_field("head_follows", 0.0)
    opened.editor.document.commit()
    assert gauge(opened).text.text() == "⚠ 29.4 % found it unnatural"
    assert "nobody was asked" not in gauge(opened).toolTip()
    opened.editor.recipe.set_field("keep_features", True)
    opened.editor.document.commit()
    assert gauge(opened).text.text().startswith("the face alone: ")


def test_a_face_that_gets_larger_is_judged_by_nobody(opened):
    field = opened.panel("recipe").percent.field
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "-4")
    QTest.keyClick(field, Qt.Key.Key_Return)
    opened.settle()
    assert opened.state.recipe.percent == -4.0
    assert field.text().startswith("-4")
    gauge = opened.panel("recipe").gauge
    assert gauge.text.text() == "larger: nobody was asked"
    opened.press_key(opened.panel("recipe").percent.slider, Qt.Key.Key_PageUp)
    assert opened.state.recipe.percent > 0.0
