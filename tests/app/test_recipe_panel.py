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

from kogao_core.additions.guard import Limit
from kogao_core.base import language
from kogao_core.faces.landmarks import CHOICES
from kogao_core.pipeline import measure, render
from kogao_core.recipe.recipe import SETTINGS, Recipe
from kogao_core.recipe.settings import CENTERS

pytestmark = pytest.mark.usefixtures("one_window")


@pytest.mark.parametrize(
    ("shares", "said"),
    [
        ((0.4,), "⚠ Limited to 40 %:"),
        ((1.0, 0.75, 0.4), "⚠ Reduced in faces 2, 3, down to 40 %."),
        ((1.0, 1.0), ""),
    ],
)
def test_it_says_in_everyday_words_which_faces_are_reduced(panel, shares, said):
    faces = [oval_face(center=(100.0 + 300.0 * k, 150.0), size=0.5) for k in range(len(shares))]
    rendering = dataclasses.replace(
        render(textured_photo(800, 300), faces, Recipe()),
        limits=tuple(
            Limit(share, tuple(face.outline[4])) for share, face in zip(shares, faces, strict=True)
        ),
    )
    panel.show_words(plain=True)
    figures = measure(rendering, counts=False)
    panel.show_frame(SimpleNamespace(rendering=rendering, figures=figures, scale=1.0))
    panel.mark_readings(final=True)
    assert panel.one_to_one.text().partition(" more")[0] == said


@pytest.fixture
def panel(qtbot):
    made = RecipePanel(lambda *_: None, lambda: None, lambda _: None)
    qtbot.addWidget(made)
    return made


def test_every_field_has_a_control_and_a_name_for_undo(panel):
    controls = [*panel.sliders, *panel.choices, *panel.switches, "center", "lens", "scope"]
    assert sorted(controls) == sorted(SETTINGS)
    assert all(fields.title(field) for field in SETTINGS)


def test_no_two_controls_have_the_same_key_and_each_tells_what_it_does(panel):
    labels = [fields.label(field) for field, setting in SETTINGS.items() if setting.letter]
    keys = [label[label.index("&") + 1].lower() for label in labels]
    assert len(keys) > 8
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
        plain = {"percent": "Amount", "lattice": "Falloff"}.get(field, setting.title)
        assert fields.title(field) == f"«{plain}»"
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
        *(recipe.percent.slider, recipe.lattice.slider, recipe.lens, protect.size_px.slider),
        *(recipe.switches["guard"], recipe.scope, recipe.choices["fit"]),
    ]
    names = (
        *("save", "save-project", "export-figure", "find", "place"),
        *("fit", "actual", "closer", "farther", "paste-settings", "smaller", "larger"),
        *("all-faces", "no-face", "invert-faces"),
    )
    actions = [empty.window.actions_by_name[name] for name in names]
    preferred = [recipe.shape.button, recipe.fold.button]
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
    opened.to_front()
    both = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier
    for workspace in ("retouch", "compare"):
        opened.window.actions_by_name[f"workspace-{workspace}"].trigger()
        assert not panel.lattice.isVisible()
        opened.key(Qt.Key.Key_M, both)
        assert panel.lattice.isVisible()
        assert panel.lattice.slider.hasFocus()
        opened.key(Qt.Key.Key_M, both)
        assert not panel.lattice.isVisible()
        assert panel.percent.slider.hasFocus()
    opened.window.actions_by_name["workspace-inspect"].trigger()
    opened.key(Qt.Key.Key_M, both)
    assert panel.lattice.isVisible(), "there it always is"
    assert panel.lattice.slider.hasFocus()
