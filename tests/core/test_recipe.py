"""Every choice as one value that refuses nonsense in words."""

import json
import math

import pytest

from kogao_core.recipe import LOSSLESS_PX, PAPER, Recipe


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("percent", -1),
        ("percent", 99),
        ("percent", math.nan),
        ("percent", "4"),
        ("percent", True),
        ("center", 0),
        ("center", 5),
        ("center", 2.5),
        ("lattice", 0),
        ("lattice", math.inf),
        ("lattice_unit", "miles"),
        ("fit", "guess"),
        ("domain", "everywhere"),
        ("threshold_px", -0.1),
        ("interpolation", "nearest"),
        ("guard", 1),
    ],
)
def test_a_bad_value_is_refused_by_name(field, value):
    with pytest.raises(ValueError, match=field):
        Recipe(**{field: value})


@pytest.mark.parametrize("recipe", [Recipe(), PAPER, Recipe(percent=7.25, center=4, lattice=0.5)])
def test_json_round_trip(recipe):
    assert Recipe.from_dict(json.loads(json.dumps(recipe.to_dict()))) == recipe


def test_unknown_fields_and_newer_versions_are_refused():
    with pytest.raises(ValueError, match="percentage"):
        Recipe.from_dict({"percentage": 4})
    with pytest.raises(ValueError, match="version"):
        Recipe.from_dict({"version": 2})
    with pytest.raises(ValueError, match="object"):
        Recipe.from_dict([4])


def test_only_a_threshold_with_a_fade_depends_on_the_scale():
    assert Recipe().at_scale(0.25) == Recipe()
    assert Recipe(threshold_px=1.0).at_scale(0.25).threshold_px == 0.25
    assert Recipe(threshold_px=0.03).at_scale(0.25).threshold_px == LOSSLESS_PX
