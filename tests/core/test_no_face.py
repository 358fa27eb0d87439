"""No face where there is none: scikit-image's sample pictures."""

from pathlib import Path

import cv2
import pytest

from kogao_core.landmarks import MeshSource

# People are in these: an astronaut, and a cameraman in profile.
PEOPLE = {"astronaut.png", "camera.png"}


@pytest.mark.usefixtures("weights")
def test_sample_pictures_without_people_have_no_face() -> None:
    skimage = pytest.importorskip("skimage", reason="scikit-image isn't installed (extra: bench)")
    folder = Path(skimage.__file__).parent / "data"
    paths = [
        path
        for path in sorted(folder.iterdir())
        if path.suffix in (".png", ".jpg") and path.name not in PEOPLE
    ]
    assert len(paths) > 10
    source = MeshSource()
    found = {}
    for path in paths:
        picture = cv2.cvtColor(cv2.imread(str(path)), cv2.COLOR_BGR2RGB)
        scores = [round(face.score, 2) for face in source.find(picture)]
        if scores:
            found[path.name] = scores
    assert found == {}
