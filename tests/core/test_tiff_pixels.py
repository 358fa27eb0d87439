"""Uncompressed TIFF pixels are taken from the file and put there as they are; rare kinds aren't."""

import io
import sys
import tracemalloc

import cv2
import files
import numpy as np
import pytest
import tifffile
from scenes import textured_photo

from kogao_core import photo
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats import colour
from kogao_core.photo.formats import tiff as tiff_format
from kogao_core.photo.metadata import tiff

DEEP = textured_photo(56, 40, 3).astype(np.uint16) * 257 + 5
PLANES = np.ascontiguousarray(np.moveaxis(DEEP, 2, 0))
SHAPES = [(37, 51), (37, 51, 3), (300, 400, 3), (37, 51, 4), (2, 70_000)]


def noise(shape, dtype):
    return np.random.default_rng(5).integers(0, 60_000, shape).astype(dtype)


def read(path):
    with path.open("rb") as file:
        return tiff_format.read_plain(file, tiff.TiffTags.read(file))


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_a_decoder_finds_the_pixels_that_were_laid_out(tmp_path, shape, dtype):
    pixels = noise(shape, dtype)
    directory, stored = tiff_format.laid_out(pixels)
    with io.BytesIO() as head:
        directory.save(head)
        data = head.getvalue() + stored
    np.testing.assert_array_equal(colour.decoded_deep(data), pixels)
    assert np.shares_memory(stored, pixels)
    if dtype != np.uint8:
        (tmp_path / "out.tif").write_bytes(data)
        np.testing.assert_array_equal(read(tmp_path / "out.tif"), pixels)


@pytest.mark.parametrize(
    ("tag", "value"),
    [(259, 5), (266, 2), (322, 16), (258, (16, 16, 8)), (339, (1, 1, 3)), (279, 9), (273, (8, 9))],
)
def test_what_lies_there_otherwise_takes_a_decoder(tmp_path, tag, value):
    path = tmp_path / "in.tif"
    path.write_bytes(files.tiff(noise((37, 51, 3), np.uint16)))
    assert read(path) is not None
    with path.open("rb") as file:
        tags = tiff.TiffTags.read(file)
        tags.tags[tag] = value
        assert tiff_format.read_plain(file, tags) is None


def test_a_file_that_became_shorter_is_damaged(tmp_path):
    path = tmp_path / "in.tif"
    path.write_bytes(files.tiff(noise((37, 51), np.uint16)))
    with path.open("r+b") as file:
        tags = tiff.TiffTags.read(file)
        file.truncate(1000)
        with pytest.raises(ValueError, match="cannot reshape"):
            tiff_format.read_plain(file, tags)


def with_peak(act):
    """Return what an act returns, and the most memory that it takes beside what was there."""
    tracemalloc.start()
    try:
        return act(), tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.skipif(sys.platform != "linux", reason="open files have a path on Linux only")
def test_a_compressed_deep_photo_is_held_once_to_read_it(tmp_path):
    pixels = noise((600, 800, 3), np.uint16)
    cv2.imwrite(str(tmp_path / "in.tif"), pixels, [cv2.IMWRITE_TIFF_COMPRESSION, 8])
    photo.read(tmp_path / "in.tif")  # modules are loaded once
    _, read_bytes = with_peak(lambda: photo.read(tmp_path / "in.tif"))
    assert read_bytes < 1.5 * pixels.nbytes


@pytest.mark.parametrize("compression", [5, 8])
def test_a_compressed_photo_is_coded_in_bands_as_at_once(tmp_path, monkeypatch, compression):
    pixels = noise((601, 333, 3), np.uint16)
    cv2.imwrite(str(tmp_path / "in.tif"), pixels, [cv2.IMWRITE_TIFF_COMPRESSION, compression])
    source = photo.read(tmp_path / "in.tif")
    for name, size in (("bands.tif", 1 << 16), ("whole.tif", 1 << 30)):
        monkeypatch.setattr(tiff_format, "_BAND_BYTES", size)
        photo.write(source, source.pixels // 2, tmp_path / name)
    assert (tmp_path / "bands.tif").read_bytes() == (tmp_path / "whole.tif").read_bytes()
    np.testing.assert_array_equal(photo.read(tmp_path / "bands.tif").pixels, source.pixels // 2)


@pytest.mark.parametrize("share", [0.3, 0.9, 0.999])
def test_damage_in_compressed_strips_is_noticed(tmp_path, share):
    path = tmp_path / "in.tif"
    cv2.imwrite(str(path), noise((300, 400, 3), np.uint16), [cv2.IMWRITE_TIFF_COMPRESSION, 8])
    data, strips = bytearray(path.read_bytes()), 300 * 400 * 6
    at = 8 + int(share * strips)
    data[at - 200 : at] = bytes(200)
    path.write_bytes(data)
    with pytest.raises(UnreadablePhoto, match="damaged"):
        photo.read(path)


def test_a_deep_photo_is_held_once_to_read_it_and_not_again_to_write_it(tmp_path):
    pixels = noise((600, 800, 3), np.uint16)
    cv2.imwrite(str(tmp_path / "in.tif"), pixels, [cv2.IMWRITE_TIFF_COMPRESSION, 1])
    photo.read(tmp_path / "in.tif")  # modules are loaded once
    source, read_bytes = with_peak(lambda: photo.read(tmp_path / "in.tif"))
    changed = source.pixels // 2
    _, written_bytes = with_peak(lambda: photo.write(source, changed, tmp_path / "out.tif"))
    assert read_bytes < 1.5 * pixels.nbytes
    assert written_bytes < 0.5 * pixels.nbytes


@pytest.mark.parametrize(
    ("pixels", "options"),
    [
        (PLANES, {"photometric": "rgb", "planarconfig": "separate"}),
        ((DEEP / 65535.0).astype(np.float16), {"photometric": "rgb"}),
        (np.dstack([DEEP, DEEP[..., 0] // 3]), {"photometric": "separated"}),
        (DEEP.astype(np.uint32), {"photometric": "rgb"}),
        (DEEP.astype(np.float64), {"photometric": "rgb"}),
        (DEEP, {"bigtiff": True, "byteorder": "<"}),
        (DEEP, {"bigtiff": True, "byteorder": ">"}),
    ],
    ids=["planes", "half floats", "inks", "32 bits", "64-bit float", "big", "big-endian big"],
)
def test_rare_layouts_are_refused(tmp_path, pixels, options):
    tifffile.imwrite(tmp_path / "in.tif", pixels, metadata=None, **options)
    why = "is a BigTIFF; save it as an ord" if "bigtiff" in options else "Kogao doesn't read"
    with pytest.raises(photo.UnreadablePhoto, match=why):
        photo.read(tmp_path / "in.tif")
