"""``kogao-cli presets``, and that its files are those of ``--recipe``."""

import json

import pytest

from kogao_core.recipe import presets
from kogao_core.recipe.recipe import Recipe


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The user's folder, in a place of its own."""
    monkeypatch.setattr(presets, "data_folder", lambda: tmp_path / "data")
    return presets.user_folder()


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "Soft.json"
    path.write_text('{"percent": 3}')
    return path


def test_a_preset_goes_in_is_listed_shown_and_goes_out(cli, file, tmp_path, folder):
    assert cli("presets", "import", file) == (0, "Soft\n", "")
    assert cli("presets", "list")[1].splitlines() == [*presets.BUILT_IN, "Soft"]
    assert Recipe.from_dict(json.loads(cli("presets", "list", "--json")[1])["Soft"]).percent == 3
    assert json.loads(cli("presets", "show", "Soft")[1])["percent"] == 3
    out = tmp_path / "out.json"
    assert cli("presets", "export", "Soft", "-o", out)[0] == 0
    assert presets.read(out) == presets.listed(folder)["Soft"] == Recipe(percent=3)
    assert cli("presets", "export", "Soft", "-o", out)[0] == 2, "never over a file"
    assert cli("presets", "export", "The paper's", "-o", out, "--force")[0] == 0


def test_an_export_is_a_recipe_for_other_commands(works, tmp_path):
    out, small = tmp_path / "clear.json", tmp_path / "small.png"
    works("presets", "export", "Subtle", "-o", out)
    told = works("warp", "--sample", "-o", small, "--recipe", out, "--json", "-")
    assert json.loads(told)["recipe"]["percent"] == 4.0


def test_a_preset_is_replaced_only_when_told_to(cli, file, folder):
    cli("presets", "import", file)
    file.write_text('{"percent": 9}')
    assert cli("presets", "import", file)[0] == 2
    assert presets.listed(folder)["Soft"].percent == 3
    assert cli("presets", "import", file, "--force")[0] == 0
    assert presets.listed(folder)["Soft"].percent == 9


def test_of_files_one_of_which_is_none_nothing_is_taken(fails, file, tmp_path, folder):
    (tmp_path / "odd.json").write_text('{"percent": 99}')
    fails(2, "odd.json.*percent must be", "presets", "import", file, tmp_path / "odd.json")
    assert not folder.exists()


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("show", "Nothing"), 2, "no preset Nothing; see kogao-cli presets list"),
        (("export", "Nothing", "-o", "x.json"), 2, "no preset Nothing"),
        (("import", "missing.json"), 2, "can't be read"),
        (("import", "Soft.json", "--name", "The paper's"), 2, "is a built-in preset"),
        (("import", "Soft.json", "--name", ""), 2, "1 to 60 letters"),
        (("import", "Soft.json", "a.json", "--name", "Both"), 2, "import one file"),
        (("export", "The paper's", "-o", "none/x.json"), 3, "can't be written"),
    ],
)
def test_wrong_calls_get_one_sentence(fails, file, monkeypatch, arguments, code, words):
    monkeypatch.chdir(file.parent)
    fails(code, words, "presets", *arguments)
