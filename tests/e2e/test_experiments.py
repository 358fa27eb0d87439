"""The experiments as commands: on the sample portrait, to files that anyone can read."""

import csv
import importlib
import json
import pkgutil
import re
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from scenes import oval_face

import kogao_core as kogao
from kogao_core.base import atomic
from kogao_core.cli import common
from kogao_core.field.field import Field
from kogao_core.lab import experiments
from kogao_core.lab.experiments import EXPERIMENTS
from kogao_core.lab.experiments.trials import Trial, append, now
from kogao_core.lab.methods import METHODS

DOCUMENT = Path(__file__).parents[2] / "docs" / "experiments.md"
# Each number of rounds at its least.
ONCE = {
    one.name: [
        part
        for option in one.options
        if isinstance(option.default, int)
        for part in (f"--{option.name}", option.least)
    ]
    for one in EXPERIMENTS
}
RECORDS = {"timing": 10, "domains": 8, "distortion": 24, "methods": len(METHODS)}
PICTURES = {"domains": 2, "methods": 3 * len(METHODS)}


@pytest.fixture
def cli(cli):
    return lambda *arguments: cli("experiment", *arguments)


def test_every_experiment_is_in_the_table_and_has_its_section():
    declared = [
        module.EXPERIMENT
        for _, name, _ in pkgutil.iter_modules(experiments.__path__, f"{experiments.__name__}.")
        if hasattr(module := importlib.import_module(name), "EXPERIMENT")
    ]
    every = {*ONCE, "paper"}  # which runs the others
    assert sorted(one.name for one in declared) == sorted(every)
    sections = re.findall(r"^## .*: `experiment (\w+)`$", DOCUMENT.read_text("utf-8"), re.MULTILINE)
    assert ONCE.keys() == set(sections)


@pytest.mark.parametrize("name", ONCE)
def test_one_command_says_how_far_it_is_and_writes_everything(
    cli, small_png, tmp_path, monkeypatch, name
):
    monkeypatch.setattr(common, "CALM_S", 0.0)
    folder = tmp_path / "out"
    code, said, err = cli(name, small_png, "-o", folder, *ONCE[name])
    begun, *steps = err.splitlines()
    assert (code, begun) == (0, f"1 of 1: {small_png}")
    assert steps, "the experiment calls `Work.progress` after each step"
    assert re.fullmatch(re.escape(begun) + r", (\d+) of \1 steps", steps[-1]), "all are done"
    assert all(line.startswith(begun) for line in steps)
    document = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    assert document["experiment"] == name
    assert document["made"]["command"].startswith(f"kogao-cli experiment {name} ")
    assert document["made"]["machine"]["packages"]["numpy"] == np.__version__
    with (folder / f"{name}.csv").open(encoding="utf-8", newline="") as lines:
        records = list(csv.DictReader(lines))
    assert len(records) == RECORDS.get(name, len(records)) > 0
    assert {record["photo"] for record in records} == {"small.png"}
    page = (folder / f"{name}.html").read_text(encoding="utf-8")
    assert not re.search(r'(src|href)="(?!data:)', page)
    assert "small.png" in said + page
    assert len(list(folder.glob("*.png"))) == PICTURES.get(name, 0)
    again = cli(name, small_png, "-o", folder, *ONCE[name])
    assert again[0] == 2
    assert "use --force" in again[2]


def test_single_files_and_printing_and_sessions_that_time_the_hand(cli, fails, small_png, tmp_path):
    trials, file = tmp_path / "sessions.jsonl", tmp_path / "figures.csv"
    for seconds in (60.0, 80.0):
        faces = (oval_face(300, 300),)
        trial = Trial(
            trial=str(seconds),
            mode="manual",
            photo="small.png",
            width=300,
            height=300,
            cold=False,
            looking_s=6.0,
            setting_s=seconds,
            corrections_s=(),
            faces=faces,
            at=now(),
        )
        append(trials, trial)
    once = ("timing", small_png, "--size", "own", *ONCE["timing"])
    code, said, _ = cli(*once, "--trials", trials, "--csv", file, "--json", "-")
    assert code == 0
    document = json.loads(said)
    assert len(document["timings"]) == 5
    assert document["made"]["machine"]["load"]
    with file.open(encoding="utf-8", newline="") as lines:
        by_way = {record["way"]: record for record in csv.DictReader(lines)}
    assert len(by_way) == 5
    assert by_way["conventional"]["setting_median_ms"] == "70000.0"
    fails(2, "use --force", *once, "--csv", file)
    trials.write_text('{"version": 1}\n', encoding="utf-8")
    fails(2, "line 1 of .+", *once, "--trials", trials)
    fails(3, "none.jsonl can't be read", *once, "--trials", tmp_path / "none.jsonl")


def test_photos_without_a_face_are_named_and_the_others_measured(
    cli, small_png, faceless, tmp_path
):
    folder = tmp_path / "photos"
    folder.mkdir()
    portrait_here = folder / "b.png"
    portrait_here.write_bytes(small_png.read_bytes())
    faceless.rename(folder / "a.png")
    (folder / "c.jpg").write_bytes(b"no picture")
    code, said, err = cli("domains", folder, "--repeats", 1, "--html", tmp_path / "r.html")
    assert code == 5
    assert "b.png" in said
    assert re.search(r"no face in .*a\.png", err)
    assert "c.jpg" in err
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "Left out" in page
    assert "a.png" in page


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        ((), 2, "name photos"),
        (("{photo}", "--sample"), 2, "name photos"),
        (("{empty}",), 2, "no photo found in"),
        (("{faceless}",), 4, "no face in"),
        (("missing.png",), 3, "missing.png"),
        (("{photo}", "--percent", 5), 2, "No such option '--percent'"),
        (("{photo}", "--recipe", "{photo}"), 2, "is not JSON"),
        (("{photo}", "--face", 7), 2, "there is no face 7"),
        (("{photo}", "--json", "{empty}/none/x.json"), 3, "create the folder first"),
        (("{photo}", "-o", "{photo}/x"), 3, "there is no folder"),
        (("{photo}", "--json", "-", "--csv", "-"), 2, "only one file can be printed"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(
    fails, small_png, faceless, tmp_path, arguments, code, words
):
    empty = tmp_path / "empty"
    empty.mkdir()
    names = {"photo": small_png, "faceless": faceless, "empty": empty}
    fails(code, words, "distortion", *(str(one).format(**names) for one in arguments))


@pytest.mark.parametrize("options", [("-o", "{folder}/out"), ("--json", "{folder}/out.json")])
def test_a_full_disk_is_named_with_what_to_do(cli, small_png, tmp_path, monkeypatch, options):
    full = Mock(side_effect=OSError(28, "No space left on device"))
    monkeypatch.setattr(atomic, "atomic_write", full)
    given = (str(option).format(folder=tmp_path) for option in options)
    code, _, err = cli("domains", small_png, "--repeats", 1, *given)
    assert code == 3
    assert re.fullmatch(r"kogao-cli: .*out.* can't be written \(No space .+\); choose .+\n", err)


def test_the_documented_series_has_pictures_landmarks_and_evidence(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"^```python\n(.*?)^```", DOCUMENT.read_text("utf-8"), re.M | re.S)
    exec(compile(block, DOCUMENT, "exec"), {})
    with Path("points.csv").open(encoding="ascii") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 5 * 21
    for amount in (-8, -4, 0, 4, 8):
        shown = [row for row in rows if float(row["amount"]) == amount]
        assert [float(row["achieved"]) for row in shown] == pytest.approx([amount] * 21, abs=1e-3)
        evidence = kogao.load_evidence(f"series{amount:+d}.npz")
        there = np.array([(row["x"], row["y"]) for row in shown], float)
        read = there + Field(evidence.lattices).at(there)
        np.testing.assert_allclose(read, evidence.points_px[:21], atol=1e-3)
    chins = [float(row["y"]) for row in rows if row["point"] == "10"]
    assert chins == sorted(chins, reverse=True)
