"""What a fit makes of the percentage that was asked for, with its sign."""

import dataclasses

import cv2
import numpy as np
import pytest
from scenes import oval_face, textured_photo
from scipy.optimize import fsolve

from kogao_core.faces.targets import aim
from kogao_core.field.measures import (
    achieved_percent,
    asked_percent,
    measures,
    toward_center_percent,
)
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER, Recipe

PHOTO = textured_photo()


def rendering(**choices):
    return render(PHOTO, [oval_face()], dataclasses.replace(PAPER, **choices))


def solved(field, pairs):
    """Every landmark's place by scipy's root finder, and its way inwards by a loop."""
    shares = []
    for landmark, target in zip(pairs.source_px, pairs.target_px, strict=True):
        place = fsolve(lambda x, p=landmark: x + field.at([x])[0] - p, target, xtol=1e-12)
        inwards = (pairs.center_px - landmark) / np.linalg.norm(pairs.center_px - landmark)
        distance = np.linalg.norm(pairs.center_px - landmark)
        shares.append(100.0 * np.dot(place - landmark, inwards) / distance)
    return np.mean(shares)


@pytest.mark.parametrize(("lattice", "percent"), [(0.25, 4.0), (1.0, 10.0), (2.0, 4.0)])
def test_achieved_is_what_a_root_finder_says(lattice, percent):
    found = rendering(lattice=lattice, percent=percent)
    (pairs,) = found.pairs
    assert found.achieved == achieved_percent(found.field, [pairs])
    assert found.achieved[0] == pytest.approx(solved(found.field, pairs), abs=1e-4)


def test_the_papers_approximation_goes_past_what_was_asked_and_exact_doesnt():
    assert asked_percent(rendering().pairs[0]) == pytest.approx(4.0)
    assert rendering().achieved[0] > 4.2
    assert rendering(fit="exact").achieved[0] == pytest.approx(4.0, abs=1e-3)


def test_outwards_counts_against_inwards_and_across_not_at_all():
    pairs = aim(oval_face(), PAPER)
    toward = pairs.center_px - pairs.source_px
    across = toward[:, ::-1] * (1.0, -1.0)
    for share, way in ((-3.0, toward), (0.0, across)):
        moved = pairs.source_px + (share or 5.0) / 100.0 * way
        assert toward_center_percent(pairs, moved) == pytest.approx(share)


def test_what_the_guard_holds_back_isnt_achieved():
    held = rendering(percent=15.0, lattice=0.5, fit="exact", guard=True)
    assert held.shares[0] < 0.8
    assert held.achieved[0] < 14.0
    assert held.achieved[0] == pytest.approx(solved(held.field, held.pairs[0]), abs=1e-3)


def test_a_face_that_isnt_moved_achieves_nothing():
    assert rendering(percent=0.0).achieved == (0.0,)
    assert render(PHOTO, [], PAPER).achieved == ()


@pytest.mark.parametrize("recipe", [dataclasses.replace(PAPER, fit="exact"), Recipe()])
def test_negative_amounts_enlarge(recipe):
    found = render(PHOTO, [oval_face()], dataclasses.replace(recipe, percent=-6.0))
    assert found.achieved[0] == pytest.approx(-6.0, abs=0.01)
    assert found.one_to_one.certified


def test_measures_are_those_of_known_shapes():
    """An ellipse's width, its chord at the mouth, and its area."""
    face = oval_face(width=960, height=720, size=0.6)
    height = 0.6 * 720
    found = measures(face)
    assert found.width_px == pytest.approx(0.78 * height, rel=0.01)
    down = 0.28 / 0.5
    assert found.jaw_px == pytest.approx(0.78 * height * np.sqrt(1.0 - down**2), rel=0.01)
    assert found.interocular_px == pytest.approx(0.60 * 0.78 * height, rel=1e-6)
    area = cv2.contourArea(face.outline.astype(np.float32))
    assert found.area_px2 == pytest.approx(area, rel=1e-5)
