"""Tiles against a slow literal loop, every depth, and bytes that must not change."""

import contextlib
import os
import subprocess
import sys
import textwrap
import threading
from dataclasses import replace

import cv2
import numpy as np
import pytest
import threadpoolctl
from opencv import needs_opencv_4
from scenes import ALONE, oval_face, textured_photo
from timeouts import LONGEST_S

from kogao_core import pipeline
from kogao_core.field.protection import NOTHING, Protection
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import LOSSLESS_PX, SETTINGS, Recipe
from kogao_core.resample import blocks as resample
from kogao_core.resample.blocks import SPANS_PX
from kogao_core.resample.canvas import Canvas

INTERPOLATIONS = SETTINGS["interpolation"].choices


def test_map_error_is_below_a_64th_of_a_pixel():
    """A ramp photo turns read positions into values."""
    width, height = 1300, 900
    x = np.broadcast_to(np.arange(width, dtype=np.float32), (height, width))
    y = np.broadcast_to(np.arange(height, dtype=np.float32)[:, None], (height, width))
    ramp = np.ascontiguousarray(np.dstack([x, y]))
    faces = [oval_face(width, height, center=(500.0, 420.0))]
    rendering = render(ramp, faces, Recipe(percent=6, interpolation="bilinear"))
    read = rendering.pixels.astype(np.float64) - ramp
    displacement = rendering.field.on_grid(np.arange(width), np.arange(height)).transpose(1, 2, 0)
    assert np.abs(read - displacement).max() < 1 / 64 + 1e-3


@pytest.mark.parametrize(
    ("interpolation", "dtype"),
    [("bilinear", np.uint8), ("cubic", np.uint16), ("lanczos4", np.float32)],
)
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@needs_opencv_4("channel counts differ by two units")
def test_every_depth_and_channel_count(interpolation, dtype, channels):
    photo = textured_photo(300, 240, channels, dtype)
    kept = photo.copy()
    rendering = render(photo, [oval_face(300, 240)], Recipe(interpolation=interpolation))
    assert rendering.pixels.dtype == photo.dtype
    assert rendering.pixels.shape == photo.shape
    assert (rendering.pixels != photo).any()
    np.testing.assert_array_equal(photo, kept)
    if channels > 1:
        alone = render(photo[..., 0].copy(), [oval_face(300, 240)], rendering.recipe).pixels
        # OpenCV sums in another order for other channel counts: one unit in the last place.
        unit = 2e-6 if dtype is np.float32 else 1
        np.testing.assert_allclose(rendering.pixels[..., 0].astype(float), alone, rtol=0, atol=unit)


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_the_three_domains_give_the_same_bytes(interpolation):
    photo, faces = textured_photo(600, 400), [oval_face(600, 400)]
    whole, cells, lossless = (
        render(photo, faces, Recipe(interpolation=interpolation, domain=domain)).pixels
        for domain in SETTINGS["domain"].choices
    )
    np.testing.assert_array_equal(whole, cells)
    np.testing.assert_array_equal(whole, lossless)


@pytest.mark.parametrize("threshold_px", [LOSSLESS_PX, 1.0])
def test_pixels_outside_the_domain_keep_their_bytes(threshold_px):
    photo = textured_photo(1200, 700)
    recipe = Recipe(interpolation="lanczos4", threshold_px=threshold_px, percent=8)
    rendering = render(photo, [oval_face(1200, 700, size=0.4)], recipe)
    displacement = rendering.field.on_grid(np.arange(1200), np.arange(700))
    # A position of up to 1200 px is known to within 1e-4 px in single precision.
    outside = np.hypot(*displacement) <= LOSSLESS_PX - 1e-4
    assert outside.mean() > 0.5
    np.testing.assert_array_equal(rendering.pixels[outside], photo[outside])
    changed = np.ones(photo.shape[:2], bool)
    for box in rendering.changed:
        changed[box.slices] = False
    np.testing.assert_array_equal(rendering.pixels[changed], photo[changed])


def test_a_used_canvas_gives_the_same_bits_as_a_fresh_one():
    photo, face = textured_photo(900, 600), oval_face(900, 600)
    canvas, small = Canvas(photo), oval_face(900, 600, size=0.3)
    dragged = face.with_outline_point(0, face.outline[0] + 9.0)
    hard = Protection().with_stroke([(200, 60), (200, 540)], 4.0)
    for moved, percent, still in (
        *((face, 0.0, NOTHING), (dragged, 3.0, NOTHING), (small, 6.0, NOTHING)),
        *((face, 9.0, NOTHING), (face, 9.0, hard), (face, 5.0, hard), (face, 5.0, NOTHING)),
    ):
        recipe = Recipe(percent=percent)
        used = render(photo, [moved], recipe, protection=still, canvas=canvas).pixels
        fresh = render(photo, [moved], recipe, protection=still).pixels
        np.testing.assert_array_equal(used, fresh)


@pytest.mark.parametrize(
    ("where", "after"), [("caller", "the same"), ("helper", "another"), ("caller", "nothing")]
)
def test_a_canvas_is_whole_again_after_an_exception_in_the_middle(monkeypatch, where, after):
    photo, face = textured_photo(1500, 900), oval_face(1500, 900)
    canvas, before, broken = Canvas(photo), Recipe(percent=3), Recipe(percent=9, domain="image")
    render(photo, [face], before, canvas=canvas)
    with monkeypatch.context() as patch:
        patch.setattr(resample.Job, "run", failing_in(where, resample.Job.run))
        with pytest.raises(MemoryError):
            render(photo, [oval_face(1500, 900, size=0.3)], broken, canvas=canvas, threads=2)
    faces = {"the same": [face], "another": [oval_face(1500, 900, size=0.4)], "nothing": []}[after]
    again, fresh = render(photo, faces, before, canvas=canvas), render(photo, faces, before)
    np.testing.assert_array_equal(again.pixels, fresh.pixels)
    np.testing.assert_array_equal(canvas.pixels, fresh.pixels)


HASHING = """
    import zlib
    from scenes import ALONE, oval_face, textured_photo
    from dataclasses import replace
    from kogao_core.pipeline import render
    photo, faces = textured_photo(700, 600), [oval_face(700, 600, size=0.5)]
    for kind, longest_px, fade in (
        ("cubic", 0, 0.0), ("bilinear", 0, 0.0), ("lanczos4", 0, 0.5), ("cubic", 300, 0.0)
    ):
        recipe = replace(ALONE, percent=8.0, interpolation=kind, threshold_px=max(fade, 1 / 64))
        print(zlib.crc32(render(photo, faces, recipe, longest_px=longest_px).pixels.tobytes()))
    """


def test_bytes_are_the_same_on_processors_with_fewer_instructions():
    """OpenBLAS adds in another order, and neither it nor OpenCV fuses products with sums."""
    older = {"OPENBLAS_CORETYPE": "Prescott", "OPENCV_CPU_DISABLE": "AVX2,FP16,AVX"}
    path = os.pathsep.join(filter(None, sys.path))
    hashes = [
        subprocess.run(
            [sys.executable, "-c", textwrap.dedent(HASHING)],
            env={**os.environ, "PYTHONPATH": path, **some}, capture_output=True, text=True,
            check=True,
        ).stdout
        for some in ({}, older)
    ]  # fmt: skip
    assert hashes[0] == hashes[1]


def failing_in(where, run):
    """Return a `Job.run` that fails in one thread, in the middle of the photo."""
    failed, done = threading.Event(), []

    def broken_run(job, number, box, *buffers):
        here = "caller" if threading.current_thread() is threading.main_thread() else "helper"
        if here != where:
            # Wait, so that the other thread gets its share.
            assert failed.wait(LONGEST_S)
        elif len(done) == 15:
            failed.set()
            raise MemoryError
        else:
            done.append(box)
        run(job, number, box, *buffers)

    return broken_run


@pytest.mark.parametrize("fit", SETTINGS["fit"].choices)
def test_a_dragged_landmark_redoes_few_tiles_and_gives_the_same_bits(fit):
    photo = textured_photo(1200, 800)
    canvas, face, recipe = Canvas(photo), oval_face(1200, 800, size=0.7), replace(ALONE, fit=fit)
    whole = render(photo, [face], recipe, canvas=canvas)
    for step in range(1, 4):
        face = face.with_outline_point(10, face.outline[10] + (3.0 * step, 2.0))
        partial = render(photo, [face], recipe, canvas=canvas)
        np.testing.assert_array_equal(partial.pixels, render(photo, [face], recipe).pixels)
        if fit != "exact":
            assert area(partial.changed) < 0.5 * area(whole.changed)
    again = render(photo, [face], recipe, canvas=canvas)
    assert again.changed == []


def area(boxes):
    return sum(box.area for box in boxes)


def test_threads_and_order_make_no_difference():
    photo = textured_photo(1500, 900)
    first = render(photo, [oval_face(1500, 900)], Recipe(), threads=1)
    for threads in (2, 4):
        canvas = Canvas(photo)
        canvas.warp(first.field, first.domain, "cubic", threads)
        np.testing.assert_array_equal(canvas.pixels, first.pixels)


def test_a_pull_longer_than_the_margin_still_reads_the_right_place():
    photo = np.zeros((900, 2400), np.uint8)
    cv2.circle(photo, (1700, 450), 20, 255, -1)
    face = oval_face(2400, 900)
    face = face.with_outline_point(10, (1700.0, 450.0)).with_target(10, (1100.0, 450.0))
    rendering = render(photo, [face], replace(ALONE, percent=0, lattice=2, guard=False))
    assert rendering.field.lattices[0].magnitude_px.max() > 600
    assert rendering.pixels[450, 1100] == 255


def test_images_about_as_large_as_a_span():
    for width in (1, 5, *(size + more for size in SPANS_PX[::3] for more in (-1, 0, 1))):
        photo = textured_photo(width, 40)
        face = oval_face(width, 40, center=(width - 3.0, 20.0), size=0.5)
        assert render(photo, [face], Recipe(percent=8)).pixels.shape == photo.shape


def test_bytes_do_not_depend_on_how_many_threads_blas_has(monkeypatch):
    # threadpoolctl obeys only one Python thread at a time: workers can't rely on its limit.
    monkeypatch.setattr(pipeline, "one_blas_thread", contextlib.nullcontext)
    photo, face, recipe = textured_photo(), oval_face(), Recipe(percent=5.0)
    results = []
    for threads in (1, 2, 4):
        with threadpoolctl.threadpool_limits(limits=threads, user_api="blas"):
            results.append(render(photo, [face], recipe).pixels)
    np.testing.assert_array_equal(results[1], results[0])
    np.testing.assert_array_equal(results[2], results[0])


def test_nothing_is_added_to_what_nobody_has_written(monkeypatch):
    """Neighbours' maps end in different columns: beyond the first one there is none to add to."""
    photo = textured_photo(1300, 700)
    faces = [
        oval_face(1300, 700, center=(1230.0, 200.0), size=0.2),
        oval_face(1300, 700, center=(1200.0, 380.0), size=0.9),
    ]
    expected = render(photo, faces, Recipe(percent=4)).pixels
    empty = np.empty

    def worst(shape, dtype=float, **kwargs):
        array = empty(shape, dtype, **kwargs)
        if array.dtype == np.float32:
            array.view(np.uint32)[...] = 0x7F800001  # a signalling NaN
        return array

    monkeypatch.setattr(np, "empty", worst)
    with np.errstate(invalid="raise"):
        pixels = render(photo, faces, Recipe(percent=4), threads=1).pixels
    np.testing.assert_array_equal(pixels, expected)
