"""The editor has words and a place for every field of the recipe, and for every choice of one."""

import dataclasses
from gettext import NullTranslations
from types import SimpleNamespace

import pytest
from kogao_app.features.recipe import fields
from kogao_app.features.recipe.panel import RecipePanel
from kogao_app.i18n import bare
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QCheckBox
from scenes import oval_face, textured_photo

from kogao_core.base import language
from kogao_core.faces.landmarks import CHOICES
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import SETTINGS, Recipe
from kogao_core.recipe.settings import CENTERS

pytestmark = pytest.mark.usefixtures("one_window")


@pytest.mark.parametrize(
    ("shares", "said"),
    [
        ((0.4,), "⚠ Held back to 40 %:"),
        ((1.0, 0.75, 0.4), "⚠ Held back: faces 2, 3, down to 40 %;"),
        ((1.0, 1.0), ""),
    ],
)
def test_in_everyday_words_it_says_how_many_faces_are_held_back(panel, shares, said):
    faces = [oval_face(center=(100.0 + 300.0 * k, 150.0), size=0.5) for k in range(len(shares))]
    rendering = dataclasses.replace(
        render(textured_photo(800, 300), faces, Recipe()), shares=shares
    )
    panel.show_words(plain=True)
    panel.show_frame(SimpleNamespace(rendering=rendering, scale=1.0))
    panel.mark_readings(final=True)
    assert panel.one_to_one.text().partition(" more")[0] == said


@pytest.fixture
def panel(qtbot):
    made = RecipePanel(lambda *_: None, lambda: None, lambda _: None)
    qtbot.addWidget(made)
    return made


def test_every_field_has_a_control_and_a_name_for_undo(panel):
    controls = [*panel.sliders, *panel.choices, *panel.switches, "center", "lens"]
    assert sorted(controls) == sorted(SETTINGS)
    assert all(fields.title(field) for field in SETTINGS)


def test_every_control_has_a_key_of_its_own_and_tells_what_it_does(panel):
    # Parts of the face share a key that leads into their fold: there aren't letters for each.
    shared = {*fields.FOLDED_PARTS, "interpolation"}
    labels = [fields.label(field) for field in SETTINGS if field not in shared]
    labels += [panel.zones.button.text(), panel.sliders["jaw_width"].title.text()]
    assert all(label.count("&") == 1 for label in labels)
    keys = [label[label.index("&") + 1].lower() for label in labels]
    assert len(set(keys)) == len(keys)
    sliders = {field: slider.slider for field, slider in panel.sliders.items()}
    for field, control in {**sliders, **panel.choices, **panel.switches}.items():
        assert SETTINGS[field].help in control.toolTip()
        assert SETTINGS[field].where in control.toolTip()
        assert control.accessibleName() or control.text()


class Marked(NullTranslations):
    """A catalogue that shows what it was asked for."""

    def gettext(self, message):
        return f"«{message}»"


@pytest.mark.usefixtures("english")
def test_declared_words_are_translated(start):
    language.use_catalogue("xx", Marked())
    driver = start()
    for field, setting in SETTINGS.items():
        assert fields.title(field) == f"«{setting.title}»"
        assert f"«{setting.help}»" in fields.tip(field)
    for field, box in driver.panel("recipe").choices.items():
        for place, one in enumerate(SETTINGS[field].alternatives):
            assert f"«{one.title}»" in box.itemText(place)
            assert f"«{one.help}»" in box.itemText(place)
    texts = [bare(action.text()) for action in driver.window.actions_by_name.values()]
    assert all(any(f"«{choice.title}»" in text for text in texts) for choice in CHOICES)


def test_what_belongs_to_a_photo_waits_for_one_and_what_a_user_prefers_does_not(empty, photo):
    recipe, protect = empty.panel("recipe"), empty.panel("protect")
    by_photo = [
        *(recipe.percent.slider, recipe.lattice.slider, recipe.centre, protect.size_px.slider),
        *(recipe.switches["zones"], recipe.switches["guard"], recipe.choices["fit"]),
    ]
    names = (
        *("save", "save-project", "import-landmarks", "export-figure", "find", "place"),
        *("fit", "actual", "closer", "farther", "paste-settings", "smaller", "larger"),
    )
    actions = [empty.window.actions_by_name[name] for name in names]
    preferred = [recipe.zones.button, recipe.fold.button, protect.hard]
    preferred += empty.panel("overlays").findChildren(QCheckBox)
    assert len(preferred) > 10
    for one in preferred:
        assert one.isEnabled(), one.text()
    assert not any(one.isEnabled() for one in (*by_photo, *actions))
    empty.open(photo)
    assert all(one.isEnabled() for one in (*by_photo, *actions))


def test_every_choice_has_an_entry_with_words_in_its_box(panel):
    for field, box in panel.choices.items():
        entries = {box.itemData(k): box.itemText(k) for k in range(box.count())}
        assert entries.keys() == set(SETTINGS[field].choices)
        assert all(entries.values())
        assert len(set(entries.values())) == box.count()
        assert box.toolTip()


def test_the_buttons_of_many_centres_give_way(qtbot, monkeypatch):
    monkeypatch.setattr(fields, "CENTERS", CENTERS * 3)
    made = fields.CenterChoice()
    qtbot.addWidget(made)
    assert len(made.group.buttons()) == 3 * len(CENTERS)
    assert made.minimumSizeHint().width() < 0.8 * made.sizeHint().width()


def test_sliders_and_buttons_stay_within_the_ranges(panel):
    for field in panel.sliders:
        scale = fields.scale(field)
        low, high = SETTINGS[field].within
        assert low <= scale.value(scale.low) < scale.value(scale.high) <= high
    assert len(panel.centre.group.buttons()) == len(CENTERS) == SETTINGS["center"].within[1]


def test_more_has_a_key_that_leads_into_it_and_back(opened):
    panel = opened.panel("recipe")
    opened.window.activateWindow()
    opened.qtbot.waitUntil(opened.window.isActiveWindow)
    both = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier
    for workspace in ("retouch", "compare"):
        opened.window.actions_by_name[f"workspace-{workspace}"].trigger()
        assert not panel.zones.button.isVisible()
        opened.key(Qt.Key.Key_M, both)
        assert panel.zones.button.isVisible()
        assert panel.centre.group.checkedButton().hasFocus()
        opened.key(Qt.Key.Key_M, both)
        assert not panel.zones.button.isVisible()
        assert panel.percent.slider.hasFocus()
    opened.window.actions_by_name["workspace-inspect"].trigger()
    opened.key(Qt.Key.Key_M, both)
    assert panel.zones.button.isVisible(), "there it always is"
    assert panel.centre.group.checkedButton().hasFocus()
