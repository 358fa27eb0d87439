"""What is kept about a photo is listed and deleted, and another user can take it over."""

import json
import shutil
from pathlib import Path

import pytest
from originals_oracle import write_in_place
from PIL import Image

from kogao_core.photo import read
from kogao_core.photo.originals import Originals
from kogao_core.projects import forgetting, sidecar
from kogao_core.projects.acts import Acts
from kogao_core.projects.edits import FOLDER, Edits
from kogao_core.projects.project import Original, Project, Sheet, load, save
from kogao_core.projects.results import Results
from kogao_core.recipe import presets
from kogao_core.recipe.recipe import Recipe


@pytest.fixture
def data(tmp_path):
    return tmp_path / "data"


def filled(data, folder, name, beside=False):
    """Make a photo of which everything is kept, and return what names it."""
    path = folder / name
    Image.effect_noise((40, 30), 60.0 + len(name)).convert("RGB").save(path)
    photo = read(path)
    edits = Edits(data / FOLDER)
    edits.note(photo)
    made = Project(sidecar.original(photo), "automatic", Sheet(recipe=Recipe(percent=7.0)))
    edits.keep(made, path, b"steps", beside=beside)
    original = path.read_bytes()
    write_in_place(Originals(data / "originals"), path, original + b"\0")
    Results(data).add(path, path)
    Acts(data).begin(path, 1, "Apply", {"percent": 7.0}, [path])
    (data / "recovery").mkdir(exist_ok=True)
    left = Project(Original(str(path), photo.picture, 40, 30), "automatic", Sheet())
    save(left, data / "recovery" / f"{name}.json")
    (data / "exports").mkdir(exist_ok=True)
    for file, line in (
        ("exports/x.jsonl", json.dumps({"source": str(path)})),
        ("kogao.log", f"Trouble with {name}"),
    ):
        with (data / file).open("a") as log:
            log.write(f"{line}\n")
    return path, [name.encode(), photo.picture.encode(), photo.sha256.encode(), original]


def traces(data, needles):
    files = [file for file in data.rglob("*") if file.is_file()]
    return {file.name for file in files for one in needles if one in file.read_bytes()}


def test_after_deleting_all_about_a_photo_no_file_names_it_and_others_stay(data, tmp_path):
    (path, needles), (other, others) = (filled(data, tmp_path, one) for one in ("a.png", "éb.png"))
    listed = forgetting.kept(data)
    assert [one.photo for one in listed] == [path, other]
    kinds = {"edits", "names and hashes", "original", "unsaved changes"}
    assert all(set(one.what) == kinds for one in listed)
    assert all(one.size > path.stat().st_size and one.newest_ns for one in listed)
    assert traces(data, needles)
    forgetting.forget([path], data)
    assert traces(data, needles) == set()
    assert [one.photo for one in forgetting.kept(data)] == [other]
    assert len(traces(data, others)) >= 6
    assert Edits(data / FOLDER).find(other).edits is not None


def test_files_whose_photo_is_not_known_are_listed_and_deleted_by_their_own_name(data, tmp_path):
    filled(data, tmp_path, "a.png")
    (data / "index.db").unlink()
    for one in forgetting.kept(data):
        forgetting.forget([one.photo], data)
    assert forgetting.kept(data) == []
    assert not list((data / FOLDER).glob("*.json"))


@pytest.mark.parametrize("beside", [True, False])
def test_the_folders_can_be_copied_to_another_user(data, tmp_path, beside):
    (before := tmp_path / "one").mkdir()
    path, (_, _, _, original) = filled(data, before, "a.png", beside=beside)
    presets.add(data / "presets", "Mine", Recipe(percent=3.0))
    after, theirs = before.rename(tmp_path / "two"), Path(shutil.move(data, tmp_path / "theirs"))
    moved = after / path.name
    found = Edits(theirs / FOLDER).find(moved, read(moved)).edits
    assert found is not None
    assert next(Edits(theirs / FOLDER).steps_of(found, load(found.file)), None) == b"steps"
    assert list(presets.listed(theirs / "presets")) == ["Mine"]
    originals = Originals(theirs / "originals")
    assert [one.file.read_bytes() for one in originals.all()] == [original]
    assert originals.restore(moved)
    assert moved.read_bytes() == original
