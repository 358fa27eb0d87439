"""The pixels of JPEG files are the same whoever decodes them, OpenCV or Pillow."""

import json
import subprocess
import sys
import textwrap
from pathlib import Path

import files
import numpy as np
import pytest
from damaging import bytewise, parts
from PIL import Image
from scenes import textured_photo

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


def saved(pixels, mode="RGB", **options):
    return files.saved(Image.fromarray(pixels).convert(mode), "JPEG", **options)


def sound():
    """Every way of coding a JPEG that Pillow writes, in rows and columns cut off anywhere."""
    tags = Image.Exif()
    for size in ((77, 101), (9, 17), (1, 1)):
        picture = textured_photo(*size)
        for kind in ("4:4:4", "4:2:2", "4:2:0"):
            for progressive in (False, True):
                tags[0x0112] = 1 + len(kind + str(progressive) * 3) % 8
                more = {"subsampling": kind, "progressive": progressive, "exif": tags}
                yield saved(picture, **more)
                yield saved(picture, restart_marker_rows=1, **more)
        yield saved(picture, keep_rgb=True)
        yield saved(picture, "L")


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
    found["printers"] = [saved(textured_photo(40, 30), "CMYK")]
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
    command = [sys.executable, *options, "-c", textwrap.dedent(READING)]
    given = json.dumps(names)
    done = subprocess.run(command, input=given, capture_output=True, text=True, check=True)
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
