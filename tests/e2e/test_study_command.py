"""A study from the command line: made, answered by made-up raters, reported."""

import csv
import hashlib
import json
import os
import re
import shutil

import pytest
from ratings import begun, judged, save
from scenes import oval_face

from kogao_core.lab.study import making, plan
from kogao_core.lab.study.design import Conduct
from kogao_core.lab.study.plan import PictureFigures
from kogao_core.projects import interchange

# One picture of each face.
FEW = ("--percents", "4", "--centers", "2", "--lattices", "", "--no-catch")


@pytest.fixture
def cli(cli):
    return lambda *arguments: cli("experiment", "study", *arguments)


def answer_all(folder, rater):
    """Rate everything by a rule: these are nobody's ratings."""
    key = plan.load_key(plan.key_path(folder))
    session = begun(plan.load_study(folder), rater)
    while session.current is not None:
        meaning = key.pictures[session.current]
        strange = meaning.variant.percent > 6.0 or meaning.variant.kind == "catch"
        answer = "unnatural" if strange else "natural"
        session.take(judged(session, answer, 92))
    save(session, folder / plan.RATINGS_FOLDER / f"{rater}.jsonl")


def test_a_study_is_made_answered_and_reported(cli, works, portrait, tmp_path):
    folder = tmp_path / "study"
    said = works(
        "make", portrait, "-o", folder, "--control", "--satisfaction", "--lattices", "0.5,1"
    )
    assert "25 pictures of 1 face" in said
    assert f"open {folder / making.PAGE_FILE} in a browser" in said
    if os.name == "posix":
        assert plan.key_path(folder).stat().st_mode & 0o077 == 0
    answer_all(folder, "synthetic-1")
    answer_all(folder, "synthetic-2")
    outputs = [tmp_path / f"report.{kind}" for kind in ("json", "csv", "html")]
    files = zip(("--json", "--csv", "--html"), outputs, strict=True)
    said = works("report", folder, *(word for pair in files for word in pair))
    assert re.search(r"candidate\s3 +0\.0 % \(0\.0 to 65\.8\)", said)
    document = json.loads(outputs[0].read_text())
    assert document["raters"] == 2
    assert document["satisfaction"] == {
        "grades": 2,
        "mean": 92.0,
        "standard_deviation": 0.0,
        "of_others": 0,
        "skipped": 0,
        "published_mean": 92,
    }
    rows = list(csv.DictReader(outputs[1].read_text().splitlines()))
    ten = next(row for row in rows if (row["percent"], row["center"]) == ("10.0", "2"))
    assert (ten["unnatural"], ten["answers"], ten["published"]) == ("2", "2", "0.7")
    assert "http" not in re.sub(r'http-equiv|xmlns="[^"]*"', "", outputs[2].read_text())
    with (folder / plan.RATINGS_FOLDER / "synthetic-1.jsonl").open("a") as log:
        log.write('{"n": 99, "pic')
    code, _, err = cli("report", folder)
    assert code == 5
    assert "synthetic-1.jsonl is not a rating file" in err
    code, _, err = cli("report", folder, "--json", outputs[0])
    assert code == 2
    assert "--force" in err


def test_a_study_of_ones_own_design(works, portrait, tmp_path):
    (tmp_path / "consent.txt").write_text("You may stop.\n\nAt any time.\n")
    folder = tmp_path / "own"
    works(
        "make", portrait, "-o", folder, "--percents", "-4,3", "--centers", "2", "--lattices", "",
        "--fits", "exact,approximation", "--match", "--practice", "2", "--catch",
        "--picture-size", "640px", "--consent", tmp_path / "consent.txt",
        "--swap-keys", "--faces-each", "1",
    )  # fmt: skip
    study, key = plan.load_study(folder), plan.load_key(plan.key_path(folder))
    assert study.conduct == Conduct(
        size="640px", consent="You may stop.\n\nAt any time.", swap_keys=True,
        faces_each=1,
    )  # fmt: skip
    assert (len(study.ratings), len(study.practice)) == (5, 2)
    made = {
        (one.variant.percent, one.variant.fit): one.measured
        for one in key.pictures.values()
        if one.variant.kind == "table1"
    }
    assert len(made) == 4
    for (percent, fit), measured in made.items():
        assert measured.achieved == pytest.approx(percent, abs=0.002)
        assert (abs(measured.asked) < 0.95 * abs(percent)) == (fit == "approximation")
    answer_all(folder, "synthetic-1")
    said = works("report", folder, "--data", tmp_path / "data")
    assert re.search(r"candidate\s2, exact fit +0\.0 %", said)
    lines = (tmp_path / "data" / "answers.csv").read_text().splitlines()
    assert len(lines) == 1 + 5, "practice isn't among them"
    assert {path.name for path in (tmp_path / "data").iterdir()} == {
        "answers.csv", "raters.csv", "codebook.csv", "model.R",
    }  # fmt: skip


def test_points_of_a_file_are_the_photos_and_practice_needs_none(works, small_png, tmp_path):
    interchange.write([oval_face(300, 300)], tmp_path / "small.csv")
    works(
        "make", small_png, "-o", tmp_path / "own", "--points", tmp_path / "small.csv", *FEW,
        "--practice", "1",
    )  # fmt: skip
    key = plan.load_key(plan.key_path(tmp_path / "own"))
    assert key.origin.landmarks == "--points small.csv"
    assert len(key.pictures) == len(key.subjects) == 2


def test_ratings_of_another_study_are_named_and_not_counted(cli, works, small_png, tmp_path):
    for seed in ("one", "two"):
        works("make", small_png, "-o", tmp_path / seed, *FEW, "--seed", seed)
    one = plan.load_key(plan.key_path(tmp_path / "one"))
    assert one.subjects[0].sha256 == hashlib.sha256(small_png.read_bytes()).hexdigest()
    assert one.origin.landmarks
    answer_all(tmp_path / "one", "synthetic-1")
    shutil.copytree(tmp_path / "one" / plan.RATINGS_FOLDER, tmp_path / "two" / plan.RATINGS_FOLDER)
    code, said, err = cli("report", tmp_path / "two")
    assert code == 5
    assert re.fullmatch(
        r"kogao-cli: not counted: \S+synthetic-1.jsonl: ratings of another study, [^\n]+\n", err
    )
    assert "1 face, 0 raters, 0 answers per kind" in said


def test_what_cant_be_done_is_said_and_leaves_nothing(fails, portrait, tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    (tmp_path / "text.jpg").write_text("no picture")
    for wanted, words, *arguments in (
        (2, "isn't empty", "make", portrait, "-o", tmp_path / "full"),
        (2, "list such as", "make", portrait, "-o", tmp_path / "new", "--lattices", "1,x"),
        (2, "different numbers", "make", portrait, "-o", tmp_path / "new", "--lattices", "1,99"),
        (2, "within -15..15", "make", portrait, "-o", tmp_path / "new", "--percents", "-4,20"),
        (2, "a list such as exact", "make", portrait, "-o", tmp_path / "new", "--fits", "exact,x"),
        (2, "not a size such", "make", portrait, "-o", tmp_path / "new", "--picture-size", "big"),
        (
            3,
            "name a text file in UTF-8",
            "make",
            portrait,
            "-o",
            tmp_path / "new",
            "--consent",
            tmp_path,
        ),
        (3, "text.jpg", "make", tmp_path / "text.jpg", "-o", tmp_path / "new"),
        (3, "contains no study", "report", tmp_path / "full"),
        (2, "64 printable letters", "make", portrait, "-o", tmp_path / "new", "--seed", "x" * 65),
        (2, "one --key per folder", "report", "a", "b", "--key", "c"),
    ):
        fails(wanted, words, *arguments)


def test_a_study_that_cant_be_finished_leaves_nothing(cli, portrait, tmp_path, monkeypatch):
    made = []

    def full(*arguments, **_):
        made.append(arguments)
        if len(made) == 5:
            raise OSError(28, "No space left on device")
        return b"no picture", PictureFigures(4.0, 5.0)

    monkeypatch.setattr(making, "drawn", full)
    code, _, err = cli("make", portrait, "-o", tmp_path / "new")
    assert code == 3
    assert "No space left" in err
    assert list(tmp_path.iterdir()) == []
