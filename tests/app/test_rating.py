"""The script of the rating page: order of the pictures, answers, and undo."""

import itertools
import json
import re
from collections import Counter

import pytest
from PySide6.QtQml import QJSEngine
from ratings import DISPLAY, graded, judged, line_of, taken_back

from kogao_core.base.web_page import SURROUND
from kogao_core.lab.study import page, results
from kogao_core.lab.study.design import Conduct
from kogao_core.lab.study.plan import Study
from kogao_core.lab.study.results import Session

NAMES = tuple(f"{number:016x}.jpg" for number in range(30))
STUDY = Study("a-study", NAMES[:25], NAMES[25:])
SINGLE = Study("single", NAMES[:25], (), (), (NAMES[:25],), (NAMES[:2],))


@pytest.fixture
def script(qapp, tmp_path, request):  # noqa: ARG001
    """Run an expression of the page's script, as far as it needs no page."""
    shown = page.page(getattr(request, "param", STUDY), tmp_path)
    found = re.search(r"<script>(.*?)// The browser stores", shown, re.DOTALL)
    text = found[1]
    engine = QJSEngine()

    def run(expression):
        value = engine.evaluate(f"(function () {{{text}\nreturn JSON.stringify({expression});}})()")
        assert not value.isError(), value.toString()
        return json.loads(value.toString())

    return run


def test_an_order_follows_from_the_study_and_the_code(script):
    again = script("[fresh('r1'), fresh('r1'), fresh('r2')]")
    assert again[0] == again[1]
    assert again[0]["order"] != again[2]["order"]


FACES = tuple(tuple(f"{face:08x}{number:08x}.jpg" for number in range(13)) for face in range(10))
DESIGNED = Study(
    "designed",
    tuple(name for face in FACES for name in face[:12]),
    tuple(face[12] for face in FACES),
    tuple(f"f{number:015x}.jpg" for number in range(4)),
    FACES,
    tuple(face[:2] for face in FACES),
    Conduct(faces_each=4, swap_keys=True),
)


@pytest.mark.parametrize("script", [DESIGNED], indirect=True)
def test_raters_in_turn_judge_every_face_as_often_with_either_keys(script):
    begun = script("Array.from({ length: 20 }, (_, k) => fresh('r' + k, k))")
    seen = Counter()
    for one in begun:
        session = Session(DESIGNED, one["rater"], tuple(one["order"]), keys=one["keys"])
        assert session.order[:4] != DESIGNED.practice or session.order[4:] != DESIGNED.ratings
        seen.update((name, one["keys"]) for name in one["order"])
    # 20 raters of 4 faces of 10: each face 8 times, half of them with F for natural.
    judged = [*DESIGNED.ratings, *DESIGNED.satisfaction]
    assert {seen[name, keys] for name in judged for keys in ("fj", "jf")} == {4}
    assert {sum(seen[name, keys] for keys in ("fj", "jf")) for name in DESIGNED.practice} == {20}


@pytest.mark.parametrize("script", [DESIGNED], indirect=True)
@pytest.mark.parametrize("number", ["NaN", "-1", "undefined"])
def test_a_session_without_a_valid_number_has_faces_drawn_by_chance(script, number):
    assert script(f"fresh('r1', {number})") == script("fresh('r1')")


@pytest.mark.parametrize("script", [DESIGNED], indirect=True)
def test_pictures_of_one_face_and_twins_dont_follow_one_another(script):
    face_of = {name: number for number, face in enumerate(FACES) for name in face}
    for one in script("Array.from({ length: 100 }, (_, k) => fresh('r' + k, k))"):
        order = one["order"][4:52]
        faces = [face_of[name] for name in order]
        assert all(first != second for first, second in itertools.pairwise(faces))
        for twins in DESIGNED.twins:
            places = [order.index(name) for name in twins if name in order]
            assert len(places) in (0, 2)
            assert not places or abs(places[0] - places[1]) > 3


@pytest.mark.parametrize("script", [SINGLE], indirect=True)
def test_twins_of_a_single_face_are_kept_apart(script):
    for one in script("Array.from({ length: 200 }, (_, k) => fresh('r' + k, k))"):
        first, second = (one["order"].index(name) for name in SINGLE.twins[0])
        assert abs(first - second) > 3


def test_what_the_page_saves_is_read(script, tmp_path):
    begun = script("fresh('r1')")
    session = Session(STUDY, "r1", tuple(begun["order"]), keys=begun["keys"])
    for _ in range(26):
        session.take(judged(session, "unnatural"))
    session.take(graded(session, None))
    session.take(taken_back(session))
    begun["records"] = [line_of(record) for record in session.records]
    assert script(f"standing({json.dumps(begun['records'])}).length") == 26
    path = tmp_path / "ratings-r1.jsonl"
    path.write_text(script(f"file({json.dumps(begun)})"))
    held = results.load(path)
    assert held.session(STUDY) == session
    assert held.records[0].display == DISPLAY
    assert json.loads(path.read_text().splitlines()[0])["surround"] == SURROUND


def test_the_orders_that_the_page_draws_are_even(script):
    """Chi square of 24 degrees, 1 in 10^9; 1,500 orders."""
    first = script("Array.from({ length: 1500 }, (_, k) => fresh('r' + k).order[0])")
    counts = [first.count(name) for name in STUDY.ratings]
    assert sum((count - 60.0) ** 2 / 60.0 for count in counts) < 94.0
