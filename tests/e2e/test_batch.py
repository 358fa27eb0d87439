"""Many photos: bad ones are named, good ones done, interrupted runs gone on with."""

import concurrent.futures
import csv
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock
from zipfile import ZipFile

import numpy as np
import pytest
from few_cases import few_of
from PIL import Image

from kogao_core import batch, photo
from kogao_core.batch import workers
from kogao_core.batch.measures import COLUMNS
from kogao_core.photo.picture import sha256_of
from kogao_core.retouch import RetouchJob


@pytest.fixture
def folder(tmp_path, small_portrait):
    """Four portraits in two folders, a broken file, a picture without a face, and notes."""
    inputs = tmp_path / "in"
    (inputs / "deeper").mkdir(parents=True)
    for name in ("a.jpg", "b.jpg", "c.JPG", "deeper/a.jpg"):
        shutil.copy(small_portrait, inputs / name)
    (inputs / "broken.jpg").write_bytes(small_portrait.read_bytes()[:3000])
    Image.fromarray(np.full((300, 300, 3), 90, np.uint8)).save(inputs / "wall.png")
    (inputs / "notes.txt").write_text("not a photo")
    return inputs


def test_what_nobody_foresaw_fails_one_photo_and_says_whose_fault_it_is(
    small_portrait, tmp_path, monkeypatch
):
    monkeypatch.setattr("kogao_core.retouch.render", Mock(side_effect=KeyError("strange")))
    task = batch.Task(str(small_portrait), str(tmp_path / "out.jpg"), RetouchJob())
    outcome = batch.work(task)
    assert outcome.status == "failed"
    assert "internal error (KeyError: 'strange')" in outcome.reason
    assert not list(tmp_path.iterdir())


def test_a_photo_without_a_face_is_searched_again_only_after_a_change(
    folder, tmp_path, monkeypatch
):
    task = batch.Task(str(folder / "wall.png"), str(tmp_path / "wall.png"), RetouchJob())
    first = batch.work(task)
    monkeypatch.setattr("kogao_core.batch.tasks._sources", Mock(side_effect=KeyError("searched")))
    resumed = replace(task, done=first.key)
    assert batch.work(resumed) == first
    assert first.status == "no face"
    assert "searched" in batch.work(replace(resumed, job=RetouchJob(which="largest"))).reason
    Image.fromarray(np.full((300, 300, 3), 91, np.uint8)).save(folder / "wall.png")
    assert "searched" in batch.work(resumed).reason


@pytest.fixture
def cli(cli):
    return lambda *arguments: cli("batch", *arguments)


def lines(out):
    text = (out / "kogao-batch.jsonl").read_text(encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()]


@pytest.mark.usefixtures("in_process")
def test_good_photos_are_done_and_bad_ones_named(cli, folder, tmp_path):
    out = tmp_path / "out"
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    code, said, err = cli(folder, "-o", out, "-j", 2, "--amount", 6)
    assert (code, said) == (5, "")
    assert "broken.jpg" in err
    assert "wall.png: no face" in err
    assert "6 of 6: 4 done, 1 failed, 1 no face" in err
    report = lines(out)
    assert sorted(line["status"] for line in report) == [*["done"] * 4, "failed", "no face"]
    for line in report:
        achieved = [6.0] if line["status"] == "done" else []
        assert line["achieved_percent"] == pytest.approx(achieved, abs=0.01)
    written = sorted(path.relative_to(out).as_posix() for path in out.rglob("*.[jJ]*[gG]"))
    assert written == ["a.jpg", "b.jpg", "c.JPG", "deeper/a.jpg"]
    assert not list(out.rglob("*.partial"))
    assert {path: path.read_bytes() for path in before} == before
    source, result = photo.read(folder / "a.jpg"), photo.read(out / "a.jpg")
    assert (source.pixels != result.pixels).any()


@pytest.mark.usefixtures("in_process")
def test_measures_of_all_faces_are_one_table_whenever_they_were_done(cli, folder, tmp_path):
    out, table, card = (tmp_path / name for name in ("out", "measures.csv", "set.zip"))
    (folder / "LICENCE.txt").write_text("CC0")
    wanted = folder, "-o", out, "-j", 1, "--amount", 6, "--measures", table, "--card", card
    cli(folder / "a.jpg", *wanted[1:-4])
    code, _, err = cli(*wanted, "--force")
    assert (code, "1 skipped" in err) == (5, True)
    rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
    pictures = [Path(row["picture"]).relative_to(out).as_posix() for row in rows]
    assert pictures == ["a.jpg", "b.jpg", "c.JPG", "deeper/a.jpg"]
    for row in rows:
        assert float(row["achieved_percent"]) == pytest.approx(6.0, abs=0.01)
        assert float(row["width_change_percent"]) < -4.0
        assert row["one_to_one_proven"] == "1"
    told = (tmp_path / "measures-codebook.csv").read_text(encoding="utf-8").splitlines()
    assert [one["column"] for one in csv.DictReader(told)] == list(rows[0]) == list(COLUMNS)
    with ZipFile(card) as zipped:
        content = {name: zipped.read(name).decode(errors="replace") for name in zipped.namelist()}
    assert {f"pictures/{name}" for name in pictures} <= content.keys()
    assert content["photos/LICENCE.txt"] == "CC0"
    assert json.loads(content["recipe.json"])["percent"] == 6.0
    assert len(content["landmarks.csv"].splitlines()) == 1 + 4 * 27
    told = json.loads(content["card.json"])["pictures"]
    assert told[1] == {"name": "b.jpg", "sha256": sha256_of(out / "b.jpg"),
                       "photo": "b.jpg", "photo_sha256": sha256_of(folder / "b.jpg")}  # fmt: skip
    assert str(tmp_path) not in "".join(content.values())
    made = card.read_bytes()
    cli(*wanted, "--force")
    assert card.read_bytes() == made
    # The report stays what it is; what is there isn't replaced unasked.
    code, _, err = cli(*wanted)
    assert code == 2
    assert "measures.csv already exists; use --force" in err
    # What is no longer done isn't told, nor what a damaged line says.
    (folder / "b.jpg").write_bytes(b"broken")
    with (out / "kogao-batch.jsonl").open("a", encoding="utf-8") as report:
        entry = {"source": "", "status": "done", "key": "", "measures": [3, {}]}
        report.write(json.dumps(entry | {"output": str(out / "c.JPG")}) + "\n")
    cli(*wanted, "--force")
    left = [line.split(",")[0][-5:] for line in table.read_text().splitlines()[1:]]
    assert left == ["a.jpg", "c.JPG", "a.jpg"]


@pytest.mark.usefixtures("in_process")
def test_what_was_done_is_skipped_unless_something_has_changed(cli, folder, tmp_path):
    out = tmp_path / "out"
    cli(folder, "-o", out, "-j", 1, "--amount", 6)
    code, _, err = cli(folder, "-o", out, "-j", 1, "--amount", 6)
    assert (code, "4 skipped" in err) == (5, True)
    # Other choices, another source or a damaged result are worked on again.
    (out / "b.jpg").write_bytes(b"damaged")
    Image.open(folder / "a.jpg").rotate(5).save(folder / "a.jpg")
    _, _, err = cli(folder, "-o", out, "-j", 1, "--amount", 6)
    assert "2 done, 1 failed, 1 no face, 2 skipped" in err
    _, _, err = cli(folder / "b.jpg", "-o", out, "-j", 1, "--amount", 5)
    assert "1 of 1: 1 done" in err
    _, _, err = cli(folder / "b.jpg", "-o", out, "-j", 1, "--amount", 5, "--again")
    assert "1 of 1: 1 done" in err


def test_wrong_calls_end_with_one_line(fails, folder, tmp_path):
    (tmp_path / "empty").mkdir()
    for arguments, words in (
        ((folder / "nothing.jpg",), "doesn't exist; check"),
        ((folder / "*.gif",), "no file matches .*; check"),
        ((folder / "a.jpg", "--measures", folder / "b.jpg"), "b.jpg is a photo"),
        ((folder / "a.jpg", folder / "deeper" / "a.jpg"), "both become"),
        ((folder / "a.jpg", "--amount", "99"), "'99' is not a number in the range"),
        ((tmp_path / "empty",), "no photos"),
        ((folder / "a.jpg", "--names", "{date}"), "made of letters"),
        ((folder, "--names", "same"), "would both become"),
    ):
        fails(2, words, *arguments, "-o", tmp_path / "out")


def test_results_inside_the_input_folder_are_not_inputs_the_next_time(folder):
    out = folder / "small"
    out.mkdir()
    shutil.copy(folder / "a.jpg", out / "a.jpg")
    tasks = batch.plan([folder], out, RetouchJob())
    assert not any("small" in task.source for task in tasks)


def test_a_file_that_is_no_report_is_left_alone(fails, small_portrait, tmp_path):
    source, notes = shutil.copy(small_portrait, tmp_path), tmp_path / "notes.txt"
    notes.write_text("remember the milk")
    for report in (source, notes):
        words = "it is no report of a batch"
        fails(3, words, source, "-o", tmp_path / "out", "--report", report)


def test_a_damaged_report_is_read_as_far_as_it_goes(folder, tmp_path):
    out = tmp_path / "out"
    report = tmp_path / "report.jsonl"
    good = batch.Outcome("x", str(out / "a.jpg"), "done", key="k").to_json()
    report.write_text('{"cut\n[1, 2]\n{"output": 3, "status": "done", "key": "z"}\n' + good + "\n")
    tasks = batch.plan([folder / "a.jpg"], out, RetouchJob(), report=report)
    assert [task.done for task in tasks] == ["k"]


def test_a_stopped_batch_hands_out_no_more(monkeypatch):
    monkeypatch.setattr(workers, "work", lambda task: batch.Outcome(task.source, "", "done"))
    seen = []
    one = batch.Workers(lambda: concurrent.futures.ThreadPoolExecutor(1), 1)
    tasks = [batch.Task(str(k), str(k), RetouchJob()) for k in range(100)]
    for outcome in batch.run(tasks, one, stop=lambda: len(seen) >= 3):
        seen.append(outcome)
    assert 3 <= len(seen) <= 6


# Stands still as soon as so many photos are in the report, 0 for never; its worker works on.
STOPPING = """
import os, signal, sys
from kogao_core.cli import batch, main
left, add = int(sys.argv.pop(1)), batch._Progress.add

def counted(progress, outcome):
    global left
    add(progress, outcome)
    if outcome.status == "done":
        left -= 1
        if left == 0:
            os.kill(os.getpid(), signal.SIGSTOP)

batch._Progress.add = counted
main()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
@pytest.mark.parametrize("kills", few_of([[2], [1, 4, 8]], 1))
def test_a_killed_batch_leaves_whole_files_and_goes_on(small_portrait, tmp_path, kills):
    inputs, out = tmp_path / "in", tmp_path / "out"
    inputs.mkdir()
    photos = kills[-1] + 4  # one is waiting beside each that is worked on
    for k in range(photos):
        shutil.copy(small_portrait, inputs / f"{k}.jpg")
    before = small_portrait.read_bytes()

    def command(count):
        program = [sys.executable, "-c", STOPPING, str(count)]
        return [*program, "batch", str(inputs), "-o", str(out), "-j", "1"]

    for count in np.diff(kills, prepend=0):
        process = subprocess.Popen(
            command(count), stderr=subprocess.DEVNULL, start_new_session=True
        )
        assert os.WIFSTOPPED(os.waitpid(process.pid, os.WUNTRACED)[1])
        os.killpg(process.pid, signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
        assert all(path.read_bytes() == before for path in inputs.iterdir())
        for path in out.glob("*.jpg"):
            assert photo.read(path).pixels.shape == (300, 300, 3)
    done = subprocess.run(command(0), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(re.search(r"(\d+) skipped", done.stderr)[1]) >= kills[-1]
    assert len(list(out.glob("*.jpg"))) == photos


@pytest.mark.usefixtures("in_process")
@pytest.mark.skipif(sys.platform == "win32", reason="POSIX files")
def test_what_looks_like_a_photo_and_is_none_fails_by_name(cli, small_portrait, tmp_path):
    inputs, out = tmp_path / "in", tmp_path / "out"
    (inputs / "album.jpg").mkdir(parents=True)  # a folder may be called anything
    shutil.copy(small_portrait, inputs / "a.jpg")
    os.mkfifo(inputs / "pipe.jpg")
    (inputs / "dangling.jpg").symlink_to("gone.jpg")
    (inputs / "circle.jpg").symlink_to("circle.jpg")
    (inputs / ".kogao-0123456789abcdef.partial").mkdir()
    shutil.copy(small_portrait, inputs / ".kogao-0123456789abcdef.partial" / "b.jpg")
    code, _, err = cli(inputs, "-o", out, "-j", 1)
    assert code == 5
    assert "4 of 4: 1 done, 3 failed" in err
    for words in (
        "pipe.jpg is not an ordinary file",
        "dangling.jpg is a link to gone.jpg, where there is nothing",
        "circle.jpg is a link to circle.jpg, where there is nothing",
    ):
        assert words in err


@pytest.mark.usefixtures("in_process")
def test_results_are_exported_as_the_options_say(small_portrait, tmp_path, cli):
    inputs = tmp_path / "in"
    inputs.mkdir()
    for name in ("a.jpg", "b.jpg"):
        shutil.copy(small_portrait, inputs / name)
    out, longest = tmp_path / "out", 200
    export = ("--longest-side", longest, "--quality", 80, "--srgb", "--sharpen", 50)
    export += ("--no-metadata",)
    named = ("--to", "webp", "--names", "{n}-{name}-{amount}")
    code = ("-j", 1, "--amount", 5)
    ended, _, told = cli(inputs, "-o", out, *export, *named, *code)
    assert (ended, "2 done" in told) == (0, True)
    assert sorted(one.name for one in out.glob("*.webp")) == ["001-a-5.webp", "002-b-5.webp"]
    with Image.open(out / "001-a-5.webp") as made:
        assert max(made.size) == longest
        assert "exif" not in made.info
        assert "sRGB".encode("utf-16-be") in made.info["icc_profile"]
