"""A photo in the form of an identity document gets a sentence; other portraits don't."""

import numpy as np
import pytest
from scenes import oval_face

from kogao_core.faces import identity

WIDTH, HEIGHT = 700, 900


def photo(level=225, noise=0.0):
    pixels = np.full((HEIGHT, WIDTH, 3), level, np.float64)
    pixels += noise * np.random.default_rng(1).normal(size=pixels.shape)
    return pixels.clip(0, 255).astype(np.uint8)


def head(**how):
    return oval_face(WIDTH, HEIGHT, **{"size": 0.55, "center": (WIDTH / 2, HEIGHT / 2)} | how)


def test_a_plain_frontal_photo_of_35_by_45_mm_is_recognised():
    assert "passport" in identity.note(photo(), [head()])
    assert "passport" in identity.note(photo()[..., 0], [head()])


@pytest.mark.parametrize(
    ("pixels", "faces"),
    [
        (photo()[:600], [head()]),  # another shape
        (photo(level=90), [head()]),  # a dark background
        (photo(noise=20.0), [head()]),  # a busy background
        (photo(), [head(size=0.25)]),  # a small head
        (photo(), [head(center=(WIDTH / 3, HEIGHT / 2))]),  # off centre
        (photo(), [head(), head()]),
        (photo(), []),
    ],
)
def test_other_photos_get_no_sentence(pixels, faces):
    assert identity.note(pixels, faces) == ""
