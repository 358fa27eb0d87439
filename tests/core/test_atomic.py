"""Files are put in place whole, only where files belong, and as what they replace."""

import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from kogao_core.base import atomic
from kogao_core.base.atomic import NotAFile, atomic_write, temporary_folder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="POSIX files")
HOLDER = """
import sys, time
from pathlib import Path
from kogao_core.base.atomic import temporary_folder
with temporary_folder(Path(sys.argv[1])) as place:
    (place / "fresh").write_bytes(b"a whole photo")
    print(place, flush=True)
    time.sleep(60)
"""


def not_files(folder, device):
    """Make what files must not replace, and links to it."""
    os.mkfifo(folder / "pipe")
    (folder / "folder").mkdir()
    (folder / "a").symlink_to(folder / "b")
    (folder / "b").symlink_to(folder / "a")
    (folder / "to a pipe").symlink_to("pipe")
    (folder / "to a device").symlink_to(device)
    yield from ("pipe", "folder", "a", "to a pipe", "to a device")


def test_only_files_are_replaced(tmp_path, device):
    names = list(not_files(tmp_path, device))
    before = {path: path.lstat() for path in tmp_path.iterdir()}
    for name in names:
        with pytest.raises(NotAFile, match="it is a"):
            atomic_write(b"data", tmp_path / name)
    assert {path: path.lstat() for path in tmp_path.iterdir()} == before


def test_what_comes_in_the_way_at_the_last_moment_stays(tmp_path):
    with pytest.raises(NotAFile, match="pipe or device"):
        atomic_write(b"data", tmp_path / "file", lambda: os.mkfifo(tmp_path / "file"))
    assert [path.is_fifo() for path in tmp_path.iterdir()] == [True]


def test_a_link_to_nothing_leads_to_the_new_file(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "file")
    atomic_write(b"data", tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_bytes() == b"data"


def test_a_file_keeps_its_owner_attributes_and_permissions(tmp_path):
    path, copy = tmp_path / "file", tmp_path / "copy"
    path.write_bytes(b"old")
    path.chmod(0o640)
    groups = {*os.getgroups(), os.getgid()} - {path.stat().st_gid}
    owner = 1234 if os.geteuid() == 0 else -1
    os.chown(path, owner, 1235 if owner > 0 else min(groups, default=-1))
    try:
        os.setxattr(path, "user.xdg.tags", b"family")
        attributes = {"user.xdg.tags": b"family"}
    except (AttributeError, OSError):  # no such thing here
        attributes = {}
    before = path.stat()
    atomic_write(b"new", path)
    atomic_write(b"new", copy, like=path)
    for one in (path, copy):
        after = one.stat()
        assert (after.st_mode, after.st_uid, after.st_gid) == (
            *(before.st_mode, before.st_uid),
            before.st_gid,
        )
        assert {name: os.getxattr(one, name) for name in attributes} == attributes
    assert path.stat().st_ino != before.st_ino


def test_the_folder_is_flushed_after_the_file_is_in_place(tmp_path, monkeypatch):
    flushed = []

    def seen(opened, fsync=os.fsync):
        flushed.append((stat.S_ISDIR(os.fstat(opened).st_mode), (tmp_path / "file").exists()))
        fsync(opened)

    monkeypatch.setattr(os, "fsync", seen)
    atomic_write(b"data", tmp_path / "file")
    assert flushed == [(False, False), (True, True)]


@pytest.fixture
def holder(tmp_path):
    """A program that is at work on a file in the folder."""
    command = [sys.executable, "-c", HOLDER, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        yield program, Path(program.stdout.readline().strip())
        program.kill()


def test_what_a_killed_program_left_goes_and_what_others_do_stays(tmp_path, holder, monkeypatch):
    program, place = holder
    mine = tmp_path / ".kogao-mine.partial"  # a file, whoever it is from
    mine.write_bytes(b"")
    monkeypatch.setattr(atomic, "_swept", set())
    atomic_write(b"data", tmp_path / "file")
    assert (place / "fresh").exists()
    program.send_signal(signal.SIGKILL)
    program.wait()
    atomic_write(b"data", tmp_path / "file")
    assert place.exists(), "looked at once a process"
    atomic._swept.clear()
    atomic_write(b"data", tmp_path / "file")
    assert sorted(tmp_path.iterdir()) == [mine, tmp_path / "file"]


def test_a_sweep_that_comes_in_between_costs_another_try(tmp_path, monkeypatch):
    tries = []

    def swept(place, locked=atomic._locked):
        tries.append(place)
        if len(tries) == 1:
            place.rmdir()
        if len(tries) == 2:
            raise BlockingIOError
        return locked(place)

    monkeypatch.setattr(atomic, "_locked", swept)
    with temporary_folder(tmp_path) as place:
        assert place == tries[2]
        assert place.is_dir()
