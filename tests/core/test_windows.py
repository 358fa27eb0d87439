"""On Windows: names, read-only and open files, attributes, long paths, leftovers, clocks."""

import os
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

from kogao_core.base import atomic, installed
from kogao_core.base.atomic import NotAFile, atomic_write, check_target, temporary_folder
from kogao_core.lab.reports import spread

on_windows = pytest.mark.skipif(sys.platform != "win32", reason="files of Windows")
HOLDER = """
import sys
from pathlib import Path
from kogao_core.base.atomic import temporary_folder
with temporary_folder(Path(sys.argv[1])) as place:
    (place / "fresh").write_bytes(b"a whole photo")
    print(place.name, flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def windows(monkeypatch):
    """Windows, as far as its rules for names and renaming go."""
    monkeypatch.setattr(sys, "platform", "win32")
    replace = Path.replace

    def renamed(self, target):
        if not self.stat().st_mode & stat.S_IWRITE:
            raise PermissionError(13, "Access is denied")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", renamed)


@pytest.mark.usefixtures("windows")
@pytest.mark.parametrize(
    "name",
    ["con.jpg", "NUL", "aux.tar.png", "Com1.jpg", "x?.jpg", 'a"b.png', "x:y.jpg", "a.", "b "],
)
def test_names_that_windows_refuses_are_refused_with_a_sentence(tmp_path, name):
    with pytest.raises(NotAFile, match="Windows doesn't allow this name"):
        check_target(f"{tmp_path}{os.sep}{name}")


@pytest.mark.usefixtures("windows")
@pytest.mark.parametrize("name", ["console.jpg", "写真 é.jpg", "com.jpg", "a.con", "a b;c'.png"])
def test_other_names_are_allowed(tmp_path, name):
    check_target(tmp_path / name)


@pytest.mark.usefixtures("windows")
def test_a_read_only_file_is_refused_and_nothing_is_left(tmp_path):
    path = tmp_path / "photo.jpg"
    path.write_bytes(b"old")
    path.chmod(0o444)
    with pytest.raises(NotAFile, match="it is read-only"):
        atomic_write(b"new", path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]
    path.chmod(0o666)


@on_windows
def test_a_copy_of_a_read_only_file_can_be_replaced(tmp_path):
    path, copy = tmp_path / "photo.jpg", tmp_path / "copy.jpg"
    path.write_bytes(b"old")
    path.chmod(stat.S_IREAD)
    atomic_write(b"1", copy, like=path)
    atomic_write(b"2", copy)
    path.chmod(stat.S_IWRITE)
    assert sorted(tmp_path.iterdir()) == [copy, path]


@on_windows
def test_a_file_that_a_program_uses_is_named_as_used(tmp_path):
    path = tmp_path / "photo.jpg"
    path.write_bytes(b"old")
    with path.open("rb"), pytest.raises(NotAFile, match="another program uses it"):
        atomic_write(b"new", path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]
    atomic_write(b"new", path)
    assert path.read_bytes() == b"new"


@on_windows
def test_a_hidden_file_stays_hidden(tmp_path):
    import ctypes

    path = tmp_path / "photo.jpg"
    path.write_bytes(b"old")
    ctypes.windll.kernel32.SetFileAttributesW(str(path), stat.FILE_ATTRIBUTE_HIDDEN)
    atomic_write(b"new", path)
    assert path.stat().st_file_attributes & stat.FILE_ATTRIBUTE_HIDDEN
    assert path.read_bytes() == b"new"


@on_windows
def test_a_path_of_nearly_260_letters_can_be_written(tmp_path):
    folder = tmp_path / ("f" * (225 - len(str(tmp_path))))
    folder.mkdir()
    path = folder / ("n" * (254 - len(str(folder))) + ".jpg")
    assert len(str(path)) in range(250, 260)
    atomic_write(b"new", path)
    assert path.read_bytes() == b"new"
    assert list(folder.iterdir()) == [path]


@on_windows
def test_what_a_killed_program_left_goes_and_what_others_do_stays(tmp_path, monkeypatch):
    command = [sys.executable, "-c", HOLDER, str(tmp_path)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as program:
        place = tmp_path / program.stdout.readline().strip()
        monkeypatch.setattr(atomic, "_swept", set())
        atomic_write(b"data", tmp_path / "file")
        assert (place / "fresh").exists()
        program.kill()
    atomic._swept.clear()
    atomic_write(b"data", tmp_path / "file")
    assert list(tmp_path.iterdir()) == [tmp_path / "file"]


def test_temporary_folders_end_with_their_program(tmp_path):
    with temporary_folder(tmp_path) as place:
        assert place.is_dir()
        atomic._clear()
        assert not place.exists()
    assert not atomic._mine
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("windows")
@pytest.mark.parametrize(
    ("url", "path"), [("file:///C:/my%20kogao", "C:/my kogao"), ("file://server/a", "//server/a")]
)
def test_addresses_of_windows_folders_are_paths(monkeypatch, url, path):
    from importlib import metadata

    class Told:
        def read_text(self, _):
            return f'{{"url": "{url}", "dir_info": {{}}}}'

    monkeypatch.setattr(metadata, "distribution", lambda _: Told())
    monkeypatch.setattr(os.path, "exists", lambda _: True)
    assert installed._requirement() == [str(Path(path))]


def test_work_is_repeated_until_a_slow_clock_has_ticked(monkeypatch):
    now = [0.0]  # s
    monkeypatch.setattr(time, "process_time", lambda: int(now[0] * 64) / 64)

    def wait(seconds=0.001):
        now[0] += seconds
        return "done"

    monkeypatch.setattr(spread, "_tick_s", lambda: 1 / 64)
    for took_s in (0.0004, 0.003, 0.4):
        result, took_ms = spread.processor_ms(lambda took_s=took_s: wait(took_s))
        assert result == "done"
        assert took_ms == pytest.approx(1e3 * took_s, rel=0.09)


def test_the_processor_clock_has_a_step():
    assert 0.0 < spread._tick_s() < 0.1
