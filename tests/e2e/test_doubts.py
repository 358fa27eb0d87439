"""Doubtful faces are left alone by every command alike, and each says why."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from kogao_core import photo

WHY = "face {n} is left alone: part of it lies outside the photo"


@pytest.fixture
def cut(portrait: Path, tmp_path: Path) -> Path:
    """The sample, cut above its chin."""
    path = tmp_path / "cut.png"
    Image.open(portrait).crop((0, 0, 900, 575)).resize((450, 287)).save(path)
    return path


@pytest.fixture
def pair(portrait: Path, tmp_path: Path) -> Path:
    """The sample twice, the second one cut above its chin by the photo's edge."""
    one = Image.open(portrait).crop((150, 250, 750, 800)).resize((300, 275))
    both = Image.new("RGB", (600, 275), (150, 150, 150))
    both.paste(one, (0, 0))
    both.paste(one.crop((0, 0, 300, 162)), (300, 113))
    path = tmp_path / "pair.png"
    both.save(path)
    return path


def test_detect_says_who_is_doubted_and_how_sure_each_point_is(works, pair):
    assert works("detect", pair).splitlines()[-1] == WHY.format(n=2)
    first, second = json.loads(works("detect", pair, "--json", "-"))["faces"]
    assert (first["doubt"], first["look_at"]) == (None, [])
    assert second["doubt"]["reason"] == "cut"
    assert second["doubt"]["why"] in WHY
    for face in (first, second):
        assert len(face["confidence"]) == 27
        assert all(0.0 <= one <= 1.0 for one in face["confidence"])


def test_warp_leaves_a_doubtful_face_alone_unless_told_otherwise(warns, pair, tmp_path):
    kept, every = tmp_path / "kept.png", tmp_path / "every.png"
    assert WHY.format(n=2) in warns("warp", pair, "-o", kept)[1]
    assert "left alone" not in warns("warp", pair, "-o", every, "--doubtful")[1]
    before, left, both = (photo.read(path).pixels for path in (pair, kept, every))
    assert (left[:, :300] != before[:, :300]).any()
    # Held background lines may move pixels of the doubtful face by at most a tenth of a pixel.
    face = slice(188, 275), slice(376, 524)
    change, all_change = (np.abs(one[face].astype(int) - before[face]) for one in (left, both))
    assert change.max() <= 12
    assert change.mean() < 0.1 < all_change.mean()


@pytest.mark.parametrize("which", ["all", "largest", "1"])
def test_warp_writes_nothing_where_the_only_face_is_doubtful(fails, cut, which):
    words = f"cut.png was not changed: {WHY.format(n=1)}; use --doubtful"
    fails(4, words, "warp", cut, "--in-place", "--face", which)


@pytest.mark.usefixtures("in_process")
def test_a_batch_leaves_the_same_faces_alone_and_its_report_says_why(cli, cut, pair, tmp_path):
    folder = tmp_path / "out"
    code, _, said = cli("batch", cut, pair, "-o", folder)
    assert code == 5
    assert f"cut.png: {WHY.format(n=1)}" in said
    lines = (folder / "kogao-batch.jsonl").read_text(encoding="utf-8").splitlines()
    alone, first = sorted(map(json.loads, lines), key=lambda one: one["source"])
    assert (alone["status"], alone["faces"]) == ("no face", 0)
    assert (first["status"], first["faces"]) == ("done", 1)
    assert [one["reason"] for one in (alone, first)] == [WHY.format(n=1), WHY.format(n=2)]
    assert sorted(path.name for path in folder.iterdir()) == ["kogao-batch.jsonl", "pair.png"]
    code, _, said = cli("batch", cut, pair, "-o", folder, "--doubtful")
    assert code == 0
    assert "2 of 2: 2 done" in said, "another choice: what the report lists is done again"


def test_a_project_says_itself_who_is_made_smaller(cli, fails, warns, pair, tmp_path):
    warns("warp", pair, "-o", tmp_path / "a.png", "--save-project")
    saved = pair.with_name("pair.png.kogao.json")
    fails(2, "--doubtful can't be combined with --project", "warp", pair, "-o", tmp_path / "b.png",
          "--project", saved, "--doubtful")  # fmt: skip
    _, said, _ = cli("warp", pair, "-o", tmp_path / "b.png", "--project", saved, "--json", "-")
    assert len(json.loads(said)["faces"]) == 1
