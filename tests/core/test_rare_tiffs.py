"""TIFFs that OpenCV doesn't decode: big ones, half floats, planes, inks of 16 bits."""

import sys

import files
import numpy as np
import pytest
from PIL import Image
from scenes import textured_photo

from kogao_core import photo

tifffile = pytest.importorskip("tifffile", reason="needs the extra [tiff]")
pytest.importorskip("imagecodecs", reason="needs the extra [tiff]")
DEEP = textured_photo(56, 40, 3).astype(np.uint16) * 257 + 5
WAYS = [{}, {"compression": "zlib", "predictor": True}, {"compression": "lzw"}, {"tile": (16, 16)}]


def read(tmp_path, pixels, **options):
    tifffile.imwrite(tmp_path / "in.tif", pixels, metadata=None, **options)
    return photo.read(tmp_path / "in.tif")


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("big", "byteorder"), [(False, "<"), (False, ">"), (True, "<")])
def test_planes_of_16_bits_are_read_exactly(tmp_path, way, big, byteorder):
    planes = np.ascontiguousarray(np.moveaxis(DEEP, 2, 0))
    options = {"photometric": "rgb", "planarconfig": "separate", "bigtiff": big, **way}
    found = read(tmp_path, planes, byteorder=byteorder, **options)
    np.testing.assert_array_equal(found.pixels, DEEP)
    assert found.notes == (("a BigTIFF becomes an ordinary TIFF",) if big else ())


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


@pytest.mark.parametrize("way", WAYS[:2])
def test_half_floats_become_whole_ones_and_it_is_said(tmp_path, way):
    half = (DEEP / 65535.0 * 3.0 - 1.0).astype(np.float16)
    found = read(tmp_path, half, photometric="rgb", **way)
    np.testing.assert_array_equal(found.pixels, half.astype(np.float32))
    assert "converted from 16-bit to 32-bit floating-point numbers" in found.notes


def test_inks_of_16_bits_are_seen_as_those_of_8(tmp_path):
    inks = np.dstack([DEEP, DEEP[..., 0] // 3])
    found = read(tmp_path, inks, photometric="separated")
    seen = Image.fromarray((inks >> 8).astype(np.uint8), "CMYK").convert("RGB")
    np.testing.assert_array_equal(found.pixels, np.asarray(seen))
    assert found.notes == (
        "converted from 16 bits to 8", "converted from CMYK to RGB without a colour profile",
    )  # fmt: skip


def test_what_is_missing_or_of_unknown_colours_is_refused(tmp_path, monkeypatch):
    planes = np.ascontiguousarray(np.moveaxis(DEEP, 2, 0))
    options = {"photometric": "rgb", "planarconfig": "separate"}
    read(tmp_path, planes, compression="zlib", **options)
    data = (tmp_path / "in.tif").read_bytes()
    for cut in (400, 2000, 6000):
        (tmp_path / "in.tif").write_bytes(data[:-cut])
        with pytest.raises(photo.UnreadablePhoto, match="damaged"):
            photo.read(tmp_path / "in.tif")
    for pixels in (DEEP.astype(np.uint32), DEEP.astype(np.float64)):
        with pytest.raises(photo.UnreadablePhoto, match="TIFF of a kind"):
            read(tmp_path, pixels, photometric="rgb")
    with pytest.raises(photo.UnreadablePhoto, match="a BigTIFF whose high bytes come first"):
        read(tmp_path, DEEP, bigtiff=True, byteorder=">", photometric="rgb")
    monkeypatch.setitem(sys.modules, "imagecodecs", None)
    with pytest.raises(photo.UnreadablePhoto, match="a rare kind, which an extra reads"):
        read(tmp_path, planes, **options)
