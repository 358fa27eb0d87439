"""Landmarks out by one command and in by another."""

import json

import numpy as np
import pytest
from PIL import Image
from scenes import oval_face

from kogao_core.projects import interchange
from kogao_core.projects.interchange import along


@pytest.mark.parametrize("form", ["json", "csv"])
def test_exported_points_warp_like_those_found(cli, works, small_portrait, tmp_path, form):
    said = works("landmarks", "export", small_portrait, "--format", form, "-o", tmp_path / "lm")
    file = tmp_path / "lm" / f"small.{form}"
    assert str(file) in said
    # The forehead isn't in the files: what surrounds the face would follow an arch over it.
    alone = "--scope", "face"
    cli("warp", small_portrait, *alone, "-o", tmp_path / "found.png")
    works("warp", small_portrait, *alone, "--points", file, "-o", tmp_path / "given.png")
    found, given = (
        np.asarray(Image.open(tmp_path / f"{name}.png"), int) for name in ("found", "given")
    )
    # Files other than JSON hold thousandths of a px.
    assert np.abs(found - given).max() <= (0 if form == "json" else 2)


def _ibug(face):
    """68 points; jaw and corners are the face's."""
    points = np.random.default_rng(4).uniform((80, 60), (220, 240), (68, 2))
    points[:17] = along(face.outline, 17)
    points[[36, 39, 42, 45]], points[[48, 54]] = face.eyes, face.mouth
    return points


def test_what_cant_be_done_is_said_and_leaves_nothing(fails, small_portrait, tmp_path):
    (tmp_path / "text.pts").write_text("hello")
    for name in ("small.csv", "empty/text.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    interchange.write([oval_face(9000, 9000)], tmp_path / "far.json")
    export = ("landmarks", "export", small_portrait)
    warp = ("warp", small_portrait, "-o", tmp_path / "out.png")
    batch = ("batch", small_portrait, "-o", tmp_path / "out")
    no_points = "empty has no points for small.jpg; expected small with one of .json"
    for wanted, words, *arguments in (
        (2, "use --force", *export, "--format", "csv", "-o", tmp_path),
        (2, "several photos", *export, small_portrait, "--format", "csv", "-o", tmp_path / "new"),
        (3, "n_points: N", *warp, "--points", tmp_path / "text.pts"),
        (3, "must end in one of .json, .csv, .pts, .tem, .xml", *warp, "--points", "points.txt"),
        (3, "another photo or size", *warp, "--points", tmp_path / "far.json"),
        (3, no_points, *batch, "--points", tmp_path / "empty"),
        (2, "combined with --project", *warp, "--points", "x.pts", "--project", "x.kogao.json"),
    ):
        fails(wanted, words, *arguments)


def test_every_command_reads_landmarks_from_files(cli, small_png, tmp_path):
    face = oval_face(300, 300)
    every = _ibug(face)
    points = tmp_path / "points"
    points.mkdir()
    rows = "\n".join(f"{x:.3f},{y:.3f}" for x, y in every.tolist())
    (points / "small.csv").write_text(f"x,y\n{rows}\n")
    ours = np.round(face.outline[0], 1).tolist()
    code, _, _ = cli("landmarks", "export", small_png, "--points", points, "--format", "json",
                     "-o", tmp_path / "json")  # fmt: skip
    assert code == 0
    (found,) = json.loads((tmp_path / "json" / "small.json").read_text(encoding="utf-8"))["faces"]
    assert np.abs(np.subtract(found["eyes"], face.eyes)).max() < 0.002
    assert np.abs(np.subtract(found["outline"][0], ours)).max() < 0.06
    report = tmp_path / "out" / "kogao-batch.jsonl"
    batch = "batch", small_png, "--points", points, "-o", tmp_path / "out", "--jobs", "1"
    assert cli(*batch)[0] == 0
    assert json.loads(report.read_text(encoding="utf-8"))["status"] == "done"
    given = "experiment", "domains", small_png, "--points", points, "--repeats", "1"
    code, said, _ = cli(*given, "--json", "-")
    assert code == 0
    assert json.loads(said)["photos"][0]["photo"] == "small.png"
    code, said, _ = cli("experiment", "study", "make", small_png, "--points", points,
                        "-o", tmp_path / "study", "--lattices", "", "--percents", "4")  # fmt: skip
    assert code == 0
