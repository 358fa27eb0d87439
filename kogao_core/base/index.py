"""One SQLite database in the user's folder: what Kogao looks up about photos."""

from __future__ import annotations

import errno
import hashlib
import os
import sqlite3
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeVar

NAME: Final = "index.db"
"""File name of the database, in the user's data folder."""
_WAIT_S: Final = 30.0  # for another program's transaction
_DAMAGED: Final = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)
_Out = TypeVar("_Out")
Row = tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class IndexTable:
    """A table of the database, and the rows that files of the data folder can restore."""

    name: str
    columns: tuple[str, ...]  # SQL definitions; constraints come last
    indexed: tuple[str, ...] = ()  # columns with an index
    from_files: Callable[[Path], Iterable[Row]] = lambda _: ()

    def insert(self, *, replace: bool = True) -> str:
        """Return the statement that inserts a row, instead of a row with the same key."""
        count = sum(not one.startswith("PRIMARY") for one in self.columns)
        verb = "REPLACE" if replace else "IGNORE"
        return f"INSERT OR {verb} INTO {self.name} VALUES ({', '.join('?' * count)})"


@dataclass(frozen=True, slots=True)
class Index:
    """The database of a data folder. Each call of `run` is one transaction.

    A new, damaged or deleted database is filled from the files in the folder, such as the lists of
    version 1.0. Without permission to write, reading uses a copy in memory.
    """

    folder: Path

    def run(
        self, table: IndexTable, act: Callable[[sqlite3.Connection], _Out], *, writes: bool = False
    ) -> _Out:
        """Run `act` in a transaction, and return its result. Raises OSError."""
        try:
            return self._run(table, act, writes)
        except sqlite3.DatabaseError as error:
            if _code(error) not in _DAMAGED:
                raise _as_os_error(error) from error
        try:
            self._set_aside()
            return self._run(table, act, writes)
        except sqlite3.Error as error:
            raise _as_os_error(error) from error

    def rows(self, table: IndexTable, sql: str, *values: object) -> list[Row]:
        """Return the rows of a query. Raises OSError."""
        return self.run(table, lambda db: db.execute(sql, values).fetchall())

    def change(self, table: IndexTable, sql: str, *values: object) -> int:
        """Execute a statement; return the number of changed rows. Raises OSError."""
        return self.run(table, lambda db: db.execute(sql, values).rowcount, writes=True)

    def refill(self, table: IndexTable) -> None:
        """Insert the rows of files that the table lacks. Raises OSError."""
        if self.folder.is_dir():
            self.run(table, lambda db: _fill(db, table, self.folder), writes=True)

    def compact(self) -> None:
        """Leave no trace of deleted rows in the files of the database. Raises OSError."""
        if (self.folder / NAME).is_file():
            with closing(self._opened(writes=True)) as db:
                db.execute("VACUUM")
                db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        (self.folder / f"{NAME}.damaged").unlink(missing_ok=True)

    def _run(
        self, table: IndexTable, act: Callable[[sqlite3.Connection], _Out], writes: bool
    ) -> _Out:
        with closing(self._opened(writes)) as db:
            known = "SELECT 1 FROM sqlite_master WHERE name = ?"
            if not db.execute(known, (table.name,)).fetchone():
                with _transaction(db, writes=True):
                    _create(db, table, self.folder)
            with _transaction(db, writes=writes):
                return act(db)

    def _opened(self, writes: bool) -> sqlite3.Connection:
        file = self.folder / NAME
        try:
            if writes:
                self.folder.mkdir(parents=True, exist_ok=True)
            elif not self.folder.is_dir():
                return sqlite3.connect(":memory:", isolation_level=None)
            with suppress(FileExistsError):  # only its owner may read the paths
                os.close(os.open(file, os.O_CREAT | os.O_EXCL, 0o600))
            db = sqlite3.connect(file, timeout=_WAIT_S, isolation_level=None)
            try:
                db.execute("PRAGMA journal_mode = WAL")
            except sqlite3.Error:
                db.close()  # Windows sets no open file aside
                raise
            return db
        except (OSError, sqlite3.OperationalError):
            if writes:
                raise
        db = sqlite3.connect(":memory:", isolation_level=None)
        if file.is_file():
            place = f"{file.absolute().as_uri()}?immutable=1"
            with closing(sqlite3.connect(place, uri=True)) as kept:
                kept.backup(db)
        return db

    def _set_aside(self) -> None:
        file = self.folder / NAME
        file.replace(file.with_name(f"{NAME}.damaged"))
        for end in ("-wal", "-shm"):
            file.with_name(NAME + end).unlink(missing_ok=True)


@contextmanager
def _transaction(db: sqlite3.Connection, *, writes: bool) -> Iterator[None]:
    db.execute("BEGIN IMMEDIATE" if writes else "BEGIN")
    with db:  # commit, or roll back after an exception
        yield


def _create(db: sqlite3.Connection, table: IndexTable, folder: Path) -> None:
    if db.execute("SELECT 1 FROM sqlite_master WHERE name = ?", (table.name,)).fetchone():
        return  # created by another program since
    db.execute(f"CREATE TABLE {table.name} ({', '.join(table.columns)})")
    for column in table.indexed:
        db.execute(f"CREATE INDEX {table.name}_{column} ON {table.name} ({column})")
    _fill(db, table, folder)


def _fill(db: sqlite3.Connection, table: IndexTable, folder: Path) -> None:
    db.executemany(table.insert(replace=False), table.from_files(folder))


@contextmanager
def locked(folder: Path, name: str, *, wait_s: float = 0.0) -> Iterator[None]:
    """Hold a lock that other programs respect, until the end of this program at most.

    Raises BlockingIOError if another program holds the lock for longer than `wait_s`.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    with closing(sqlite3.connect(folder / name, timeout=wait_s, isolation_level=None)) as db:
        try:
            db.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError as error:
            if _code(error) == sqlite3.SQLITE_BUSY:
                raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN)) from error
            raise _as_os_error(error) from error
        yield


def path_key(path: str | os.PathLike[str]) -> bytes:
    """Return the key of a file in the tables: its real path."""
    return os.fsencode(os.path.realpath(path))


def path_hash(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file's real path."""
    return hashlib.sha256(path_key(path)).hexdigest()


def _code(error: sqlite3.Error) -> int:
    return getattr(error, "sqlite_errorcode", 0) & 0xFF


def _as_os_error(error: sqlite3.Error) -> OSError:
    code = errno.ENOSPC if _code(error) == sqlite3.SQLITE_FULL else errno.EIO
    return OSError(code, os.strerror(code) if code == errno.ENOSPC else str(error))
