"""Edits belong to a picture at a path: version 1.0's are found, others are moved aside."""

import json
import lzma
import os
from pathlib import Path

import pytest
from PIL import Image
from stories import write_photo

from kogao_core.photo import read
from kogao_core.photo.whereabouts import Gone, Replaced, current, to_save
from kogao_core.projects.edits import Edits, own_place, sidecar_of
from kogao_core.projects.project import Original, Project, Sheet, load, save
from kogao_core.recipe.recipe import Recipe


@pytest.fixture
def edits(tmp_path):
    return Edits(tmp_path / "data" / "edits")


@pytest.fixture
def photo(tmp_path):
    (folder := tmp_path / "in").mkdir()
    write_photo(folder / "a.png", (1, 1), 0)
    return folder / "a.png"


def project(photo, percent=9.0, sha256=None):
    made = read(photo)
    name = made.picture if sha256 is None else sha256
    original = Original(photo.name, name, made.width, made.height)
    return Project(original, "automatic", Sheet(recipe=Recipe(percent=percent)))


def percent(edits, path):
    found = edits.find(path, read(path)).edits
    return None if found is None else load(found.file).automatic.recipe.percent


@pytest.mark.parametrize("ending", ["jpg", "png", "webp", "tif"])
def test_metadata_is_no_part_of_a_picture_but_its_turn_is(tmp_path, ending):
    pixels, path = Image.effect_noise((40, 30), 50).convert("RGB"), tmp_path / f"a.{ending}"
    hashes = []
    for turn, artist in ((1, ""), (1, "me"), (3, "me")):
        exif = Image.Exif()
        exif[0x112], exif[0x13B] = turn, artist
        pixels.save(path, exif=exif, quality=90)
        hashes.append(read(path).picture)
    assert hashes[0] == hashes[1] != hashes[2]


def test_edits_of_version_1_0_are_found_with_their_undo_steps(edits, photo):
    """Version 1.0 knew the file's hash; a record led to edits of a photo that has moved."""
    known, own = read(photo).sha256, own_place(photo, edits.folder)
    edits.folder.mkdir(parents=True)
    save(project(photo, 7.0, known), own)
    steps = own.with_suffix(".steps")
    steps.write_bytes(b'{"index": 0, "texts": [], "states": []}')
    record = edits.folder / f"{photo.stat().st_size}-{known[:32]}.place"
    record.write_text(json.dumps({"photo": str(photo), "file": str(own)}))
    moved = photo.rename(photo.with_name("b.png"))
    found = edits.find(moved, read(moved)).edits
    assert load(found.file).automatic.recipe.percent == 7.0
    assert list(edits.steps_of(found, load(found.file))) == [steps.read_bytes()]
    assert record.exists(), "left in place"
    assert edits.newest(moved) == own, "as for batch and strip"


def test_edits_of_another_picture_at_the_same_path_are_moved_aside(edits, photo):
    edits.keep(project(photo, 5.0), photo)
    first = photo.rename(photo.with_name("first.png"))
    write_photo(photo, (2, 1), 0)
    assert percent(edits, photo) is None
    assert edits.find(photo, read(photo)).foreign == sidecar_of(photo)
    edits.keep(project(photo, 6.0), photo)
    assert (percent(edits, photo), percent(edits, first)) == (6.0, 5.0)


def test_copies_keep_their_own_edits_and_a_new_copy_has_none(edits, photo):
    other = photo.with_name("b.png")
    other.write_bytes(photo.read_bytes())
    edits.keep(project(photo, 5.0), photo)
    assert percent(edits, other) is None
    edits.keep(project(other, 6.0), other)
    other.unlink()
    assert percent(edits, photo) == 5.0, "its own, although newer ones have lost their photo"


def test_nothing_goes_below_the_mount_point_of_a_missing_drive(edits, photo):
    edits.keep(project(photo, 5.0), photo)
    made, steps = project(photo, 6.0), lzma.compress(b"")
    drive = photo.parent.rename(photo.parent.with_name("drive"))
    photo.parent.mkdir()
    assert edits.keep(made, photo, steps).parent == edits.folder
    assert not list(photo.parent.iterdir())
    photo.parent.rmdir()
    drive.rename(photo.parent)
    found = edits.find(photo, read(photo))
    assert percent(edits, photo) == 6.0, "the newer ones"
    assert found.other is None, "both are known here: nothing to ask"
    old = load(sidecar_of(photo))
    save(project(photo, 8.0), sidecar_of(photo))
    os.utime(sidecar_of(photo), (1, 1))
    assert old.automatic.recipe.percent == 5.0
    assert edits.find(photo, read(photo)).other.file == sidecar_of(photo), "written elsewhere"


@pytest.mark.parametrize("renames", ["folder", "file"])
def test_own_edits_in_both_places_stay_own_when_the_photo_moves(edits, photo, renames):
    edits.keep(project(photo, 5.0), photo)
    if renames == "folder":
        photo = photo.parent.rename(photo.parent.with_name("moved")) / photo.name
    edits.keep(project(photo, 6.0), photo, beside=False)
    if renames == "file":
        photo = photo.rename(photo.with_name("b.png"))
    assert percent(edits, photo) == 6.0
    assert edits.find(photo, read(photo)).other is None, "written here: nothing to ask"


def test_edits_survive_the_loss_of_their_file_and_of_the_index(edits, photo):
    edits.keep(project(photo, 5.0), photo)
    sidecar_of(photo).unlink()
    assert percent(edits, photo) == 5.0
    edits.keep(project(photo, 6.0), photo, beside=False)
    (edits.folder.parent / "index.db").unlink()
    assert percent(edits, photo) == 6.0


def test_a_photo_is_followed_through_renames_and_only_then(photo):
    opened = read(photo)
    assert current(opened) is opened
    write_photo(photo, (1, 1), 5)
    starred = current(opened)
    assert starred.picture == opened.picture
    assert starred.pixels is opened.pixels
    now = photo.rename(photo.with_name("b.png"))
    starred = current(starred)
    assert starred.path == now
    folder = now.parent.rename(now.parent.with_name("elsewhere"))
    assert current(starred).path == folder / "b.png"
    (folder / "b.png").rename(photo.parents[1] / "b.part")
    with pytest.raises(Gone):
        current(starred)
    folder.rename(photo.parent)
    write_photo(now, (2, 1), 5)
    with pytest.raises(Replaced):
        current(starred)


def test_no_copy_goes_over_an_original_under_any_name(photo, tmp_path):
    opened = read(photo)
    renamed = photo.rename(photo.with_name("renamed.png"))
    (link := photo.with_name("link.png")).hardlink_to(renamed)

    def never(_: Path) -> bool:
        return False

    for path in (renamed, link):
        assert to_save(opened, path, never) is None
    (elsewhere := tmp_path / "drive.png").write_bytes(renamed.read_bytes())
    assert to_save(opened, elsewhere, never) is not None, "a copy while the original is there"
    renamed.unlink()
    link.unlink()
    assert to_save(opened, elsewhere, never) is None, "where it has gone"
    assert to_save(opened, tmp_path / "free.png", never) is opened
    write_photo(tmp_path / "other.png", (3, 1), 0)
    assert to_save(opened, tmp_path / "other.png", lambda _: True) is None
