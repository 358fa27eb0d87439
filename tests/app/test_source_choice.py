"""Which source finds the faces is the user's choice."""

import pytest

from kogao_core.base import assets
from kogao_core.faces.landmarks import CHOICES

pytestmark = pytest.mark.usefixtures("one_window")


@pytest.fixture
def networks():
    for name in ("models/face_detection_back.tflite", "models/aam.npz"):
        try:
            assets.path(name)
        except assets.AssetMissing as missing:
            pytest.skip(str(missing))


def test_the_choices_stand_in_the_menu_with_their_figures(opened):
    for choice in CHOICES:
        action = opened.window.actions_by_name[f"landmarks-{choice.name}"]
        if choice.measured is not None:
            assert f"{choice.measured.wild_jaw:g} %" in action.toolTip()
        assert not action.shortcut().isEmpty()


@pytest.mark.usefixtures("networks")
def test_another_source_finds_the_faces_again(opened):
    opened.editor.files.open_sample()
    opened.settle()
    for name in ("aam", "mesh"):
        opened.window.actions_by_name[f"landmarks-{name}"].trigger()
        opened.settle()
        assert [face.source for face in opened.state.faces] == [name]
        assert opened.window.actions_by_name[f"landmarks-{name}"].isChecked()


def test_without_the_networks_it_is_said_once_that_the_aam_stands_in(source, start, monkeypatch):
    monkeypatch.setattr("kogao_app.features.landmarks.networks_are_here", lambda: False)
    source.name = "aam"
    driver = start()
    for _ in range(2):
        driver.editor.files.open_sample()
        driver.settle()
        said = driver.say()
        driver.window.bar.clear()
    assert said == ""
    driver = start()
    driver.editor.files.open_sample()
    driver.settle()
    assert "networks are missing" in driver.say()
