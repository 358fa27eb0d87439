"""The gauge: visibility beside the original, and the paper's survey where it applies."""

from dataclasses import replace

import pytest
from kogao_app.workspaces import WORKSPACES
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from kogao_core.additions.guard import Limit

pytestmark = pytest.mark.usefixtures("one_window")

KEYS = Qt.Key


def gauge(driver):
    return driver.panel("recipe").gauge


def is_speaking(driver):
    return bool(gauge(driver).seen.text() or gauge(driver).text.text())


def test_the_papers_choice_reads_zero_and_names_its_source(opened):
    opened.show("scope", "face")
    assert gauge(opened).text.text() == "0.0 % of answers: unnatural"
    for words in ("Table 1", "32 students", "25 faces", "past the targets by about 13 %"):
        assert words in gauge(opened).text.toolTip()
    for words in ("2024", "220 raters", "15 % in ears", "2008", "61.7 %"):
        assert words in gauge(opened).seen.toolTip()


def test_visibility_has_three_grades_by_the_studies(opened):
    """Of the moves that are made: the photo's edge and heads in front take some of the amount."""
    opened.show("scope", "face")
    seen = gauge(opened).seen
    for percent, words in (
        (4.9, "Subtle: fewer than half"),
        (5.0, "Visible: half of viewers notice"),
        (7.9, "Visible: half of viewers notice"),
        (8.0, "Strong: 62 % call it clearly different"),
    ):
        opened.show("percent", percent)
        assert words in seen.text(), percent


def test_the_survey_follows_distance_and_centre_and_warns_above_six_percent(opened):
    opened.show("scope", "face")
    text = gauge(opened).text
    for percent, words in (
        (6.0, "5.0 % of answers: unnatural"),
        (1.0, "At most 0.6 % of answers: unnatural"),
        (15.0, "⚠ At least 70 % of answers: unnatural"),
    ):
        opened.show("percent", percent)
        assert (text.text(), text.warns) == (words, percent > 6.0)
    opened.show("percent", 6.0)
    QTest.mouseClick(opened.panel("recipe").centre.group.button(4), Qt.MouseButton.LeftButton)
    opened.settle()
    assert "6.8 %" in text.text()
    opened.show("lattice", 0.25)
    assert text.text() == "⚠ Table 1 doesn't apply: outline bent between landmarks"


def test_it_is_silent_where_its_sources_say_nothing(opened):
    for field, value in (("scope", "head"), ("percent", 8.0)):
        opened.show(field, value)
    assert gauge(opened).seen.text()
    assert not gauge(opened).text.text(), "the survey showed the face alone"
    opened.show("jaw_width", -4.0)
    assert not is_speaking(opened), "no figure for parts of the face"
    opened.show("jaw_width", 0.0)
    assert is_speaking(opened)
    for percent in (0.0, -4.0):
        opened.show("percent", percent)
        assert not is_speaking(opened)


def test_without_an_active_face_there_is_none(opened):
    assert is_speaking(opened)
    opened.panel("faces").item(0).setCheckState(Qt.CheckState.Unchecked)
    opened.settle()
    assert not is_speaking(opened)


@pytest.mark.parametrize("workspace", WORKSPACES)
def test_the_controls_below_stay_whatever_is_read(start, photo, workspace):
    driver = start(photo, workspace=workspace)
    panel = driver.panel("recipe")

    def top():
        driver.settle()
        for _ in range(3):  # nested layouts pass on a new height one event at a time
            QApplication.processEvents()
        return panel.scope.mapTo(driver.window, QPoint()).y()

    for scope in ("head", "face"):
        driver.editor.manual.switch("automatic")
        driver.set("scope", scope)
        before = top()
        frame = driver.editor.view.frame
        limits = (Limit(0.4, tuple(driver.state.faces[0].outline[4])),)
        panel.show_frame(replace(frame, rendering=replace(frame.rendering, limits=limits)))
        panel.mark_readings(final=True)
        assert "40 %" in panel.one_to_one.text()
        assert top() == before
        driver.editor.manual.switch("manual")
        driver.show("scope", scope)
        assert not is_speaking(driver)
        assert top() == before


def test_all_faces_means_those_without_settings_of_their_own(two):
    two.show("scope", "face")
    two.show("percent", 4.0)
    two.editor.recipe.choose(1)
    two.show("percent", 10.0)
    assert gauge(two).text.warns
    two.editor.recipe.choose(None)
    assert gauge(two).text.text() == "0.0 % of answers: unnatural", "as the slider above it"
    assert not gauge(two).text.warns
    two.editor.recipe.choose(1)
    two.panel("faces").item(1).setCheckState(Qt.CheckState.Unchecked)
    two.settle()
    assert not is_speaking(two), "this face is switched off"


def test_what_was_achieved_stands_under_it_and_the_papers_fit_goes_past(opened):
    opened.show("scope", "face")
    opened.settle()
    recipe = opened.panel("recipe")
    assert recipe.residual.text().startswith("achieved 4.00 % of D\n")
    recipe.choices["fit"].setCurrentIndex(recipe.choices["fit"].findData("approximation"))
    opened.settle()
    (achieved,) = opened.editor.view.frame.rendering.achieved
    assert achieved > 4.2
    assert recipe.residual.text().startswith(f"achieved {achieved:.2f} % of D\n")
