"""Recorded setting times: lines are added whole, and nothing else passes for one."""

import json

import pytest

from kogao_core.base.strict import BadFile
from kogao_core.lab.experiments.setting_times import SettingTime, append, read


@pytest.fixture
def file(tmp_path):
    return tmp_path / "deep" / "sessions.jsonl"


def session(seconds: float = 74.25) -> SettingTime:
    return SettingTime.now("Müller „x“.jpg", (960, 720), [21, 19], seconds)


def test_what_is_appended_is_read(file):
    sessions = [session(seconds) for seconds in (74.25, 61.0)]
    for one in sessions:
        append(file, one)
    assert read(file) == sessions
    assert (sessions[0].faces, sessions[0].landmarks) == (2, 40)


@pytest.mark.parametrize("kept", [1, 30, 100])
def test_a_line_that_was_cut_off_harms_no_other(file, kept):
    append(file, session())
    whole = file.read_bytes()
    file.write_bytes(whole + whole[:kept])
    assert len(read(file)) == 1
    append(file, session(5.0))
    assert [one.setting_s for one in read(file)] == [74.25, 5.0]


@pytest.mark.parametrize(
    "change",
    [
        {"setting_s": -1.0},
        {"setting_s": "12"},
        {"version": 2},
        {"at": "yesterday"},
        {"faces": 0},
        {"photo": None},
        {"surprise": 1},
    ],
)
def test_other_lines_are_refused_by_number(file, change):
    append(file, session())
    good = json.loads(file.read_text(encoding="utf-8"))
    with file.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps({**good, **change}) + "\n")
    with pytest.raises(BadFile, match="line 2 of"):
        read(file)
