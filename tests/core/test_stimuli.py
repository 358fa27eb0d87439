"""Stimuli: the dose is the one asked for, and points, masks and fields are the picture's own."""

import io
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from scenes import oval_face, textured_photo

from kogao_core.lab.stimuli import STIMULI, Posed, Wanted, sheet, stimuli
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe
from kogao_core.warp.measures import measures

DOSES = (-10.0, -5.0, 0.0, 5.0, 10.0)
FACE = oval_face(size=0.5)
PIXELS = textured_photo()
EVERYWHERE = np.random.default_rng(3).uniform((60, 40), (420, 320), (189, 2))


def posed(face=FACE) -> Posed:
    photo = SimpleNamespace(pixels=PIXELS, path=Path("a photo.jpg"))
    return Posed(photo, (face,), (EVERYWHERE,))


def field_at(percent):
    return render(PIXELS, [FACE], replace(STIMULI, percent=percent)).field


@pytest.fixture(scope="module")
def made():
    wanted = Wanted(DOSES, mask="oval", exports=("tfm", "evidence"))
    return {one.percent: one for one in stimuli(posed(), wanted)}


def test_faces_get_smaller_and_larger_by_what_was_asked(made):
    for dose, one in made.items():
        (record,) = one.records
        assert record["asked_percent"] == dose
        assert record["achieved_percent"] == pytest.approx(dose, abs=1e-3)
        assert record["area_change_percent"] == pytest.approx(
            100.0 * ((1.0 - dose / 100.0) ** 2 - 1.0), abs=0.01
        )
        assert record["one_to_one_proven"]
        assert f"{dose:+06.2f}" in one.name
    np.testing.assert_array_equal(made[0.0].pixels[..., :3], PIXELS)


@pytest.mark.parametrize("recipe", [STIMULI, Recipe()])
def test_a_recipe_may_go_below_zero(recipe):
    rendering = render(PIXELS, [FACE], replace(recipe, percent=-6.0))
    assert rendering.achieved[0] == pytest.approx(-6.0, abs=0.01)
    assert rendering.one_to_one.certified


def test_all_points_of_a_file_are_where_the_picture_shows_them(made):
    for dose, one in made.items():
        (points,) = one.points
        assert len(points) == 189
        read = points + field_at(dose).at(points)
        np.testing.assert_allclose(read, EVERYWHERE, atol=1e-3)


def test_measures_are_those_of_known_shapes():
    """An ellipse's width, its chord at the mouth, and its area."""
    face = oval_face(width=960, height=720, size=0.6)
    height = 0.6 * 720
    found = measures(face)
    assert found.width_px == pytest.approx(0.78 * height, rel=0.01)
    down = 0.28 / 0.5
    assert found.jaw_px == pytest.approx(0.78 * height * np.sqrt(1.0 - down**2), rel=0.01)
    assert found.interocular_px == pytest.approx(0.60 * 0.78 * height, rel=1e-6)
    assert found.area_px2 == pytest.approx(
        cv2.contourArea(face.outline.astype(np.float32)), rel=1e-5
    )


def test_masks_follow_the_face(made):
    areas = [(made[dose].pixels[..., 3] > 127).sum() for dose in DOSES]
    assert areas == sorted(areas, reverse=True)
    alpha = made[5.0].pixels[..., 3]
    x, y = np.round(made[5.0].faces[0].middle).astype(int)
    assert (alpha[y, x], alpha[0, 0]) == (255, 0)
    bare = next(stimuli(posed(), Wanted((5.0,))))
    assert bare.pixels.shape == PIXELS.shape
    outline = next(stimuli(posed(), Wanted((5.0,), mask="outline"))).pixels[..., 3]
    polygon = bare.faces[0].outline.astype(np.float32)
    assert (outline > 127).sum() == pytest.approx(cv2.contourArea(polygon), rel=0.02)


def test_aligned_eyes_lie_at_one_place_and_pixels_are_resampled_once():
    size, places = (300, 400), []
    for degrees in (0.0, 20.0):
        turn = cv2.getRotationMatrix2D((240, 180), degrees, 0.9)
        moved = replace(
            FACE,
            **{
                part: getattr(FACE, part) @ turn[:, :2].T + turn[:, 2]
                for part in ("outline", "eyes", "mouth")
            },
        )
        one = next(stimuli(posed(moved), Wanted((0.0,), size=size)))
        assert one.pixels.shape == (400, 300, 3)
        places.append(one.faces[0].eyes.reshape(2, 2, 2).mean(axis=1))
    np.testing.assert_allclose(*places, atol=1e-6)
    np.testing.assert_allclose(places[0], [(0.39 * 300, 180.0), (0.61 * 300, 180.0)], atol=1e-6)
    # As a picture that is read where alignment and warp together say, bilinear against cubic.
    (one,) = stimuli(posed(), Wanted((8.0,), size=size))
    smooth = cv2.GaussianBlur(PIXELS, (0, 0), 3)
    photo = SimpleNamespace(pixels=smooth, path=Path("b.jpg"))
    (blurred,) = stimuli(Posed(photo, (FACE,)), Wanted((8.0,), size=size))
    assert one.records[0]["achieved_percent"] == pytest.approx(8.0, abs=1e-3)
    two = next(stimuli(Posed(photo, (FACE,)), Wanted((0.0,), size=size)))
    assert np.abs(blurred.pixels.astype(int) - two.pixels).max() > 5


def test_itk_moves_points_as_the_field_does(made, tmp_path):
    sitk = pytest.importorskip("SimpleITK")
    for dose in (-10.0, 5.0):
        file = tmp_path / f"{dose}.tfm"
        file.write_bytes(made[dose].files["-face1.tfm"])
        transform = sitk.ReadTransform(str(file))
        assert transform.GetName() == "BSplineTransform"
        points = np.vstack([EVERYWHERE, [(0.0, 0.0), (479.0, 359.0), (-50.0, 1000.0)]])
        itk = [transform.TransformPoint(point) for point in points.tolist()]
        np.testing.assert_allclose(itk, points + field_at(dose).at(points), atol=1e-9)


def test_evidence_moves_pixels_as_the_picture_does(made):
    arrays = np.load(io.BytesIO(made[5.0].files["-evidence.npz"]))
    xs, ys = np.arange(480, dtype=np.float32), np.arange(360, dtype=np.float32)
    x, y = np.moveaxis(arrays["displacement_px"], 2, 0)
    shown = cv2.remap(PIXELS, x + xs, y + ys[:, None], cv2.INTER_CUBIC)
    apart = np.abs(shown.astype(int) - made[5.0].pixels[..., :3])
    assert apart.max() <= 2, "except for rounding to 1/32 px"


def test_the_contact_sheet_has_a_row_a_photo_and_a_column_a_dose(made):
    row = list(made.values())
    picture = cv2.imdecode(np.frombuffer(sheet([row, row]), np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape == (2 * 220, 5 * 200, 3)
