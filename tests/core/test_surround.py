"""The head moves as one body; features and bars keep their shape; nothing folds."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from few_cases import few_of
from scenes import oval_face, read_outside_px, textured_photo

from kogao_core.additions.fit import fit
from kogao_core.additions.guard import LEAST_DET
from kogao_core.additions.head import forehead_pairs
from kogao_core.base.geometry import Affine, Box
from kogao_core.faces.head import HeadFrame
from kogao_core.faces.targets import aim
from kogao_core.field.field import shown_at
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER, SETTINGS, SHAPE, Recipe

ON = Recipe(percent=8.0, scope="head")  # the defaults are not tested here
ALONE = dataclasses.replace(ON, scope="face")
FITS = SETTINGS["fit"].choices
SIDES = (-1.0, 1.0)
PHOTO = Box(0, 0, 480, 360)


def face_at(x=239.5, y=200.0, size=0.4, *, forehead=True):
    return oval_face(center=(x, y), size=size, forehead=forehead)


def rendered(recipe, *faces, photo=None, **more):
    photo = textured_photo() if photo is None else photo
    return render(photo, faces or [face_at()], recipe, **more)


def field_of(recipe, *faces):
    """What the whole photo is warped by, with only a corner of it drawn."""
    return render(np.zeros((8, 8), np.uint8), faces or [face_at()], recipe, whole=PHOTO).field


def inward(field, center, points):
    """How far places come towards a centre, % of their distance."""
    away = points - center
    return 100.0 * (field.at(points) * away).sum(axis=1) / (away**2).sum(axis=1)


def half_width(face):
    return 0.5 * np.ptp(face.outline[:, 0])


def length(ends):
    return float(np.hypot(*(ends[-1] - ends[0])))


def strip(field, face, out=1.25):
    """Change of width of the strip beside the outline at the height of the ears, %, both sides."""
    half, found = half_width(face), []
    for side in (face.outline[:11], face.outline[10:]):
        height = face.eye_center[1] + 0.35 * (face.mouth_center - face.eye_center)[1]
        at = side[np.argmin(np.abs(side[:, 1] - height))]
        aside = np.sign(at[0] - face.eye_center[0]) * (out - 1.0) * half
        ends = np.stack([at, at + np.array([aside, 0.0])])
        found.append(100.0 * (length(shown_at(field, ends)) / length(ends) - 1.0))
    return np.array(found)


# -- the face alone --------------------------------------------------------------------------------


@pytest.mark.parametrize("fit_name", FITS)
def test_with_the_face_alone_every_byte_is_that_of_the_landmarks_alone(fit_name):
    face, photo = face_at(), textured_photo()
    recipe = dataclasses.replace(ALONE, fit=fit_name)
    made = rendered(recipe, face, photo=photo)
    alone = fit([aim(face, recipe)], [face.anchor], [recipe])
    for mine, expected in zip(made.field.lattices, alone, strict=True):
        assert mine.phi.tobytes() == expected.phi.tobytes()
    unknown = rendered(recipe, dataclasses.replace(face, forehead=None), photo=photo)
    assert unknown.pixels.tobytes() == made.pixels.tobytes()


@pytest.mark.parametrize("fit_name", FITS)
@pytest.mark.parametrize("recipe", [ALONE, ON])
def test_far_from_the_photos_edge_the_guard_changes_nothing_of_any_fit(recipe, fit_name):
    recipe = dataclasses.replace(recipe, percent=4.0, fit=fit_name)
    guarded, loose = (
        rendered(dataclasses.replace(recipe, guard=on), face_at(size=0.25)).field.lattices
        for on in (True, False)
    )
    for mine, other in zip(guarded, loose, strict=True):
        assert mine.phi.tobytes() == other.phi.tobytes()


def test_a_face_alone_that_moves_far_keeps_all_of_its_move():
    far = dataclasses.replace(ALONE, percent=10.0, width=-9.0, jaw_width=-9.0)
    made = rendered(far)
    assert made.shares == (1.0,)
    assert made.residual.max_px < 5e-3
    loose = rendered(dataclasses.replace(far, guard=False))
    assert loose.one_to_one.min_det < LEAST_DET, "the landmarks alone have room enough"


# -- what follows ----------------------------------------------------------------------------------


@pytest.mark.parametrize("forehead", [True, False])
def test_an_exact_fit_meets_every_landmark(forehead):
    assert rendered(ON, face_at(forehead=forehead)).residual.max_px < 5e-3


@pytest.mark.parametrize("at", [(239.5, 200.0, 0.3), (239.5, 130.0, 0.4), (180.0, 150.0, 0.35)])
def test_face_ears_skull_and_hair_shrink_alike_in_width_and_height(at):
    face = face_at(*at)
    field, frame = field_of(ON, face), HeadFrame.of(face)
    down, right = frame.down, np.array([frame.down[1], -frame.down[0]])
    ends = (
        *((-0.6 * right, 0.6 * right), (0.0 * down, down), (-0.7 * down, 0.0 * down)),
        *((-0.4 * right - 0.5 * down, 0.4 * right - 0.5 * down), (-1.1 * down, -0.4 * down)),
    )
    chin = float(((face.outline - frame.eyes_px) @ down).max())
    for end in ends:
        place = frame.eyes_px + chin * np.array(end)
        assert length(shown_at(field, place)) / length(place) == pytest.approx(0.92, abs=0.012)


@pytest.mark.parametrize("fit_name", FITS)
def test_the_forehead_comes_and_the_face_comes_as_far_as_it_did(fit_name):
    face = face_at()
    on, off = (rendered(dataclasses.replace(r, fit=fit_name), face) for r in (ON, ALONE))
    assert abs(on.achieved[0] - 8.0) < abs(off.achieved[0] - 8.0) + 0.05
    came, stayed = (inward(one.field, on.pairs[0].center_px, face.forehead) for one in (on, off))
    np.testing.assert_allclose(came, 8.0 / 0.92, rtol=0.1)
    assert abs(stayed[6]) < 0.01


@pytest.mark.parametrize("percent", [2.0, 4.0, 6.0, 8.0, 10.0])
@pytest.mark.parametrize("forehead", [True, False])
def test_the_rim_of_the_ears_goes_with_the_cheek(percent, forehead):
    face = face_at(forehead=forehead)
    change = strip(field_of(dataclasses.replace(ON, percent=percent), face), face)
    assert (change <= 3.0).all()
    # An ear that keeps its shape beside the face gets narrower by as much as the face.
    assert (change >= -1.4 * percent - 0.5).all()
    alone = strip(field_of(dataclasses.replace(ALONE, percent=percent), face), face)
    assert (alone > percent).all(), "the field of the face alone stretches them"


def test_it_fades_without_a_step_on_the_way_out():
    face = face_at(y=190.0, size=0.3)
    field, center = field_of(ON, face), face.middle
    ear = face.outline[2] - center
    moves = np.linalg.norm(field.at(center + np.linspace(1.0, 2.6, 200)[:, None] * ear), axis=1)
    whole = moves.argmax()
    assert (np.diff(moves[whole:]) < 1e-3 * moves.max()).all()
    assert np.abs(np.diff(moves)).max() < 0.03 * moves.max(), "in 200 steps"
    assert moves[-1] < 1e-3 * moves.max()


def test_a_side_that_is_made_slimmer_takes_the_forehead_and_the_ear_along():
    face, one_sided = face_at(), dataclasses.replace(ON, percent=0.0, left_width=-8.0)
    field = field_of(one_sided, face)
    away = 1.15 * half_width(face)
    y = face.eye_center[1] + 0.2 * (face.mouth_center - face.eye_center)[1]
    left, right = (field.at(np.array([[face.eye_center[0] + s * away, y]]))[0] for s in SIDES)
    assert np.hypot(*left) > 2.0
    assert np.hypot(*right) < 0.2
    source, target = forehead_pairs(face, one_sided, aim(face, one_sided))
    moved = np.linalg.norm(target - source, axis=1)
    assert moved[-1] < 0.2 * moved[0]


def test_what_follows_of_a_forehead_is_told_where_it_was_seen_and_follows():
    face = face_at()
    source, target = forehead_pairs(face, ON, aim(face, ON, photo=PHOTO))
    np.testing.assert_array_equal(source, face.forehead)
    shown = shown_at(field_of(ON, face), source)
    np.testing.assert_allclose(target, shown, atol=0.6)
    for other, recipe in ((face, ALONE), (dataclasses.replace(face, forehead=None), ON)):
        assert [part.shape for part in forehead_pairs(other, recipe, aim(other, recipe))] == [
            (0, 2),
            (0, 2),
        ]


# -- features keep their shape ---------------------------------------------------------------------


def crooked():
    """Return a face whose eyes lie unevenly in its outline, as in a head that is turned."""
    face = face_at()
    return dataclasses.replace(face, eyes=face.eyes - (7.0, 0.0), mouth=face.mouth - (5.0, 0.0))


@pytest.mark.parametrize("make", [face_at, crooked])
def test_each_eye_and_the_mouth_get_smaller_alike_in_width_and_height(make):
    face = make()
    field = field_of(dataclasses.replace(ON, percent=10.0), face)
    parts = [face.eyes[:2], face.eyes[2:], face.mouth]
    for eye in parts[:2]:
        half = 0.4 * length(eye)
        parts.append(eye.mean(axis=0) + np.array([(0.0, -half), (0.0, half)]))
    scales = np.array([length(shown_at(field, part)) / length(part) for part in parts])
    assert 100.0 * np.abs(scales - 0.96).max() < 3.0


def sag(field, face):
    """How far a straight bar from temple to temple is from straight, % of the eyes' distance."""
    height = face.eye_center[1]
    ends = [s[np.argmin(np.abs(s[:, 1] - height))] for s in (face.outline[:11], face.outline[10:])]
    bar = shown_at(field, np.linspace(*ends, 60))
    chord = (bar[-1] - bar[0]) / length(bar)
    return 100.0 * float(np.abs((bar - bar[0]) @ [-chord[1], chord[0]]).max()) / length(face.eyes)


@pytest.mark.parametrize("percent", [4.0, 8.0])
def test_a_bar_from_temple_to_temple_stays_straight(percent):
    face, kept = face_at(), dataclasses.replace(ON, percent=percent)
    assert sag(field_of(kept, face), face) <= percent / 4.0
    assert sag(field_of(dataclasses.replace(ALONE, percent=percent), face), face) > percent / 4.0


# -- what must not happen --------------------------------------------------------------------------


def random_recipe(rng, shape=()):
    return Recipe(
        percent=float(rng.uniform(1, 15)),
        center=int(rng.integers(1, 5)),
        lattice=float(rng.uniform(0.4, 3.0)),
        fit=str(rng.choice(FITS)),
        scope=str(rng.choice(["head", "head", "face"])),
        **{name: float(rng.uniform(*SETTINGS[name].within)) for name in shape},
    )


def random_face(rng):
    face = face_at(
        *(rng.uniform(130, 350), rng.uniform(90, 260), rng.uniform(0.3, 0.6)),
        forehead=bool(rng.integers(2)),
    )
    turn = Affine.similarity(1.0, float(rng.uniform(-40, 40)), (0.0, 0.0))
    middle = face.eye_center
    return face.mapped(Affine(turn.matrix, middle - turn(middle)))


@pytest.mark.parametrize("seed", few_of(range(8), 5))
def test_by_random_settings_it_never_folds_nor_reads_outside_the_photo(seed):
    rng = np.random.default_rng(seed)
    for shape in ((), (), SHAPE, SHAPE):
        recipe, face = random_recipe(rng, shape), random_face(rng)
        made = rendered(recipe, face)
        assert not made.one_to_one.folds
        assert made.one_to_one.settled
        assert read_outside_px(made.field, PHOTO) < 0.02


@pytest.mark.parametrize("recipe", [ON, dataclasses.replace(ON, lens=26.0)])
def test_a_part_of_a_photo_moves_as_it_does_in_the_whole(recipe):
    photo, face = textured_photo(), face_at(y=150.0)
    part = Box(60, 70, 420, 330)
    there = Affine(np.eye(2), np.array([-part.left, -part.top], np.float64))
    whole = Box(-part.left, -part.top, 480 - part.left, 360 - part.top)
    alone = render(photo[part.slices], [face.mapped(there)], recipe, whole=whole)
    points = np.random.default_rng(3).uniform((100, 90), (380, 300), (200, 2))
    np.testing.assert_allclose(
        alone.field.at(there(points)), rendered(recipe, face).field.at(points), atol=1e-3
    )


@pytest.mark.parametrize("fit_name", FITS)
def test_a_head_in_front_is_as_it_would_be_alone_and_the_head_behind_gives_way(fit_name):
    front, behind = face_at(190.0, 240.0, 0.35), face_at(290.0, 130.0, 0.35)
    recipe = dataclasses.replace(ON, fit=fit_name)
    both, alone = rendered(recipe, front, behind), rendered(recipe, front)
    np.testing.assert_allclose(
        both.field.at(front.outline), alone.field.at(front.outline), atol=0.1
    )
    assert both.achieved[0] == pytest.approx(alone.achieved[0], abs=0.05)
    assert 7.0 < both.achieved[1] < 7.98
    if fit_name == "exact":
        assert both.residual.max_px < 0.02


def test_a_neighbour_that_is_made_smaller_by_itself_isnt_carried_along():
    near, other = face_at(170.0, 200.0, 0.35), face_at(310.0, 200.0, 0.35)
    still = dataclasses.replace(other, recipe=dataclasses.replace(ON, percent=0.0))
    made = rendered(ON, near, still)
    assert np.abs(made.field.at(still.outline)).max() < 0.05


# -- the photo's edge ------------------------------------------------------------------------------


@pytest.mark.parametrize("at", [(239.5, 60.0), (70.0, 180.0), (420.0, 300.0), (239.5, 330.0)])
@pytest.mark.parametrize("recipe", [ON, ALONE])
def test_no_pixel_is_read_from_outside_the_photo(at, recipe):
    recipe = dataclasses.replace(recipe, percent=10.0)
    made = rendered(recipe, face_at(*at))
    # Control points are rounded to quanta far below what a pixel shows.
    assert read_outside_px(made.field, PHOTO) < 0.02
    assert not made.one_to_one.folds


def test_a_face_cut_by_the_edge_slides_along_it_and_a_sentence_says_so():
    face = face_at(32.0, 180.0)
    made = rendered(dataclasses.replace(ON, percent=10.0), face)
    moved = made.pairs[0].displacement_px
    asked = aim(face, made.recipe, photo=PHOTO).displacement_px
    cut = face.outline[:, 0] < 4.0
    assert cut.any()
    np.testing.assert_allclose(moved[cut][:, 1], asked[cut][:, 1], atol=1e-9)
    assert (np.abs(moved[cut][:, 0]) < np.abs(asked[cut][:, 0])).all()
    assert made.note.startswith("1 face lies at the photo's edge")
    within = face.outline[:, 0] > 30.0
    missed = made.field.at(made.pairs[0].target_px) - moved
    assert np.abs(missed[within]).max() < 0.3, "what is left of it is met"
    clear = rendered(ON)
    assert not clear.note
    (pairs,) = clear.pairs
    np.testing.assert_array_equal(pairs.target_px, aim(face_at(), ON, photo=PHOTO).target_px)


def test_without_the_guard_pixels_may_come_from_outside_as_in_the_paper():
    loose = rendered(dataclasses.replace(PAPER, percent=10.0), face_at(50.0, 180.0))
    assert read_outside_px(loose.field, PHOTO) > 1.0
    assert not loose.note


# -- continuity ------------------------------------------------------------------------------------


def places():
    xs, ys = np.arange(60.0, 420.0, 9.0), np.arange(20.0, 340.0, 9.0)
    return np.stack(np.meshgrid(xs, ys), -1).reshape(-1, 2)


def jumps(found):
    return np.array([np.abs(after - before).max() for before, after in pairwise(found)])


@pytest.mark.parametrize(
    ("recipe", "name", "end"),
    [
        (ON, "percent", 10.0),
        (ON, "width", -10.0),
        (dataclasses.replace(ALONE, width=-9.0, jaw_width=-9.0), "percent", 10.0),
    ],
)
def test_a_small_step_of_a_setting_is_a_small_step_of_the_field(recipe, name, end):
    face = face_at(y=170.0)
    # In 40 steps: no step is much larger than its share.
    values = np.linspace(0.0, end, 41).tolist()
    recipes = [dataclasses.replace(recipe, **{"percent": 0.0, name: value}) for value in values]
    found = [field_of(one, face).at(places()) for one in recipes]
    taken = jumps(found)
    assert taken.max() < 0.08 * np.abs(found[-1]).max()
    assert taken.min() > 0.0


def test_a_face_that_comes_to_the_edge_does_so_without_a_step():
    found = []
    for x in np.linspace(20.0, 140.0, 61):
        face = face_at(float(x), 180.0)
        at = face.outline + 0.2
        found.append(field_of(ON, face).at(at))
    most = np.abs(found[-1]).max()
    assert jumps(found).max() < 0.25 * most
