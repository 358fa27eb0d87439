"""Masks: white pixels keep their bytes, soft edges are soft, and nothing folds."""

import cv2
import numpy as np
import pytest
from few_cases import few_of
from PIL import Image
from scenes import oval_face, textured_photo

from kogao_core.base.geometry import Affine
from kogao_core.field.mask import STEPS, Mask, read_mask, steps_of
from kogao_core.field.protection import Protection
from kogao_core.pipeline import render
from kogao_core.projects import project
from kogao_core.recipe.recipe import Recipe

WIDTH, HEIGHT = 480, 360
FACE = oval_face(WIDTH, HEIGHT, size=0.5)
PHOTO = textured_photo(WIDTH, HEIGHT)
LEAST_DET = 0.4  # of the guard


def protecting(grey):
    return Protection().with_mask(Mask.of(steps_of(grey), WIDTH, HEIGHT))


def beside(radius_px=40):
    """White beside the cheek, black elsewhere."""
    grey = np.zeros((HEIGHT, WIDTH), np.uint8)
    x, y = FACE.outline[16].round().astype(int).tolist()
    return cv2.circle(grey, (x, y), radius_px, 255, -1)


def random_mask(seed):
    """Blots with hard or soft edges, ellipses on landmarks, or white noise."""
    rng = np.random.default_rng(seed)
    if seed % 4 == 3:
        return np.where(rng.uniform(size=(HEIGHT, WIDTH)) > rng.uniform(0.9, 0.9999), 255, 0)
    if seed % 4 == 2:
        grey = np.zeros((HEIGHT, WIDTH), np.uint8)
        for place in rng.choice(FACE.points, 3) + rng.normal(size=(3, 2)) * 30:
            sizes, turn = rng.uniform(2, 45, 2).astype(int).tolist(), rng.uniform(0, 180)
            cv2.ellipse(grey, place.astype(int).tolist(), sizes, turn, 0, 360, 255, -1)
        return cv2.GaussianBlur(grey, (0, 0), rng.uniform(0.1, 10))
    blots = cv2.GaussianBlur(rng.normal(size=(HEIGHT, WIDTH)), (0, 0), rng.uniform(2, 30))
    contrast = 1e6 if seed % 2 else rng.uniform(50, 600)
    return np.clip((blots / blots.std() - rng.uniform(-0.5, 1.8)) * contrast, 0, 255)


@pytest.mark.parametrize("seed", few_of(range(200), 8))
def test_no_mask_changes_a_white_pixel_or_squeezes_the_picture(seed):
    grey = random_mask(seed).astype(np.uint8)
    percent = (4.0, 8.0, -6.0, 12.0)[seed // 4 % 4]
    made = render(PHOTO, [FACE], Recipe(percent=percent), protection=protecting(grey))
    white = steps_of(grey) == STEPS
    np.testing.assert_array_equal(made.pixels[white], PHOTO[white])
    assert made.one_to_one.certified
    # Differences of neighbouring pixels, without the field's own derivatives.
    moves = made.field.on_grid(np.arange(WIDTH), np.arange(HEIGHT))
    x, y = np.diff(moves, axis=2)[:, :-1], np.diff(moves, axis=1)[:, :, :-1]
    assert ((1.0 + x[0]) * (1.0 + y[1]) - x[1] * y[0]).min() > LEAST_DET


def test_a_soft_edge_is_soft_and_far_places_move_in_full():
    steepest = []
    for soft_px in (0.1, 12.0):
        grey = np.maximum(cv2.GaussianBlur(beside(56), (0, 0), soft_px), beside())
        field = render(PHOTO, [FACE], Recipe(percent=8), protection=protecting(grey)).field
        places = FACE.outline[16] - np.outer(np.arange(38.0, 110.0), (1.0, 0.0))
        share = field.protected_share(places)
        assert np.hypot(*field.at(FACE.outline[4][None]).T) > 2.0, "nothing moves beside it"
        assert share[0] < 0.15
        assert share[-1] == 1.0
        assert (np.diff(share) > -1e-6).all()
        steepest.append(np.diff(share).max())
    assert steepest[1] < 0.6 * steepest[0]


@pytest.mark.parametrize(
    ("name", "depth"), [("mask.png", np.uint8), ("mask.png", np.uint16), ("mask.tif", np.uint16)]
)
def test_masks_of_8_and_16_bits_are_one_mask(tmp_path, name, depth):
    grey = cv2.GaussianBlur(beside(), (0, 0), 6)
    cv2.imwrite(str(tmp_path / name), grey.astype(depth) * (np.iinfo(depth).max // 255))
    mask = read_mask(tmp_path / name, WIDTH, HEIGHT)
    np.testing.assert_array_equal(mask.steps, steps_of(grey))


def test_a_white_mask_stops_everything_and_a_black_mask_nothing():
    white = np.full((HEIGHT, WIDTH), 255, np.uint8)
    np.testing.assert_array_equal(
        render(PHOTO, [FACE], Recipe(percent=8), protection=protecting(white)).pixels, PHOTO
    )
    assert protecting(0 * white).strokes == ()


def test_a_mask_of_another_size_is_refused_with_both_sizes(tmp_path):
    Image.new("L", (90, 80)).save(tmp_path / "mask.png")
    with pytest.raises(ValueError, match="90 x 80 px, the photo 480 x 360 px"):
        read_mask(tmp_path / "mask.png", WIDTH, HEIGHT)
    noise = np.random.default_rng(1).integers(0, 2, (1200, 1200)).astype(np.uint8) * 255
    Image.fromarray(noise).save(tmp_path / "noise.png")
    with pytest.raises(ValueError, match="too detailed"):
        read_mask(tmp_path / "noise.png", 1200, 1200)


def test_masks_and_lines_hold_together():
    (mask,) = protecting(beside(20)).masks
    line = FACE.outline[[4, 5]]
    both = Protection().with_stroke(line, 3.0).with_mask(mask)
    made = render(PHOTO, [FACE], Recipe(percent=8), protection=both)
    for places in (line, np.argwhere(mask.steps == STEPS)[:, ::-1].astype(float)):
        assert not made.field.at(places).any()


def test_an_eraser_takes_away_the_part_of_a_mask_under_it():
    line, radius = [FACE.outline[16] - (50, 0), FACE.outline[16] + (50, 0)], 10.0
    left = protecting(beside()).erased(line, radius)
    (mask,) = left.masks
    rows = np.flatnonzero((mask.steps == 0) & (steps_of(beside()) > 0)) // WIDTH
    assert abs(np.ptp(rows) - 2 * radius) <= 2
    assert protecting(beside()).erased(line, 60.0).strokes == ()


def test_a_project_keeps_a_mask_in_every_size(tmp_path):
    grey = cv2.GaussianBlur(beside(), (0, 0), 6)
    original = project.Original("me.jpg", "0" * 64, WIDTH, HEIGHT)
    sheet = project.Sheet((FACE,))
    made = project.Project(original, "automatic", sheet, protection=protecting(grey))
    project.save(made, tmp_path / "me.kogao.json")
    (mask,) = project.load(tmp_path / "me.kogao.json").protection.masks
    np.testing.assert_array_equal(mask.steps, steps_of(grey))
    half = made.at_size(WIDTH // 2, HEIGHT // 2)
    project.save(half, tmp_path / "half.kogao.json")
    for one in (half, project.load(tmp_path / "half.kogao.json")):
        face = FACE.mapped(Affine.resize(0.5, 0.5))
        small = render(PHOTO[::2, ::2].copy(), [face], Recipe(percent=8), protection=one.protection)
        assert not small.field.at(FACE.outline[16][None] / 2 - 0.25).any()
