"""A file made of bands is the file that the library writes at once, bit for bit."""

import dataclasses
import io

import numpy as np
import pytest
from PIL import Image
from scenes import textured_photo

from kogao_core.photo.jpeg import bands, coefficients


def read(folder, pixels, **options):
    with io.BytesIO() as file:
        Image.fromarray(pixels).save(file, "JPEG", **options)
        return coefficients.read(file.getvalue(), folder / "read")


@pytest.fixture
def at_once_and_in_bands(tmp_path, monkeypatch):
    def both(whole):
        before = [plane.copy() for plane in whole.planes]
        monkeypatch.setattr(bands, "_BAND_BYTES", 1 << 40)
        at_once = coefficients.write(whole, tmp_path)
        monkeypatch.setattr(bands, "_BAND_BYTES", 20_000)
        in_bands = coefficients.write(whole, tmp_path)
        for plane, was in zip(whole.planes, before, strict=True):
            np.testing.assert_array_equal(plane, was)
        return at_once, in_bands

    return both


@pytest.mark.parametrize("quality", [30, 88])
@pytest.mark.parametrize("size", [(317, 203), (320, 208)])
@pytest.mark.parametrize("kind", ["4:4:4", "4:2:2", "4:2:0", "grey"])
def test_bands_make_the_file_that_is_made_at_once(
    tmp_path, at_once_and_in_bands, kind, size, quality
):
    picture, options = textured_photo(*size, 3), {"subsampling": kind}
    if kind == "grey":
        picture, options = picture[..., 0].copy(), {}
    whole = read(tmp_path, picture, quality=quality, **options)
    assert len(bands.cuts(whole.planes, whole.frame.factors)) == 2
    at_once, in_bands = at_once_and_in_bands(whole)
    assert len(bands.cuts(whole.planes, whole.frame.factors)) > 4
    assert in_bands == at_once


@pytest.mark.parametrize("rows", [[7], [7, 8, 9], [-1], range(26)])
def test_nothing_is_cut_behind_a_block_without_an_end(tmp_path, at_once_and_in_bands, rows):
    """Its last bit may be 1, as those are that fill a byte."""
    whole = read(tmp_path, textured_photo(320, 208, 3), subsampling="4:4:4")
    whole.planes[-1][list(rows), -1, 63] = 1
    at_once, in_bands = at_once_and_in_bands(whole)
    at = bands.cuts(whole.planes, whole.frame.factors)
    assert not {row % 26 + 1 for row in rows} & set(at[1:-1])
    assert in_bands == at_once


def around(folder, whole, first, end):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bands, "_BAND_BYTES", 1000)
        return coefficients.around(whole, first, end, folder)


def change(whole, first, end):
    """Turn rows of units round, all but the last one, and leave the rest."""
    for plane, (down, _) in zip(whole.planes, whole.frame.factors, strict=True):
        rows = slice(first * down, (end - 1) * down)
        plane[rows] = plane[rows][:, ::-1].copy()


@pytest.mark.parametrize("rows", [(0, 7), (5, 9), (6, -1), (9, None)])
@pytest.mark.parametrize("size", [(317, 203), (320, 416)])
@pytest.mark.parametrize("kind", ["4:4:4", "4:2:2", "4:2:0", "grey"])
def test_data_around_changed_rows_serve_again(tmp_path, kind, size, rows):
    picture, options = textured_photo(*size, 3), {"subsampling": kind}
    if kind == "grey":
        picture, options = picture[..., 0].copy(), {}
    whole = read(tmp_path, picture, **options)
    first, end, _ = slice(*rows).indices(bands.rows_of(whole.planes, whole.frame.factors))
    rest = around(tmp_path, whole, first, end)
    assert (rest.before.length > 0, rest.after.length > 0) == (first > 0, rows[1] is not None)
    change(whole, first, end)
    assert coefficients.write(whole, tmp_path, rest) == coefficients.write(whole, tmp_path)


def test_data_around_rows_are_not_told_by_what_repeats_itself(tmp_path):
    picture = np.tile(textured_photo(320, 16, 3), (13, 1, 1))
    picture[72:104] = textured_photo(320, 208, 3)[72:104]
    whole = read(tmp_path, picture, subsampling="4:4:4")
    assert around(tmp_path, whole, 4, 20) is None
    assert around(tmp_path, whole, 9, 12)


@pytest.mark.parametrize(
    "options", [{"restart_marker_rows": 1}, {"optimize": True}, {"progressive": True}]
)
def test_only_one_scan_with_usual_codes_is_looked_through(tmp_path, options):
    picture = textured_photo(320, 208, 3)
    assert around(tmp_path, read(tmp_path, picture), 5, 9)
    assert around(tmp_path, read(tmp_path, picture, **options), 5, 9) is None


@pytest.mark.parametrize("scans", [b"\xff\xd0", b"\xff\xff", b"\0", b""])
def test_data_that_another_encoder_ends_otherwise_do_not_serve(tmp_path, scans):
    whole = read(tmp_path, textured_photo(320, 208, 3))
    data = bytes(whole.scans[:-2]) + scans + b"\xff\xd9"
    odd = dataclasses.replace(whole, scans=memoryview(data))
    assert (around(tmp_path, odd, 5, 9) is None) == bool(scans)


def test_rows_that_lose_their_end_are_written_with_all_others(tmp_path):
    whole = read(tmp_path, textured_photo(320, 208, 3), subsampling="4:4:4")
    rest = around(tmp_path, whole, 20, 26)
    whole.planes[-1][-1, -1, 63] = 1
    assert rest
    assert coefficients.write(whole, tmp_path, rest) == coefficients.write(whole, tmp_path)
