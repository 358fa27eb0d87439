"""A photo in the form of an identity document gets a sentence; other portraits don't."""

import numpy as np
import pytest
from scenes import oval_face

from kogao_core.base.geometry import Affine
from kogao_core.faces import identity

WIDTH, HEIGHT = 700, 900
MIDDLE = (WIDTH / 2, HEIGHT / 2)


def photo(level=225, noise=0.0, height=HEIGHT, mark=None):
    pixels = np.full((height, WIDTH, 3), level, np.float64)
    pixels += noise * np.random.default_rng(1).normal(size=pixels.shape)
    if mark:
        pixels[mark] = 0.0
    return pixels.clip(0, 255).astype(np.uint8)


def head(right=0.0, degrees=0.0, **how):
    face = oval_face(WIDTH, HEIGHT, **{"size": 0.55, "center": MIDDLE} | how)
    turn = Affine.similarity(1.0, degrees, (0.0, 0.0))
    return face.mapped(Affine(turn.matrix, MIDDLE - turn(MIDDLE) + (right * WIDTH, 0.0)))


@pytest.mark.parametrize(
    ("pixels", "face"),
    [
        (photo(), head()),
        (photo()[..., 0], head()),
        (photo(height=892), head()),
        (photo(noise=4.5), head()),
        (photo(mark=np.s_[290:, :90]), head()),
        (photo(mark=np.s_[:90, 90:-90]), head()),
        (photo(), head(right=0.03)),
        (photo(), head(degrees=2.0)),
    ],
)
def test_a_plain_frontal_photo_of_35_by_45_mm_is_recognised(pixels, face):
    assert "passport" in identity.note(pixels, [face])


@pytest.mark.parametrize(
    ("pixels", "faces"),
    [
        (photo(height=600), [head()]),
        (photo(height=885), [head()]),
        (photo(level=90), [head()]),
        (photo(noise=8.0), [head()]),
        (photo(mark=np.s_[240:260, :60]), [head()]),
        (photo(mark=np.s_[:100, 60:90]), [head()]),
        (photo(), [head(size=0.25)]),
        (photo(), [head(right=0.05)]),
        (photo(), [head(degrees=4.0)]),
        (photo(), [head(), head()]),
        (photo(), []),
    ],
)
def test_other_photos_get_no_sentence(pixels, faces):
    assert identity.note(pixels, faces) == ""
