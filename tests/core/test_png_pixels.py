"""A PNG of several strips is one stream, whatever the number of threads."""

import io

import numpy as np
import pytest
from PIL import Image

from kogao_core import photo
from kogao_core.photo.formats import colour, png


@pytest.mark.parametrize(
    ("shape", "dtype"),
    [
        *(((1, 1), np.uint8), ((1, 3000, 3), np.uint16), ((3000, 1), np.uint16)),
        *(((900, 700, 3), np.uint8), ((500, 800, 4), np.uint16)),
    ],
)
def test_decoders_find_the_pixels_that_were_written(tmp_path, monkeypatch, shape, dtype):
    pixels = np.random.default_rng(5).integers(0, 60_000, shape).astype(dtype)
    source, found = photo.Photo(pixels, tmp_path / "none", "TIFF"), set()
    for threads in (1, 2, 4):
        monkeypatch.setattr(png, "default_threads", lambda threads=threads: threads)
        photo.write(source, pixels, tmp_path / "out.png", force=True)
        found.add((tmp_path / "out.png").read_bytes())
    (data,) = found
    with Image.open(io.BytesIO(data)) as image:
        image.verify()  # the sums of all chunks
    with Image.open(io.BytesIO(data)) as image:
        image.load()  # and that of the stream
    np.testing.assert_array_equal(colour.decoded_deep(data), pixels)
