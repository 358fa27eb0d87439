"""``kogao-cli verify``: which blocks and which metadata of two JPEGs differ, and nothing else."""

import json

import numpy as np
import pytest
from PIL import Image
from scenes import textured_photo

from kogao_core import photo
from kogao_core.cli import verify


@pytest.fixture
def original(tmp_path):
    exif = Image.Exif()
    exif[0x10F] = "Maker"
    path = tmp_path / "in.jpg"
    Image.fromarray(textured_photo(200, 120, 3)).save(
        path, quality=90, subsampling="4:2:0", exif=exif, comment=b"as it was"
    )
    return path


@pytest.fixture
def verified(cli, original):
    return lambda result: json.loads(cli("verify", result, original, "--json")[1])


def changed(original, box):
    """Write the photo with a box of pixels inverted."""
    source = photo.read(original)
    pixels = source.pixels.copy()
    left, top, right, bottom = box
    pixels[top:bottom, left:right] ^= 255
    photo.write(source, pixels, result := original.with_name("out.jpg"), force=True)
    return result


@pytest.mark.parametrize(
    ("box", "units", "where"),
    [
        ((50, 40, 51, 41), 1, [48, 32, 64, 48]),
        ((0, 0, 33, 17), 6, [0, 0, 48, 32]),
        ((199, 119, 200, 120), 1, [192, 112, 200, 120]),
    ],
)
def test_every_changed_unit_is_told_and_no_other(verified, original, box, units, where):
    found = verified(changed(original, box))
    assert (found["units"], found["changed_units"], found["box_px"]) == (13 * 8, units, where)
    assert found["metadata"] == []
    assert found["same"] == dict.fromkeys(("size", "subsampling", "tables", "components"), True)


def test_it_is_told_in_a_sentence(works, original):
    said = works("verify", changed(original, (50, 40, 51, 41)), original)
    assert said == (
        "103 of 104 units of blocks are the same, bit for bit; the others lie from 48, 32 to 64, "
        "48 px. The metadata are the same.\n"
    )
    assert "the same, byte for byte" in works("verify", original, original)


@pytest.mark.parametrize(
    ("way", "more"),
    [("optimize", ""), ("progressive", " The frame type changed: SOF2 → SOF0.")],
)
def test_another_way_of_coding_is_named_and_no_change(works, tmp_path, way, more):
    paths = tmp_path / "in.jpg", tmp_path / "again.jpg"
    for path, options in zip(paths, ({}, {way: True}), strict=True):
        Image.fromarray(textured_photo(200, 120, 3)).save(path, quality=90, **options)
    assert works("verify", *paths) == (
        f"All 104 units of blocks are the same, bit for bit. The metadata are the same.{more}\n"
    )


def test_metadata_that_differ_are_named(cli, verified, original, tmp_path):
    data, other = original.read_bytes(), tmp_path / "other.jpg"
    other.write_bytes(
        data.replace(b"Maker", b"maker").replace(b"as it was", b"as it is.") + b"more"
    )
    found = verified(other)
    assert [one["name"] for one in found["metadata"]] == [
        "APP1 Exif",
        "COM",
        "appended data",
    ]
    assert found["metadata"][2] == {
        "name": "appended data",
        "bytes": 4,
        "original_bytes": 0,
    }
    assert found["changed_units"] == 0
    code, said, _ = cli("verify", other, original)
    assert (code, "Different metadata: APP1 Exif" in said) == (1, True)


def test_other_sizes_and_tables_cant_be_compared(cli, original, tmp_path):
    for size, quality, words in (((201, 120), 90, "size"), ((200, 120), 70, "quantisation tables")):
        other = tmp_path / "other.jpg"
        Image.fromarray(textured_photo(*size, 3)).save(other, quality=quality, subsampling="4:2:0")
        code, said, _ = cli("verify", other, original)
        assert (code, f"Different: {words}." in said) == (1, True)


def test_other_component_names_are_other_colours(cli, verified, tmp_path, original):
    data, other = original.read_bytes(), tmp_path / "rgb.jpg"
    at = data.index(b"\xff\xc0") + 10
    names = bytearray(data)
    names[at : at + 9 : 3] = b"RGB"
    scan = data.index(b"\xff\xda") + 5
    names[scan : scan + 6 : 2] = b"RGB"
    other.write_bytes(names)
    assert verified(other)["same"]["components"] is False
    assert cli("verify", other, original)[0] == 1


def test_a_file_without_an_end_has_no_data_after_the_picture(verified, tmp_path, original):
    other = tmp_path / "endless.jpg"
    other.write_bytes(original.read_bytes()[:-2])
    assert verified(other)["metadata"] == []


def test_a_bundle_has_no_second_reader_and_says_so(fails, original, monkeypatch):
    monkeypatch.setattr(verify, "is_bundle", lambda: True)
    other = changed(original, (0, 0, 9, 9))
    fails(1, "this bundle has no second reader", "verify", other, original)


def test_what_is_no_jpeg_or_damaged_is_refused(fails, original, tmp_path):
    png, damaged = tmp_path / "a.png", tmp_path / "damaged.jpg"
    Image.fromarray(np.zeros((9, 9), np.uint8)).save(png)
    damaged.write_bytes(original.read_bytes()[:300])
    fails(2, "is no JPEG; name two JPEGs", "verify", png, original)
    fails(3, "can't be read", "verify", damaged, original)
    fails(3, "can't be read", "verify", tmp_path / "none.jpg", original)
