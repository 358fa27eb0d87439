"""Results of stored scenes stay the same: a changed constant is noticed.

`tests/benchmarks/constants.py` halves and doubles each constant and lists those that no test
notices.
After a deliberate change of the pictures, run `tests/pinned.py`.
"""

import json

import pinned
import pytest
from opencv import needs_opencv_4
from systems import needs_stored_decimals

STORED = json.loads(pinned.FILE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", pinned.SCENES)
@needs_stored_decimals
@needs_opencv_4("its networks give other decimals")
def test_a_scene_gives_the_stored_result(name):
    assert pinned.difference(name, pinned.result(name), STORED[name]) == ""


@needs_stored_decimals
@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("aam", pinned.aam_faces),
        ("search", pinned.steps_of_the_search),
        ("statements", pinned.statements),
    ],
)
def test_what_is_found_and_said_of_faces_is_as_stored(name, found):
    assert pinned.difference(name, found(), STORED[name]) == ""
