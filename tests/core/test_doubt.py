"""Which faces of a group are better left as they are, and why."""

import dataclasses

import numpy as np
import pytest
from scenes import oval_face

from kogao_core.base.geometry import Box
from kogao_core.faces.doubt import doubt, doubtful

IMAGE = Box(0, 0, 480, 360)


def found(*, unsure_landmarks=0, **changes):
    confidence = np.where(np.arange(27) < unsure_landmarks, 0.49, 0.5)
    face = dataclasses.replace(oval_face(), source="mesh", confidence=confidence, score=0.9)
    return dataclasses.replace(face, **changes)


@pytest.mark.parametrize(
    ("face", "why"),
    [
        (found(), None),
        (found(confidence=None), None),
        (found(score=0.75), None),
        (found(score=0.74), "unsure"),
        (found(unsure_landmarks=13), None),
        (found(unsure_landmarks=14), "hidden"),
        (found(score=0.43, unsure_landmarks=27), "unsure"),
        (found(score=0.43, source="manual"), None),
    ],
)
def test_a_face_is_doubted_for_its_score_or_what_hides_it(face, why):
    assert doubt(face, IMAGE) == why


@pytest.mark.parametrize(("outside", "why"), [(2, None), (3, "cut")])
def test_a_face_is_cut_once_more_than_an_ear_lies_outside_the_photo(outside, why):
    edge = float(np.sort(found().points[:, 0])[outside - 1])
    # The last pixel reaches half a px beyond its centre.
    image = Box(int(np.ceil(edge + 0.5)), 0, 480, 360)
    assert (found().points[:, 0] < image.left - 0.5).sum() == outside
    assert doubt(found(), image) == why


def test_a_photos_only_face_is_never_left_out():
    unsure = found(score=0.3)
    assert doubtful([unsure], IMAGE) == frozenset()
    assert doubtful([], IMAGE) == frozenset()
    assert doubtful([found(), unsure, found()], IMAGE) == {1}
