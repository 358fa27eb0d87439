"""What a JPEG file's data cost and hold is told before, and rare kinds are what they are."""

import re

import files
import jpeglib
import numpy as np
import pytest
from files import segment
from PIL import ImageFile, JpegImagePlugin
from scenes import textured_photo

from kogao_core import photo
from kogao_core.photo import UnreadablePhoto
from kogao_core.photo.jpeg.decoding import MOST_SCANS

FRAME = re.compile(rb"\xff[\xc0-\xc2]\0[\x0b\x11]\x08")


def encoded(pixels, **options):
    return files.saved(pixels, "JPEG", **options)


def in_scans(count, more=b""):
    """Return a progressive JPEG of some scans, the last of its own repeated."""
    data = encoded(textured_photo(48, 40, 3), progressive=True)
    starts = [found.start() for found in re.finditer(rb"\xff\xda", data)]
    last = data[starts[-1] : -2]
    return data[:-2] + (more + last) * (count - len(starts)) + data[-2:]


def claiming(data, side):
    """Return a JPEG that claims to be `side` px wide and high."""
    at = FRAME.search(data).start() + 5
    return data[:at] + side.to_bytes(2, "big") * 2 + data[at + 4 :]


@pytest.fixture
def decoded(monkeypatch):
    """Return the list of pictures that were decoded from JPEG files."""
    seen = []

    def load(image, really=ImageFile.ImageFile.load):
        seen.extend([image] if image.fp is not None and image.tile else [])
        return really(image)

    monkeypatch.setattr(JpegImagePlugin.JpegImageFile, "load", load)
    return seen


def refusal(path, data):
    path.write_bytes(data)
    with pytest.raises(UnreadablePhoto) as problem:
        photo.read(path)
    return str(problem.value)


def test_scans_beyond_count_are_refused_before_they_are_decoded(tmp_path, decoded):
    path = tmp_path / "in.jpg"
    assert not decoded
    path.write_bytes(in_scans(MOST_SCANS) + b"\xff\xda\0\2" * 999)  # behind the end there are none
    assert photo.read(path).width == 48
    remark = segment(0xFE, b"\xff\xda" * 9)  # a remark isn't a scan, whatever it holds
    path.write_bytes(in_scans(40, remark))
    assert photo.read(path).width == 48
    too_many = in_scans(MOST_SCANS + 1), in_scans(10)[:-2] + segment(0xFE, b"") * 2000
    for data in too_many:
        assert f"more than {MOST_SCANS} scans" in refusal(path, data)
    assert len(decoded) == 2


@pytest.mark.parametrize("progressive", [False, True])
@pytest.mark.parametrize("sampling", [0, 2])
def test_more_pixels_than_data_are_refused_and_a_flat_picture_is_not(
    tmp_path, decoded, progressive, sampling
):
    path = tmp_path / "in.jpg"
    options = {"progressive": progressive, "subsampling": sampling, "optimize": True}
    path.write_bytes(encoded(np.full((800, 900, 3), 90, np.uint8), **options))
    assert photo.read(path).width == 900
    data = claiming(encoded(textured_photo(48, 40, 3), **options), 9000)
    assert "damaged or incomplete" in refusal(path, data)
    assert len(decoded) == 1


@pytest.mark.parametrize("progressive", [False, True])
def test_a_jpeg_without_its_end_marker_is_read_with_a_word(tmp_path, progressive):
    path, cut = tmp_path / "in.jpg", tmp_path / "cut.jpg"
    path.write_bytes(encoded(textured_photo(80, 64, 3), quality=95, progressive=progressive))
    cut.write_bytes(path.read_bytes()[:-2])
    whole, source = photo.read(path), photo.read(cut)
    np.testing.assert_array_equal(source.pixels, whole.pixels)
    assert source.notes == ("the file is slightly damaged: its end marker is missing",)
    pixels = source.pixels.copy()
    pixels[:8, :8] ^= 255
    said = photo.write(source, pixels, tmp_path / "out.jpg")
    assert "of the JPEG unchanged" in said
    photo.write(whole, pixels, path, force=True)
    assert (tmp_path / "out.jpg").read_bytes() == path.read_bytes()
    for lacking in (6, 20, 400):
        assert "damaged or incomplete" in refusal(cut, whole_bytes(progressive)[:-lacking])


def whole_bytes(progressive):
    return encoded(textured_photo(80, 64, 3), quality=95, progressive=progressive)


@pytest.mark.parametrize("more", [[], ["+PROGRESSIVE_MODE"]])
def test_arithmetic_coding_is_read(tmp_path, more):
    down, across = np.mgrid[:64, :80].astype(np.uint8)
    pixels = np.dstack([3 * across, 2 * down, across + down])
    path = tmp_path / "in.jpg"
    with jpeglib.version("9e"):
        jpeglib.from_spatial(pixels).write_spatial(str(path), qt=95, flags=["+ARITH_CODE", *more])
    assert re.search(rb"\xff[\xc9\xca]\0\x11\x08", path.read_bytes())
    source = photo.read(path)
    assert np.abs(source.pixels.astype(int) - pixels).mean() < 3
    said = photo.write(source, 255 - source.pixels, tmp_path / "out.jpg")
    assert said.endswith("compressed again: it is coded in a rare way")


def test_a_lossless_jpeg_is_read(tmp_path):
    path = tmp_path / "in.jpg"
    table = segment(0xC4, b"\0" + bytes([1] + [0] * 15) + b"\0")  # one code: no difference
    frame = segment(0xC3, b"\x08\0\x08\0\x08\1\1\x11\0")
    path.write_bytes(
        b"\xff\xd8" + frame + table + segment(0xDA, b"\1\1\0\1\0\0") + bytes(8) + b"\xff\xd9"
    )
    source = photo.read(path)
    assert (source.pixels == 128).all()
    said = photo.write(source, 255 - source.pixels, tmp_path / "out.jpg")
    assert said.endswith("compressed again: it was lossless")


@pytest.mark.parametrize(("code", "depth"), [(0xC5, 8), (0xC1, 12), (0xF7, 8)])
def test_kinds_that_nobody_decodes_are_not_called_damaged(tmp_path, code, depth):
    data = encoded(textured_photo(48, 40, 3))
    at = FRAME.search(data).start()
    data = data[: at + 1] + bytes([code]) + data[at + 2 : at + 4] + bytes([depth]) + data[at + 5 :]
    assert "of a rare kind (hierarchical, or deeper" in refusal(tmp_path / "in.jpg", data)
