"""Every choice as one value that refuses nonsense in words."""

import dataclasses
import json
import math
from typing import Literal, Union, get_args, get_origin, get_type_hints

import click
import numpy as np
import pytest
from scenes import textured_photo

import kogao_core as kogao
from kogao_core.cli.commands import program
from kogao_core.recipe.recipe import LOSSLESS_PX, SETTINGS, VERSION, Recipe
from kogao_core.recipe.settings import CENTERS


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("percent", -16),
        ("percent", 99),
        ("percent", math.nan),
        ("percent", "4"),
        ("percent", True),
        ("center", 0),
        ("center", len(CENTERS) + 1),
        ("center", 2.5),
        ("lattice", 0),
        ("lattice", math.inf),
        ("lattice_unit", "miles"),
        ("fit", "guess"),
        ("domain", "everywhere"),
        ("threshold_px", -0.1),
        ("interpolation", "nearest"),
        ("guard", 1),
        ("scope", "nose"),
        ("even_out", None),
        *(("lens", value) for value in ("wide", 7.0, 2000.0, math.nan)),
    ],
)
def test_a_bad_value_is_refused_by_name(field, value):
    with pytest.raises(ValueError, match=field):
        Recipe(**{field: value})


def test_numbers_of_numpy_become_plain_ones():
    made = Recipe(percent=np.float32(6.5), center=np.int64(3), lattice=np.int16(2), width=5)
    assert made == Recipe(percent=6.5, center=3, lattice=2.0, width=5)
    numbers = {type(value) for value in made.to_dict().values() if not isinstance(value, str)}
    assert numbers == {int, float, bool}
    assert Recipe.from_dict(json.loads(json.dumps(made.to_dict()))) == made


def test_unknown_fields_and_newer_versions_are_refused():
    with pytest.raises(ValueError, match="percentage"):
        Recipe.from_dict({"percentage": 4})
    with pytest.raises(ValueError, match="version"):
        Recipe.from_dict({"version": VERSION + 1})
    with pytest.raises(ValueError, match="object"):
        Recipe.from_dict([4])


def test_only_a_threshold_with_a_fade_depends_on_the_scale():
    assert Recipe().at_scale(0.25) == Recipe()
    assert Recipe(threshold_px=1.0).at_scale(0.25).threshold_px == 0.25
    assert Recipe(threshold_px=0.03).at_scale(0.25).threshold_px == LOSSLESS_PX


# -- every field is declared once -----------------------------------------------------------------


def test_every_field_is_declared_with_the_choices_of_its_type():
    assert list(SETTINGS) == [field.name for field in dataclasses.fields(Recipe)]
    for name, kind in get_type_hints(Recipe).items():
        setting = SETTINGS[name]
        kinds = get_args(kind) if get_origin(kind) is Union else (kind,)
        names = [get_args(one) for one in kinds if get_origin(one) is Literal]
        assert setting.choices == (names[0] if names else ())
        assert (setting.within is not None) == bool({int, float} & set(kinds))
        assert setting.is_whole == (kind is int)
        setting.check(getattr(Recipe(), name))


@pytest.mark.parametrize("command", ["warp", "batch"])
@pytest.mark.parametrize("setting", SETTINGS.values(), ids=lambda setting: setting.name)
def test_every_field_has_an_option_with_its_choices(command, setting):
    option = next(p for p in program.every[command].params if p.name == setting.name)
    assert setting.help in option.help
    if setting.choices and setting.within is not None:
        assert option.metavar.split("|")[:-1] == list(setting.choices)
    elif setting.choices:
        assert isinstance(option.type, click.Choice)
        assert tuple(option.type.choices) == setting.choices


def other_than(setting, default):
    """Return another value of a field than its default."""
    if setting.within is not None:
        low, high = setting.within
        return high if default != high else low
    others = setting.choices or (True, False)
    return next(value for value in others if value != default)


@pytest.mark.parametrize("setting", SETTINGS.values(), ids=lambda setting: setting.name)
def test_whatever_becomes_of_a_face_is_told_and_how_is_not(setting):
    plain = Recipe(lens=26.0)  # without which its amount says nothing
    if not setting.counts(plain):
        plain = dataclasses.replace(plain, scope="face")
    other = dataclasses.replace(
        plain, **{setting.name: other_than(setting, getattr(plain, setting.name))}
    )
    assert (other.amount == plain.amount) == setting.is_method


def test_what_is_not_told_moves_nothing_of_itself():
    """A record of 0 % is true: no field that it leaves out moves a pixel then."""
    photo = textured_photo(320, 240, 3)
    faces, still = [kogao.template_face((160, 120), 120)], Recipe(percent=0)
    for setting in SETTINGS.values():
        if setting.is_method:
            value = other_than(setting, getattr(still, setting.name))
            recipe = dataclasses.replace(still, **{setting.name: value})
            np.testing.assert_array_equal(kogao.render(photo, faces, recipe).pixels, photo)
