"""A recipe refuses nonsense in words; each choice is declared once, and the rest follows."""

import dataclasses
import json
import math
import re
from functools import cache
from pathlib import Path
from typing import Literal, Union, get_args, get_origin, get_type_hints

import click
import numpy as np
import pytest
from click.testing import CliRunner
from edges_along import held_along
from scenes import oval_face, textured_photo

import kogao_core as kogao
from kogao_core.base.geometry import Box
from kogao_core.cli.commands import program
from kogao_core.faces.targets import center_candidates
from kogao_core.lab.methods import METHODS
from kogao_core.pipeline import render
from kogao_core.recipe import settings
from kogao_core.recipe.recipe import LOSSLESS_PX, PAPER, SETTINGS, VERSION, Recipe
from kogao_core.recipe.settings import CENTERS, DOMAINS, FITS, PAPER_CENTERS

EXPERIMENTS = Path(__file__).parents[2] / "docs" / "experiments.md"
WHERE = re.compile(r"(sections? \d\.\d(, \d\.\d)*|figure \d+[ab]?)?")
CHOSEN = [(s.name, one) for s in SETTINGS.values() for one in s.alternatives]


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


def other_value(setting, value):
    """Return a value of a field that isn't `value`."""
    if setting.within is not None:
        value = setting.within[1] if isinstance(value, str) else value
        return max(setting.within, key=lambda end: abs(end - value))
    return next(one for one in setting.choices or (True, False) if one != value)


@pytest.mark.parametrize("setting", SETTINGS.values(), ids=lambda setting: setting.name)
def test_whatever_becomes_of_a_face_is_told_and_how_is_not(setting):
    plain = Recipe(lens=26.0)  # without which its amount says nothing
    if not setting.counts(plain):
        plain = dataclasses.replace(plain, scope="face")
    other = dataclasses.replace(
        plain, **{setting.name: other_value(setting, getattr(plain, setting.name))}
    )
    assert (other.amount == plain.amount) == setting.is_method


def test_what_is_not_told_moves_nothing_of_itself():
    """A record of 0 % is true: no field that it leaves out moves a pixel then."""
    photo = textured_photo(320, 240, 3)
    faces, still = [kogao.template_face((160, 120), 120)], Recipe(percent=0)
    for setting in SETTINGS.values():
        if setting.is_method:
            value = other_value(setting, getattr(still, setting.name))
            recipe = dataclasses.replace(still, **{setting.name: value})
            np.testing.assert_array_equal(render(photo, faces, recipe).pixels, photo)


@pytest.mark.parametrize(
    ("declared", "kind"),
    [
        (FITS, settings.Fit),
        (DOMAINS, settings.DomainName),
        (settings.INTERPOLATIONS, settings.Interpolation),
        (settings.LATTICE_UNITS, settings.LatticeUnit),
        (settings.LENSES, settings.LensName),
    ],
)
def test_each_name_of_the_type_is_declared_in_its_order(declared, kind):
    assert tuple(one.name for one in declared) == get_args(kind)


def test_all_have_words_and_a_place_in_the_paper_or_none():
    for setting in SETTINGS.values():
        titles = [one.title for one in setting.alternatives]
        assert len(set(titles)) == len(titles)
        for one in (setting, *setting.alternatives):
            assert one.title[0].isupper()
            assert one.help
            assert not one.help.endswith(".")
            assert WHERE.fullmatch(one.where)
    assert all(WHERE.fullmatch(center.where) for center in CENTERS)
    assert all(fit.reference for fit in FITS)


def test_help_says_what_each_choice_is():
    said = " ".join(CliRunner().invoke(program, ["warp", "--help"]).output.split())
    for field, one in CHOSEN:
        option = said[said.index(f"--{field.replace('_', '-')} ") :]
        assert f"{one.name} ({one.help})" in option.partition(" --")[0]


@pytest.mark.parametrize(("field", "one"), CHOSEN, ids=lambda it: getattr(it, "name", it))
def test_each_choice_warps(field, one):
    photo, face = textured_photo(240, 180), oval_face(240, 180)
    rendering = render(photo, [face], Recipe(**{field: one.name}))
    assert (rendering.pixels != photo).any()
    assert rendering.achieved[0] == pytest.approx(6.0, abs=0.6)


@cache
def outcome(recipe):
    """Return the pixels and the domain of a face beside a line."""
    photo, face = textured_photo(240, 180), oval_face(240, 180, forehead=True)
    face = face.with_outline_point(5, face.outline[5] - (3.0, 0.0))  # uneven, to be evened out
    held = held_along([[(180.0, 10.0), (180.0, 170.0)]], [face])
    rendering = render(photo, [face], recipe, held=held)
    return rendering.pixels.tobytes(), rendering.domain.mask(Box.of(photo)).tobytes()


@pytest.mark.parametrize("setting", SETTINGS.values(), ids=lambda setting: setting.name)
def test_every_field_has_a_say_in_what_is_rendered(setting):
    def matters(recipe):
        other = other_value(setting, getattr(recipe, setting.name))
        return outcome(dataclasses.replace(recipe, **{setting.name: other})) != outcome(recipe)

    # So large a move on so fine a lattice folds: otherwise the guard has nothing to do.
    bases = Recipe(), Recipe(percent=12.0, lattice=0.25), PAPER, Recipe(lens=20.0)
    assert any(map(matters, bases))


def test_the_papers_centres_come_first_and_each_lies_between_eyes_and_mouth():
    assert CENTERS[: len(PAPER_CENTERS)] == PAPER_CENTERS
    assert all(center.where == "figure 7a" for center in PAPER_CENTERS)
    face = oval_face()
    down = (center_candidates(face) - face.eye_center) @ (face.mouth_center - face.eye_center)
    share = down / ((face.mouth_center - face.eye_center) ** 2).sum()
    np.testing.assert_allclose(share, [center.fraction for center in CENTERS])
    assert all(0.0 <= center.fraction <= 1.0 for center in CENTERS)


def test_methods_and_their_table_name_every_fit():
    table = EXPERIMENTS.read_text(encoding="utf-8")
    for fit in FITS:
        method = next(method for method in METHODS if method.name == fit.name)
        assert f"| {method.title} | {fit.reference} |" in table
