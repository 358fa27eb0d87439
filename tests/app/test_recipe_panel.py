"""The editor has words and a place for every field of the recipe, and for every choice of one."""

import pytest
from kogao_app.controllers import choices
from kogao_app.panels import fields
from kogao_app.panels.recipe import RecipePanel

from kogao_core.recipe import CENTERS, SETTINGS

# For recipes from elsewhere; the lattice's note shows the spacing in both units.
WITHOUT_A_CONTROL = {"lattice_unit"}


@pytest.fixture
def panel(qtbot):
    made = RecipePanel()
    qtbot.addWidget(made)
    return made


def test_every_field_has_a_control_and_a_name_for_undo(panel):
    sliders = {"percent", "lattice", "threshold_px"}
    assert {*panel.choices, *sliders, "center", "guard"} | WITHOUT_A_CONTROL == set(SETTINGS)
    assert all(choices.gesture_name(field) for field in SETTINGS)


def test_every_choice_has_an_entry_with_words_in_its_box(panel):
    for field, box in panel.choices.items():
        entries = {box.itemData(k): box.itemText(k) for k in range(box.count())}
        assert entries.keys() == set(SETTINGS[field].choices)
        assert all(entries.values())
        assert len(set(entries.values())) == box.count()
        assert box.toolTip()


def test_sliders_and_buttons_stay_within_the_ranges(panel):
    scales = {
        "percent": fields.percent(),
        "lattice": fields.lattice(),
        "threshold_px": fields.threshold(),
    }
    for field, scale in scales.items():
        low, high = SETTINGS[field].within
        assert low <= scale.value(scale.low) < scale.value(scale.high) <= high
    assert len(panel.centre.buttons) == len(CENTERS) == SETTINGS["center"].within[1]
