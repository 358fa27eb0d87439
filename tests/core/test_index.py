"""The index survives damage, other programs, a kill at any statement and a full disk."""

import contextlib
import multiprocessing
import os
import sqlite3
import sys

import pytest
from timeouts import LONGEST_S

from kogao_core.base.index import NAME, Index, IndexTable, locked

TABLE = IndexTable("marks", ("name PRIMARY KEY", "value"), (), lambda _: [("old", 1)])


def put(folder, name, value=2):
    Index(folder).change(TABLE, TABLE.insert(), name, value)


def names(folder):
    return {name for (name,) in Index(folder).rows(TABLE, "SELECT name FROM marks")}


def test_a_new_index_has_what_files_hold_and_only_its_owner_reads_it(tmp_path):
    assert names(tmp_path / "none") == {"old"}
    assert not (tmp_path / "none").exists(), "reading makes no folder"
    put(tmp_path, "new")
    assert names(tmp_path) == {"old", "new"}
    if sys.platform != "win32":
        assert (tmp_path / NAME).stat().st_mode & 0o077 == 0


@pytest.mark.parametrize(
    "damage", [b"", b"no database" * 99, b"SQLite format 3\0" + b"\xff" * 9999]
)
def test_a_damaged_index_is_set_aside_and_filled_from_files_again(tmp_path, damage):
    put(tmp_path, "new")
    (tmp_path / NAME).write_bytes(damage)
    assert names(tmp_path) == {"old"}
    put(tmp_path, "newer")
    assert names(tmp_path) == {"old", "newer"}


def write_many(folder, start):
    for n in range(start, start + 25):
        put(folder, f"n{n}")


def test_two_programs_write_at_once(tmp_path):
    spawn = multiprocessing.get_context("spawn")
    programs = [spawn.Process(target=write_many, args=(tmp_path, 25 * n)) for n in range(2)]
    for one in programs:
        one.start()
    for one in programs:
        one.join()
    assert names(tmp_path) == {"old", *(f"n{n}" for n in range(50))}


def killed_at(folder, statement):
    def act(db):
        for n in range(6):
            if n == statement:
                os._exit(9)
            db.execute(TABLE.insert(), (f"n{n}", n))

    Index(folder).run(TABLE, act, writes=True)


@pytest.mark.parametrize("statement", [0, 1, 3, 5])
def test_a_killed_program_leaves_all_of_an_act_or_nothing(tmp_path, statement):
    put(tmp_path, "new")
    program = multiprocessing.get_context("spawn").Process(
        target=killed_at, args=(tmp_path, statement)
    )
    program.start()
    program.join()
    assert program.exitcode == 9
    assert names(tmp_path) == {"old", "new"}


def test_a_full_disk_is_called_full_and_changes_nothing(tmp_path):
    put(tmp_path, "new")

    def act(db):
        pages = db.execute("PRAGMA page_count").fetchone()[0]
        db.execute(f"PRAGMA max_page_count = {pages}")
        db.execute(TABLE.insert(), ("large", "x" * 10**6))

    with pytest.raises(OSError, match="No space left"):
        Index(tmp_path).run(TABLE, act, writes=True)
    assert names(tmp_path) == {"old", "new"}


def test_without_permission_to_write_it_is_read(tmp_path, monkeypatch):
    put(tmp_path, "new")
    connect = sqlite3.connect

    def refuse(place, *args, **named):
        if place == tmp_path / NAME:
            raise sqlite3.OperationalError("unable to open database file")
        return connect(place, *args, **named)

    monkeypatch.setattr(sqlite3, "connect", refuse)
    assert names(tmp_path) == {"old", "new"}
    with pytest.raises(OSError, match="unable to open"):
        put(tmp_path, "newer")


def hold(folder, ready, end):
    with locked(folder, "x"):
        ready.set()
        end.wait()


def test_a_lock_ends_with_its_program(tmp_path):
    spawn = multiprocessing.get_context("spawn")
    ready, end = spawn.Event(), spawn.Event()
    program = spawn.Process(target=hold, args=(tmp_path, ready, end))
    program.start()
    assert ready.wait(LONGEST_S)
    with pytest.raises(BlockingIOError), locked(tmp_path, "x"):
        pass
    with locked(tmp_path, "another"):
        program.kill()
        program.join()
    with contextlib.ExitStack() as stack:
        stack.enter_context(locked(tmp_path, "x"))
