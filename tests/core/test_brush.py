"""Push and restore: displacements of the same field that never fold and leave the rest alone."""

import dataclasses

import numpy as np
import pytest
from few_cases import few_of
from scenes import oval_face, read_outside_px, textured_photo

from kogao_core.additions.brush import UNTOUCHED, BrushStroke, Brushwork
from kogao_core.additions.limits import OutOfBounds, check_brushwork
from kogao_core.base.geometry import Affine, Box
from kogao_core.base.json_reader import BadFile, Node
from kogao_core.field.one_to_one import LEAST_MEASURED_DET
from kogao_core.field.protection import Protection
from kogao_core.pipeline import render
from kogao_core.projects import json as project_json
from kogao_core.recipe.recipe import LOSSLESS_PX, PAPER, Recipe
from kogao_core.resample.canvas import Canvas

WIDTH, HEIGHT = 640, 480
PHOTO = textured_photo(WIDTH, HEIGHT)
FACE = oval_face(WIDTH, HEIGHT, size=0.5)
RECIPE = Recipe(percent=6)
JAW, CHIN = FACE.outline[4], FACE.outline[len(FACE.outline) // 2]


def beside(x, y):
    """A place so far from the jaw."""
    return JAW + np.array([x, y])


IMAGE = Box.of(PHOTO)


def push(start, by, radius=40.0, strength=1.0, falloff=1.0):
    way = [np.asarray(start), np.asarray(start) + by]
    return Brushwork().with_stroke("push", way, radius, strength, falloff)


def drawn(brushwork, recipe=RECIPE, faces=(FACE,), **others):
    return render(PHOTO, list(faces), recipe, brushwork=brushwork, **others)


def strokes_of(rng, count):
    """Strokes of any kind, anywhere, off the photo's edges too."""
    work = Brushwork()
    for _ in range(count):
        points = rng.uniform((-40, -40), (WIDTH + 40, HEIGHT + 40), 2) + np.cumsum(
            rng.normal(0, 40, (rng.integers(1, 6), 2)), axis=0
        )
        kind = rng.choice(["push", "push", "restore"])
        work = work.with_stroke(
            kind, points, 10 ** rng.uniform(0.9, 2), rng.uniform(0.2, 1), rng.uniform(0.4, 1)
        )
    return work


@pytest.mark.parametrize("recipe", [PAPER, RECIPE, Recipe(percent=15, lattice=0.5)])
def test_a_stroke_that_does_nothing_leaves_every_byte(recipe):
    without = drawn(UNTOUCHED, recipe).pixels
    dot, still, far = (
        Brushwork().with_stroke("push", [JAW], 30.0),
        push(JAW, (30.0, 0.0), strength=0.0),
        Brushwork().with_stroke("restore", [(15.0, 15.0)], 10.0, 1.0),
    )
    for nothing in (dot, still, far):
        rendering = drawn(nothing, recipe)
        np.testing.assert_array_equal(rendering.pixels, without)
        assert rendering.brush_shares == (1.0,)


def test_what_lies_under_a_push_goes_along_and_what_is_beside_it_keeps_its_bytes():
    by = np.array([12.0, -5.0])
    rendering = drawn(push((320.0, 240.0), by), faces=())
    np.testing.assert_allclose(rendering.field.at([(326.0, 237.5)]), [-by], atol=0.15 * 12)
    ys, xs = np.mgrid[:HEIGHT, :WIDTH]
    far = np.hypot(xs - 326.0, ys - 237.5) > 1.6 * 40 + 6
    np.testing.assert_array_equal(rendering.pixels[far], PHOTO[far])
    assert (rendering.pixels != PHOTO).any()
    assert rendering.one_to_one.certified


def test_a_restore_takes_the_face_and_earlier_pushes_back_and_a_later_push_moves_again():
    work = push(JAW, (20.0, 0.0)).with_stroke("restore", [JAW, beside(20, 0)], 90.0, 1.0, 0.4)
    near = JAW + np.random.default_rng(3).uniform(-12, 12, (50, 2)) + (10, 0)
    alone = dataclasses.replace(RECIPE, scope="face")
    moved = drawn(Brushwork(work.strokes[:1]), alone).field.at(near)
    kept = drawn(work, alone)
    assert np.hypot(*moved.T).min() > 5.0
    assert np.hypot(*kept.field.at(near).T).max() < LOSSLESS_PX
    x, y = near.round().astype(int).T
    np.testing.assert_array_equal(kept.pixels[y, x], PHOTO[y, x])
    again = work.with_stroke("push", [JAW, beside(8, 0)], 40.0, 1.0)
    half = drawn(again, alone).field.at([beside(4, 0)])
    np.testing.assert_allclose(half, [(-8.0, 0.0)], atol=1.0)


def test_a_restore_takes_its_share():
    at = CHIN[None]
    whole = drawn(UNTOUCHED).field.at(at)
    work = Brushwork().with_stroke("restore", [CHIN], 120.0, 0.5, 0.4)
    np.testing.assert_allclose(drawn(work).field.at(at), whole / 2, atol=0.02 * np.abs(whole).max())


@pytest.mark.parametrize("seed", few_of(range(40), 3))
def test_no_strokes_fold_or_read_across_the_edges(seed):
    rng = np.random.default_rng(seed)
    faces = [FACE] if seed % 3 else []
    still = Protection()
    if seed % 2:
        still = still.with_stroke(rng.uniform((0, 0), (WIDTH, HEIGHT), (3, 2)), 8.0)
    recipe = Recipe(percent=float(rng.uniform(0, 12)))
    rendering = drawn(strokes_of(rng, 6), recipe, faces, protection=still)
    sound, before = rendering.one_to_one, drawn(UNTOUCHED, recipe, faces, protection=still)
    # A face alone may be proven and come nearer to a fold than what is only measured.
    assert sound.settled or before.one_to_one.min_det < LEAST_MEASURED_DET
    assert sound.min_det > 0.0
    if not faces:
        assert sound.min_det >= LEAST_MEASURED_DET
    # Finer than any sample of the guard.
    xs, ys = np.arange(0.0, WIDTH, 1.7), np.arange(0.0, HEIGHT, 1.7)
    assert rendering.field.det_jacobian(xs, ys).min() > 0.0
    assert read_outside_px(rendering.field, IMAGE) < 0.01


def test_a_push_that_would_fold_is_held_back_alone():
    work = push(JAW, (60.0, 0.0), 20.0)
    for _ in range(3):
        work = Brushwork((*work.strokes, *push(JAW, (60.0, 0.0), 20.0).strokes))
    work = Brushwork((*work.strokes, *push((60.0, 60.0), (5.0, 0.0), 20.0).strokes))
    rendering = drawn(work)
    assert rendering.brush_shares[1] < 1.0
    assert rendering.brush_shares[-1] == 1.0
    assert rendering.shares == (1.0,)


def test_a_limit_acts_only_on_the_part_of_a_stroke_that_squeezes():
    work = push((120.0, 60.0), (400.0, 0.0), 30.0)
    rendering, bare = drawn(work, faces=()), drawn(work, Recipe(guard=False), faces=())
    assert rendering.brush_shares[0] < 0.9
    assert rendering.one_to_one.min_det > 0.15 > bare.one_to_one.min_det
    along = np.column_stack([np.linspace(240.0, 400.0, 40), np.full(40, 60.0)])
    np.testing.assert_allclose(rendering.field.at(along), bare.field.at(along), atol=1e-2)


def test_protected_places_stay_under_a_push():
    still = Protection().with_stroke([beside(0, 30), beside(0, -30)], 6.0)
    held = np.column_stack([np.full(40, JAW[0]), np.linspace(JAW[1] - 28, JAW[1] + 28, 40)])
    work = push(beside(-40, 0), (25.0, 0.0), 30.0)
    after = drawn(work, protection=still)
    assert not after.field.at(held).any()
    assert (after.field.at([beside(-35, 0)]) != drawn(UNTOUCHED).field.at([beside(-35, 0)])).any()


def test_another_resolution_moves_the_same_places():
    work = push(JAW, (20.0, -6.0), 36.0).with_stroke("restore", [CHIN], 50.0, 0.8)
    for scale in (0.4, 2.5):
        size = Affine.resize(scale, scale)
        large = render(
            textured_photo(round(WIDTH * scale), round(HEIGHT * scale)),
            [FACE.mapped(size)], RECIPE, brushwork=work.mapped(size),
        )  # fmt: skip
        at = np.random.default_rng(1).uniform((100, 60), (500, 460), (400, 2))
        small = drawn(work).field.at(at)
        np.testing.assert_allclose(large.field.at(size(at)) / scale, small, atol=0.02)


def test_a_canvas_follows_a_growing_stroke_to_the_bit():
    canvas = Canvas(PHOTO)
    for end in (1, 2, 4, 9, 16):
        way = JAW + np.linspace(0, 1, 16)[:end, None] * (40, 12)
        work = Brushwork().with_stroke("push", way, 30.0, 0.7)
        live = render(PHOTO, [FACE], RECIPE, brushwork=work, canvas=canvas)
        np.testing.assert_array_equal(live.pixels, drawn(work).pixels)


def test_a_pens_pressure_scales_the_strength():
    way = [JAW, beside(10, 0)]
    light = BrushStroke("push", np.array(way), 40.0, 0.8, 1.0, np.array([0.5, 0.5]))
    half = push(JAW, (10, 0), 40.0, 0.4)
    at = JAW[None]
    np.testing.assert_allclose(
        drawn(Brushwork((light,)), faces=()).field.at(at), drawn(half, faces=()).field.at(at)
    )


@pytest.mark.parametrize(
    "change",
    [
        {"kind": "twirl"}, {"points": []}, {"radius": 0.0}, {"radius": 1e9}, {"strength": 1.5},
        {"falloff": 0.3}, {"pressure": [1.0]}, {"pressure": [2.0, 1.0]}, {"colour": 1},
    ],
)  # fmt: skip
def test_a_file_with_a_broken_stroke_is_refused(change):
    (stroke,) = project_json.brushwork_list(push(JAW, (5, 5)), 1024)
    with pytest.raises(BadFile):
        project_json.brushwork(Node([{**stroke, **change}]), 1024)


def test_too_long_and_far_away_strokes_are_refused():
    rng = np.random.default_rng(0)
    scribble = Brushwork().with_stroke("push", rng.uniform(0, 5000, (2000, 2)), 2.0)
    with pytest.raises(OutOfBounds, match="take a larger brush"):
        drawn(scribble)
    with pytest.raises(OutOfBounds):
        check_brushwork(push((1e6, 0), (5, 0)), IMAGE)
