"""Big TIFFs, and TIFFs of half floats, planes and inks of 16 bits are refused."""

import numpy as np
import pytest
import tifffile
from scenes import textured_photo

from kogao_core import photo

DEEP = textured_photo(56, 40, 3).astype(np.uint16) * 257 + 5


def read(tmp_path, pixels, **options):
    tifffile.imwrite(tmp_path / "in.tif", pixels, metadata=None, **options)
    return photo.read(tmp_path / "in.tif")


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


@pytest.mark.parametrize("byteorder", "<>")
def test_a_big_tiff_is_refused(tmp_path, byteorder):
    with pytest.raises(photo.UnreadablePhoto, match="is a BigTIFF; save it as an ordinary TIFF"):
        read(tmp_path, DEEP, bigtiff=True, byteorder=byteorder, photometric="rgb")
