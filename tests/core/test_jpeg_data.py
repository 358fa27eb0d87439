"""JPEG files: cost and kind are told before, and every decoder finds the same pixels."""

import json
import re
from pathlib import Path

import files
import jpeglib
import numpy as np
import pytest
from damaging import bytewise, parts
from files import segment
from PIL import Image, ImageFile, JpegImagePlugin
from programs import ran
from scenes import textured_photo

from kogao_core import photo
from kogao_core.photo import UnreadablePhoto
from kogao_core.photo.jpeg.decoding import MOST_SCANS

FRAME = re.compile(rb"\xff[\xc0-\xc2]\0[\x0b\x11]\x08")
READING = """
    import hashlib, json, sys
    from kogao_core import photo
    from kogao_core.photo.jpeg import decoding as jpeg_data
    read, by_opencv, decode = {}, 0, jpeg_data.pixels
    def counted(*given):
        global by_opencv
        found = decode(*given)
        by_opencv += found is not None
        return found
    jpeg_data.pixels = counted
    def told(name):
        try:
            one = photo.read(name)
        except photo.UnreadablePhoto as problem:
            return str(problem)
        digest = hashlib.sha256(one.pixels.tobytes()).hexdigest()
        return [digest, one.pixels.shape, one.notes, one.jpeg is not None]
    for kind, names in json.load(sys.stdin).items():
        by_opencv = 0
        read[kind] = [[told(name) for name in names], by_opencv / len(names)]
    print(json.dumps(read))
"""

# Huffman codes of which there are too many, and a second frame.
BEHIND = (b"\xff\xc4\0\x16\0" + b"\xff" * 19, b"\xff\xc0\0\x0b\x08\0\x10\0\x10\1\1\x11\0")


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
    assert files.opened(path, in_scans(40, remark)).width == 48
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
    assert files.opened(path, encoded(np.full((800, 900, 3), 90, np.uint8), **options)).width == 900
    data = claiming(encoded(textured_photo(48, 40, 3), **options), 9000)
    assert "damaged or incomplete" in refusal(path, data)
    assert len(decoded) == 1


@pytest.mark.parametrize("progressive", [False, True])
def test_a_jpeg_without_its_end_marker_is_read_with_a_word(tmp_path, progressive):
    path, cut = tmp_path / "in.jpg", tmp_path / "cut.jpg"
    path.write_bytes(encoded(textured_photo(80, 64, 3), quality=95, progressive=progressive))
    whole, source = photo.read(path), files.opened(cut, path.read_bytes()[:-2])
    np.testing.assert_array_equal(source.pixels, whole.pixels)
    assert source.notes == ("the file is slightly damaged: its end marker is missing",)
    pixels = source.pixels.copy()
    pixels[:8, :8] ^= 255
    said = photo.write(source, pixels, tmp_path / "out.jpg")
    assert "of the JPEG unchanged" in said
    photo.write(whole, pixels, tmp_path / "whole.jpg")
    assert (tmp_path / "out.jpg").read_bytes() == (tmp_path / "whole.jpg").read_bytes()
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


def sound():
    """Every way of coding a JPEG that Pillow writes, in rows and columns cut off anywhere."""
    tags = Image.Exif()
    for size in ((77, 101), (9, 17), (1, 1)):
        picture = textured_photo(*size)
        for kind in ("4:4:4", "4:2:2", "4:2:0"):
            for progressive in (False, True):
                tags[0x0112] = 1 + len(kind + str(progressive) * 3) % 8
                more = {"subsampling": kind, "progressive": progressive, "exif": tags}
                yield encoded(picture, **more)
                yield encoded(picture, restart_marker_rows=1, **more)
        yield encoded(picture, keep_rgb=True)
        yield encoded(Image.fromarray(picture).convert("L"))


@pytest.fixture(scope="module")
def read_twice(tmp_path_factory):
    """What becomes of files by their kind: by OpenCV where it has nothing to say, and by Pillow.

    Sound ones, cut short, damaged behind their scans and at random, and those for printers.
    """
    folder, rng = tmp_path_factory.mktemp("jpeg"), np.random.default_rng(11)
    whole = list(sound())
    found = {"sound": whole, "cut": [one[:-cut] for one in whole for cut in (1, 2, 3, 40)]}
    found["damage behind"] = [one[:-2] + more + one[-2:] for one in whole for more in BEHIND]
    found["damaged"] = []
    for number in range(150):
        data = whole[number % len(whole)]
        way = parts if number % 2 else bytewise
        found["damaged"].append(way.change(data, rng, whole[int(rng.integers(len(whole)))]))
    found["printers"] = [encoded(Image.fromarray(textured_photo(40, 30)).convert("CMYK"))]
    names = {}
    for kind, data in found.items():
        names[kind] = [str(folder / f"{kind}{number}.jpg") for number in range(len(data))]
        for name, one in zip(names[kind], data, strict=True):
            Path(name).write_bytes(one)
    # Where nothing can be kept from standard error, Pillow decodes all of them.
    ours, theirs = (read(names, *options) for options in ((), ("-X", "faulthandler")))
    return {kind: (ours[kind], theirs[kind]) for kind in found}


def read(names, *options):
    """Return by kind what becomes of files, and what share of them OpenCV decoded."""
    done = ran(READING, flags=options, input=json.dumps(names))
    assert options or done.stderr == "", "decoders are not heard"
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    ("kind", "least", "most"),
    [
        *(("sound", 1.0, 1.0), ("cut", 0.0, 0.0), ("damage behind", 0.0, 0.0)),
        *(("damaged", 0.01, 0.9), ("printers", 0.0, 0.0)),
    ],
)
def test_pixels_and_refusals_are_those_of_pillow(read_twice, kind, least, most):
    (ours, by_opencv), (theirs, by_opencv_there) = read_twice[kind]
    assert ours == theirs
    assert by_opencv_there == 0
    assert least <= by_opencv <= most
