"""A project beside a photo does the same again, also at another resolution of the photo."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import cv2
import numpy as np
import pytest
from few_cases import few_of
from scenes import oval_face, textured_photo

from kogao_core.additions.brush import Brushwork
from kogao_core.base.json_reader import BadFile
from kogao_core.field.protection import Protection
from kogao_core.photo.model import Photo
from kogao_core.pipeline import render
from kogao_core.projects import edits, sidecar
from kogao_core.projects.project import Original, Project, Sheet, load, save
from kogao_core.recipe.recipe import Recipe

WIDTH, HEIGHT = 900, 680
HASH = "a" * 64


def project(**changes):
    faces = (
        dataclasses.replace(oval_face(center=(240.3, 330.7)), recipe=Recipe(percent=8.0)),
        oval_face(center=(640, 330), size=0.9).with_target(10, (645.0, 450.0)),
        oval_face(center=(450, 600), size=0.3),
    )
    protection = Protection().with_stroke(np.array([[420.0, 80.0], [430.0, 620.0]]), 5.0)
    automatic = Sheet(faces, frozenset({2}), Recipe(percent=6.0, interpolation="bilinear"))
    manual = Sheet((oval_face(center=(241, 330)),), recipe=Recipe(percent=3.0))
    original = Original("portrait.png", HASH, WIDTH, HEIGHT)
    work = Brushwork().with_stroke("push", [(180.0, 400.0), (200.0, 395.0)], 40.0)
    work = work.with_stroke("restore", [(560.0, 420.0)], 50.0, 0.7)
    made = Project(original, "automatic", automatic, manual, protection, (), work)
    return dataclasses.replace(made, **changes)


def rendered(applied, pixels):
    return render(
        *(pixels, applied.faces, applied.recipe),
        protection=applied.protection,
        brushwork=applied.brushwork,
    )


def test_it_lies_beside_the_photo_under_its_whole_name():
    assert edits.sidecar_of("a/b.jpg") == Path("a/b.jpg.kogao.json")
    assert edits.sidecar_of("a/b.jpg") != edits.sidecar_of("a/b.png")


def test_the_very_photo_gets_identical_pixels_without_a_word(tmp_path):
    pixels, made = textured_photo(WIDTH, HEIGHT), project()
    save(made, tmp_path / "p.kogao.json")
    applied = sidecar.apply(load(tmp_path / "p.kogao.json"), pixels, HASH)
    assert applied.note == ""
    assert len(applied.faces) == 2
    sheet = made.automatic
    first = render(
        *(pixels, sheet.active, sheet.recipe), protection=made.protection, brushwork=made.brushwork
    ).pixels
    np.testing.assert_array_equal(rendered(applied, pixels).pixels, first)
    assert (first != pixels).any()


@pytest.mark.parametrize("scale", few_of([0.5, 1.7, 0.35], 1))
def test_at_another_resolution_everything_lands_within_a_pixel(scale):
    size = round(WIDTH * scale), round(HEIGHT * scale)
    pixels = cv2.GaussianBlur(textured_photo(WIDTH, HEIGHT), (0, 0), 3.0)
    resized = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    here = sidecar.apply(project(), pixels, HASH)
    there = sidecar.apply(project(), resized, "b" * 64)
    assert "has been scaled" in there.note
    full, other = rendered(here, pixels), rendered(there, resized)
    # Where pixels come from, in px of the larger of the two.
    grid = np.stack(np.meshgrid(np.arange(0, WIDTH, 7.0), np.arange(0, HEIGHT, 7.0)), -1)
    ratio = np.array([size[0] / WIDTH, size[1] / HEIGHT])
    points = grid.reshape(-1, 2)
    same_points = (points + 0.5) * ratio - 0.5
    displacements = full.field.at(points), other.field.at(same_points) / ratio
    assert np.abs(displacements[0]).max() > 4.0
    assert np.linalg.norm(displacements[0] - displacements[1], axis=1).max() * max(1.0, scale) < 1.0
    # And what is seen is the same picture, resized.
    expected = cv2.resize(full.pixels, size, interpolation=cv2.INTER_AREA).astype(float)
    error = np.abs(other.pixels - expected).mean()
    assert error < 0.25 * np.abs(resized - expected).mean()


@pytest.mark.parametrize("mode", ["automatic", "manual"])
def test_what_lies_far_outside_the_photo_is_refused_in_either_mode(mode):
    pixels, whole = textured_photo(WIDTH, HEIGHT), project(mode=mode)
    far = oval_face(center=(60 * WIDTH, 100.0))
    for strange in (
        dataclasses.replace(whole, automatic=Sheet((far,))),
        dataclasses.replace(whole, manual=Sheet((far,))),
        dataclasses.replace(whole, protection=Protection().with_stroke([[0.0, 1e6]])),
        dataclasses.replace(
            whole, brushwork=Brushwork().with_stroke("restore", [[0.0, 1e6]], 20.0)
        ),
    ):
        with pytest.raises(BadFile, match="far outside the photo, which ends at") as refused:
            sidecar.apply(strange, pixels, HASH)
        assert "\n" not in str(refused.value)


def test_the_mode_decides_whose_faces_count():
    pixels = textured_photo(WIDTH, HEIGHT)
    applied = sidecar.apply(project(mode="manual", brushwork=Brushwork()), pixels, HASH)
    assert [len(applied.faces), applied.recipe.percent] == [1, 3.0]
    assert applied.what == "1 face made smaller: 3 %"
    assert sidecar.apply(project(), pixels).what.endswith("; 2 strokes of a brush")
    evened = dataclasses.replace(applied, recipe=Recipe(percent=0, jaw_width=-8, even_out=50))
    assert evened.what.endswith(": 0 %, even out 50 %, jaw width -8 %")


def test_names_that_are_no_text_are_written_as_text(tmp_path):
    pixels = textured_photo(WIDTH, HEIGHT)
    path = Path("secret/folder/a\nb\x1b\udcff\u3000c.jpg")
    original = sidecar.original(Photo(pixels, path, "JPEG", picture=HASH))
    save(project(original=original), tmp_path / "p.json")
    assert load(tmp_path / "p.json").original == Original("a?b??\u3000c.jpg", HASH, WIDTH, HEIGHT)
