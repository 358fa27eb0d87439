"""Photos of one person: each gets the amount at which its result is that of all."""

import csv
from dataclasses import replace

import cv2
import numpy as np
import pytest
from scenes import KnownFaces, oval_face, textured_photo

from kogao_core.base.geometry import Affine
from kogao_core.lab import series
from kogao_core.lab.series import Shot, bring, one_result, ratio, solve
from kogao_core.recipe.recipe import PAPER, Recipe
from kogao_core.warp.measures import measures

EXACT = replace(PAPER, fit="exact")
PIXELS = textured_photo()


def wide(share: float):
    """The made-up face with its outline so many times as wide."""
    face = oval_face()
    middle = face.outline[:, 0].mean()
    outline = face.outline.copy()
    outline[:, 0] = middle + share * (outline[:, 0] - middle)
    return replace(face, outline=outline)


SHOTS = [Shot(f"{share}", PIXELS, wide(share)) for share in (0.97, 1.0, 1.02, 1.05)]


@pytest.mark.parametrize("recipe", [EXACT, Recipe(), replace(Recipe(), head_follows=100.0)])
def test_the_amount_solved_for_gives_the_result_asked_for(recipe):
    face = wide(1.03)
    goal = ratio(oval_face(), PIXELS, replace(recipe, percent=4.0))
    percent = solve(face, PIXELS, recipe, goal)
    assert 4.0 < percent < 15.0
    after = ratio(face, PIXELS, replace(recipe, percent=percent))
    assert after == pytest.approx(goal, rel=1e-4)


def test_results_are_one_and_the_median_photo_gets_what_was_asked():
    goal, brought = bring(SHOTS[:3], EXACT)
    assert [one.after for one in brought] == pytest.approx([goal] * 3, rel=1e-4)
    assert np.std([one.equal for one in brought]) > 0.01
    amounts = [one.percent for one in brought]
    assert amounts == sorted(amounts)
    assert amounts[1] == pytest.approx(EXACT.percent, abs=2e-3)
    assert not any(one.limited for one in brought)
    assert [one.interval for one in brought] == [None] * 3


def test_a_goal_out_of_reach_ends_at_the_largest_amount_and_is_named():
    shots = [*SHOTS[:2], Shot("far", PIXELS, wide(1.5))]
    _, brought = bring(shots, EXACT)
    assert brought[-1].percent == 15.0
    assert brought[-1].limited
    (table,) = series.report(brought, EXACT).tables
    assert "beyond the largest amount for far" in table.note


def test_the_interval_is_of_what_other_views_ask_for():
    others = (wide(0.99), wide(1.01))
    shots = [Shot("a", PIXELS, wide(1.0), others), SHOTS[2], SHOTS[0]]
    goal, (one, *_) = bring(shots, EXACT)
    ends = [solve(face, PIXELS, EXACT, goal) for face in others]
    assert one.interval == pytest.approx((min(ends), max(ends)))
    assert one.interval[0] < one.percent < one.interval[1]


def test_other_views_lead_back_to_the_photo():
    """A source that finds a mark in the picture finds it where it is, whatever the view."""

    class Marked:
        def find(self, rgb):
            y, x = np.argwhere(rgb[..., 0] > 250).mean(axis=0)
            face = oval_face()
            return [face.mapped(Affine(np.eye(2), np.array([x, y]) - face.eye_center))]

    photo = np.full((360, 480, 3), 40, np.uint8)
    face = oval_face()
    cv2.circle(photo, tuple(np.round(face.eye_center).astype(int).tolist()), 9, (255,) * 3, -1)
    found = series.views(face, photo, Marked())
    assert len(found) == 4
    for one in found:
        assert np.abs(one.eye_center - face.eye_center).max() < 1.0
        assert measures(one).jaw_to_eyes == pytest.approx(measures(face).jaw_to_eyes, rel=0.02)


def test_turned_heads_and_what_has_no_face_are_left_out_by_name(tmp_path):
    faces = {}
    for number, (name, shift) in enumerate([("a", 0.0), ("b", 0.0), ("turned", 40.0)]):
        pixels = textured_photo(seed=number)
        assert cv2.imwrite(str(tmp_path / f"{name}.png"), pixels[..., ::-1])
        face = oval_face()
        ends = replace(face, eyes=face.eyes + (shift, 0.0), mouth=face.mouth + (shift, 0.0))  # noqa: RUF005
        faces[name] = [ends]
    (tmp_path / "broken.png").write_bytes(b"no photo")
    paths = sorted(tmp_path.glob("*.png"))
    given = {"find": lambda photo: faces[photo.path.stem]}
    brought, left_out = one_result(paths, tmp_path / "out", EXACT, KnownFaces(), **given)
    assert [one.name for one in brought] == ["a.png", "b.png"]
    assert any("turned.png is left out: the head is turned" in one for one in left_out)
    assert any(one.startswith("broken.png is left out") for one in left_out)
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert written == {"a_+04.00.png", "b_+04.00.png", "series.csv"}
    with (tmp_path / "out" / "series.csv").open(encoding="utf-8") as file:
        assert [row["photo"] for row in csv.DictReader(file)] == ["a.png", "b.png"]
    with pytest.raises(ValueError, match="at least two photos"):
        one_result(paths[2:], tmp_path / "none", EXACT, KnownFaces(), **given)
    assert not (tmp_path / "none").exists()
