"""Table 2: turns are fair, sizes are the paper's, recorded trials are read as they were written."""

import json
import statistics
from collections import Counter
from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
from scenes import oval_face, textured_photo

from kogao_core.base.json_reader import BadFile
from kogao_core.faces.landmarks.sources import template_face
from kogao_core.lab.experiments import timing, timing_report
from kogao_core.lab.experiments.trials import Trial, append, read
from kogao_core.lab.reports.spread import Spread, in_turns, rounded
from kogao_core.lab.subjects import Subject, at_paper_size, set_by_hand
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER

REPEATS = 3
NONE = "\N{EN DASH}"
SEVENTY = f"70.0 (65.0{NONE}75.0)"


class SameFace:
    """Finds the same face in every picture, or none."""

    name = "same"

    def __init__(self, *, finds: bool = True):
        self.finds, self.asked = finds, 0

    def find(self, rgb):
        self.asked += 1
        return [oval_face(rgb.shape[1], rgb.shape[0])] if self.finds else []


def subject(width: int = 480, height: int = 360) -> Subject:
    return Subject("made.png", textured_photo(width, height), (oval_face(width, height),))


def trial(name="t1", **changed) -> Trial:
    made = Trial(
        trial=name,
        mode="manual",
        photo="made.png",
        width=480,
        height=360,
        cold=False,
        looking_s=6.0,
        setting_s=20.0,
        corrections_s=(),
        faces=set_by_hand((oval_face(480, 360),), PAPER),
        at="2026-11-23T10:00:00+00:00",
    )
    return replace(made, **changed)


@pytest.fixture(scope="module")
def timings():
    steps = []
    found, missing = timing.measure(
        subject(),
        SameFace(),
        PAPER,
        repeats=REPEATS,
        warm_up=1,
        progress=lambda *at: steps.append(at),
    )
    assert missing == []
    assert steps == [(n, 40) for n in range(1, 41)]
    return found


def table_2(timings, known=()):
    return timing.TimingResult(tuple(timings), known, PAPER, REPEATS, 1)


def test_every_case_has_its_turn_in_every_round():
    turns = list(in_turns("abc", 4, 2))
    assert Counter(turns) == {(n, c): 4 if c else 2 for n in "abc" for c in (True, False)}
    rounds = ["".join(n for n, _ in turns[k : k + 3]) for k in range(0, len(turns), 3)]
    assert all(sorted(one) == list("abc") for one in rounds)
    assert turns == list(in_turns("abc", 4, 2)), "the same in every run"
    many = [name for name, _ in in_turns("abc", 60, 0)]
    followed = Counter(pairwise(many))
    assert min(followed[a, b] for a in "abc" for b in "abc" if a != b) > 10


def test_spread_is_median_and_hinges():
    assert Spread.of([5.0, 1.0, 3.0, 2.0, 4.0]) == Spread(3.0, 2.0, 4.0, 5)
    assert Spread.of([1.0, 2.0, 3.0, 4.0]) == Spread(2.5, 1.5, 3.5, 4)
    assert Spread.of([7.0]).text() == "7.00"
    with pytest.raises(ValueError, match="at least one"):
        Spread.of([])


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.001234, "0.00123"), (1234.5, "1234"), (0.0, "0"), (9.996, "10.00"), (12.34, "12.3")],
)
def test_rounding_keeps_digits_and_writes_no_powers(value, text):
    assert rounded(value) == text


@pytest.mark.parametrize("size", [(1600, 1200), (700, 1400), (300, 200), (1000, 1000)])
def test_the_papers_size_keeps_the_face_where_it_is(size):
    before = Subject("made.png", np.zeros((size[1], size[0], 3), np.uint8), (oval_face(*size),))
    spot = np.round(before.faces[0].eye_center).astype(int)
    before.pixels[spot[1] - 6 : spot[1] + 7, spot[0] - 6 : spot[0] + 7] = (255, 0, 0)
    after = at_paper_size(before)
    assert sorted(after.size) == [720, 960]
    assert (after.size[0] >= after.size[1]) == (size[0] >= size[1])
    red = np.argwhere((after.pixels.astype(int) @ [1, -1, -1]) > 150)[:, ::-1]
    scale = max(1.0, max(after.size) / max(size))
    assert np.abs(red.mean(axis=0) - after.faces[0].eye_center).max() < 1.5 * scale


def test_points_set_by_hand_give_the_same_picture():
    made = subject()
    by_hand = set_by_hand(made.faces, PAPER)
    assert not np.isnan(by_hand[0].targets).any()
    same = render(made.pixels, by_hand, PAPER).pixels
    np.testing.assert_array_equal(same, render(made.pixels, made.faces, PAPER).pixels)


def test_all_ways_are_timed_by_the_pipelines_stages(timings):
    assert [(one.size, one.procedure) for one in timings] == [
        (size, procedure.name)
        for size in timing.SIZES
        for procedure in (*timing.PROCEDURES, timing.AGAIN)
    ]
    stages = list(render(textured_photo(), [oval_face()], PAPER).timings_ms)
    for one in timings:
        assert list(one.stages_ms) == stages
        assert len(one.computing_ms) == len(one.processor_ms) == REPEATS
        assert min(one.processor_ms) > 0.0
        assert len(one.setting_ms) == (REPEATS if one.procedure in ("akt", "dual") else 0)
        assert sorted((one.width, one.height)) == ([720, 960] if one.size != "own" else [360, 480])
        assert (one.domain_share == 1.0) == (one.procedure in ("conventional", "akt", "again"))


def test_automatic_ways_search_in_every_run():
    source = SameFace()
    timing.measure(subject(), source, PAPER, sizes=["own"], repeats=2, warm_up=1)
    assert source.asked == 1 + 2 * (2 + 1)


class TwoFaces(SameFace):
    """Finds another face, too."""

    def find(self, rgb):
        return [template_face((60, 60), 80), *super().find(rgb)]


def test_automatic_ways_warp_the_faces_that_were_asked_for():
    found, missing = timing.measure(
        subject(), TwoFaces(), PAPER, sizes=["own"], repeats=1, warm_up=0
    )
    assert missing == []
    assert {one.procedure: one.faces for one in found} == {
        procedure.name: 1 for procedure in (*timing.PROCEDURES, timing.AGAIN)
    }
    shares = {one.procedure: one.domain_share for one in found}
    assert shares["dual"] == shares["wdr"]


@pytest.mark.parametrize("finds", [True, False])
def test_where_another_face_or_none_is_found_nothing_is_automatic(finds):
    elsewhere = Subject("made.png", textured_photo(), (template_face((60, 60), 80),))
    source = SameFace(finds=finds)
    found, missing = timing.measure(elsewhere, source, PAPER, sizes=["own"], repeats=1, warm_up=0)
    assert [one.procedure for one in found] == ["conventional", "wdr", "again"]
    assert "made.png at own" in missing[0]


def test_totals_with_and_without_sessions(timings):
    trials = tuple(trial(str(s), setting_s=s) for s in (60.0, 80.0, 70.0))
    for known in ((), trials):
        (*rows, _) = timing_report.report(table_2(timings, known)).tables[0].rows
        manual = [row for row in rows if row[0].startswith(("Conv", "Warp"))]
        assert [row[1] for row in manual] == [SEVENTY if known else NONE] * 2
        assert all((row[6] == NONE) is (not known) for row in manual)
        automatic = [row for row in rows if row not in manual]
        assert all(row[6] != NONE for row in automatic)


def test_the_same_computation_under_two_names_names_the_floor(timings):
    result = table_2(timings)
    table = timing_report.report(result).tables[0]
    first, *_, again = table.rows
    assert again[0] == "Conventional method, again"
    assert first[-3:] == ("1.00", "1.00", "1.00")
    by_name = {one.procedure: one for one in result.of("960x720", "again") + timings[:1]}
    medians = [statistics.median(by_name[n].processor_ms) for n in ("again", "conventional")]
    assert again[-2] == f"{medians[0] / medians[1]:.2f}"


def test_the_hands_points_are_what_manual_ways_compute(monkeypatch):
    """Points that a person set on a photo are warped there, at the paper's size, too."""
    face = replace(oval_face(480, 360), outline=oval_face(480, 360).outline[::2])
    (by_hand,) = set_by_hand((face,), PAPER)
    mine = timing.with_trial(subject(), [trial(faces=(by_hand,))])
    np.testing.assert_array_equal(mine.by_hand[0].outline, face.outline)
    assert timing.with_trial(subject(), [trial(photo="other.png")]).by_hand == ()
    warped = []

    def spy(pixels, faces, recipe):
        warped.append(len(faces[0].outline))
        return render(pixels, faces, recipe)

    monkeypatch.setattr(timing, "render", spy)
    # A clock that ticks slowly repeats work.
    monkeypatch.setattr(timing, "processor_ms", lambda work: (work(), 1.0))
    timing.measure(mine, SameFace(), PAPER, repeats=1, warm_up=0)
    assert sorted(warped) == 6 * [11] + 4 * [21], "three ways by hand, two found, at two sizes"


def test_setting_times_are_told(timings):
    known = (
        trial("t1", setting_s=20.0, corrections_s=(2.0, 1.0)),
        trial("t1", mode="automatic", setting_s=0.1, cold=True),
        trial("t2", setting_s=30.0),
    )
    result = table_2(timings, known)
    tables = {table.caption: table for table in timing_report.report(result).tables}
    times = {row[0]: row for row in tables["Setting time"].rows}
    assert list(times) == ["by hand", "machine, cold"]
    assert times["by hand"][1] == "2"
    assert times["by hand"][4:6] == ["2", "3.00"]
    assert result.setting.count == 2


@pytest.fixture
def file(tmp_path):
    return tmp_path / "deep" / "trials.jsonl"


def test_what_is_appended_is_read(file):
    two = set_by_hand((oval_face(480, 360), oval_face(480, 360, size=0.3)), PAPER)
    odd = trial(photo="Müller „x“.jpg", faces=two)
    made = [odd, trial("t2", mode="automatic", cold=True)]
    for one in made:
        append(file, one)
    for one, other in zip(read(file), made, strict=True):
        for name in (field.name for field in fields(Trial) if field.name != "faces"):
            assert getattr(one, name) == getattr(other, name)
        for face, given in zip(one.faces, other.faces, strict=True):
            np.testing.assert_allclose(face.outline, given.outline)
            np.testing.assert_allclose(face.targets, given.targets)
    assert made[0].landmarks == 42


def test_corrections_after_applying_are_part_of_the_same_trial(file):
    for corrections in ((), (2.2,), (2.2, 1.2)):
        append(file, trial(corrections_s=corrections))
    append(file, trial(mode="automatic", setting_s=0.1))
    manual, automatic = read(file)
    assert manual.total_s == pytest.approx(20.0 + 2.2 + 1.2)
    assert automatic.total_s == 0.1


@pytest.mark.parametrize("kept", [1, 30, 100])
def test_a_line_that_was_cut_off_harms_no_other(file, kept):
    append(file, trial())
    whole = file.read_bytes()
    file.write_bytes(whole + whole[:kept])
    assert len(read(file)) == 1
    append(file, trial("t2", setting_s=5.0))
    assert [one.setting_s for one in read(file)] == [20.0, 5.0]


@pytest.mark.parametrize(
    "change",
    [
        {"setting_s": -1.0},
        {"looking_s": "12"},
        {"version": 1},
        {"at": "yesterday"},
        {"faces": []},
        {"faces": [{}]},
        {"mode": "both"},
        {"photo": None},
        {"corrections_s": 2.0},
        {"surprise": 1},
    ],
)
def test_other_lines_are_refused_by_number(file, change):
    append(file, trial())
    good = json.loads(file.read_text(encoding="utf-8"))
    with file.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps({**good, **change}) + "\n")
    with pytest.raises(BadFile, match="line 2 of"):
        read(file)


def test_lines_of_former_versions_count_without_practice(file):
    append(file, trial())
    line = json.loads(file.read_text(encoding="utf-8")) | {"person": "anna", "order": 1}
    later = [{**line, "trial": name, "practice": name == "t2"} for name in ("t2", "t3")]
    with file.open("a", encoding="utf-8") as lines:
        lines.writelines(json.dumps(one) + "\n\n" for one in later)
    assert [one.trial for one in read(file)] == ["t1", "t3"]
