"""Photos written over in place: files of the same kind, whose originals come back."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import files
import jpeglib
import metadata_cases
import numpy as np
import pytest
from PIL import Image
from programs import ran
from scenes import oval_face

from kogao_core import photo
from kogao_core.photo import originals
from kogao_core.photo.originals import Originals
from kogao_core.projects import forgetting
from kogao_core.projects.interchange import faces_text


@pytest.fixture(autouse=True)
def store(monkeypatch, tmp_path):
    """The user's store, in a folder of the test's own."""
    for module in (originals, forgetting):
        monkeypatch.setattr(module, "data_folder", lambda: tmp_path / "data")
    return tmp_path / "data" / "originals"


@pytest.fixture
def jpeg(small_portrait, tmp_path):
    return Path(shutil.copy(small_portrait, tmp_path / "photo.jpg"))


def pixels_of(path, depth=np.uint8):
    return cv2.cvtColor(cv2.imread(str(path)), cv2.COLOR_BGR2RGB).astype(depth)


def names(folder):
    return sorted(path.name for path in folder.iterdir() if path.is_file())


def test_a_photo_is_written_over_and_comes_back_byte_for_byte(cli, works, jpeg, tmp_path, store):
    before = jpeg.read_bytes()
    said = works("warp", "--in-place", jpeg)
    assert "of the JPEG unchanged" in said
    assert jpeg.read_bytes() != before
    assert names(tmp_path) == ["photo.jpg"]
    then, now = (jpeglib.read_dct(str(path)) for path in (next(store.glob("*.jpg")), jpeg))
    np.testing.assert_array_equal(now.qt, then.qt)
    assert cli("restore", jpeg)[:2] == (0, f"{jpeg}: original restored\n")
    assert jpeg.read_bytes() == before
    assert cli("restore", jpeg)[:2] == (0, f"{jpeg} is already the original\n")


def test_of_a_file_that_the_caller_throws_away_no_original_is_kept(
    cli, jpeg, tmp_path, store, monkeypatch
):
    copied = tmp_path / "copied.jpg"
    copied.write_bytes(jpeg.read_bytes())
    monkeypatch.setattr(originals, "atomic_write", None)  # nor any copy, for now
    assert cli("warp", "--in-place", "--temporary", jpeg)[0] == 0
    assert not store.exists()
    monkeypatch.undo()
    monkeypatch.setattr(originals, "data_folder", lambda: store.parent)
    assert cli("warp", "--in-place", copied)[0] == 0
    assert jpeg.read_bytes() == copied.read_bytes()


def test_a_phones_portrait_comes_back_whole(cli, works, small_portrait, tmp_path):
    """It lies in its file, has a gain map and a film, and goes all three ways."""
    upright = Image.open(small_portrait)
    map_pixels = upright.convert("L").reduce(4)
    xmp = metadata_cases.packet('hdrgm:Version="1.0" hdrgm:GainMapMax="2"', name="map")
    more = files.saved(map_pixels.transpose(Image.Transpose.ROTATE_90), "JPEG", xmp=xmp)
    items = [("Primary", 0), ("GainMap", len(more)), ("MotionPhoto", len(metadata_cases.MP4))]
    told = 'hdrgm:Version="1.0" GCamera:MotionPhoto="1"'
    xmp = metadata_cases.packet(told, metadata_cases.container(*items))
    phone = tmp_path / "phone.jpg"
    lying = upright.transpose(Image.Transpose.ROTATE_90)
    exif = files.exif_block(6, *lying.size)
    lying.save(phone, exif=exif, xmp=xmp, icc_profile=files.SRGB)
    phone.write_bytes(phone.read_bytes() + more + metadata_cases.MP4)
    said = works("warp", phone, "-o", tmp_path / "out.jpg", "--motion", "keep")
    assert "the motion photo's video still shows the original face" in said
    assert "not kept" not in said
    source, result = photo.read(phone), photo.read(tmp_path / "out.jpg")
    assert result.orientation == 6
    assert (tmp_path / "out.jpg").read_bytes().endswith(metadata_cases.MP4)
    assert photo.has_gain_map(result)
    assert cli("batch", phone, "-o", tmp_path / "batch", "--motion", "keep")[0] == 0
    assert (tmp_path / "batch" / "phone.jpg").read_bytes() == (tmp_path / "out.jpg").read_bytes()
    dropped = works("warp", "--in-place", phone)
    assert "not kept: the motion photo's video" in dropped
    assert photo.has_gain_map(photo.read(phone))
    assert b"MotionPhoto" not in phone.read_bytes()
    assert works("restore", phone)
    assert photo.read(phone).extras == source.extras


def test_the_same_pixels_come_as_in_a_copy(cli, small_portrait, tmp_path):
    face = tmp_path / "face.json"
    face.write_text(faces_text([oval_face(150, 150)]))
    for suffix, make in files.MAKERS.items():
        source = tmp_path / f"in{suffix}"
        source.write_bytes(make(pixels_of(small_portrait)))
        assert cli("warp", source, "-o", tmp_path / f"out{suffix}", "--points", face)[0] == 0
        assert cli("warp", "--in-place", source, "--points", face)[0] == 0
        assert source.read_bytes() == (tmp_path / f"out{suffix}").read_bytes()


@pytest.mark.skipif(not shutil.which("exiftool"), reason="needs ExifTool")
def test_exiftool_finds_the_same_metadata(cli, small_portrait, tmp_path):
    # Strips are the writer's own; whole numbers are meant where nothing is said.
    def told(path):
        groups = ("-EXIF:all", "-GPS:all", "-IPTC:all", "-XMP:all", "-ICC_Profile:all", "-File:all")
        left_out = ("--IFD1:all", "--File:System:all", "--ThumbnailImage")
        layout = ("--StripOffsets", "--RowsPerStrip", "--StripByteCounts", "--SampleFormat")
        command = ["exiftool", "-j", "-G1", *groups, *left_out, *layout, str(path)]
        (tags,) = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
        return tags

    for path, make in ((tmp_path / "a.jpg", files.jpeg), (tmp_path / "a.tif", files.tiff)):
        path.write_bytes(make(pixels_of(small_portrait)))
        before = told(path)
        assert "GPS:GPSLatitude" in before
        assert cli("warp", "--in-place", path)[0] == 0
        assert told(path) == before


def test_the_first_original_is_kept_through_several_changes(cli, jpeg, store):
    before = jpeg.read_bytes()
    for changed_before in (False, True, True):
        code, said, _ = cli("warp", "--in-place", jpeg)
        assert code == 0
        assert ("resampled twice; kogao-cli restore first" in said) == changed_before
    assert len(names(store)) == 2
    assert cli("restore", jpeg)[0] == 0
    assert jpeg.read_bytes() == before


def test_every_original_of_a_photo_is_listed_and_restored(cli, jpeg, store):
    first = jpeg.read_bytes()
    assert cli("warp", "--in-place", jpeg)[0] == 0
    with Image.open(jpeg) as theirs:
        theirs.transpose(Image.Transpose.FLIP_LEFT_RIGHT).save(jpeg)
    second = jpeg.read_bytes()
    assert cli("warp", "--in-place", jpeg)[0] == 0
    code, listed, _ = cli("originals", jpeg)
    *lines, total = listed.splitlines()
    kept = [line.split("  ") for line in lines]
    assert (code, [(number, Path(file).read_bytes()) for number, *_, file, _ in kept]) == (
        0,
        [("1", second), ("2", first)],
    )
    assert {(Path(file).parent, path) for *_, file, path in kept} == {(store, str(jpeg))}
    assert total.startswith("2 originals, ")
    for number, whole in (("2", first), ("1", second), ("2", first)):
        assert cli("restore", jpeg, "--original", number)[0] == 0
        assert jpeg.read_bytes() == whole
    assert cli("restore", jpeg)[:2] == (0, f"{jpeg} is already the original\n"), "not the newest"
    jpeg.write_bytes(b"theirs")
    assert cli("restore", jpeg, "--original", 2)[0] == 2
    assert cli("restore", jpeg, "--original", 2, "--force")[0] == 0
    assert jpeg.read_bytes() == first
    code, _, err = cli("restore", jpeg, "--original", 3)
    assert (code, "there is no original 3" in err) == (2, True)


def test_without_a_face_the_photo_stays_untouched(fails, faceless, weights):
    assert weights
    fails(4, "no face in", "warp", "--in-place", faceless)


def test_nothing_is_written_where_nothing_changes(cli, jpeg, store):
    before = jpeg.stat().st_mtime_ns
    code, said, _ = cli("warp", "--in-place", jpeg, "--amount", 0)
    assert code == 0
    assert "nothing changed: the file is as it was" in said
    assert jpeg.stat().st_mtime_ns == before
    assert not store.exists()


def tiff(mode="RGB", **options):
    return lambda picture: files.saved(picture.convert(mode), "TIFF", **options)


REFUSED = {
    "pages.tif": (
        lambda one: files.saved(one, "TIFF", save_all=True, append_images=[one]),
        "wouldn't come back as it is, but without further pictures",
    ),
    "moving.png": (lambda _: metadata_cases.animated("PNG"), "but without further pictures"),
    "cmyk.jpg": (lambda one: files.saved(one.convert("CMYK"), "JPEG"), "from CMYK to RGB"),
    "palette.png": (
        lambda one: files.saved(one.quantize(), "PNG"),
        "but converted from a palette to RGB; write the result to another file with -o",
    ),
    "scan.tif": (tiff("1", compression="group4"), "but converted from 1 bit to 8-bit grey"),
    "preview.tif": (tiff(compression="jpeg"), "but compressed by LZW instead of jpeg"),
    "no-ending": (
        lambda one: files.saved(one, "PNG"),
        "is a PNG photo by its content; name it no-ending",
    ),
    "raw.dng": (lambda _: files.dng(), "is a raw photo, which can't be written in place"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_would_come_back_as_less_is_refused(fails, small_portrait, tmp_path, name):
    if name.endswith(".dng"):
        pytest.importorskip("rawpy")
    (make, words), path = REFUSED[name], tmp_path / name
    path.write_bytes(make(Image.fromarray(pixels_of(small_portrait))))
    fails(2, words, "warp", "--in-place", path)


def test_no_original_is_no_restoring(fails, jpeg):
    fails(2, "no original of", "restore", jpeg)
    fails(2, "no original 1 of", "restore", jpeg, "--original", 1)


@pytest.mark.skipif(sys.platform == "win32", reason="needs a file in the way of a folder")
def test_an_original_that_cant_be_kept_stops_the_change(fails, jpeg, store):
    store.parent.write_text("in the way")
    fails(3, "the original of .* can't be kept", "warp", "--in-place", jpeg)


def test_a_file_that_was_written_twice_by_its_editor_keeps_the_first_blocks(jpeg, store):
    shown, place = photo.read(jpeg), Originals(store)
    whole = jpeg.read_bytes()
    for shade in (0, 99):
        pixels = shown.pixels.copy()
        pixels[:8, :8] = shade
        note = photo.write_in_place(shown, pixels, place)
        assert note.startswith(("99.", "100."))
    assert photo.write_in_place(shown, shown.pixels, place) == ""
    assert jpeg.read_bytes() == whole


@pytest.mark.parametrize("suffix", [".jpg", ".tif"])
def test_a_result_that_is_opened_again_may_be_written_several_times(
    small_portrait, tmp_path, store, suffix
):
    path, place = tmp_path / f"photo{suffix}", Originals(store)
    cv2.imwrite(str(path), cv2.imread(str(small_portrait)))
    whole = path.read_bytes()
    photo.write_in_place(first := photo.read(path), first.pixels // 2, place)
    again = photo.read(path)
    for shade in (10, 20, 30):
        pixels = again.pixels.copy()
        pixels[:16, :16] = shade
        photo.write_in_place(again, pixels, place)
        written = photo.read(path).pixels
        assert abs(written[:8, :8].mean() - shade) < 2
        np.testing.assert_array_equal(written[64:], again.pixels[64:])
    assert place.restore(path)
    assert path.read_bytes() == whole


def test_a_full_store_stops_the_change_unless_it_may_delete(cli, tmp_path, jpeg, monkeypatch):
    other = Path(shutil.copy(jpeg, tmp_path / "other.jpg"))
    assert cli("warp", "--in-place", jpeg)[0] == 0
    before = other.read_bytes()
    monkeypatch.setattr(originals.Originals.__init__, "__defaults__", (1000, False))
    code, _, err = cli("warp", "--in-place", other)
    assert (code, "is full" in err, other.read_bytes() == before) == (3, True, True)
    code, said, _ = cli("warp", "--in-place", "--anyway", other)
    assert (code, "the oldest original was deleted" in said) == (0, True)
    assert cli("forget", other)[1].startswith(f"{other}: deleted 1 original, ")
    assert "no original of" in cli("restore", other)[2]


def test_a_file_that_another_program_changed_is_not_written_over(jpeg, store):
    shown = photo.read(jpeg)
    Image.new("RGB", (8, 8)).save(jpeg)
    theirs = jpeg.read_bytes()
    with pytest.raises(photo.CannotWrite, match="changed by another program since"):
        photo.write_in_place(shown, shown.pixels // 2, Originals(store))
    assert jpeg.read_bytes() == theirs


def test_a_damaged_list_of_results_is_a_warning_of_the_program(tmp_path):
    place = tmp_path / "kogao" / "results.jsonl"
    place.parent.mkdir()
    place.write_text("damaged\n")
    env = os.environ | dict.fromkeys(["XDG_DATA_HOME", "LOCALAPPDATA"], str(tmp_path))
    program = "from kogao_core.cli import main; main()"
    done = ran(program, "forget", "a.jpg", cwd=tmp_path, env=env)
    assert done.stderr == f"kogao-cli: {place}: skipped 1 damaged line\n"
