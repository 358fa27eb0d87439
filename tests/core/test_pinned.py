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
def test_the_aam_finds_the_stored_faces():
    assert pinned.difference("aam", pinned.aam_faces(), STORED["aam"]) == ""


@needs_stored_decimals
def test_computed_heads_are_searched_as_stored():
    assert pinned.difference("search", pinned.steps_of_the_search(), STORED["search"]) == ""


def test_template_faces_are_judged_as_stored():
    assert pinned.difference("statements", pinned.statements(), STORED["statements"]) == ""
