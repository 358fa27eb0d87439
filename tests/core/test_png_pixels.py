"""PNG pixels are packed in strips, and decoders find one stream."""

import io
import itertools
import zlib

import numpy as np
import pytest
from PIL import Image as Pillow

from kogao_core.photo.formats import colour, png

SHAPES = [(37, 51), (37, 51, 3), (37, 51, 4), (1, 1), (1, 3000, 3), (3000, 1)]
GREY_WITH_ALPHA = (37, 51, 2)  # of 8 bits only


def noise(shape, dtype):
    return np.random.default_rng(5).integers(0, 60_000, shape).astype(dtype)


def file_of(pixels):
    return b"".join([png.header(pixels), *png.packed(pixels)])


def stream(data):
    found, at = b"", len(png.SIGNATURE)
    while at < len(data):
        size = int.from_bytes(data[at : at + 4], "big")
        found += data[at + 8 : at + 8 + size] if data[at + 4 : at + 8] == b"IDAT" else b""
        at += 12 + size
    return found


@pytest.fixture(params=[1, 500, 1 << 20])
def _strips(request, monkeypatch):
    monkeypatch.setattr(png, "_STRIP_BYTES", request.param)


@pytest.mark.usefixtures("_strips")
@pytest.mark.parametrize(
    ("shape", "dtype"),
    [*itertools.product(SHAPES, (np.uint8, np.uint16)), (GREY_WITH_ALPHA, np.uint8)],
)
def test_a_decoder_finds_the_pixels_that_were_packed(shape, dtype):
    pixels = noise(shape, dtype)
    data = file_of(pixels)
    with Pillow.open(io.BytesIO(data)) as image:
        image.verify()  # the sum of each chunk
    lines = zlib.decompress(stream(data))  # and that of all lines
    assert len(lines) == shape[0] + pixels.nbytes
    if shape == GREY_WITH_ALPHA:  # OpenCV makes four channels of it
        with Pillow.open(io.BytesIO(data)) as image:
            found = np.asarray(image)
    else:
        found = colour.decoded_deep(data)
    np.testing.assert_array_equal(found, pixels)


def test_files_are_the_same_whatever_the_number_of_threads(monkeypatch):
    pixels = noise((900, 400, 3), np.uint16)
    found = []
    for threads in (1, 2, 4):
        monkeypatch.setattr(png, "default_threads", lambda threads=threads: threads)
        found.append(file_of(pixels))
    assert len(stream(found[0])) > 2 * (1 << 20)  # more than two strips
    assert found[0] == found[1] == found[2]
