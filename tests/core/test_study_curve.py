"""The curve through a study's answers finds what made-up raters were given."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import expit

from kogao_core.lab.study import curve
from kogao_core.lab.study.design import variants
from kogao_core.lab.study.plan import Meaning, PictureFigures

MIDDLE, SCALE, LAPSE = 7.19, 1.05, 0.03


@pytest.fixture(autouse=True)
def _few_draws(request, monkeypatch):
    """Intervals of an eighth of the draws, but where they are counted."""
    if not request.node.get_closest_marker("slow"):
        monkeypatch.setattr(curve, "RESAMPLES", 50)


def simulated(seed, raters=20, faces=4, later=0.0, spread=0.0, floor=LAPSE):
    """Answers to table 1 of raters who follow a curve; centre 3 is judged `later`, % of D."""
    draw, key = np.random.default_rng(seed), SimpleNamespace(identity="k")
    own = draw.normal(0.0, spread, raters)
    rows = []
    for face in range(faces):
        for number, variant in enumerate(one for one in variants() if one.kind == "table1"):
            achieved = variant.percent * draw.uniform(1.1, 1.16)
            meaning = Meaning(face, variant, PictureFigures(achieved, None))
            middle = MIDDLE + own + later * (variant.center == 3)
            share = floor + (1.0 - LAPSE - floor) * expit((achieved - middle) / SCALE)
            rows += [
                SimpleNamespace(
                    key=key, session=SimpleNamespace(rater=f"r{rater}"), meaning=meaning,
                    variant=variant, is_unnatural=bool(hit),
                    record=SimpleNamespace(
                        picture=f"{face}-{number}", answer="unnatural" if hit else "natural"
                    ),
                )
                for rater, hit in enumerate(draw.random(raters) < share)
            ]  # fmt: skip
    return rows


@pytest.mark.parametrize(
    ("studies", "most_missed"), [(3, 0), pytest.param(20, 1, marks=pytest.mark.slow)]
)
def test_twenty_raters_of_a_known_curve_are_found_in_nineteen_of_twenty_studies(
    studies, most_missed
):
    found = [curve.fitted(simulated(seed)).whole for seed in range(studies)]
    inside = [
        one.middle.low <= MIDDLE <= one.middle.high and one.scale.low <= SCALE <= one.scale.high
        for one in found
    ]
    assert inside.count(False) <= most_missed
    # Nor are they so because the intervals are wide.
    assert np.mean([one.middle.high - one.middle.low for one in found]) < 0.7
    assert abs(np.mean([one.middle.value for one in found]) - MIDDLE) < 0.1


def test_guessing_between_two_is_known_of():
    rows = simulated(1, raters=40, faces=8, floor=0.5)
    found = curve.fitted(rows, floor=0.5).whole
    assert found.middle.low <= MIDDLE <= found.middle.high
    assert found.scale.low <= SCALE <= found.scale.high
    assert found.at(np.array([MIDDLE])) == pytest.approx(0.5 * (1.0 + 0.5), abs=0.08)
    assert curve.fitted(rows).whole.middle.value < MIDDLE - 1.0


def test_raters_who_differ_make_the_interval_wider_than_answers_alone():
    alike, differing = (curve.fitted(simulated(7, spread=spread)).whole for spread in (0.0, 1.5))
    assert differing.middle.high - differing.middle.low > 1.5 * (
        alike.middle.high - alike.middle.low
    )


def test_a_centre_that_is_judged_later_is_told_from_the_others():
    found = curve.fitted(simulated(3, raters=40, faces=8, later=1.0))
    assert found.later[3, "approximation"].low > 0.0
    assert found.later[3, "approximation"].value == pytest.approx(1.0, abs=0.4)
    assert found.later[2, "approximation"].low <= 0.0 <= found.later[2, "approximation"].high
    assert found.p < 0.001
    assert curve.fitted(simulated(3, raters=40, faces=8)).p > 0.05


def test_centres_are_compared_by_cochrans_q():
    """His own example in Biometrika 37 (1950): four media, 69 specimens; Q = 8.05, p = 0.045."""
    counts = {(1, 1, 1, 1): 4, (1, 1, 0, 1): 2, (0, 1, 1, 1): 3, (0, 1, 0, 1): 1, (0, 0, 0, 0): 59}
    variant = variants()[0]
    rows = []
    for number, said in enumerate(s for s, n in counts.items() for _ in range(n)):
        for center, hit in enumerate(said, start=1):
            rows.append(
                SimpleNamespace(
                    key=SimpleNamespace(identity="k"), meaning=SimpleNamespace(subject=number),
                    session=SimpleNamespace(rater="r"),
                    variant=dataclasses.replace(variant, center=center),
                    is_unnatural=bool(hit),
                )
            )  # fmt: skip
    assert curve._cochran(rows) == pytest.approx(0.045, abs=0.0005)


def test_more_raters_are_needed_where_there_is_less_to_go_by():
    few, many = (curve.fitted(simulated(5, raters=n, faces=8)) for n in (8, 40))
    assert few.raters < few.raters_needed
    assert 0.4 < few.raters_needed / many.raters_needed < 2.5, "whoever was asked in the pilot"


@pytest.mark.parametrize(
    "rows",
    [[], simulated(1)[:19], simulated(1, raters=1), simulated(1, faces=1)],
    ids=["nothing", "too little", "one rater", "one face"],
)
def test_no_curve_where_it_couldnt_be_told_how_sure_it_is(rows):
    assert curve.fitted(rows) is None


def test_answers_that_are_all_but_separated_have_a_curve():
    rows = [row for row in simulated(1) if not 5.0 < row.variant.percent < 7.0]
    for row in rows:
        row.is_unnatural = row.variant.percent > 6.0
    found = curve.fitted(rows).whole
    assert 4.4 < found.middle.value < 9.3
    assert found.scale.value > 0.0
