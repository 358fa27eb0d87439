"""Presets are files: any name, any folder, any content, and nothing lost."""

import os

import numpy as np
import pytest
from scenes import oval_face, textured_photo

from kogao_core.pipeline import render
from kogao_core.recipe import presets
from kogao_core.recipe.recipe import Recipe

SIX = Recipe(percent=6.0)
PHOTO, FACE = textured_photo(), oval_face(forehead=True)


@pytest.mark.parametrize(
    "name",
    [
        "Wedding",
        "a/b\\c",
        "..",
        ".hidden",
        "小顔",
        "4 %",
        "100%25",
        'Ann@home\\ "é", (1)',
        "é" * 60,
    ],
)
def test_any_name_that_prints_comes_back_from_a_file_of_the_folder(tmp_path, name):
    presets.add(tmp_path, name, Recipe())
    presets.add(tmp_path, name, SIX)
    assert presets.listed(tmp_path) == {name: SIX}
    assert len(list(tmp_path.iterdir())) == 1, "in place of the first, and nowhere else"
    presets.remove(tmp_path, name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["", "  ", "x" * 61, "a\nb", "\ud800"])
def test_what_cannot_be_a_name_is_refused_before_anything_is_written(tmp_path, name):
    with pytest.raises(ValueError, match="a preset's name has 1 to 60 letters"):
        presets.add(tmp_path / "new", name, SIX)
    assert not (tmp_path / "new").exists()


def test_files_that_this_program_cannot_read_are_left_out_and_left_alone(tmp_path):
    presets.add(tmp_path, "Mine", SIX)
    strange = {"newer.json": b'{"version": 9}', "deep.json": b"[" * 99999, "other.txt": b"{}"}
    for name, data in strange.items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / "folder.json").mkdir()
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.json")
    assert presets.listed(tmp_path) == {"Mine": SIX}
    presets.add(tmp_path, "Other", SIX)
    presets.remove(tmp_path, "Other")
    assert {name: (tmp_path / name).read_bytes() for name in strange} == strange


@pytest.mark.parametrize("name", ["none", "out of the system's reach" * 20])
def test_there_are_none_without_a_folder(tmp_path, name):
    assert presets.listed(tmp_path / name) == {}
    presets.remove(tmp_path / "none", "Mine")


def test_the_program_comes_with_presets_of_names_that_files_can_have(tmp_path):
    for name, recipe in presets.BUILT_IN.items():
        presets.add(tmp_path, name, recipe)
    assert presets.listed(tmp_path) == presets.BUILT_IN


def test_every_preset_has_an_effect_of_its_own():
    """None is a twin of another, and none leaves the default face as it is."""
    recipes = [*presets.BUILT_IN.values()]
    field = [tuple(render(PHOTO, [FACE], it).field.at(FACE.points).ravel()) for it in recipes]
    assert len(set(field)) == len(recipes)
    assert all(np.abs(moves).max() > 0.5 for moves in field)
