"""No face where there is none: scikit-image's sample pictures."""

from importlib.util import find_spec
from pathlib import Path

import pytest
from few_cases import few_of
from real_photos import picture_of

from kogao_core.faces.landmarks import MeshSource
from kogao_core.faces.landmarks.aam.source import AamSource

# People are in these: an astronaut, and a cameraman in profile.
PEOPLE = {"astronaut.png", "camera.png"}
# It is full of small dark things.
FEW = ("page.png",)


def pictures() -> list[Path]:
    """The pictures that come with scikit-image, `FEW` first."""
    home = find_spec("skimage")
    if home is None or home.origin is None:
        return []
    folder = Path(home.origin).parent / "data"
    found = sorted(folder.iterdir(), key=lambda one: (one.name not in FEW, one.name))
    return [one for one in found if one.suffix in (".png", ".jpg") and one.name not in PEOPLE]


@pytest.mark.skipif(not pictures(), reason="scikit-image isn't installed (extra: test)")
def test_there_are_pictures() -> None:
    assert len(pictures()) > 10


@pytest.mark.parametrize("path", few_of(pictures(), len(FEW)), ids=lambda path: path.name)
def test_sample_pictures_without_people_have_no_face(source: MeshSource, path: Path) -> None:
    assert source.find(picture_of(path)) == []


@pytest.mark.usefixtures("weights")
@pytest.mark.skipif(not pictures(), reason="scikit-image isn't installed (extra: test)")
@pytest.mark.parametrize("name", few_of(("clock_motion.png", "coins.png", "cell.png"), 1))
def test_what_the_aam_fits_badly_is_no_face(name: str) -> None:
    (path,) = (one for one in pictures() if one.name == name)
    assert AamSource().find(picture_of(path)) == []
