"""People are told from the background round their faces, each once, or not at all."""

import cv2
import numpy as np
import pytest
from scenes import textured_photo

import kogao_core as kogao
from kogao_core.background.people import PersonFinder, PersonLook, PersonMask, PersonNetwork
from kogao_core.base.geometry import Affine

HALF = 128


@pytest.fixture(scope="module")
def sample(portrait):
    photo = kogao.read(portrait).pixels
    return photo, kogao.find(photo)


def shared(one, other):
    """Return what two pictures of a mask have in common, of what either has."""
    one, other = one > HALF, other > HALF
    return (one & other).sum() / (one | other).sum()


def test_a_portrait_stands_out_from_its_background(sample):
    photo, (face,) = sample
    people = PersonFinder().find(photo, [face])
    assert (len(people.looks), people.missed) == (1, 0)
    assert people.at(face.points[None]).mean() > 0.8
    inside = np.array([[face.eye_center, face.mouth_center]])
    assert people.at(inside).min() > 0.95
    corner = face.anchor.origin_px + np.array([1.2, -1.2]) * face.box[2]
    assert people.at(corner[None, None]).item() < 0.05
    picture = people.picture(photo.shape[1], photo.shape[0])
    assert (picture.shape, picture.dtype) == (photo.shape[:2], np.uint8)
    x, y = np.rint(face.mouth_center).astype(int)
    assert picture[y, x] > 240


def test_nothing_is_known_where_nobody_looked(sample):
    photo, (face,) = sample
    wide = cv2.copyMakeBorder(photo, 0, 0, 0, 3000, cv2.BORDER_CONSTANT)
    people = PersonFinder().find(wide, [face])
    assert np.isnan(people.at(np.array([[[3800.0, 450.0]]]))).all()
    assert not people.picture(3900, 900)[:, 3000:].any()
    assert np.isnan(PersonMask().at(np.zeros((1, 2, 2)))).all()


def test_people_grow_all_round(sample):
    photo, faces = sample
    people = PersonFinder().find(photo, faces)
    size = photo.shape[1::-1]
    before, after = people.picture(*size) > HALF, people.grown(0.05).picture(*size) > HALF
    assert after[before].mean() > 0.99
    away = cv2.distanceTransform((~before).astype(np.uint8), cv2.DIST_L2, 5)
    assert away[after].max() == pytest.approx(0.05 * max(faces[0].box[2:]), rel=0.35)


@pytest.mark.parametrize("degrees", [90.0, 180.0])
def test_the_mask_turns_with_the_photo(sample, degrees):
    photo, faces = sample
    middle = (np.array(photo.shape[1::-1]) - 1.0) / 2.0
    turn = Affine.similarity(1.0, degrees, (0.0, 0.0))
    turn = Affine(turn.matrix, middle - turn(middle))
    size = photo.shape[1::-1]
    turned = cv2.warpAffine(photo, turn.opencv, size, borderMode=cv2.BORDER_REPLICATE)
    upright = PersonFinder().find(photo, faces).picture(*size)
    found = PersonFinder().find(turned, [face.mapped(turn) for face in faces]).picture(*size)
    assert shared(cv2.warpAffine(found, turn.inverse.opencv, size), upright) > 0.97


def test_a_photo_is_looked_at_once(sample, monkeypatch):
    photo, faces = sample
    looks = []
    look = PersonNetwork.look

    def counted(self, *given):
        looks.append(given)
        return look(self, *given)

    monkeypatch.setattr(PersonNetwork, "look", counted)
    finder = PersonFinder()
    finder.find(photo, faces)
    finder.find(photo, faces)
    assert len(looks) == 1
    moved = faces[0].with_outline_point(10, faces[0].outline[10] + (0.0, 4.0))
    finder.find(photo, [moved])
    finder.find(photo.copy(), [moved])
    assert len(looks) == 3


@pytest.mark.parametrize(("sure", "missed"), [(0.75, 1), (0.85, 0)])
def test_a_crop_in_which_most_of_the_face_is_background_is_not_used(
    sample, monkeypatch, sure, missed
):
    photo, faces = sample
    look = PersonLook(np.ones((9, 9), np.float32), Affine.resize(1.0, 1.0), sure)
    monkeypatch.setattr(PersonNetwork, "look", lambda *_: look)
    assert PersonFinder().find(photo, faces).missed == missed


def test_where_nobody_is_it_is_sure_of_nothing(weights):
    assert weights
    photo = textured_photo(480, 360)
    people = PersonFinder().find(photo, [kogao.template_face((240, 180), 120)])
    assert (people.looks, people.missed) == ((), 1)


def test_whom_any_look_sees_is_there():
    still = Affine.similarity(1.0, 0.0, (0.0, 0.0))
    aside = Affine.similarity(1.0, 0.0, (6.0, 0.0))
    nobody, somebody = np.zeros((10, 10), np.float32), np.ones((10, 10), np.float32)
    people = PersonMask((PersonLook(nobody, still, 1.0), PersonLook(somebody, aside, 1.0)))
    seen = people.at(np.array([[[2.0, 5.0], [8.0, 5.0], [13.0, 5.0], [17.0, 5.0]]]))
    np.testing.assert_array_equal(seen, [[0.0, 1.0, 1.0, np.nan]])


def test_the_mask_of_a_smaller_photo_is_the_smaller_mask():
    opacity = np.zeros((64, 64), np.float32)
    opacity[16:48, 32:] = 1.0
    people = PersonMask((PersonLook(opacity, Affine.similarity(1.0, 0.0, (0.0, 0.0)), 1.0),))
    half = people.mapped(Affine.resize(0.5, 0.5)).picture(32, 32)
    assert (half == people.picture(64, 64)[::2, ::2]).mean() > 0.9
    assert half[:, 20:].sum() == pytest.approx(255 * 16 * 12, rel=0.05)


def test_free_is_where_somebody_looked_and_nobody_is():
    turned = Affine.similarity(2.0, 90.0, (40.0, 10.0))
    somebody = np.zeros((10, 10), np.float32)
    somebody[:, :4] = 0.7
    alone = PersonMask((PersonLook(somebody, turned, 1.0),))
    nobody = PersonLook(np.zeros((10, 10), np.float32), Affine.resize(2.0, 2.0), 1.0)
    both = PersonMask((*alone.looks, nobody))
    y, x = np.indices((40, 60))
    for people in (alone, both, PersonMask()):
        known = people.at(np.stack([x, y], axis=-1).astype(float))
        assert (people.free(60, 40) == (known < 0.5)).mean() > 0.98
    assert 0 < alone.free(60, 40).sum() < both.free(60, 40).sum()
