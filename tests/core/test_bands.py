"""A file made of bands is the file that the library writes at once, bit for bit."""

import io

import numpy as np
import pytest
from PIL import Image
from scenes import textured_photo

from kogao_core.photo import bands, coefficients


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
