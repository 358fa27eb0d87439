"""A photo tells its focal length, or a sentence says why nobody knows it."""

import dataclasses
import json

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image
from PIL.ExifTags import Base as Tag
from scenes import textured_photo

import kogao_core as kogao
from kogao_core.additions.lens import distance_m, stretch_percent
from kogao_core.base.geometry import Box
from kogao_core.cli import reading
from kogao_core.cli.commands import program
from kogao_core.photo.optics import optics_of
from kogao_core.recipe.recipe import Recipe

WHOLE = {Tag.FocalLength: 4.2, Tag.FocalLengthIn35mmFilm: 26}
SENSOR = {  # a sensor of 22.3 x 14.9 mm
    Tag.FocalLength: 18.0,
    Tag.ExifImageWidth: 600,
    Tag.ExifImageHeight: 400,
    Tag.FocalPlaneXResolution: 600 / 22.3 * 25.4,
    Tag.FocalPlaneYResolution: 400 / 14.9 * 25.4,
    Tag.FocalPlaneResolutionUnit: 2,
}


def saved(folder, size, tags, *, xmp=None, orientation=1):
    exif, path = Image.Exif(), folder / "photo.jpg"
    exif[Tag.Orientation] = orientation
    exif[Tag.Make] = tags.get(Tag.Make, "Nobody's")
    exif.get_ifd(Tag.ExifOffset).update({k: v for k, v in tags.items() if k != Tag.Make})
    more = {} if xmp is None else {"xmp": xmp}
    Image.fromarray(textured_photo(*size, 3)).save(path, exif=exif, quality=95, **more)
    return path


@pytest.mark.parametrize(
    ("size", "tags", "focal_mm"),
    [
        ((600, 400), WHOLE, 26.0),
        ((300, 400), WHOLE, 26.0),
        ((600, 400), {**WHOLE, Tag.ExifImageWidth: 600, Tag.ExifImageHeight: 400}, 26.0),
        ((400, 600), {**WHOLE, Tag.ExifImageWidth: 600, Tag.ExifImageHeight: 400}, 26.0),
        ((600, 400), SENSOR, 29.0),
        ((600, 400), {**SENSOR, Tag.FocalLengthIn35mmFilm: 29}, 29.0),
    ],
)
def test_a_whole_photo_tells_its_focal_length(tmp_path, size, tags, focal_mm):
    optics = optics_of(kogao.read(saved(tmp_path, size, tags)))
    assert optics.focal_mm == pytest.approx(focal_mm, abs=0.15)
    assert not optics.why
    assert optics.settled(Recipe(lens="auto")).lens == optics.focal_mm
    assert optics.settled(Recipe(lens=40.0)) == Recipe(lens=40.0)


def test_a_photo_that_is_turned_counts_as_it_was_taken(tmp_path):
    tags = {**WHOLE, Tag.ExifImageWidth: 600, Tag.ExifImageHeight: 400}
    photo = kogao.read(saved(tmp_path, (600, 400), tags, orientation=6))
    assert (photo.width, photo.height) == (400, 600)
    assert optics_of(photo).focal_mm == 26.0


@pytest.mark.parametrize(
    ("size", "tags", "word"),
    [
        ((600, 400), {}, "doesn't tell"),
        ((600, 400), {Tag.FocalLength: 50.0}, "doesn't tell"),
        ((600, 400), {Tag.FocalLengthIn35mmFilm: 0}, "doesn't tell"),
        ((500, 400), WHOLE, "cropped"),
        ((400, 400), WHOLE, "cropped"),
        ((600, 338), WHOLE, "cropped"),
        ((300, 200), {**WHOLE, Tag.ExifImageWidth: 600, Tag.ExifImageHeight: 400}, "600 x 400"),
        ((600, 400), {**SENSOR, Tag.FocalLengthIn35mmFilm: 50}, "cropped"),
        ((600, 400), {**WHOLE, Tag.DigitalZoomRatio: 2.0}, "cropped"),
        ((600, 400), {**WHOLE, Tag.CustomRendered: 6}, "panorama"),
        ((600, 400), {**WHOLE, Tag.LensModel: "8mm F3.5 Fisheye"}, "fisheye"),
        ((600, 400), {**WHOLE, Tag.Make: "GoPro"}, "action camera"),
    ],
)
def test_otherwise_a_sentence_says_why_it_is_not_known(tmp_path, size, tags, word):
    optics = optics_of(kogao.read(saved(tmp_path, size, tags)))
    assert optics.focal_mm is None
    assert word in optics.why
    assert optics.settled(Recipe(lens="auto")).lens == "off"
    assert word in optics.note(Recipe(lens="auto"))
    assert not optics.note(Recipe())
    assert not optics.note(Recipe(lens=26.0))


def test_a_panorama_says_so_in_its_xmp(tmp_path):
    xmp = (
        b'<x xmlns:GPano="http://ns.google.com/photos/1.0/panorama/" GPano:UsePanoramaViewer="1"/>'
    )
    assert "panorama" in optics_of(kogao.read(saved(tmp_path, (600, 400), WHOLE, xmp=xmp))).why


@pytest.mark.parametrize(
    ("tags", "lens", "recorded", "word"),
    [
        (WHOLE, "auto", 26.0, ""),
        ({}, "auto", "off", "doesn't tell its focal length"),
        ({}, "28", 28.0, ""),
        (WHOLE, "off", "off", ""),
    ],
)
def test_the_command_goes_by_the_photo_or_by_what_is_said(tmp_path, tags, lens, recorded, word):
    face = kogao.template_face((420, 60), 90)
    points, path = tmp_path / "points.json", saved(tmp_path, (600, 400), tags)
    points.write_text(json.dumps({"faces": [face.to_dict()]}))
    out = tmp_path / "out.png"
    told = CliRunner().invoke(
        program,
        ["warp", str(path), "-o", str(out), "--points", str(points), "--amount", "0",
         "--no-hold-background", "--lens", lens, "--json", "-"],
    )  # fmt: skip
    assert told.exit_code == 0, told.output
    found = json.loads(told.stdout)
    assert found["recipe"]["lens"] == recorded
    assert word in " ".join(found["notes"])
    before, after = kogao.read(path).pixels, kogao.read(out).pixels
    assert np.array_equal(before, after) == (recorded == "off")


def test_detect_says_how_far_each_face_is_stretched(tmp_path, monkeypatch):
    face = kogao.template_face((420, 60), 90)
    monkeypatch.setattr(reading, "find_faces", lambda *_, **__: [face])
    path = saved(tmp_path, (600, 400), WHOLE)
    found = json.loads(CliRunner().invoke(program, ["detect", str(path), "--json", "-"]).stdout)
    assert found["lens"] == {"focal_mm": 26.0, "why": ""}
    percent = found["faces"][0]["stretch_percent"]
    assert percent == pytest.approx(stretch_percent(face, 26.0, Box(0, 0, 600, 400)), abs=0.01)
    distance = found["faces"][0]["distance_m"]
    assert distance["about"] == pytest.approx(distance_m(face, 26.0, Box(0, 0, 600, 400)), abs=1e-3)
    assert distance["least"] < distance["about"] < distance["most"]
    assert found["faces"][0]["nose_percent"] > 5.0
    told = CliRunner().invoke(program, ["detect", str(path)]).stdout
    assert "26 mm" in told
    assert f"{percent:.1f} %" in told
    assert f"about {100 * distance['about']:.0f} cm from the camera" in told


def test_a_damaged_block_is_read_in_silence(tmp_path, recwarn):
    photo = kogao.read(saved(tmp_path, (600, 400), WHOLE))
    for length in range(20, len(photo.exif), 7):
        optics_of(dataclasses.replace(photo, exif=photo.exif[:length]))
    assert not recwarn.list
    nowhere = dataclasses.replace(photo, exif=b"Exif\0\0II*\0\xff\xff\xff\x7f")
    assert "doesn't tell" in optics_of(nowhere).why
