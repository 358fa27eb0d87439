"""``kogao-cli presets``, and that its output is a file for ``--recipe``."""

import json

import pytest

from kogao_core.recipe import presets
from kogao_core.recipe.recipe import Recipe


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The user's folder, in a place of its own."""
    monkeypatch.setattr(presets, "data_folder", lambda: tmp_path / "data")
    return presets.user_folder()


def test_a_file_in_the_folder_is_a_preset(cli, folder):
    folder.mkdir(parents=True)
    (folder / "Soft.json").write_text('{"percent": 3}')
    *names, place = cli("presets")[1].splitlines()
    assert names == [*presets.BUILT_IN, "Soft"]
    assert place == f"Your presets: {folder}"
    assert Recipe.from_dict(json.loads(cli("presets", "--json")[1])["Soft"]).percent == 3
    assert json.loads(cli("presets", "Soft")[1])["percent"] == 3


def test_a_file_cannot_replace_a_built_in_preset(cli, folder):
    folder.mkdir(parents=True)
    (folder / "Subtle.json").write_text('{"percent": 9}')
    assert json.loads(cli("presets", "Subtle")[1])["percent"] == 4


def test_a_printed_preset_is_a_recipe_for_other_commands(works, tmp_path):
    file, small = tmp_path / "clear.json", tmp_path / "small.png"
    file.write_text(works("presets", "Subtle"))
    told = works("warp", "--sample", "-o", small, "--recipe", file, "--json", "-")
    assert json.loads(told)["recipe"]["percent"] == 4.0


@pytest.mark.parametrize("name", ["Nothing", "list"])
def test_an_unknown_preset_gets_one_sentence(fails, name):
    fails(2, f"no preset {name}; see kogao-cli presets", "presets", name)
