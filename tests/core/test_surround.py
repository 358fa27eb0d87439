"""What surrounds a face goes along: ears, temples, hair; features and bars keep shape; no folds."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from few_cases import few_of
from scenes import oval_face, read_outside_px, textured_photo

from kogao_core.background import holding
from kogao_core.background.holding import Held
from kogao_core.base.geometry import Affine, Box
from kogao_core.faces.targets import aim
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER, SETTINGS, SHAPE, Recipe
from kogao_core.warp.field import shown_at
from kogao_core.warp.fit import fit, problems_of
from kogao_core.warp.protection import Protection
from kogao_core.warp.surround import forehead_pairs, surrounds_of

# Neither the amount nor the share that photos begin with is what is tested here.
ON = Recipe(percent=8.0, center=2, head_follows=50.0, keep_features=True)
ALONE = dataclasses.replace(ON, head_follows=0.0, keep_features=False)
FOLLOWS = dataclasses.replace(ON, keep_features=False)
WHOLE = dataclasses.replace(ON, head_follows=100.0)
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


# -- 0 % and features not kept is the paper's path -------------------------------------------------


@pytest.mark.parametrize("fit_name", FITS)
def test_at_0_percent_and_features_not_kept_every_byte_is_that_of_the_landmarks_alone(fit_name):
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


# -- what follows ----------------------------------------------------------------------------------


@pytest.mark.parametrize("recipe", [ON, FOLLOWS, WHOLE])
@pytest.mark.parametrize("forehead", [True, False])
def test_an_exact_fit_meets_every_landmark(recipe, forehead):
    assert rendered(recipe, face_at(forehead=forehead)).residual.max_px < 5e-3


@pytest.mark.parametrize("fit_name", FITS)
def test_the_forehead_comes_and_the_face_comes_as_far_as_it_did(fit_name):
    face = face_at()
    on, off = (rendered(dataclasses.replace(r, fit=fit_name), face) for r in (ON, ALONE))
    assert abs(on.achieved[0] - 8.0) < abs(off.achieved[0] - 8.0) + 0.05
    center = on.pairs[0].center_px
    came, stayed = (inward(one.field, center, face.forehead) for one in (on, off))
    # Less at its top than at its ends, and more than where the face alone moves.
    assert (came > 2.0).all()
    assert came.max() < 12.0
    assert came[6] > stayed[6] + 2.0
    assert abs(stayed[6]) < 0.01


@pytest.mark.parametrize("percent", [2.0, 4.0, 6.0, 8.0, 10.0])
@pytest.mark.parametrize("forehead", [True, False])
def test_the_rim_of_the_ears_goes_with_the_cheek(percent, forehead):
    face = face_at(forehead=forehead)
    for recipe in (ON, WHOLE):
        change = strip(field_of(dataclasses.replace(recipe, percent=percent), face), face)
        assert (change <= 3.0).all()
        # An ear that keeps its shape beside the face gets narrower by as much as the face.
        assert (change >= -1.4 * percent - 0.5).all()
    alone = strip(field_of(dataclasses.replace(ALONE, percent=percent), face), face)
    assert (alone > percent).all(), "the field of the face alone stretches them"


def test_it_fades_without_a_step_on_the_way_out():
    face = face_at(y=190.0, size=0.3)
    field, center = field_of(ON, face), aim(face, ON).center_px
    ear = face.outline[2] - center
    moves = np.linalg.norm(field.at(center + np.linspace(1.0, 2.6, 200)[:, None] * ear), axis=1)
    whole = moves.argmax()
    assert (np.diff(moves[whole:]) < 1e-3 * moves.max()).all()
    assert np.abs(np.diff(moves)).max() < 0.03 * moves.max(), "in 200 steps"
    assert moves[-1] < 1e-3 * moves.max()


def test_with_the_whole_head_hair_beside_the_cheeks_comes_as_the_hair_above_does():
    face = face_at(y=180.0, size=0.25)
    half, eye = half_width(face), face.eye_center
    height = float((face.outline[:, 1] - eye[1]).max())
    # At 1.3 half widths, half a face's height below the eye line, and above it.
    below, above = (
        np.array([eye + np.array([sign * 1.3 * half, up * height]) for sign in SIDES])
        for up in (0.5, -0.5)
    )
    field = field_of(WHOLE, face)
    towards = [float((field.at(p)[:, 0] * SIDES).mean()) for p in (below, above)]
    assert towards[0] >= 0.6 * towards[1] > 0.0
    less = field_of(ON, face)
    assert float((less.at(below)[:, 0] * SIDES).mean()) < towards[0]


def test_the_zones_of_the_sides_go_on_beside_the_face():
    face = face_at()
    one_sided = dataclasses.replace(FOLLOWS, left=0.0)
    field = field_of(one_sided, face)
    away = 1.15 * half_width(face)
    y = face.eye_center[1] + 0.2 * (face.mouth_center - face.eye_center)[1]
    left, right = (field.at(np.array([[face.eye_center[0] + s * away, y]]))[0] for s in SIDES)
    assert np.hypot(*left) < 0.2
    assert np.hypot(*right) > 2.0
    source, target = forehead_pairs(face, one_sided, aim(face, one_sided))
    moved = np.linalg.norm(target - source, axis=1)
    assert moved[0] < 0.2 * moved[-1]


def test_what_follows_of_a_forehead_is_told_where_it_was_seen_and_follows():
    face = face_at()
    source, target = forehead_pairs(face, ON, aim(face, ON))
    np.testing.assert_array_equal(source, face.forehead)
    shown = shown_at(field_of(FOLLOWS, face), source)
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


@pytest.mark.parametrize("follows", [0.0, 50.0, 100.0])
@pytest.mark.parametrize("make", [face_at, crooked])
def test_each_eye_and_the_mouth_get_smaller_alike_in_width_and_height(follows, make):
    face = make()
    recipe = dataclasses.replace(ON, percent=10.0, head_follows=follows)
    loosely = dataclasses.replace(recipe, keep_features=False)
    worst = []
    for one in (recipe, loosely):
        field = field_of(one, face)
        parts = [face.eyes[:2], face.eyes[2:], face.mouth]
        for eye in parts[:2]:
            half = 0.4 * length(eye)
            parts.append(eye.mean(axis=0) + np.array([(0.0, -half), (0.0, half)]))
        scales = np.array([length(shown_at(field, part)) / length(part) for part in parts])
        worst.append(100.0 * np.abs(scales - 0.96).max())
    kept, loose = worst
    assert kept < min(3.0, 0.7 * loose)


def sag(field, face):
    """How far a straight bar from temple to temple is from straight, % of the eyes' distance."""
    height = face.eye_center[1]
    ends = [s[np.argmin(np.abs(s[:, 1] - height))] for s in (face.outline[:11], face.outline[10:])]
    bar = shown_at(field, np.linspace(*ends, 60))
    chord = (bar[-1] - bar[0]) / length(bar)
    return 100.0 * float(np.abs((bar - bar[0]) @ [-chord[1], chord[0]]).max()) / length(face.eyes)


@pytest.mark.parametrize("percent", [4.0, 8.0])
@pytest.mark.parametrize("follows", [0.0, 50.0, 100.0])
def test_a_bar_from_temple_to_temple_stays_straight(percent, follows):
    face = face_at()
    kept = dataclasses.replace(ON, percent=percent, head_follows=follows)
    assert sag(field_of(kept, face), face) <= percent / 4.0
    assert sag(field_of(dataclasses.replace(ALONE, percent=percent), face), face) > percent / 4.0


# -- what must not happen --------------------------------------------------------------------------


def random_recipe(rng, shape=()):
    return Recipe(
        percent=float(rng.uniform(1, 15)),
        center=int(rng.integers(1, 5)),
        lattice=float(rng.uniform(0.4, 3.0)),
        fit=str(rng.choice(FITS)),
        head_follows=float(rng.uniform(0, 100)),
        keep_features=bool(rng.integers(2)),
        cheeks=float(rng.uniform(0, 200)),
        left=float(rng.uniform(0, 200)),
        even_out=float(rng.uniform(0, 100)),
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


def test_at_usual_amounts_the_guard_has_no_more_to_do_and_less_is_squeezed():
    on, off = rendered(ON), rendered(ALONE)
    assert on.shares == off.shares == (1.0,)
    assert on.one_to_one.min_det > off.one_to_one.min_det - 0.02


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


def test_protected_places_beside_and_above_the_face_stay():
    face = face_at()
    brim = face.forehead[6] + [(-60.0, -12.0), (60.0, -12.0)]
    free, held = rendered(ON, face), rendered(ON, face, protection=Protection().with_stroke(brim))
    along = brim[0] + np.linspace(0.0, 1.0, 30)[:, None] * (brim[1] - brim[0])
    assert np.abs(free.field.at(along)).max() > 1.0
    assert np.abs(held.field.at(along)).max() < 0.1
    assert held.residual.max_px < 0.05


@pytest.mark.parametrize("follows", [0.0, 100.0])
def test_what_the_hard_brush_covers_keeps_every_byte(follows):
    face, photo = face_at(), textured_photo()
    recipe = dataclasses.replace(ON, head_follows=follows)
    ear = face.outline[3] + [(-14.0, -10.0), (-14.0, 14.0)]
    brush = Protection().with_stroke(ear, radius_px=9.0, feather_px=6.0)
    kept = rendered(recipe, face, photo=photo, protection=brush)
    pixels = np.stack(np.meshgrid(np.arange(480.0), np.arange(360.0)), -1).reshape(-1, 2)
    covered = brush.away_px(pixels).reshape(360, 480) <= 0.0
    assert covered.sum() > 300
    np.testing.assert_array_equal(kept.pixels[covered], photo[covered])
    loose = rendered(recipe, face, photo=photo)
    assert (loose.pixels[covered] != photo[covered]).mean() > (0.5 if follows else 0.05)


@pytest.mark.parametrize(("lattice", "halves"), [(1.0, False), (0.5, False), (0.2, True)])
def test_of_very_many_control_points_holding_uses_a_coarser_lattice(lattice, halves):
    face, recipe = face_at(), dataclasses.replace(ON, lattice=lattice)
    pairs = aim(face, recipe)
    surrounds = surrounds_of([face], [pairs], [recipe], PHOTO, Protection())
    (problem,) = problems_of([pairs], [face.anchor], [recipe], surrounds=surrounds)
    room = holding._Room.of(problem)
    assert (room.empty.grid.spacing_px > problem.grid.spacing_px) == halves
    assert len(room.rows) * len(room.columns) <= 1.1 * holding._MOST_NODES


def test_a_control_point_more_or_less_makes_no_difference_to_what_is_held():
    face = face_at()
    free = rendered(ON, face).field
    x, y = face.outline[5] + (-8.0, 6.0)
    held = Held(np.array([[(0.0, y + 3.0), (x, y)]]))
    (problem,) = problems_of([aim(face, ON)], [face.anchor], [ON], photo=PHOTO)
    low, high = problem.near_px
    moved = []
    for more in np.linspace(0.0, 1.0, 21) * problem.grid.spacing_px:
        around = np.array([low - more, high + more])
        wider = dataclasses.replace(problem, around_px=around)
        field = holding.hold(free, [wider], [face], held)
        moved.append(field.lattices[0].at(held.lines[0]))
    steps = [np.abs(after - before).max() for before, after in pairwise(moved)]
    assert max(steps) < 0.02 * np.abs(moved[0] - free.at(held.lines[0])).max()


@pytest.mark.parametrize("fit_name", FITS)
def test_a_neighbour_goes_where_it_went(fit_name):
    faces = [face_at(190.0, 240.0, 0.35), face_at(290.0, 130.0, 0.35)]
    on, off = (
        rendered(dataclasses.replace(recipe, fit=fit_name), *faces) for recipe in (ON, ALONE)
    )
    # An approximation overshoots, and less so where all round the face goes along.
    assert (
        np.abs(np.subtract(on.achieved, 8.0)) <= np.abs(np.subtract(off.achieved, 8.0)) + 0.05
    ).all()
    if fit_name == "exact":
        assert on.residual.max_px < 0.02


def test_a_neighbour_that_is_made_smaller_by_itself_isnt_carried_along():
    near, other = face_at(170.0, 200.0, 0.35), face_at(310.0, 200.0, 0.35)
    still = dataclasses.replace(other, recipe=dataclasses.replace(ON, percent=0.0))
    made = rendered(WHOLE, near, still)
    assert np.abs(made.field.at(still.outline)).max() < 0.05


# -- the photo's edge ------------------------------------------------------------------------------


@pytest.mark.parametrize("at", [(239.5, 60.0), (70.0, 180.0), (420.0, 300.0), (239.5, 330.0)])
@pytest.mark.parametrize("follows", [0.0, 50.0, 100.0])
def test_no_pixel_is_read_from_outside_the_photo(at, follows):
    recipe = dataclasses.replace(ON, percent=10.0, head_follows=follows)
    made = rendered(recipe, face_at(*at))
    # Control points are rounded to quanta far below what a pixel shows.
    assert read_outside_px(made.field, PHOTO) < 0.02
    assert not made.one_to_one.folds


def test_a_face_cut_by_the_edge_slides_along_it_and_a_sentence_says_so():
    face = face_at(32.0, 180.0)
    made = rendered(dataclasses.replace(ON, percent=10.0), face)
    moved, asked = (p.displacement_px for p in (made.pairs[0], aim(face, made.recipe)))
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
    np.testing.assert_array_equal(pairs.target_px, aim(face_at(), ON).target_px)


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
    ("recipe", "name", "end"), [(ON, "head_follows", 100.0), (FOLLOWS, "percent", 10.0)]
)
def test_a_small_step_of_a_setting_is_a_small_step_of_the_field(recipe, name, end):
    face = face_at(y=170.0)
    whole = dataclasses.replace(recipe, percent=10.0, head_follows=100.0)
    most = np.abs(field_of(whole, face).at(places())).max()
    # The way is made in 40 steps: nowhere is one much larger than its share.
    values = np.linspace(0.0, end, 41).tolist()
    recipes = [dataclasses.replace(recipe, **{name: value}) for value in values]
    taken = jumps([field_of(one, face).at(places()) for one in recipes])
    assert taken.max() < 0.08 * most
    assert taken.min() > 0.0


def test_a_face_that_comes_to_the_edge_does_so_without_a_step():
    found = []
    for x in np.linspace(20.0, 140.0, 61):
        face = face_at(float(x), 180.0)
        at = face.outline + 0.2
        found.append(field_of(ON, face).at(at))
    most = np.abs(found[-1]).max()
    assert jumps(found).max() < 0.25 * most


# -- files and words -------------------------------------------------------------------------------


@pytest.mark.parametrize("version", [1, 2])
def test_older_recipes_are_read_as_what_they_meant(version):
    new = ("head_follows", "keep_features", "version")
    older = {name: value for name, value in ON.to_dict().items() if name not in new}
    for said, follows in ((True, 100.0), (False, 0.0), (None, 0.0)):
        if said is not None:
            older["whole_head"] = said
        read = Recipe.from_dict({**older, "version": version})
        assert (read.head_follows, read.keep_features) == (follows, False)
        assert Recipe.from_dict(read.to_dict()) == read
        older.pop("whole_head", None)


def test_a_recipe_says_in_words_what_goes_along_where_it_isnt_the_usual():
    assert "head follows" not in Recipe().amount
    assert "head follows 100 %" in WHOLE.amount
    assert "the face alone" in ALONE.amount
    assert "no features kept" in dataclasses.replace(WHOLE, keep_features=False).amount
