"""Tests of the faces that are left alone, the reasons, and the points to check by eye."""

import dataclasses

import numpy as np
import pytest
from scenes import oval_face

from kogao_core.base.geometry import Affine, Box
from kogao_core.faces.doubt import AllDoubted, Verdict, choose, doubtful, is_partial, verdicts

IMAGE = Box(0, 0, 480, 360)


def found(**changes):
    face = dataclasses.replace(oval_face(), source="mesh", confidence=np.full(27, 0.6), score=0.9)
    return dataclasses.replace(face, **changes)


def parts(outline, eyes, mouth):
    """Return the confidence of a face by part."""
    return np.repeat([outline, eyes, mouth], [21, 4, 2])


def turned(degrees):
    face = found()
    turn = Affine.similarity(1.0, degrees, (0.0, 0.0))
    middle = np.array([240.0, 180.0])
    return face.mapped(Affine(turn.matrix, middle - turn(middle)))


def doubt(face, image=IMAGE):
    (verdict,) = verdicts([face], image)
    return verdict.reason


@pytest.mark.parametrize(
    ("face", "why"),
    [
        (found(), None),
        (found(confidence=None), None),
        (found(score=0.75), None),
        (found(score=0.74), "unsure"),
        (found(confidence=parts(0.2, 0.9, 0.6)), None),
        (found(confidence=parts(0.3, 0.8, 0.5)), "hidden"),
        (found(score=0.43, confidence=np.zeros(27)), "unsure"),
        (found(score=0.43, source="manual"), None),
    ],
)
def test_a_face_is_left_alone_for_a_low_score_or_hidden_parts(face, why):
    assert doubt(face) == why
    assert doubtful([face], IMAGE) == ({0} if why else frozenset())


def test_sure_faces_of_the_same_size_lower_the_least_score():
    unsure, sure = found(score=0.6), found(score=0.95)
    reasons = [next(iter(verdicts([unsure, *[sure] * count], IMAGE))).reason for count in range(6)]
    assert reasons[0] == "unsure"
    assert reasons[-1] is None
    assert reasons == sorted(reasons, key=lambda reason: reason is None), "more faces, less doubt"


def test_faces_of_another_size_and_unsure_faces_support_less():
    unsure = found(score=0.6)
    far = [found(score=0.95).mapped(Affine.similarity(0.1, 0.0, (0.0, 0.0)))] * 6
    assert doubtful([unsure, *far], IMAGE) == {0}
    assert doubtful([unsure] * 20, IMAGE) == frozenset(range(20))


def test_a_hidden_face_is_left_alone_in_a_group():
    hidden = found(score=0.6, confidence=parts(0.5, 0.7, 0.1))
    assert verdicts([hidden, *[found(score=0.95)] * 9], IMAGE)[0].reason == "hidden"


@pytest.mark.parametrize(("outside", "why"), [(2, None), (3, "cut")])
def test_a_face_is_cut_once_more_than_an_ear_lies_outside_the_photo(outside, why):
    edge = float(np.sort(found().points[:, 0])[outside - 1])
    # The last pixel reaches half a px beyond its centre.
    image = Box(int(np.ceil(edge + 0.5)), 0, 480, 360)
    assert (found().points[:, 0] < image.left - 0.5).sum() == outside
    assert doubt(found(), image) == why


@pytest.mark.parametrize(("across", "why"), [(1.0, None), (0.4, "turned")])
@pytest.mark.parametrize("degrees", [0.0, 70.0])
def test_a_face_is_doubted_once_one_side_of_it_is_out_of_sight(across, why, degrees):
    narrow = found().mapped(Affine(np.diag([across, 1.0]), np.zeros(2)))
    assert doubt(narrow.mapped(Affine.similarity(0.5, degrees, (200.0, 20.0)))) == why


@pytest.mark.parametrize(("degrees", "why"), [(100.0, None), (130.0, "on its head")])
def test_a_face_on_its_head_is_doubted_among_upright_ones(degrees, why):
    here, upright = turned(degrees), found()
    assert [one.reason for one in verdicts([here, upright], IMAGE)] == [why, None]
    assert [one.reason for one in verdicts([here, here], IMAGE)] == [None, None]


@pytest.mark.parametrize(("ends", "between", "listed"), [(0.0, 0.5, False), (1.0, 0.49, True)])
def test_points_are_listed_if_the_outline_between_its_ends_is_hidden(ends, between, listed):
    confidence = np.concatenate([np.repeat([ends, between, ends], [2, 17, 2]), np.ones(6)])
    (verdict,) = verdicts([found(confidence=confidence)], IMAGE)
    assert verdict.look_at == (tuple(range(2, 19)) if listed else ())
    assert bool(verdict.why) == listed


def test_points_to_look_at_are_named_by_part_until_they_are_placed_by_hand():
    confidence = parts(0.6, 1.0, 1.0)
    confidence[[0, 9, 10, 11, 12, 13, 21, 24, 26]] = 0.2
    face = found(confidence=confidence)
    (verdict,) = verdicts([face], IMAGE)
    assert verdict.told(3) == (
        "face 3: look at these points, they may be wrong: "
        "outline 1 10 11 12 13 14, eyes 1 4, mouth 2"
    )
    assert verdicts([face.with_outline_point(9, face.outline[9])], IMAGE) == [Verdict()]


def test_faces_asked_for_are_chosen_but_for_doubtful_ones():
    sure, unsure = found(), found(score=0.4)
    chosen = choose([sure, unsure], "all", IMAGE)
    assert chosen.faces == [sure]
    assert chosen.others == [unsure]
    assert chosen.note.startswith("face 2 is left alone: it is 40 % sure")
    every = choose([sure, unsure], "all", IMAGE, doubtful=True)
    assert (every.faces, every.others, every.note) == ([sure, unsure], [], "")
    first = choose([sure, unsure], "1", IMAGE)
    assert (first.faces, first.others, first.note) == ([sure], [unsure], ""), "nobody asked for 2"


@pytest.mark.parametrize("which", ["all", "largest", "1"])
def test_a_photo_whose_faces_are_all_doubtful_has_none_to_work_on(which):
    with pytest.raises(AllDoubted, match="face 1 is left alone: it is 40 % sure"):
        choose([found(score=0.4)], which, IMAGE)
    assert choose([found(score=0.4)], which, IMAGE, doubtful=True).faces


@pytest.mark.parametrize(
    ("rows", "in_part"),
    [
        (range(21), False),
        (range(0, 21, 5), False),
        (range(11), True),
        (range(8, 13), True),
        ((0, 20, 19), True),
    ],
)
def test_an_outline_by_hand_that_leaves_a_side_out_is_marked_in_part(rows, in_part):
    for roll in (0.0, 60.0, 180.0):
        whole = dataclasses.replace(turned(roll), confidence=None, source="manual")
        face = dataclasses.replace(whole, outline=whole.outline[sorted(rows)])
        assert is_partial(face) is in_part
        assert not is_partial(dataclasses.replace(face, source="mesh"))
        assert bool(verdicts([face], IMAGE)[0].told(1)) is in_part
