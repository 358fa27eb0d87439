"""What there is to choose from is declared once: words, options, solvers and documents follow."""

import dataclasses
import re
from functools import cache
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from click.testing import CliRunner
from edges_along import held_along
from scenes import oval_face, textured_photo

from kogao_core.base.geometry import Box
from kogao_core.cli.commands import program
from kogao_core.faces.targets import center_candidates
from kogao_core.lab.methods import METHODS
from kogao_core.pipeline import render
from kogao_core.recipe import settings
from kogao_core.recipe.recipe import PAPER, SETTINGS, Recipe
from kogao_core.recipe.settings import CENTERS, DOMAINS, FITS, PAPER_CENTERS

EXPERIMENTS = Path(__file__).parents[2] / "docs" / "experiments.md"
WHERE = re.compile(r"(sections? \d\.\d(, \d\.\d)*|figure \d+[ab]?)?")
CHOSEN = [(s.name, one) for s in SETTINGS.values() for one in s.alternatives]


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


def other_value(setting, value):
    """Return a value of a field that isn't `value`."""
    if setting.within is not None:
        value = setting.within[1] if isinstance(value, str) else value
        return max(setting.within, key=lambda end: abs(end - value))
    return next(one for one in setting.choices or (True, False) if one != value)


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
