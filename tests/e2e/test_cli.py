"""The command line as its users meet it: files, exit codes, one line when something is wrong."""

import dataclasses
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from importlib import util
from pathlib import Path
from unittest.mock import Mock

import files
import metadata_cases
import numpy as np
import pytest
from named import HEAD, mwg
from PIL import Image
from PIL.PngImagePlugin import PngInfo
from programs import ran
from scenes import oval_face, textured_photo
from systems import needs_linux

import kogao_core as kogao
from kogao_core import photo, pipeline
from kogao_core import retouch as retouching
from kogao_core.base import assets, installed
from kogao_core.cli import doctor, licences, warping
from kogao_core.cli.commands import program as commands
from kogao_core.projects import interchange
from kogao_core.recipe.recipe import LOSSLESS_PX, Recipe

ROOT = Path(__file__).parents[2]
PROGRAM = "from kogao_core.cli import main; main()"


# ---- what works -----------------------------------------------------------------------------


def test_warp_writes_what_render_gives(cli, works, portrait, tmp_path):
    out = tmp_path / "out.png"
    said = works("warp", portrait, "-o", out, "--amount", 6, "--no-hold-background")
    assert said == f"{out}: 1 face, 6 % smaller\n"
    source = photo.read(portrait)
    faces = json.loads(cli("detect", portrait, "--json", "-")[1])["faces"]
    written = photo.read(out).pixels
    assert (written != source.pixels).any()
    from kogao_core.faces.landmarks import MeshSource

    found = MeshSource().find(source.pixels)
    expected = pipeline.render(source.pixels, found, Recipe(percent=6.0)).pixels
    np.testing.assert_array_equal(written, expected)
    np.testing.assert_allclose(faces[0]["outline"], found[0].outline)


def test_warp_names_what_a_result_does_not_keep(cli, small_portrait, tmp_path):
    source = tmp_path / "motion.jpg"
    source.write_bytes(small_portrait.read_bytes() + metadata_cases.MP4)
    told = "not kept: the motion photo's video"
    report = tmp_path / "a.json"
    _, said, _ = cli("warp", source, "-o", tmp_path / "a.png", "--amount", 6, "--json", report)
    assert said.endswith(f"6 % smaller; {told}\n")
    assert json.loads(report.read_text())["notes"] == [told]
    _, said, _ = cli("warp", source, "-o", tmp_path / "c.jpg", "--amount", 0)
    assert said.endswith("1 face, unchanged\n")


def test_damage_that_only_the_blocks_show_is_in_the_report_alone(small_portrait, tmp_path):
    """Another thread reads the blocks; decoders of pixels stop before the stray bytes."""
    data = small_portrait.read_bytes()
    source = tmp_path / "stray.jpg"
    source.write_bytes(data[:-2] + b"\0\1\2abc" + data[-2:])
    done = ran(PROGRAM, "warp", source, "-o", tmp_path / "out.jpg")
    assert "slightly damaged: 2 extraneous bytes" in done.stdout
    assert done.stderr == ""


def test_a_face_at_the_photos_edge_is_a_warning_and_in_the_json(warns, tmp_path):
    photo, points = tmp_path / "cut.png", tmp_path / "cut.json"
    Image.fromarray(textured_photo()).save(photo)
    face = oval_face(center=(40.0, 180.0), size=0.4)
    points.write_text(json.dumps({"faces": [face.to_dict()]}))
    told = "1 face lies at the photo's edge"
    report = tmp_path / "report.json"
    said = warns("warp", photo, "-o", tmp_path / "a.png", "--points", points, "--json", report)
    assert told in said[1]
    assert any(told in note for note in json.loads(report.read_text())["notes"])
    loose = warns("warp", photo, "-o", tmp_path / "c.png", "--points", points, "--no-guard")
    assert told not in loose[1]


@pytest.mark.usefixtures("portrait")
def test_warp_reports_in_json(works, tmp_path):
    out = tmp_path / "out.jpg"
    # Held lines reach farther: their control points cover all of a small photo.
    alone = "--scope", "face", "--no-hold-background"
    said = works("warp", "--sample", "-o", out, "--json", "-", "--fit", "approximation", *alone)
    report = json.loads(said)
    recipe = Recipe(fit="approximation", scope="face", hold_background=False)
    assert report["recipe"] == recipe.to_dict()
    assert set(report["timings_ms"]) >= {"targets", "lattice", "domain", "warp"}
    assert len(report["faces"]) == 1
    size = report["image"]["width"] * report["image"]["height"]
    counts = [
        report["domains"][name]["pixels"] for name in ("image", "control-points", "threshold")
    ]
    assert counts[0] == size > counts[1] > counts[2] > 0
    assert report["domains"]["image"]["percent"] == 100.0
    assert report["residual"]["max_px"] > report["residual"]["mean_px"] > 0
    (dose,) = report["dose"]
    assert dose["asked_percent"] == pytest.approx(6.0)
    assert 6.3 < dose["achieved_percent"] < 7.2, "the approximation goes past its targets"
    assert 0 < report["one_to_one"]["min_det"] < 1
    assert out.exists()


@pytest.mark.usefixtures("portrait")
def test_warp_protects_a_line_and_says_what_turns(cli, fails, works, tmp_path):
    still = tmp_path / "still.png"
    _, said, _ = cli("warp", "--sample", "-o", tmp_path / "free.png", "--json", "-")
    face = json.loads(said)["faces"][0]
    x = max(point[0] for point in face["outline"]) + 10
    line = f"{x:.1f},100 {x:.1f},700"
    said = works(
        "warp", "--sample", "-o", still, "--protect", line, "--protect-width", "8",
        "--json", "-",
    )  # fmt: skip
    report = json.loads(said)
    assert report["one_to_one"]["edges_proven"]
    assert min(report["protected_shares"][0]) < 0.9
    assert max(report["protected_shares"][0]) == 1.0
    assert all(line["turn_degrees"] >= 0 <= line["rise_permille"] for line in report["lines"])
    assert report["notes"] == []
    cli("warp", "--sample", "-o", tmp_path / "copy.png", "--amount", "0")
    sample, kept = (np.asarray(Image.open(path)) for path in (tmp_path / "copy.png", still))
    assert (sample != kept).any()
    columns = slice(round(x) - 3, round(x) + 4)
    np.testing.assert_array_equal(kept[110:690, columns], sample[110:690, columns])
    for wrong in ("10,20 30", "1,2,3 4,5,6", "a,b c,d", "", "nan,1 2,3"):
        fails(2, "10,20 10,400", "warp", "--sample", "-o", tmp_path / "x.png", "--protect", wrong)


def test_warp_protects_the_white_pixels_of_masks_beside_lines(
    works, warns, fails, small_png, tmp_path
):
    before, out = np.asarray(Image.open(small_png)), tmp_path / "out.png"
    grey = np.zeros(before.shape[:2], np.uint8)
    grey[150:190, 180:230] = 255
    Image.fromarray(grey).save(tmp_path / "mask.png")
    command = "warp", small_png, "-o", out, "--force", "--quiet"
    works(*command)
    free = np.asarray(Image.open(out))
    assert (free != before)[grey > 0].any()
    line = "--protect", "60,10 60,290"
    warns(*command, *line, "--protect", tmp_path / "mask.png", "--save-project")
    after = np.asarray(Image.open(out))
    assert (after != before).any()
    np.testing.assert_array_equal(after[grey > 0], before[grey > 0])
    np.testing.assert_array_equal(after[20:280, 60], before[20:280, 60])
    project = small_png.with_name(f"{small_png.name}.kogao.json")
    warns(*command, "--project", project)
    np.testing.assert_array_equal(np.asarray(Image.open(out)), after)
    project.unlink()
    Image.new("L", (30, 20)).save(tmp_path / "small.png")
    fails(2, "30 x 20 px, the photo 300 x 300", *command, "--protect", tmp_path / "small.png")
    fails(3, "doesn't exist", *command, "--protect", tmp_path / "none.png")


def test_warp_and_batch_change_only_people_of_given_names(works, fails, cli, portrait, tmp_path):
    with Image.open(portrait) as image:
        face = image.convert("RGB").resize((300, 300))
    both, known = Image.new("RGB", (600, 300)), tmp_path / "in" / "both.png"
    both.paste(face, (0, 0))
    both.paste(face.transpose(Image.Transpose.FLIP_LEFT_RIGHT), (300, 0))
    known.parent.mkdir()
    both.save(known)
    found = json.loads(works("detect", known, "--json"))["faces"]
    named = [
        (name, (((x + w / 2) / 600, (y + 0.2 * h) / 300), (1.1 * w / 600, 1.6 * h / 300)))
        for name, (x, y, w, h) in zip(("Ann", "Kate"), (one["box"] for one in found), strict=True)
    ]
    note = PngInfo()
    note.add_itxt("XML:com.adobe.xmp", HEAD.format(mwg(named, (600, 300))))
    both.save(known, pnginfo=note)
    before, out = np.asarray(both), tmp_path / "out.png"
    code, _, _ = cli("warp", known, "-o", out, "--person", "kate=6", "--quiet")
    assert code == 0
    moved = (np.asarray(Image.open(out)) != before).any(axis=(0, 2))
    assert moved[300:].any()
    assert moved[:200].mean() < 0.1
    for wrong in ("Ann", "Ann=3,ann=4", "Ann=99"):
        fails(2, "", "warp", known, "-o", tmp_path / "x.png", "--person", wrong)
    refused = "warp", known, "-o", tmp_path / "x.png", "--person"
    fails(4, "person 1 of the named people: the photo has no face of this name", *refused, "Eve=3")
    batch = tmp_path / "batch"
    code, _, said = cli("batch", known.parent, "-o", batch, "--person", "Eve=3", "--jobs", 1)
    assert (code, list(batch.glob("*.png"))) == (5, [])
    assert "the photo has no face of this name" in said
    assert "Eve" not in said + (batch / "kogao-batch.jsonl").read_text()


def test_an_upright_face_has_no_negative_tilt(works, portrait, tmp_path):
    mirrored = tmp_path / "mirrored.png"
    with Image.open(portrait) as image:
        image.transpose(Image.Transpose.FLIP_LEFT_RIGHT).save(mirrored)
    assert works("detect", mirrored).splitlines()[2].endswith(" +0°")


def test_detect_prints_exactly_the_documented_json(works, portrait):
    said = works("detect", "--sample", "--json", "-")
    found = json.loads(said)
    with Image.open(portrait) as image:
        assert found["image"] == {"width": image.width, "height": image.height}
    assert list(found) == ["image", "lens", "faces"]
    assert found["lens"]["focal_mm"] is None
    assert "focal length" in found["lens"]["why"]
    face = found["faces"][0]
    assert face.pop("look_at") == []
    for name in ("doubt", "stretch_percent", "distance_m", "nose_percent"):
        assert face.pop(name) is None
    shapes = {name: np.shape(value) for name, value in face.items()}
    assert shapes == {
        "box": (4,),
        "score": (),
        "outline": (21, 2),
        "eyes": (4, 2),
        "mouth": (2, 2),
        "confidence": (27,),
    }
    assert list(np.argsort(np.array(face["eyes"])[:, 0])) == [0, 1, 2, 3]


def test_detect_writes_where_people_are(works, fails, portrait, tmp_path):
    mask = tmp_path / "mask.png"
    said = works("detect", portrait, "--person-mask", mask, "--json", "-")
    found = json.loads(said)
    assert found["person_mask"] == {"file": str(mask), "missed_faces": 0}
    with Image.open(mask) as picture, Image.open(portrait) as photo:
        assert (picture.mode, picture.size) == ("L", photo.size)
        x, y = np.mean(found["faces"][0]["mouth"], axis=0)
        assert picture.getpixel((round(x), round(y))) > 240
        assert picture.getpixel((5, 5)) < 15
    fails(2, "exists; use --force", "detect", portrait, "--person-mask", mask)
    fails(2, "is the input photo", "detect", mask, "--person-mask", mask, "--force")
    fails(2, "doesn't end in .png", "detect", portrait, "--person-mask", tmp_path / "mask.jpg")
    nowhere = tmp_path / "no" / "mask.png"
    fails(3, "create the folder first", "detect", portrait, "--person-mask", nowhere)


def test_without_the_network_for_people_warp_warns_once(
    works, warns, fails, small_png, tmp_path, lack
):
    assert "nearby" not in works("warp", small_png, "-o", tmp_path / "with.png", "-v")
    lack("selfie")
    said, warning = warns("warp", small_png, "-o", tmp_path / "without.png", "-v")
    assert warning.count("the network that tells people apart is missing") == 1
    assert "lines nearby" in said
    assert "1 face, 6 % smaller" in said
    fails(1, "is missing; reinstall", "detect", small_png, "--person-mask", tmp_path / "mask.png")


def test_deep_photos_stay_deep(cli, small_png, tmp_path):
    source = photo.read(small_png)
    deep = photo.Photo(source.pixels, small_png, "PNG", exif=b"Exif\0\0II*\0\x08\0\0\0\0\0\0\0\0\0")
    for suffix in (".png", ".tif"):
        photo.write(deep, source.pixels.astype(np.uint16) * 257, tmp_path / f"in{suffix}")
        out = tmp_path / f"out{suffix}"
        assert cli("warp", tmp_path / f"in{suffix}", "-o", out)[0] == 0
        written = photo.read(out).pixels
        assert written.dtype == np.uint16
        assert 0.02 < (written != source.pixels.astype(np.uint16) * 257).any(-1).mean() < 0.65


@pytest.fixture
def told(warns, small_png, tmp_path):
    """Warp a portrait with options; return the warnings, and the figures."""

    def run(*options):
        out, report = tmp_path / "out.png", tmp_path / "report.json"
        _, said = warns("warp", small_png, "-o", out, "--json", report, "--force", *options)
        return said, json.loads(report.read_text())

    return run


def test_a_threshold_that_is_not_used_is_told(told):
    said, report = told("--amount", 8, "--lattice", 0.5, "--scope", "face", "--threshold", 8)
    assert report["recipe"]["threshold_px"] == 8
    assert report["threshold_px"] == 1 / 64
    assert "threshold 8 px ignored" in said
    said, report = told("--amount", 8, "--lattice", 0.5, "--scope", "face", "--threshold", 0.1)
    assert report["threshold_px"] == 0.1
    assert "ignored" not in said


def test_folding_is_held_back_or_told(told):
    steep = ("--amount", 12, "--lattice-unit", "warp", "--lattice", 0.5)
    steep += ("--scope", "face")
    said, report = told(*steep)
    assert report["shares"][0] < 1
    assert report["one_to_one"]["min_det"] > 0
    assert "face 1 is reduced to" in said
    said, report = told(*steep, "--no-guard")
    assert report["shares"] == [1]
    assert report["one_to_one"]["folded_cells"]
    assert "the picture folds in" in said


def test_options_override_the_recipe_file(cli, small_portrait, tmp_path):
    saved = Recipe(percent=2.0, center=4, lattice=1.5, threshold_px=0.25)
    (tmp_path / "r.json").write_text(json.dumps(saved.to_dict()), encoding="utf-8")
    arguments = ["--recipe", tmp_path / "r.json", "--amount", 3, "--json", "-"]
    _, said, _ = cli("warp", small_portrait, "-o", tmp_path / "out.png", *arguments)
    used = json.loads(said)["recipe"]
    assert used == {**saved.to_dict(), "percent": 3.0}
    assert used["threshold_px"] != LOSSLESS_PX


def test_faces_are_chosen_by_number(cli, portrait, tmp_path, fails):
    source = photo.read(portrait).pixels[::2, ::2]
    small = source[::2, ::2]
    pair = np.full((source.shape[0], source.shape[1] + small.shape[1], 3), 128, np.uint8)
    pair[:, : source.shape[1]] = source
    pair[: small.shape[0], source.shape[1] :] = small
    Image.fromarray(pair).save(tmp_path / "pair.png")
    _, said, _ = cli("detect", tmp_path / "pair.png", "--json", "-")
    both = json.loads(said)["faces"]
    assert len(both) == 2
    for face in both:
        for name in ("doubt", "look_at", "stretch_percent", "distance_m", "nose_percent"):
            del face[name]
    for which, expected in (("largest", [both[0]]), ("2", [both[1]]), ("1,2", both)):
        out = tmp_path / f"{which}.png"
        _, said, _ = cli("warp", tmp_path / "pair.png", "-o", out, "--face", which, "--json", "-")
        assert json.loads(said)["faces"] == expected
    for number in (0, 3):
        bad = ("warp", tmp_path / "pair.png", "-o", tmp_path / "bad.png", "--face", number)
        fails(2, f"there is no face {number}; the photo has 2", *bad)


def test_force_replaces_a_file_but_never_the_input(cli, small_portrait, tmp_path, fails):
    path = Path(shutil.copy(small_portrait, tmp_path / "in.jpg"))
    for force in ((), ("--force",)):
        fails(2, "is the input photo", "warp", path, "-o", path, *force)
    (tmp_path / "out.jpg").write_text("mine")
    fails(2, "already exists; use --force to overwrite", "warp", path, "-o", tmp_path / "out.jpg")
    assert cli("warp", path, "-o", tmp_path / "out.jpg", "--force")[0] == 0
    shape = photo.read(small_portrait).pixels.shape
    assert photo.read(tmp_path / "out.jpg").pixels.shape == shape
    assert path.read_bytes() == small_portrait.read_bytes()


# ---- bad values: refused before the photo is even opened ------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--amount", "99"], "'--amount': '99' is not a number in the range -15..15"),
        (["--amount", "much"], "'much' is not a number in the range"),
        (["--amount", "1" + "0" * 400], "is not a number in the range"),
        (["--center", "9"], "'--center': '9' is not a whole number in the range 1..4"),
        (["--quality", "high"], "'high' is not a whole number in the range 1..100"),
        (["--threshold", "-1"], "'-1' is not a number in the range 0..16"),
        (["--fit", "tight"], "'tight' is not one of"),
        (["--face", "biggest"], "expected all, largest, or numbers"),
        (["--face", "1,"], "expected all, largest, or numbers"),
        (["--recipe", "missing.json"], "missing.json doesn't exist; check the name"),
        (["--max-megapixels", "0"], "'0' is not a number in the range >0"),
        (["--max-megapixels", "nan"], "'nan' is not a number in the range >0"),
        (["--protect-width", "inf"], "'inf' is not a number in the range >=0"),
        (["--evidence", "photo.jpg"], "photo.jpg is a photo; name another file"),
        (["--sample"], "name one photo, or use --sample"),
        (["--wrong"], "No such option.*see kogao-cli warp --help"),
        (["second.jpg"], "warp takes one photo; use kogao-cli batch for several"),
    ],
)
def test_bad_values_are_usage(fails, tmp_path, arguments, words):
    never = tmp_path / "never-opened.jpg"
    fails(2, words, "warp", never, "-o", tmp_path / "out.jpg", *arguments)


@pytest.mark.parametrize(
    "arguments",
    [
        ["photo\x1b[31m\n\u202e.jpg", "-o", "out.jpg"],
        ["x" * 5000, "-o", "out.jpg"],
        ["photo.jpg", "-o", "out.jpg", "--amount", "x" * 5000],
        ["photo.jpg", "-o", "out.jpg", "--face", "x" * 5000],
        ["photo.jpg", "-o", "out.jpg", "--points", "x" * 5000],
        ["photo.jpg", "-o", "out.jpg", "--recipe", "\x1b]0;title\a"],
    ],
)
def test_messages_are_short_and_hold_no_orders_to_the_terminal(cli, arguments):
    code, out, err = cli("warp", *arguments)
    assert code in (2, 3)
    assert out == ""
    assert err.endswith("\n")
    assert err[:-1].isprintable()
    assert len(err) < 700


@pytest.mark.skipif(sys.platform == "win32", reason="needs any names")
def test_what_is_printed_of_a_name_holds_no_orders_to_the_terminal(works, tmp_path):
    name = tmp_path / "a\x1b]0;title\a\u3000b\u202fc.jpg"
    shutil.copy(ROOT / "resources" / "samples" / "average.jpg", name)
    for arguments in (
        ["detect", name],
        ["warp", name, "-o", name.with_suffix(".png"), "--save-project"],
        ["landmarks", "export", name, "--format", "csv", "-o", tmp_path],
        ["warp", "--in-place", name],
        ["restore", name],
    ):
        out = works(*arguments)
        assert out[-1] == "\n"
        assert "a?]0;title?\u3000b\u202fc" in out
        assert not set("\x1b\a") & set(out)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("\x80", "can't be used: the file is not JSON, but binary data"),
        (
            '{"format": "kogao-project", "version": 1}',
            "apply a project with kogao-cli warp --project",
        ),
        ("[]", "must be a JSON object"),
        ('{"percent": 99}', "can't be used: percent must be"),
        ("[" * 100_000, "nested too deeply"),
        ('{"fit": ' + "[" * 900 + "]" * 900 + "}", r"got \[\["),
        ('{"' + "x" * 500_000 + '": 1}', "unknown recipe field 'x{39}…"),
        ('{"version": 1' + "0" * 400 + "}", "version 4, got 1000*…"),
        ("{" + " " * 2**20, "at most 1048576 are allowed"),
    ],
)
def test_a_bad_recipe_file_is_usage(fails, tmp_path, content, words):
    (tmp_path / "r.json").write_bytes(content.encode("latin-1"))
    arguments = ["-o", tmp_path / "out.jpg", "--recipe", tmp_path / "r.json"]
    fails(2, words, "warp", tmp_path / "never-opened.jpg", *arguments)


@pytest.fixture
def marked(tmp_path):
    """A photo of 480 x 360 px without a face in it, and a file of points that says where one is."""
    path = tmp_path / "marked.png"
    Image.fromarray(textured_photo()).save(path)
    interchange.write([oval_face()], tmp_path / "points.json")
    return path, "--points", tmp_path / "points.json"


def test_what_lies_far_outside_the_photo_is_refused(fails, marked, tmp_path):
    warp = "warp", *marked, "-o", tmp_path / "out.png"
    words = r"corner 2 of protected line 1 .* ends at 479, 359"
    fails(2, words, *warp, "--protect", "0,0 1e9,1e9")
    interchange.write([oval_face()] * 500, marked[2])
    fails(3, "500 faces lie where face 1 does", *warp)


def test_a_label_on_an_unchanged_photo_is_left_out_and_said(cli, warns, marked, tmp_path):
    nothing = ("--amount", 0, "--label", "retouched")
    _, said = warns("warp", *marked, "-o", tmp_path / "out.png", *nothing, "--disclose")
    assert "nothing was changed, so there is no label and edit record" in said
    assert (tmp_path / "out.png").read_bytes() == marked[0].read_bytes()
    assert "nothing was changed" not in cli("warp", *marked, "-o", tmp_path / "two.png")[2]


# ---- what nobody foresaw --------------------------------------------------------------------


@pytest.fixture
def breaks(monkeypatch):
    """Make every rendering raise something."""

    def arrange(error):
        def raising(*_, **__):
            raise error

        monkeypatch.setattr(retouching, "render", raising)

    return arrange


def test_an_error_of_our_own_is_one_line_with_its_own_code(
    cli, fails, marked, tmp_path, breaks, monkeypatch
):
    command = ("warp", *marked, "-o", tmp_path / "out.png")
    breaks(KeyError("something\nstrange " + "x" * 500))
    fails(70, r"\(KeyError: 'something.*please report.*KOGAO_DEBUG=1", *command)
    breaks(MemoryError())
    fails(70, "not enough memory; close", *command)
    breaks(PermissionError(13, "Permission denied", "/some/where"))
    fails(3, "/some/where: Permission denied", *command)
    monkeypatch.setenv("KOGAO_DEBUG", "1")
    breaks(KeyError("strange"))
    first, *_, last = cli(*command)[2].splitlines()
    assert first == "Traceback (most recent call last):"
    assert last.startswith("kogao-cli: internal error")


def test_a_source_whose_landmarks_are_no_numbers_gives_a_sentence(
    fails, marked, tmp_path, monkeypatch
):
    class Broken:
        name = "broken"

        def find(self, _):
            return [dataclasses.replace(oval_face(), eyes=np.full((4, 2), np.nan))]

    monkeypatch.setattr(warping, "landmark_source", lambda _: Broken())
    words = "form no face: a face's eyes can't be used.*--landmarks"
    fails(4, words, "warp", marked[0], "-o", tmp_path / "out.png")


def test_wrong_calls_are_usage(fails, tmp_path):
    photo, out = tmp_path / "never-opened.jpg", tmp_path / "out.jpg"
    in_place = "warp", photo, "--in-place"
    for words, *call in (
        ("no command 'wrap'; did you mean warp\\?", "wrap"),
        ("no command 'xyz' .see kogao-cli --help.", "xyz"),
        ("no output given; use -o FILE or --in-place", "warp", photo),
        ("name one photo", "warp", "-o", out),
        ("name one photo", "detect"),
        ("No such option '--head-follows'", "warp", photo, "-o", out, "--head-follows", 50),
        ("--center has no effect with --scope head", "warp", photo, "-o", out, "--center", 3),
        ("--lens-amount has no effect with --lens off", *in_place, "--lens-amount", 50),
        ("--sample can't be combined", "warp", "--in-place", "--sample"),
        ("-o can't be combined", *in_place, "-o", out),
        ("--save-project can't be combined", *in_place, "--save-project"),
        ("can't be combined with --in-place", *in_place, "--srgb"),
        ("need a file, not standard input", "warp", "-", "--in-place"),
        ("need a file, not standard input", "warp", "-", "-o", out, "--save-project"),
        ("both need standard output", "warp", photo, "-o", "-", "--json", "-"),
    ):
        fails(2, words, *call)


# ---- bad files ------------------------------------------------------------------------------


def test_unreadable_photos(fails, tmp_path, monkeypatch):
    text, large = tmp_path / "text.jpg", tmp_path / "large.png"
    text.write_bytes(b"not a photo\n")
    large.write_bytes(files.empty_png(40_000, 40_000))
    fails(3, "not a JPEG", "detect", text, "--json", "-")
    fails(3, "doesn't exist", "warp", tmp_path / "missing.jpg", "-o", tmp_path / "out.jpg")
    fails(3, "1600 megapixels; the limit is 300", "warp", large, "-o", tmp_path / "out.jpg")
    fails(3, "is a folder", "detect", tmp_path)
    denied = PermissionError(13, "Permission denied")
    monkeypatch.setattr(Path, "open", Mock(side_effect=denied))
    fails(3, "check its permissions", "detect", large)


@pytest.mark.usefixtures("portrait")
def test_the_size_limit_can_be_raised(fails, faceless):
    fails(3, "the limit is 0.01: raise it by", "detect", faceless, "--max-megapixels", 0.01)
    fails(4, "no face", "detect", faceless, "--max-megapixels", 0.02)


@pytest.mark.usefixtures("portrait")
def test_no_face(fails, faceless, tmp_path):
    words = r"no face in .*faceless\.png; crop closer, or place a face by hand in the editor"
    fails(4, words, "detect", faceless)
    fails(4, words, "warp", faceless, "-o", tmp_path / "out.png")
    one = tmp_path / "one.png"
    Image.new("RGB", (1, 1)).save(one)
    fails(4, "no face in", "warp", one, "-o", tmp_path / "out.png", "--json", "-")


def test_bad_outputs(fails, tmp_path, faceless):
    never = tmp_path / "never-opened.jpg"
    fails(3, "doesn't exist; make it first", "warp", never, "-o", tmp_path / "no" / "out.jpg")
    fails(2, "must end in one of", "warp", never, "-o", tmp_path / "out.bmp")
    fails(2, "is a folder", "warp", never, "-o", tmp_path)
    deep = tmp_path / "deep.png"
    source = photo.read(faceless)
    photo.write(source, source.pixels.astype(np.uint16) * 257, deep)
    fails(2, "JPEG can't hold this 16-bit photo", "warp", deep, "-o", tmp_path / "out.jpg")


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX files")
def test_only_files_are_replaced(fails, small_portrait, tmp_path):
    """Every command asks one function what is there, which knows more kinds than a pipe."""
    photo = shutil.copy(small_portrait, tmp_path / "photo.jpg")
    for name, *command in (
        ("out.jpg", "warp", photo, "-o", tmp_path / "out.jpg"),
        ("photo.jpg.kogao.json", "warp", photo, "-o", tmp_path / "new.jpg", "--save-project"),
        ("photo.csv", "landmarks", "export", photo, "--format", "csv", "-o", tmp_path),
        ("report.html", "experiment", "domains", photo, "--html", tmp_path / "report.html"),
    ):
        os.mkfifo(tmp_path / name)
        fails(2, "can't be replaced: it is a folder, pipe or device", *command)
        fails(2, "can't be replaced: it is a folder, pipe or device", *command, "--force")
        (tmp_path / name).unlink()
    os.mkfifo(tmp_path / "batch.jsonl")
    words = "report .*can't be written .it is a"
    fails(3, words, "batch", photo, "-o", tmp_path / "out", "--report", tmp_path / "batch.jsonl")


def test_a_full_disk_leaves_nothing(fails, small_png, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", Mock(side_effect=OSError(28, "No space left on device")))
    fails(3, "No space left on device", "warp", small_png, "-o", tmp_path / "out.jpg")


def test_without_networks_the_aam_steps_in_and_says_so(cli, fails, portrait, tmp_path, lack):
    lack(".tflite")
    code, said, err = cli("detect", portrait, "--json", "-")
    assert (code, len(json.loads(said)["faces"])) == (0, 1)
    assert "less exact" in err
    fails(1, "is missing; reinstall", "detect", portrait, "--landmarks", "mesh")
    lack("")
    fails(1, "is missing; reinstall", "warp", "--sample", "-o", tmp_path / "out.png")


def test_warp_writes_the_numbers_behind_the_result(works, fails, small_png, tmp_path):
    numbers = tmp_path / "e.npz"
    warp = ("warp", small_png, "-o", tmp_path / "o.png", "--amount", "5", "--evidence", numbers)
    works(*warp)
    evidence = kogao.load_evidence(numbers)
    assert evidence.recipe.percent == 5.0
    assert evidence.made["photo_sha256"] == hashlib.sha256(small_png.read_bytes()).hexdigest()
    pixels = kogao.read(tmp_path / "o.png").pixels
    assert evidence.made["result_sha256"] == hashlib.sha256(pixels.tobytes()).hexdigest()
    (tmp_path / "o.png").unlink()
    fails(2, "e.npz already exists", *warp)


@pytest.mark.parametrize("name", ["face_detection_back", "face_landmarks_detector"])
def test_a_damaged_network_is_no_photo_without_a_face(fails, portrait, tmp_path, monkeypatch, name):
    everything = assets.path
    damaged = tmp_path / f"{name}.tflite"
    data = bytearray(everything(f"models/{name}.tflite").read_bytes())
    data[len(data) // 2 :][:64] = bytes(64)
    damaged.write_bytes(data[:-1] + bytes([data[-1] ^ 1]))
    monkeypatch.setattr(assets, "path", lambda one: damaged if name in one else everything(one))
    words = f"{name}.tflite is damaged or another file.*doctor"
    fails(1, words, "detect", portrait)
    fails(1, words, "warp", portrait, "-o", tmp_path / "out.jpg")
    fails(1, words, "batch", portrait, "-o", tmp_path / "out")


# ---- the program ----------------------------------------------------------------------------


def test_only_the_programs_help_has_the_exit_codes(works):
    meanings = ("0    done", "2    wrong usage", "3    unreadable input", "70   internal error")
    for arguments in (["--help"], ["-h"], []):
        said = works(*arguments)
        assert all(meaning in said for meaning in meanings)
    assert "Exit codes" not in works("warp", "-h")
    for option in ("-V", "--version"):
        assert works(option) == f"kogao-cli {kogao.__version__}\n"


@pytest.mark.parametrize("group", ["landmarks", "experiment", "experiment study"])
def test_a_group_alone_prints_its_help(works, group):
    assert works(*group.split()) == works(*group.split(), "--help")


def test_the_help_of_warp_begins_with_examples_and_twelve_options_at_most(works):
    examples, common, *_ = works("warp", "--help").partition("Examples:")[2].split("\n\n")
    assert len(examples.split()) > 0
    assert len([line for line in examples.splitlines() if "kogao-cli warp" in line]) == 3
    assert common.startswith("Common options:")
    assert len(re.findall(r"^  -", common, re.MULTILINE)) <= 12


def test_quiet_and_verbose(cli, works, small_png, tmp_path):
    warp = "warp", small_png, "--force", "-o", tmp_path / "out.jpg"
    assert works(*warp, "-q") == ""
    (line,) = works(*warp).splitlines()
    first, *details = works(*warp, "-v").splitlines()
    assert first == line
    names = [one.split()[0] for one in details]
    assert [name for name in names if name != "lines"] == [
        *("centre", "amount", "accuracy", "folds", "domain", "time")
    ]
    assert cli(*warp, "-q", "-v")[0] == 2


def test_one_line_for_several_faces_and_for_other_changes(works, small_png, tmp_path):
    picture = np.asarray(Image.open(small_png))
    Image.fromarray(np.hstack([picture, picture])).save(tmp_path / "pair.png")
    warp = "warp", tmp_path / "pair.png", "--force", "-o", tmp_path / "out.png"
    for options, change in (
        (("--amount", 3), "3 % smaller"),
        (("--amount", -3), "3 % larger"),
        (("--amount", 0), "unchanged"),
        (("--jaw-width", -5), "reshaped"),
    ):
        assert works(*warp, *options) == f"{tmp_path / 'out.png'}: 2 faces, {change}\n"


@pytest.mark.skipif(os.name == "nt", reason="POSIX pipes")
def test_a_photo_goes_through_pipes_and_comes_out_as_from_a_file(works, small_portrait, tmp_path):
    works("warp", small_portrait, "-o", tmp_path / "out.jpg")
    command = [sys.executable, "-c", PROGRAM, "warp", "-", "-o"]
    with small_portrait.open("rb") as file:
        done = subprocess.run([*command, "-"], stdin=file, capture_output=True, check=True)
    assert done.stdout == (tmp_path / "out.jpg").read_bytes()
    assert done.stderr.startswith(b"-: 1 face, 6 % smaller")
    broken = subprocess.run([*command, "-"], input=b"no photo", capture_output=True)
    assert (broken.returncode, broken.stdout) == (3, b"")
    empty = subprocess.run([*command, "-"], input=b"", capture_output=True)
    assert empty.returncode == 3
    assert empty.stderr == b"kogao-cli: standard input is empty; pipe a photo into the command\n"


# What a warp has no use for.
UNUSED = {
    *("webbrowser", "urllib.request", "email", "importlib.metadata", "numpy.ma"),
    *("secrets", "kogao_core.lab", "kogao_core.batch", "kogao_core.cli.batch"),
    *("kogao_core.cli.doctor", "kogao_core.lab.commands.experiment"),
}
MODULES = """
import sys
from kogao_core.cli import main
for call in sys.argv[1:]:
    try:
        main(call.split("|"))
    except SystemExit as ending:
        assert ending.code in (0, 1, 2)
print(*sys.modules)
"""


def loaded(*calls):
    """Return the modules that a program has loaded after commands without warnings."""
    env = os.environ | {"PYTHONWARNINGS": "error"}
    words = ["|".join(map(str, call)) for call in calls]
    return set(ran(MODULES, *words, env=env).stdout.splitlines()[-1].split())


def test_a_warp_loads_only_what_it_uses(small_portrait, tmp_path):
    """No command but the laboratory's loads Qt."""
    warp = loaded(("warp", small_portrait, "-o", tmp_path / "out.jpg"))
    assert warp & UNUSED == set()
    names = {name.split(".")[0] for name in warp | loaded(["doctor"], ["licenses"])}
    assert names & {"PySide6", "shiboken6", "pyqtgraph"} == set()


def test_help_and_wrong_options_load_neither_numpy_nor_opencv_nor_pillow():
    """The laboratory's commands do: their experiments declare the options."""
    calls = [["--help"], ["landmarks", "export", "--help"], ["warp", "a.jpg", "b.jpg"], ["warp"]]
    for name in set(commands.every) - {"experiment"}:
        calls += [name, "--help"], [name, "--wrong"]
    assert loaded(*calls) & {"numpy", "cv2", "PIL"} == set()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
@pytest.mark.parametrize(
    ("outside", "code", "words"),
    [
        ("| true", 0, ""),
        (">&-", 0, ""),
        ("> /dev/full", 3, r"kogao-cli: [^\n]+can't be printed[^\n]+\n"),
    ],
)
def test_a_reader_that_leaves_is_no_error_and_a_full_disk_is_one(outside, code, words):
    if shutil.which("bash") is None:
        pytest.skip("needs bash")
    command = f"set -o pipefail; {sys.executable} -c '{PROGRAM}' licenses {outside}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.returncode == code
    assert re.fullmatch(words, done.stderr)


# ---- doctor and licences --------------------------------------------------------------------


@pytest.mark.usefixtures("portrait")
def test_doctor_is_well_when_nothing_is_missing(works, monkeypatch):
    monkeypatch.setattr(installed, "_loads", lambda _: True)
    said = works("doctor")
    assert said.rstrip().endswith("No problems found.")
    for name in ("numpy", "opencv", "Pillow", "PySide6", "pyqtgraph", "Python 3"):
        assert name in said


def test_doctor_says_how_to_get_an_extra_and_calls_nothing_broken(cli, monkeypatch):
    there = doctor._package
    monkeypatch.setattr(
        doctor, "_package", lambda name: {"version": ""} if name == "rawpy" else there(name)
    )
    assert f"extra [raw]: not installed ({installed.adding('raw')})" in cli("doctor")[1]
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert set(doctor.examine()["extras"]) == (
        set(declared["optional-dependencies"]) - {"test", "bench", "dev", "docs"}
    )
    assert not any("raw" in command for command in doctor.examine()["mend"])


@needs_linux("libraries of a Linux desktop")
@pytest.mark.usefixtures("portrait")
@pytest.mark.parametrize(("user", "sudo"), [(0, ""), (1000, "sudo ")])
def test_doctor_names_missing_libraries_and_the_one_command(cli, tmp_path, monkeypatch, user, sudo):
    monkeypatch.setattr(os, "geteuid", lambda: user)
    missing = {
        "libEGL.so.1": "libegl1",
        "libX11.so.6": "libx11-6",
        "libglib-2.0.so.0": "libglib2.0-0",
        "libxcb-cursor.so.0": "libxcb-cursor0",
    }
    monkeypatch.setattr(installed, "_loads", lambda name: name not in missing)
    code, said, _ = cli("doctor", "--json", tmp_path / "found.json")
    assert code == 1
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["missing_libraries"] == missing
    assert found["mend"] == [f"{sudo}apt-get install libegl1 libglib2.0-0 libx11-6 libxcb-cursor0"]
    assert "libxcb-cursor.so.0: missing (Debian and Ubuntu: libxcb-cursor0)" in said
    assert f"Repair: {found['mend'][0]}" in said


@pytest.mark.usefixtures("portrait")
def test_doctor_sees_wrong_and_missing_networks(cli, tmp_path, monkeypatch):
    real = assets.path

    def path(name):
        if name == "models/face_detection_back.tflite":
            (tmp_path / "wrong").write_bytes(b"something else")
            return tmp_path / "wrong"
        if name.startswith("models/"):
            raise assets.AssetMissing(name)
        return real(name)

    monkeypatch.setattr(assets, "path", path)
    monkeypatch.setattr(installed, "_loads", lambda _: True)
    code, said, _ = cli("doctor", "--json", "-")
    assert code == 1
    states = json.loads(said)["assets"]
    assert states["face_detection_back.tflite"] == "differs from the original file"
    assert states["face_landmarks_detector.tflite"] == "missing"
    assert any("pip install" in command for command in json.loads(said)["mend"])


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Qt needs these on Linux only")
@pytest.mark.parametrize("platform", ["xcb", "wayland"])
def test_doctor_knows_every_library_that_qt_asks_for(platform):
    spec, readelf = util.find_spec("PySide6"), shutil.which("readelf")
    if spec is None or readelf is None:
        pytest.skip("needs PySide6 and binutils' readelf")
    qt = Path(spec.submodule_search_locations[0]) / "Qt"
    bundled = {path.name for path in (qt / "lib").iterdir()}
    todo = [qt / f"plugins/platforms/libq{one}.so" for one in (platform, "offscreen")]
    todo += [qt / "lib/libQt6Gui.so.6", qt / "lib/libQt6Widgets.so.6"]
    seen, outside = set(), set()
    while todo:
        path = todo.pop()
        seen.add(path.name)
        said = subprocess.run([readelf, "-d", path], capture_output=True, text=True, check=True)
        for name in re.findall(r"NEEDED.*\[(.*)\]", said.stdout):
            if name not in bundled:
                outside.add(name)
            elif name not in seen:
                todo.append(qt / "lib" / name)
    base = re.compile(
        r"(libc|libm|libdl|librt|libpthread|libgcc_s|libstdc\+\+|ld-linux.*)\.so\.\d+"
    )
    assert {name for name in outside if not base.fullmatch(name)} == set(
        installed.LIBRARIES[platform]
    )


@pytest.mark.usefixtures("portrait")
def test_licences_name_everything_that_is_used(works):
    said = works("licenses")
    for name in (
        f"Kogao {kogao.__version__}: Apache-2.0",
        *licences.DEPENDENCIES,
        "DeBruine",
        "CC BY 4.0",
    ):
        assert name.lower().replace("-", "_") in said.lower().replace("-", "_")
    for asset in licences.manifest():
        assert f"{asset['file']}: {asset['licence']}; {asset['from']}" in said
    assert "see its documentation" not in said


def test_the_list_of_dependencies_is_the_projects():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    names = {re.split(r"[<>=!\[; ]", line)[0] for line in project["dependencies"]}
    assert names == set(licences.DEPENDENCIES)


def test_a_single_photo_is_exported_the_same_way(small_portrait, tmp_path, works):
    out = tmp_path / "out.jpg"
    works("warp", small_portrait, "-o", out, "--longest-side", 200, "--quality", 70)
    with Image.open(out) as made:
        assert max(made.size) == 200
