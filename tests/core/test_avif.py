"""AVIF: what Pillow's libavif does to a photo, and what it would do to its metadata."""

import re
import struct

import cv2
import files
import numpy as np
import pytest
from scenes import textured_photo

from kogao_core import photo
from kogao_core.photo import in_place


@pytest.fixture
def source(tmp_path):
    return files.opened(tmp_path / "in.png", files.png(textured_photo(64, 48, 3), 6))


@pytest.mark.parametrize("block", [b"Exif\0\0no TIFF at all", b"Exif\0\0II*\0\x08"])
def test_a_block_that_is_none_is_left_out_and_said(source, tmp_path, block):
    damaged = photo.Photo(source.pixels, source.path, "PNG", exif=block)
    said = photo.write(damaged, source.pixels // 2, tmp_path / "out.avif")
    assert "the EXIF block is damaged, and AVIF can't hold it" in said
    assert photo.read(tmp_path / "out.avif").exif is None


writes_avif = pytest.mark.skipif(
    not cv2.haveImageWriter("a.avif"), reason="this OpenCV writes no AVIF, as on Windows"
)


@writes_avif
@pytest.mark.parametrize("bits", [10, 12])
def test_more_bits_stay_in_place_and_in_other_formats(tmp_path, bits):
    path = tmp_path / "in.avif"
    fine = textured_photo(64, 48, 3).astype(np.uint16) << (bits - 8)
    fine += np.arange(64, dtype=np.uint16)[:, None] % (1 << (bits - 8))
    how = [cv2.IMWRITE_AVIF_DEPTH, bits, cv2.IMWRITE_AVIF_QUALITY, 100]
    shown = files.opened(path, cv2.imencode(".avif", fine[..., ::-1], how)[1].tobytes())
    assert (shown.bits, shown.notes) == (16, ())
    off = shown.pixels * ((2**bits - 1) / 65535) - fine
    assert np.abs(off).mean() < 1.0  # of 1023 or 4095 levels
    in_place.check_in_place(shown)
    changed = 65535 - shown.pixels
    assert photo.write(shown, changed, tmp_path / "out.avif") == "stored with 10 bits"
    again = photo.read(tmp_path / "out.avif").pixels
    assert np.abs(again.astype(int) - changed).mean() < 200
    photo.write(shown, changed, tmp_path / "out.png")
    np.testing.assert_array_equal(photo.read(tmp_path / "out.png").pixels, changed)
    assert photo.read(path, bits=8).bits == 8


@writes_avif
def test_grey_is_not_made_rgb_in_place(tmp_path):
    grey = np.tile(np.arange(64, dtype=np.uint8), (48, 1))
    data = cv2.imencode(".avif", grey)[1].tobytes()
    shown = files.opened(tmp_path / "in.avif", data)
    assert shown.channels == 1
    with pytest.raises(photo.RefusedOutput, match="as RGB instead of grey"):
        in_place.check_in_place(shown)


def test_another_brand_before_it_is_still_avif(tmp_path):
    data = files.avif(np.zeros((16, 16, 3), np.uint8))
    (tmp_path / "in.avif").write_bytes(data.replace(b"ftypavif", b"ftypmif1", 1))
    assert photo.read(tmp_path / "in.avif").format == "AVIF"


def test_a_gain_map_as_iso_21496_has_it_is_named_where_it_cannot_be_written(tmp_path):
    data = files.avif(textured_photo(64, 48, 3))
    item = re.compile(rb"(infe\x02.{7})mime", re.DOTALL)  # the XMP packet's
    source = files.opened(tmp_path / "in.avif", item.sub(rb"\1tmap", data))
    for suffix in (".avif", ".jpg"):
        said = photo.write(source, source.pixels // 2, tmp_path / f"out{suffix}")
        assert "not kept: the HDR gain map" in said


def test_a_gain_map_and_a_depth_map_beside_the_picture_are_named(tmp_path):
    for name, words in (
        (b"urn:com:apple:photo:2020:aux:hdrgainmap\0", "the HDR gain map"),
        (b"urn:mpeg:mpegB:cicp:systems:auxiliary:depth\0", "the depth map"),
        (b"urn:mpeg:mpegB:cicp:systems:auxiliary:alpha\0", ""),
    ):
        (tmp_path / "in.avif").write_bytes(
            files.avif(textured_photo(64, 48, 3))
            + struct.pack(">I", 8 + len(name))
            + b"free"
            + name
        )
        names = [extra.name for extra in photo.read(tmp_path / "in.avif").extras]
        named = [name for name in names if name != "the maker's note"]
        assert [words in one for one in named] == [True] * bool(words)
