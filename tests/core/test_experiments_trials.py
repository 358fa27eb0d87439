"""Recorded trials: lines are added whole, corrections belong, and nothing else passes for one."""

import json
from dataclasses import fields, replace

import numpy as np
import pytest
from scenes import oval_face

from kogao_core.base.json_reader import BadFile
from kogao_core.lab.experiments.trials import Trial, append, now, read
from kogao_core.lab.subjects import set_by_hand
from kogao_core.recipe.recipe import PAPER

FACES = set_by_hand((oval_face(960, 720), oval_face(960, 720, size=0.3)), PAPER)


def trial(**changed) -> Trial:
    made = Trial(
        "t1", "manual", "Müller „x“.jpg", 960, 720, False, 6.2, 22.8, (),
        FACES, now(),
    )  # fmt: skip
    return replace(made, **changed)


@pytest.fixture
def file(tmp_path):
    return tmp_path / "deep" / "trials.jsonl"


def test_what_is_appended_is_read(file):
    made = [trial(), trial(trial="t2", mode="automatic", cold=True)]
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
    assert manual.total_s == pytest.approx(22.8 + 2.2 + 1.2)
    assert automatic.total_s == 0.1


@pytest.mark.parametrize("kept", [1, 30, 100])
def test_a_line_that_was_cut_off_harms_no_other(file, kept):
    append(file, trial())
    whole = file.read_bytes()
    file.write_bytes(whole + whole[:kept])
    assert len(read(file)) == 1
    append(file, trial(trial="t2", setting_s=5.0))
    assert [one.setting_s for one in read(file)] == [22.8, 5.0]


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
