"""The store of originals: which original belongs to which file, room, damage, privacy."""

from __future__ import annotations

import random
import shutil
import stat
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from originals_oracle import Trial, write_in_place

from kogao_core.photo.originals import ChangedSince, NoOriginal, Originals, StoreFull
from kogao_core.projects.forgetting import forget
from kogao_core.projects.results import Results


@pytest.fixture
def place(tmp_path):
    return Originals(tmp_path / "data" / "originals")


def twins(place, folder, count=3):
    """Write photos in place whose results are equal."""
    paths = [folder / f"{n}.jpg" for n in range(count)]
    for n, path in enumerate(paths):
        path.write_bytes(b"picture" + b"video" * n)
        write_in_place(place, path, b"result")
    return paths


@pytest.mark.parametrize("seed", range(4))
def test_no_sequence_of_operations_restores_the_bytes_of_another_photo(tmp_path, seed):
    assert Trial(tmp_path, random.Random(seed)).run(60) == []


def test_moved_photos_with_equal_results_get_their_own_originals(place, tmp_path):
    (folder := tmp_path / "x").mkdir()
    for n, path in enumerate(twins(place, tmp_path)):
        moved = path.rename(folder / path.name)
        assert place.restore(moved)
        assert moved.read_bytes() == b"picture" + b"video" * n


def test_a_copy_of_equal_results_is_refused_and_its_originals_are_listed(place, tmp_path):
    copy = shutil.copy(twins(place, tmp_path)[1], tmp_path / "copy.jpg")
    copy = Path(copy)
    with pytest.raises(NoOriginal, match=r"3 stored originals may be that of .*--original N"):
        place.restore(copy)
    assert copy.read_bytes() == b"result"
    listed = [one.file.read_bytes() for one in place.of(copy)]
    assert place.restore(copy, 2)
    assert copy.read_bytes() == listed[1]
    assert len(place.of(copy)) == 3, "a restore leaves the originals reachable"
    with pytest.raises(NoOriginal, match="no original 4"):
        place.restore(copy, 4)


def test_an_evicted_original_is_not_replaced_by_that_of_an_equal_result(place, tmp_path):
    first, *_ = twins(place, tmp_path)
    place.of(first)[-1].file.unlink()
    with pytest.raises(NoOriginal, match="was deleted to make room"):
        place.restore(first)


def test_a_full_store_deletes_no_only_original_unless_allowed(tmp_path):
    place = Originals(tmp_path / "store", limit_bytes=150)
    paths = [tmp_path / f"{n}.jpg" for n in range(4)]
    for n, path in enumerate(paths):
        path.write_bytes(bytes([n]) * 70)
    write_in_place(place, paths[0], b"result 0")
    write_in_place(place, paths[1], b"result 1")
    with pytest.raises(StoreFull):
        write_in_place(place, paths[2], b"result 2")
    assert paths[2].read_bytes() == b"\2" * 70
    assert place.restore(paths[0])
    assert write_in_place(place, paths[2], b"result 2") == 0, "0.jpg is its own original again"
    evicting = Originals(place.folder, 150, evicts=True)
    assert write_in_place(evicting, paths[3], b"result 3") == 1
    with pytest.raises(NoOriginal, match="was deleted to make room"):
        place.restore(paths[1])
    for n in (2, 3):
        assert place.restore(paths[n])
        assert paths[n].read_bytes() == bytes([n]) * 70


def test_a_killed_program_leaves_the_original_known(place, tmp_path):
    path = tmp_path / "photo.jpg"
    path.write_bytes(b"original")
    place.keep(path, [b"killed before the first result was written"])
    assert not place.restore(path)
    write_in_place(place, path, b"result")
    place.keep(path, [b"killed before the second result was written"])
    assert path.read_bytes() == b"result"
    assert place.restore(path)
    assert path.read_bytes() == b"original"
    assert len(place.all()) == 1


def test_changes_of_other_programs_are_replaced_by_force_only(place, tmp_path):
    path = tmp_path / "photo.jpg"
    path.write_bytes(b"original")
    write_in_place(place, path, b"result")
    path.write_bytes(b"theirs")
    with pytest.raises(ChangedSince):
        place.restore(path)
    assert place.restore(path, force=True)
    assert path.read_bytes() == b"original"


def test_a_damaged_record_leaves_the_original_listed(place, tmp_path):
    path = twins(place, tmp_path, 1)[0]
    (record,) = place.folder.glob("*.json")
    for damage in (b"", b"[]", b'{"path": 3}', record.read_bytes().replace(b'"', b"'")):
        record.write_bytes(damage)
        (place.folder.parent / "index.db").unlink()
        assert [one.file.read_bytes() for one in place.all()] == [b"picture"]
        with pytest.raises(NoOriginal):
            place.restore(path)
    assert place.forget(place.all()[0].file) == 1
    assert place.all() == []


def test_everything_about_a_photo_is_forgotten_and_nothing_else(place, tmp_path):
    first, second, _ = twins(place, tmp_path)
    data = place.folder.parent
    results = Results(data)
    for path in (first, second):
        (out := tmp_path / f"out-{path.name}").write_bytes(path.name.encode())
        results.add(path, out)
    twin = second.rename(tmp_path / "moved.jpg")
    copy = Path(shutil.copy(first, tmp_path / "copy.jpg"))
    (gone,) = forget([first], data)
    assert forget([copy], data)[0].originals == 0, "a copy with an equal result is another photo"
    twin.rename(second)
    assert (gone.originals, gone.results) == (1, 1)
    with suppress(NoOriginal):
        place.restore(first)
    assert first.read_bytes() == b"result"
    assert place.restore(second)
    assert results.origin(tmp_path / "out-1.jpg")
    assert results.origin(tmp_path / "out-0.jpg") is None
    assert str(first).encode() not in (data / "index.db").read_bytes()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such permissions")
def test_records_and_lists_are_readable_by_their_owner_alone(place, tmp_path):
    path = twins(place, tmp_path, 1)[0]
    results = Results(place.folder.parent)
    results.add(path, tmp_path)
    results.add(tmp_path / "x.jpg", path)
    (out := tmp_path / "out.jpg").write_bytes(b"out")
    results.add(path, out)
    for file in (*place.folder.glob("*.json"), results.folder / "index.db"):
        assert stat.S_IMODE(file.stat().st_mode) == 0o600, file
    assert stat.S_IMODE(place.folder.stat().st_mode) == 0o700
