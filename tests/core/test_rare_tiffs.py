"""Rare TIFFs: big ones are read; half floats, planes and inks of 16 bits are refused."""

import files
import numpy as np
import pytest
import tifffile
from scenes import textured_photo

from kogao_core import photo

DEEP = textured_photo(56, 40, 3).astype(np.uint16) * 257 + 5


def read(tmp_path, pixels, **options):
    tifffile.imwrite(tmp_path / "in.tif", pixels, metadata=None, **options)
    return photo.read(tmp_path / "in.tif")


@pytest.mark.parametrize("pixels", [DEEP, DEEP[..., 0].copy(), (DEEP >> 8).astype(np.uint8),
                                    (DEEP / 65535.0).astype(np.float32)])  # fmt: skip
def test_a_big_tiff_is_read_with_its_metadata_and_written_as_an_ordinary_one(tmp_path, pixels):
    xmp = files.XMP.format(1).encode()
    tags = [(700, 1, len(xmp), xmp, True), (271, 2, 0, "Maker", True), (274, 3, 1, 6, True)]
    meaning = "rgb" if pixels.ndim == 3 else "minisblack"
    found = read(tmp_path, pixels, bigtiff=True, extratags=tags,
                 photometric=meaning,
                 iccprofile=files.SRGB if pixels.ndim == 3 else None)  # fmt: skip
    np.testing.assert_array_equal(found.pixels, np.rot90(pixels, -1))
    assert found.xmp == xmp
    assert b"Maker" in found.exif
    changed = found.pixels // 2 if found.bits < 32 else found.pixels / 2
    assert "a BigTIFF becomes an ordinary TIFF" in photo.write(found, changed, tmp_path / "out.tif")
    again = photo.read(tmp_path / "out.tif")
    np.testing.assert_array_equal(again.pixels, changed)
    assert again.icc_profile == found.icc_profile
    assert (tmp_path / "out.tif").read_bytes().startswith(b"II*\0")


PLANES = np.ascontiguousarray(np.moveaxis(DEEP, 2, 0))


@pytest.mark.parametrize(
    ("pixels", "options"),
    [
        (PLANES, {"photometric": "rgb", "planarconfig": "separate"}),
        ((DEEP / 65535.0).astype(np.float16), {"photometric": "rgb"}),
        (np.dstack([DEEP, DEEP[..., 0] // 3]), {"photometric": "separated"}),
        (DEEP.astype(np.uint32), {"photometric": "rgb"}),
        (DEEP.astype(np.float64), {"photometric": "rgb"}),
    ],
    ids=["planes", "half floats", "inks", "32 bits", "64-bit float"],
)
def test_rare_layouts_are_refused(tmp_path, pixels, options):
    with pytest.raises(photo.UnreadablePhoto, match="a TIFF of a kind that Kogao doesn't read"):
        read(tmp_path, pixels, **options)


def test_a_big_tiff_with_its_high_bytes_first_is_refused(tmp_path):
    with pytest.raises(photo.UnreadablePhoto, match="a BigTIFF whose high bytes come first"):
        read(tmp_path, DEEP, bigtiff=True, byteorder=">", photometric="rgb")
