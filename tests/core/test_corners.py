"""The confidence of eye and mouth corners says what covers them."""

import sys
from pathlib import Path

import numpy as np
import pytest
from few_cases import few_of
from real_photos import picture_of

from kogao_core.faces.landmarks import MeshSource

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from distortions import DISTORTIONS

EYES, MOUTH = slice(21, 25), slice(25, 27)


@pytest.mark.parametrize("cover", few_of(("black mask", "light blue mask", "white mask"), 1))
def test_a_mouth_under_a_mask_is_less_sure_and_eyes_over_it_stay_so(
    source: MeshSource, portrait: Path, cover: str
) -> None:
    picture = picture_of(portrait, 450.0)
    (bare,) = source.find(picture)
    worn = DISTORTIONS[cover](picture, bare, np.random.default_rng(0)).picture
    (masked,) = source.find(worn)
    assert bare.confidence is not None
    assert masked.confidence is not None
    assert masked.confidence[MOUTH].max() < 0.85 < bare.confidence[MOUTH].min()
    assert min(bare.confidence[EYES].min(), masked.confidence[EYES].min()) > 0.85
