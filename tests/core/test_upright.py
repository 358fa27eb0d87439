"""A covered face isn't taken for one on its head, and one that is on its head is still found."""

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from few_cases import few_of
from real_photos import picture_of

from kogao_core.base.geometry import Box, degrees_of
from kogao_core.faces.doubt import doubtful
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import MeshSource

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from distortions import DISTORTIONS

COVERS = ("light blue mask", "white mask", "black mask", "veil", "scarf")
# Each was found on its head under one of the covers once.
ONCE_WRONG = ("p013", "p001", "p003", "p005", "p017", "p023", "p029")


def roll(face: Face) -> float:
    return degrees_of(face.eyes[3] - face.eyes[0])


def worn(name: str, picture: np.ndarray, face: Face) -> np.ndarray:
    return DISTORTIONS[name](picture, face, np.random.default_rng(0)).picture


@pytest.mark.parametrize("name", few_of(ONCE_WRONG, 1))
def test_nobody_who_covers_the_face_is_found_on_their_head(
    source: MeshSource, shared_data: Path, name: str
) -> None:
    picture = picture_of(shared_data / "portraits" / f"{name}.jpg", 600.0)
    (face, *_) = source.find(picture)
    for cover in COVERS:
        for found in source.find(worn(cover, picture, face)):
            assert abs(roll(found)) < 60.0, cover


@pytest.mark.parametrize("cover", [None, *few_of(COVERS, 1)])
def test_a_picture_on_its_head_has_a_face_on_its_head_or_a_doubtful_one(
    source: MeshSource, portrait: Path, cover: str | None
) -> None:
    picture = picture_of(portrait, 450.0)
    (face,) = source.find(picture)
    if cover is not None:
        picture = worn(cover, picture, face)
    turned = np.asarray(cv2.rotate(picture, cv2.ROTATE_180))
    (found,) = source.find(turned)
    assert abs(roll(found)) > 150.0 or (cover and doubtful([found], Box.of(turned)))
