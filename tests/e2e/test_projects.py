"""Projects and disclosure on the command line and in batches; nothing hostile comes through."""

import dataclasses
import json
import os
import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from programs import ran

from kogao_core import batch, photo
from kogao_core.additions.brush import Brushwork
from kogao_core.background.find import BackgroundFinder, held_of
from kogao_core.batch import tasks
from kogao_core.cli.commands import run
from kogao_core.pipeline import render
from kogao_core.projects.edits import Edits, sidecar_of
from kogao_core.projects.project import load, save
from kogao_core.projects.sidecar import apply
from kogao_core.retouch import RetouchJob

needs_links = pytest.mark.skipif(sys.platform == "win32", reason="needs links and any names")
pytestmark = pytest.mark.usefixtures("in_process")


@pytest.fixture(scope="session")
def once(small_portrait, tmp_path_factory):
    """A folder with a portrait and the project beside it, and what `warp` made of it then."""
    folder = tmp_path_factory.mktemp("project")
    path = folder / "in" / "a.jpg"
    path.parent.mkdir()
    shutil.copy(small_portrait, path)
    warp = (
        "warp", path, "-o", folder / "first.png", "--amount", 6, "--fit", "approximation",
        "--protect", "20,20 20,280", "--chin-length", -5, "--even-out", 50, "--save-project",
    )  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        for name in ("XDG_DATA_HOME", "LOCALAPPDATA"):
            patch.setenv(name, str(tmp_path_factory.mktemp("data")))
        assert run([str(word) for word in warp]) == 0
    return folder


@pytest.fixture
def kept(once, tmp_path):
    """A copy of that portrait, with its project."""
    shutil.copytree(once, tmp_path, dirs_exist_ok=True)
    return tmp_path / "in" / "a.jpg"


def change(path, edit):
    values = json.loads(path.read_text())
    edit(values)
    path.write_text(json.dumps(values))


# ---- warp -----------------------------------------------------------------------------------


def test_a_replayed_project_gives_the_same_file(works, kept, tmp_path):
    again, first = tmp_path / "again.png", tmp_path / "first.png"
    by_project = "--project", sidecar_of(kept), "--save-project", "--force"
    said = works("warp", kept, "-o", again, *by_project)
    assert f"; edits saved to {sidecar_of(kept)}" in said
    assert again.read_bytes() == first.read_bytes()
    project = json.loads(sidecar_of(kept).read_text())
    assert project["photo"]["path"] == "a.jpg"
    assert project["automatic"]["recipe"]["chin_length"] == -5


def test_another_photo_of_the_same_size_is_noted(cli, kept):
    Image.open(kept).transpose(Image.Transpose.FLIP_LEFT_RIGHT).save(other := kept.parent / "o.jpg")
    said = cli("warp", other, "-o", kept.parent / "b.png", "--project", sidecar_of(kept))[2]
    assert "another file of the same size; check" in said


def test_another_resolution_is_noted_and_kept_at_its_own_size(warns, kept, tmp_path):
    large = tmp_path / "large.png"
    Image.open(kept).resize((720, 720)).save(large)
    by_project = "--project", sidecar_of(kept), "--save-project"
    said = warns("warp", large, "-o", tmp_path / "out.png", *by_project)
    assert "made at 300 x 300 px" in said[1]
    assert json.loads(sidecar_of(large).read_text())["photo"]["width"] == 720


def test_projects_that_cannot_be_used_are_one_line(fails, kept, tmp_path):
    out, side = tmp_path / "x.png", sidecar_of(kept)
    Image.open(kept).crop((0, 0, 300, 240)).save(tmp_path / "cut.png")
    bad = tmp_path / "bad.json"
    bad.write_text('{"format": "kogao-project", "version": 99}')
    (recipe := tmp_path / "recipe.json").write_text('{"version": 4, "percent": 4.0}')
    for arguments, words in (
        ((tmp_path / "cut.png", "--project", side), "another shape"),
        ((kept, "--project", bad), "newer Kogao"),
        ((kept, "--project", recipe), "is no project of Kogao"),
        ((kept, "--recipe", bad), "it is no recipe; apply a project with .*--project"),
        ((kept, "--project", tmp_path / "none.json"), "none.json doesn't exist; check"),
        ((kept, "--project", side, "--amount", "3"), "--amount can't be combined"),
        ((kept, "--project", side, "--chin-length", "-5"), "--chin-length can't be combined"),
        ((kept, "--project", side, "--face", "all"), "--face can't be combined"),
        ((kept, "--save-project"), "exists; use --force"),
        (("--sample", "--save-project"), "--sample can't be combined"),
        ((kept, "--label", "x" * 101), "label"),
        ((kept, "--label", ""), "label"),
        ((kept, "--label", "two\nlines"), "one line"),
        ((kept, "--label", "x", "--label-font", bad), "font"),
    ):
        fails(2, words, "warp", *arguments, "-o", out)


# Tells of every file named bait that it or a worker of its own opens.
OPENED = """
import json, os, sys
def hear(name, given):
    if name == "open" and "bait" in str(given[0]):
        os.write(2, b"touched")
sys.addaudithook(hear)
from kogao_core.cli import main
for arguments in json.loads(sys.argv[1]):
    try:
        main(arguments)
    except SystemExit as ending:
        assert not ending.code
"""


def test_the_path_in_a_project_is_never_followed(kept, tmp_path):
    bait = tmp_path / "bait.jpg"
    shutil.copy(kept, bait)
    change(sidecar_of(kept), lambda values: values["photo"].update(path=str(bait)))
    calls = [
        ["warp", kept, "-o", tmp_path / "o.png", "--project", sidecar_of(kept)],
        ["batch", kept.parent, "-o", tmp_path / "out", "--projects", "-j", "1"],
    ]
    done = ran(OPENED, json.dumps(calls, default=str))
    assert "1 of 1: 1 done" in done.stderr
    assert "touched" not in done.stderr
    assert bait.read_bytes() == kept.read_bytes()


# ---- batch ----------------------------------------------------------------------------------


def statuses(out):
    lines = (out / "kogao-batch.jsonl").read_text().splitlines()
    return {json.loads(line)["source"].rsplit(os.sep)[-1]: json.loads(line) for line in lines}


def test_a_batch_does_what_projects_say_and_again_when_they_change(cli, kept, tmp_path):
    inputs, out = kept.parent, tmp_path / "out"
    for name in ("b.jpg", "c.jpg", "d.jpg"):
        shutil.copy(kept, inputs / name)
    sidecar_of(inputs / "c.jpg").write_text("[" * 5000)
    shutil.copy(sidecar_of(kept), sidecar_of(inputs / "d.jpg"))
    change(sidecar_of(inputs / "d.jpg"), lambda v: v["automatic"]["faces"][0].update(on=False))
    call = ("batch", inputs, "-o", out, "--projects", "-j", 1)
    code, _, err = cli(*call)
    assert code == 5
    assert "3 done, 1 failed" in err
    report = statuses(out)
    assert "nested too deeply" in report["c.jpg"]["reason"]
    assert report["d.jpg"]["faces"] == 0
    assert (out / "d.jpg").read_bytes() == (inputs / "d.jpg").read_bytes()
    assert not (out / "c.jpg").exists()
    # By its project, by the options, and by the same project on the command line.
    assert (out / "a.jpg").read_bytes() != (out / "b.jpg").read_bytes()
    cli("warp", kept, "-o", tmp_path / "a.jpg", "--project", sidecar_of(kept))
    assert (out / "a.jpg").read_bytes() == (tmp_path / "a.jpg").read_bytes()

    sidecar_of(inputs / "c.jpg").unlink()
    assert "1 done, 3 skipped" in cli(*call)[2]
    change(sidecar_of(kept), lambda values: values["automatic"]["recipe"].update(percent=3.0))
    assert "1 done, 3 skipped" in cli(*call)[2]
    shutil.copy(sidecar_of(kept), sidecar_of(inputs / "b.jpg"))
    assert "1 done, 3 skipped" in cli(*call)[2]
    assert "3 done, 1 skipped" in cli(*call[:4], "-j", 1)[2]  # c went by the options


def test_strokes_are_done_alike_by_command_batch_and_core(cli, works, kept, tmp_path):
    work = Brushwork().with_stroke("push", [(60.0, 150.0), (75.0, 146.0)], 30.0, 0.8)
    work = work.with_stroke("restore", [(150.0, 230.0)], 40.0, 1.0, 0.5)
    made = dataclasses.replace(load(sidecar_of(kept)), brushwork=work)
    save(made, sidecar_of(kept))
    out, by_command = tmp_path / "out", tmp_path / "a.jpg"
    assert cli("batch", kept.parent, "-o", out, "--projects", "-j", 1)[0] == 0
    works("warp", kept, "-o", by_command, "--project", sidecar_of(kept))
    assert (out / "a.jpg").read_bytes() == by_command.read_bytes()
    works("warp", kept, "-o", tmp_path / "a.png", "--project", sidecar_of(kept))
    pixels, done = photo.read(kept).pixels, made.automatic
    plain, pushed = (
        render(
            *(pixels, done.active, done.recipe),
            protection=made.protection,
            brushwork=strokes,
            held=held_of(pixels, apply(made, pixels), BackgroundFinder()),
        ).pixels
        for strokes in (Brushwork(), work)
    )
    np.testing.assert_array_equal(photo.read(tmp_path / "a.png").pixels, pushed)
    assert (plain != pushed).any()


def test_results_never_go_over_photos_or_strangers(cli, fails, kept, tmp_path):
    inputs, out = kept.parent, tmp_path / "out"
    before = kept.read_bytes()
    fails(2, "would be written over", "batch", inputs, "-o", inputs)
    out.mkdir()
    (out / "a.jpg").write_bytes(b"something of the user's")
    fails(2, "a file exists.*--force", "batch", inputs, "-o", out)
    assert (out / "a.jpg").read_bytes() == b"something of the user's"
    assert cli("batch", inputs, "-o", out, "--force", "-j", 1)[0] == 0
    assert kept.read_bytes() == before


@needs_links
def test_links_lead_no_result_out_of_the_folder(kept, tmp_path):
    inputs, out, elsewhere = kept.parent, tmp_path / "out", tmp_path / "elsewhere"
    (inputs / "deeper").mkdir()
    shutil.copy(kept, inputs / "deeper" / "b.jpg")
    for folder in (out, elsewhere):
        folder.mkdir()
    (out / "deeper").symlink_to(elsewhere)
    with pytest.raises(batch.NothingToDo, match="a link leads"):
        batch.plan([inputs], out, RetouchJob())
    (out / "deeper").unlink()
    (out / "a.jpg").symlink_to(kept)
    with pytest.raises(batch.NothingToDo, match="written over"):
        batch.plan([inputs], out, RetouchJob())
    (out / "a.jpg").unlink()
    (out / "a.jpg").symlink_to(out / "a.jpg")
    os.mkfifo(sidecar_of(inputs / "deeper" / "b.jpg"))
    tasks = batch.plan([inputs], out, RetouchJob(), edits=Edits.of_user())
    assert [bool(task.project) for task in tasks] == [True, False]
    assert [batch.work(task).status for task in tasks] == ["failed", "done"]


@needs_links
def test_names_may_hold_anything(cli, kept, tmp_path):
    inputs, out = kept.parent, tmp_path / "out"
    for name in (b"\xff%s..jpg", b"-rf a\n\x1b[2J $(x) `y` 'z'.jpg"):
        shutil.copy(kept, inputs / os.fsdecode(name))
    (inputs / "bad\x1b[31m\nname.jpg").write_bytes(b"no photo")
    code, _, err = cli("batch", inputs, "-o", out, "-j", 1)
    assert code == 5
    assert "3 done, 1 failed" in err
    assert "\x1b" not in err
    assert err.count("\n") == 2
    assert len(list(out.iterdir())) == 4
    assert "3 skipped" in cli("batch", inputs, "-o", out, "-j", 1)[2]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a disk that is always full")
def test_a_report_that_cannot_be_written_is_one_line(cli, kept, tmp_path, monkeypatch):
    full = Path("/dev/full")
    monkeypatch.setattr(tasks, "appended", lambda _: full.open("ab"))
    code, said, err = cli("batch", kept, "-o", tmp_path / "out", "-j", 1)
    assert (code, said) == (3, "")
    words = "jsonl can't be written .No space.*to resume"
    assert re.fullmatch(rf"kogao-cli: [^\n]*{words}[^\n]*\n", err), err
    assert (tmp_path / "out" / "a.jpg").exists()


# ---- disclosure -----------------------------------------------------------------------------


def test_a_result_tells_only_when_asked(cli, works, kept, tmp_path):
    plain, told = tmp_path / "plain.jpg", tmp_path / "told.jpg"
    cli("warp", kept, "-o", plain)
    works("warp", kept, "-o", told, "--disclose", "--label", "Retouched")
    assert photo.read(plain).xmp is None
    xmp = photo.read(told).xmp
    assert b"1 face made smaller: 6 %" in xmp
    assert b"humanEdits" in xmp
    before, after = (photo.read(path).pixels.astype(int) for path in (plain, told))
    differs = np.abs(before - after).max(axis=2) > 0
    assert differs[270:, 200:].any()
    assert not differs[:256].any()


def test_a_batch_tells_and_does_again_when_it_is_to_tell_more(cli, kept, tmp_path):
    call = ("batch", kept, "-o", tmp_path / "out", "-j", 1)
    cli(*call)
    assert "1 done" in cli(*call, "--disclose", "--label", "Retouched")[2]
    assert b"humanEdits" in photo.read(tmp_path / "out" / "a.jpg").xmp
    assert "1 skipped" in cli(*call, "--disclose", "--label", "Retouched")[2]
    assert "1 done" in cli(*call, "--disclose")[2]
