"""Stimuli from the command line, and landmarks of one's own wherever photos are taken."""

import csv
import json

import numpy as np
import pytest
from scenes import oval_face

from kogao_core.projects import interchange
from kogao_core.projects.interchange.pointmap import along

FACE = oval_face(300, 300)
ALL = np.random.default_rng(4).uniform((80, 60), (220, 240), (68, 2))


@pytest.fixture
def points(tmp_path):
    """A folder with 68 points of the photo; jaw and corners are the made-up face's."""
    everything = np.array(ALL)
    everything[:17] = along(FACE.outline, 17)
    everything[[36, 39, 42, 45]], everything[[48, 54]] = FACE.eyes, FACE.mouth
    folder = tmp_path / "points"
    folder.mkdir()
    interchange.write_points([everything], folder / "small.csv")
    return folder


def test_a_series_comes_out_whole(cli, small_png, points, tmp_path):
    out = tmp_path / "out"
    doses = "-5,0,5"
    code, said, err = cli(
        "experiment", "stimuli", small_png, "--points", points, "-o", out, "--percents", doses,
        "--field", "tfm",
    )  # fmt: skip
    assert (code, err) == (0, "")
    names = [f"small_{dose}" for dose in ("-05.00", "+00.00", "+05.00")]
    every = [f"{name}{end}" for name in names for end in (".png", ".csv", "-face1.tfm")]
    assert {p.name for p in out.iterdir()} == {
        *every, "measures.csv", "measures-codebook.csv", "contact.png",
    }  # fmt: skip
    assert "small_-05.00.png" in said
    ((_, still),) = interchange.read_all(out / "small_+00.00.csv")
    ((_, given),) = interchange.read_all(points / "small.csv")
    np.testing.assert_allclose(still, given, atol=0.0011)
    ((_, moved),) = interchange.read_all(out / "small_+05.00.csv")
    assert len(moved) == 68
    assert np.abs(moved - given).max() > 1.0
    with (out / "measures.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["asked_percent"]) for row in rows] == [-5.0, 0.0, 5.0]
    widths = [float(row["width_px"]) for row in rows]
    assert widths == sorted(widths, reverse=True)
    assert cli("experiment", "stimuli", small_png, "--points", points, "-o", out)[0] == 2


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--percents", "4,x"), "must be doses within -15..15"),
        (("--percents", "20"), "must be doses within -15..15"),
        (("--align", "900"), "is no size such as 900x1200"),
        (("--points-map", "0-16/36,39,42,45/48,54"), "needs --points"),
        (("--points", "{empty}", "--landmarks", "aam"), "don't go together"),
    ],
)
def test_what_cannot_be_made_is_refused(cli, small_png, tmp_path, options, words):
    empty = tmp_path / "empty"
    empty.mkdir()
    given = (option.format(empty=empty) for option in options)
    code, _, err = cli("experiment", "stimuli", small_png, "-o", tmp_path / "out", *given)
    assert code == 2
    assert words in err
    assert not (tmp_path / "out").exists()


def test_points_of_ones_own_are_taken_wherever_photos_are(cli, small_png, points, tmp_path):
    ours = np.round(FACE.outline[0], 1).tolist()
    code, _, _ = cli("landmarks", "export", small_png, "--points", points, "--format", "json",
                     "-o", tmp_path / "json")  # fmt: skip
    assert code == 0
    (face,) = json.loads((tmp_path / "json" / "small.json").read_text(encoding="utf-8"))["faces"]
    # A template of 189 begins its outline where its own mark-up does.
    assert np.abs(np.subtract(face["eyes"], FACE.eyes)).max() < 0.002
    assert np.abs(np.subtract(face["outline"][0], ours)).max() < 20.0
    report = tmp_path / "out" / "kogao-batch.jsonl"
    batch = "batch", small_png, "--points", points, "-o", tmp_path / "out", "--jobs", "1"
    assert cli(*batch)[0] == 0
    assert json.loads(report.read_text(encoding="utf-8"))["status"] == "done"
    drawn = "experiment", "figures", small_png, "--points", points, "--width", "240"
    assert cli(*drawn, "-o", tmp_path / "f")[0] == 0
    given = "experiment", "domains", small_png, "--points", points, "--repeats", "1"
    code, said, _ = cli(*given, "--json", "-")
    assert code == 0
    assert json.loads(said)["photos"][0]["photo"] == "small.png"
    code, said, _ = cli("experiment", "study", "make", small_png, "--points", points,
                        "-o", tmp_path / "study", "--lattices", "", "--percents", "4")  # fmt: skip
    assert code == 0


def test_points_that_are_not_there_are_named(cli, small_png, tmp_path):
    empty = tmp_path / "empty"
    empty.mkdir()
    for command in (("experiment", "figures"), ("batch",)):
        code, _, err = cli(*command, small_png, "--points", empty, "-o", tmp_path / "out")
        assert code == 3
        assert "empty has no points for small.png; expected small with one of .json" in err
