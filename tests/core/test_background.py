"""The bend meter goes by the background: lines of people are left out, others cut at them."""

import re

import cv2
import numpy as np
import pytest
from scenes import oval_face

from kogao_core.assets import AssetMissing
from kogao_core.background import background, measure
from kogao_core.bend import bends
from kogao_core.geometry import Affine, Box
from kogao_core.landmarks import ModelRefused
from kogao_core.person import PersonLook, PersonMask
from kogao_core.pipeline import render
from kogao_core.recipe import Recipe

WIDTH, HEIGHT = 960, 720
FACE = oval_face(WIDTH, HEIGHT, size=0.5)
RECIPE = Recipe(percent=8)
MISSING = "network that tells people apart is missing or damaged .*, so lines of hair"


class Finder:
    """Stands in for the network: people are where it is told."""

    def __init__(self, opacity=None, missed=0):
        self.opacity, self.missed = opacity, missed

    def find(self, _photo, faces):
        if isinstance(self.opacity, Exception):
            raise self.opacity
        if self.opacity is None:
            return PersonMask((), len(faces))
        # A look is square: the photo's own pixels, and nothing known below it.
        still = Affine.similarity(1.0, 0.0, (0.0, 0.0))
        return PersonMask((PersonLook(self.opacity, still, 1.0),), self.missed)


def photo_with(*lines):
    photo = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
    for start, end in lines:
        cv2.line(photo, start, end, (200, 200, 200), 5, cv2.LINE_AA)
    return photo


def people(left, top, right, bottom):
    opacity = np.zeros((WIDTH, WIDTH), np.float32)
    opacity[top:bottom, left:right] = 1.0
    return opacity


LEFT, RIGHT = FACE.outline[:, 0].min(), FACE.outline[:, 0].max()
BODY = people(int(LEFT), 100, int(RIGHT), HEIGHT)


def test_a_shelf_behind_a_person_is_cut_on_both_sides():
    photo = photo_with(((20, 660), (940, 660)))
    found = background(photo, Box.of(photo), [FACE], Finder(BODY))
    assert found.note == ""
    apart = 0.03 * max(FACE.box[2:])
    for low, high in np.sort(found.lines[..., 0]):
        assert high < LEFT - apart / 2 or low > RIGHT + apart / 2
    assert {bool(low < WIDTH / 2) for low, _ in np.sort(found.lines[..., 0])} == {True, False}
    assert any(high > LEFT - 3 * apart for _, high in np.sort(found.lines[..., 0]) if high < LEFT)


def test_a_collar_is_no_line_of_the_background_and_a_door_frame_is():
    collar, door = ((420, 640), (540, 700)), ((30, 60), (30, 660))
    photo = photo_with(collar, door)
    (upright,) = {round(x, -1) for x in background(
        photo, Box.of(photo), [FACE], Finder(BODY)
    ).lines[..., 0].ravel()}  # fmt: skip
    assert upright == 30


@pytest.mark.parametrize(
    ("opacity", "words"),
    [
        (None, "couldn't be told from the background, so lines of hair"),
        (
            AssetMissing("gone"),
            MISSING,
        ),
        (ModelRefused("bad"), MISSING),
    ],
)
def test_without_a_mask_all_but_the_faces_lines_count_and_it_is_said(opacity, words):
    collar, on_face = ((420, 660), (540, 700)), ((440, 360), (520, 360))
    photo = photo_with(collar, on_face)
    found = background(photo, Box.of(photo), [FACE], Finder(opacity))
    assert re.search(words, found.note)
    assert found.lines[..., 1].min() > 600
    assert len(found.lines) > 0


def test_who_could_not_be_told_from_the_background_is_counted():
    photo = photo_with(((30, 60), (30, 660)))
    found = background(photo, Box.of(photo), [FACE], Finder(BODY, missed=2))
    assert "2 faces couldn't be told" in found.note


def test_a_line_is_as_straight_as_its_edge_before_and_after():
    y = np.arange(60, 660)
    x = RIGHT + 30.0 + 4.0 * ((y - 360.0) / 300.0) ** 2
    photo = np.full((HEIGHT, WIDTH), 90, np.uint8)
    columns = np.arange(WIDTH)
    photo[60:660] = 90 + 110 / (1.0 + np.exp(-(columns - x[:, None])))
    chord = np.array([[[x[0] - 2.7, 60.0], [x[-1] - 2.7, 659.0]]])
    rendering = render(photo, [FACE], RECIPE)
    (line,) = bends(rendering.field, chord, photo)
    (ruled,) = bends(rendering.field, chord)
    assert line.bend_px == ruled.bend_px > 1.0
    assert (ruled.before_px, ruled.after_px) == (None, None)
    straight = np.polyval(np.polyfit(y, x, 1), y)
    assert line.before_px == pytest.approx(np.abs(x - straight).max(), abs=0.4)
    assert abs(line.after_px - line.before_px) > 0.5
    still = render(photo, [FACE], Recipe(percent=0))
    (line,) = bends(still.field, chord, photo)
    assert line.after_px == pytest.approx(line.before_px, abs=1e-6)


def test_measuring_changes_nothing():
    photo = photo_with(((int(RIGHT) + 30, 60), (int(RIGHT) + 30, 660)))
    photo.setflags(write=False)
    rendering = render(photo, [FACE], RECIPE)
    before = rendering.pixels.copy()
    found = measure(photo, rendering, [FACE], Finder(BODY))
    assert found.lines[0].bend_px > 1.0
    np.testing.assert_array_equal(rendering.pixels, before)
