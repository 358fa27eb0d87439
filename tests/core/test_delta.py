"""A file as what differs from another one: it comes back byte for byte, and takes little room."""

import files
import numpy as np
import pytest
from PIL import Image
from scenes import textured_photo

from kogao_core import photo
from kogao_core.base.delta import applied, difference


def comes_back(old, new):
    """Return which part of a file its difference from another takes."""
    delta = difference(old, new)
    assert applied(delta, new) == old
    return len(delta) / max(1, len(old))


def jpeg(pixels, **options):
    return files.saved(pixels, "JPEG", quality=90, **options)


@pytest.mark.parametrize("kind", ["4:4:4", "4:2:0", "grey"])
@pytest.mark.parametrize("restarts", [0, 1])
def test_of_a_jpeg_only_what_changed_is_kept(tmp_path, kind, restarts):
    picture = textured_photo(640, 480, 3)
    options = {"subsampling": kind, "restart_marker_rows": restarts}
    if kind == "grey":
        picture = picture[..., 0].copy()
        del options["subsampling"]
    path = tmp_path / "in.jpg"
    path.write_bytes(jpeg(picture, **options) + b"\xff\x00 a trailer \xff\xff\x00")
    source = photo.read(path)
    rng = np.random.default_rng(0)
    for n in range(3):
        pixels = source.pixels.copy()
        top, left = rng.integers(0, (400, 560))
        pixels[top : top + 64, left : left + 64] //= 2  # 1.3 to 3.3 % of all units
        photo.write(source, pixels, tmp_path / f"{n}.jpg")
        assert comes_back(path.read_bytes(), (tmp_path / f"{n}.jpg").read_bytes()) < 0.1


def test_of_plain_pixels_only_what_changed_is_kept(tmp_path):
    tiff = tmp_path / "in.tif"
    Image.fromarray(textured_photo(640, 480, 3)).save(tiff)
    source = photo.read(tiff)
    pixels = source.pixels.copy()
    pixels[100:164, 100:164] //= 2
    photo.write(source, pixels, tmp_path / "out.tif")
    assert comes_back(tiff.read_bytes(), (tmp_path / "out.tif").read_bytes()) < 0.03


BYTES = np.random.default_rng(1).bytes(5000)
ODD = [
    *(b"", b"\xff", b"\xff\xd8", b"\xff\xd8\xff\x00\xff", b"\0" * 9000, b"\xff" * 9000, BYTES),
    *(b"\xff\xd8" + BYTES, b"\xff\xd8" + BYTES[:2000] + b"\xff\0" * 99 + BYTES[2000:]),
    *(BYTES[7:], BYTES[:-30] + BYTES[:1000], jpeg(textured_photo(64, 64))[:-99]),
]


@pytest.mark.parametrize("old", range(len(ODD)))
def test_any_bytes_come_back_from_any_others(old):
    for new in ODD:
        comes_back(ODD[old], new)
        for cut in range(1, 90, 7):
            with pytest.raises(ValueError, match=r"\w"):
                applied(difference(ODD[old], new)[:16][:cut], new)
