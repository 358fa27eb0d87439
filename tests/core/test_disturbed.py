"""Batches and in-place changes while files, folders and other programs interfere."""

import multiprocessing
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scenes import textured_photo

from kogao_core import batch
from kogao_core.base import atomic
from kogao_core.batch import tasks
from kogao_core.photo import CannotWrite, read, write, write_in_place, writing
from kogao_core.photo.export import Export
from kogao_core.photo.originals import NoOriginal, Originals
from kogao_core.projects import project
from kogao_core.projects.results import Results
from kogao_core.retouch import RetouchJob


@pytest.fixture
def photo(tmp_path):
    (folder := tmp_path / "in").mkdir()
    Image.fromarray(textured_photo(120, 90)).save(folder / "a.jpg", quality=90)
    return folder / "a.jpg"


def outcome(path, output):
    output.parent.mkdir(exist_ok=True)
    shutil.copy(path, output)
    return batch.Outcome(str(path), str(output), "done", key="k")


def recorded(outcomes, report, tmp_path):
    batch.record(outcomes, report, Results(tmp_path / "data"), lambda _: None)


@pytest.mark.parametrize("what", ["folder", "result"])
def test_a_batch_whose_results_vanish_reports_no_success(photo, tmp_path, what):
    out = tmp_path / "out"

    def outcomes():
        yield outcome(photo, out / "1.jpg")
        shutil.rmtree(out) if what == "folder" else (out / "1.jpg").unlink()
        yield outcome(photo, out / "2.jpg")

    with pytest.raises(FileNotFoundError):
        recorded(outcomes(), out / batch.REPORT, tmp_path)


def test_a_second_batch_into_one_folder_is_told(photo, tmp_path):
    out = tmp_path / "out"

    def outcomes():
        yield outcome(photo, out / "1.jpg")
        with pytest.raises(FileExistsError, match="another export"):
            recorded([], out / batch.REPORT, tmp_path)

    recorded(outcomes(), out / batch.REPORT, tmp_path)
    recorded([], out / batch.REPORT, tmp_path)


def test_a_user_folder_that_cannot_be_written_stops_no_batch(photo, tmp_path):
    (tmp_path / "data").write_bytes(b"no folder, as if read-only")
    out = tmp_path / "out"
    recorded(iter([outcome(photo, out / "1.jpg")]), out / batch.REPORT, tmp_path)
    assert "1.jpg" in (out / batch.REPORT).read_text()


def test_a_photo_replaced_while_it_is_in_work_is_not_done(photo, tmp_path, monkeypatch):
    def late(*_):
        Image.fromarray(textured_photo(120, 90, seed=3)).save(photo)
        return (), "", False

    monkeypatch.setattr(tasks, "_render", late)
    task = batch.Task(str(photo), str(tmp_path / "out.jpg"), RetouchJob())
    assert batch.work(task).status == "failed"
    monkeypatch.setattr(tasks, "_render", lambda *_: ((), "", False))
    assert batch.work(task).status == "done"


def names(folder, out, *named, ending=""):
    folder.mkdir()
    for name in named:
        (folder / name).touch()
    job = RetouchJob(export=Export(ending=ending))
    return {Path(one.source).name: Path(one.output).name for one in batch.plan([folder], out, job)}


def test_names_that_are_one_on_a_drive_without_case_get_a_second_name(tmp_path):
    found = names(tmp_path / "in", tmp_path / "out", "IMG.JPG", "img.jpg", "other.jpg")
    assert found["other.jpg"] == "other.jpg"
    assert len({name.casefold() for name in found.values()}) == 3


def test_a_phones_pair_becomes_two_files(tmp_path):
    found = names(tmp_path / "in", tmp_path / "out", "I.heic", "I.jpg", "b.png", ending=".jpg")
    assert found == {"I.heic": "I.heic.jpg", "I.jpg": "I.jpg", "b.png": "b.jpg"}


def test_a_project_of_another_picture_fails_its_photo(photo, tmp_path):
    made = project.Original("a.jpg", "0" * 64, 120, 90)
    file = tmp_path / "p.kogao.json"
    project.save(project.Project(made, "automatic", project.Sheet()), file)
    task = batch.Task(str(photo), str(tmp_path / "o.jpg"), RetouchJob(), project=str(file),
                      edits=str(tmp_path / "edits"))  # fmt: skip
    done = batch.work(task)
    assert done.status == "failed"
    assert "another picture" in done.reason


def test_edits_of_an_older_version_say_so(monkeypatch, photo, tmp_path):
    made = project.Project(
        project.Original("a.jpg", read(photo).picture, 120, 90), "automatic", project.Sheet(),
        program="0.9.1",
    )  # fmt: skip
    file = tmp_path / "p.kogao.json"
    monkeypatch.setattr(project, "__version__", "0.9.1")
    project.save(made, file)
    monkeypatch.undo()
    assert project.load(file).looks_different
    task = batch.Task(str(photo), str(tmp_path / "o.jpg"), RetouchJob(), project=str(file))
    assert batch.planning.outdated([task]) == 1
    assert not project.Project(made.original, "automatic", project.Sheet()).looks_different


# -- in place --------------------------------------------------------------------------------------


def changed(photo, value):
    pixels = photo.pixels.copy()
    pixels[:16, :16] = value
    return pixels


def write_at_once(path, data, value, start, said):
    photo = read(path)
    start.wait()
    try:
        write_in_place(photo, changed(photo, value), Originals(data / "originals"))
        said.put(value)
    except CannotWrite:
        said.put(0)


def pairs(photo, tmp_path, count):
    """Change a photo by two programs at once; return the pairs with wrong bytes, and lost edits."""
    spawn, wrong, lost = multiprocessing.get_context("fork"), 0, 0
    for _ in range(count):
        before, data = photo.read_bytes(), tmp_path / "data"
        start, said = spawn.Barrier(2), spawn.Queue()
        both = [
            spawn.Process(target=write_at_once, args=(photo, data, value, start, said))
            for value in (50, 200)
        ]
        for one in both:
            one.start()
        told = sorted(said.get() for _ in both)
        for one in both:
            one.join()
        lost += told[0] != 0
        Originals(data / "originals").restore(photo)
        wrong += photo.read_bytes() != before
        shutil.rmtree(data)
    return wrong, lost


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_the_second_of_two_programs_that_change_a_photo_is_refused(photo, tmp_path):
    assert pairs(photo, tmp_path, 4) == (0, 0)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_two_hundred_pairs_of_programs(photo, tmp_path):
    assert pairs(photo, tmp_path, 200) == (0, 0)


def test_a_damaged_stored_original_is_noticed_before_the_photo_is_overwritten(photo, tmp_path):
    store, before = Originals(tmp_path / "data" / "originals"), photo.read_bytes()

    def write(value):
        opened = read(photo)
        write_in_place(opened, changed(opened, value), store)

    write(50)
    store.restore(photo)
    (kept,) = (one.file for one in store.all())
    kept.write_bytes(b"damaged")
    write(60)
    assert store.restore(photo)
    assert photo.read_bytes() == before, "the copy was written again"
    write(70)
    kept.write_bytes(b"damaged")
    result = photo.read_bytes()
    with pytest.raises(CannotWrite, match="stored original is damaged"):
        write(80)
    assert photo.read_bytes() == result
    with pytest.raises(NoOriginal, match="damaged"):
        store.restore(photo)


# -- drives ----------------------------------------------------------------------------------------


def test_a_drive_without_permissions_gets_its_file_replaced(photo, monkeypatch):
    def refuse(*_):
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(atomic.shutil, "copymode", refuse)
    atomic.atomic_write(b"new", photo)
    assert photo.read_bytes() == b"new"


def test_a_gone_photo_is_called_gone_and_a_changed_one_changed(photo, tmp_path):
    opened = read(photo)
    os.utime(photo, (1, 1))
    assert "has changed since" in write(opened, changed(opened, 9), tmp_path / "1.jpg")
    photo.unlink()
    assert "a.jpg is gone" in write(opened, changed(opened, 9), tmp_path / "2.jpg")


@pytest.mark.parametrize(("number", "says"), [(28, "make room"), (5, "another folder or drive")])
def test_a_full_drive_and_a_failing_one_are_told_apart(photo, tmp_path, monkeypatch, number, says):
    def fail(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(writing, "atomic_write", fail)
    opened = read(photo)
    with pytest.raises(CannotWrite, match=says) as refused:
        write(opened, changed(opened, 9), tmp_path / "1.jpg")
    assert os.strerror(number) in str(refused.value)
    assert np.array_equal(read(photo).pixels, opened.pixels)
