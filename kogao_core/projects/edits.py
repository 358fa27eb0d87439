"""The saved edits of photos: beside the photo or in the user's folder, with undo steps.

Edits belong to a picture (`kogao_core.photo.picture`) at a path. A photo at a new path takes over
the edits of its picture from a path where that picture is no longer.
"""

from __future__ import annotations

import lzma
import os
import threading
import time
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from sqlite3 import Connection
from typing import Final

from kogao_core.base import json_reader
from kogao_core.base.atomic import atomic_write
from kogao_core.base.index import Index, IndexTable, Row, path_hash, path_key
from kogao_core.base.installed import data_folder
from kogao_core.base.json_reader import BadFile
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.model import Photo, Stamp
from kogao_core.photo.reading import read
from kogao_core.projects.project import Project, load, save, to_bytes

SUFFIX: Final = ".kogao.json"
FOLDER: Final = "edits"
"""Name of the folder of edits, in the user's data folder."""
_RECORD: Final = ".place"  # suffix of a record of version 1.0
_MOST_RECORD_BYTES: Final = 1 << 14


TOGETHER: Final = threading.Lock()
"""Locked while edits and their undo steps are read or written together."""


@dataclass(frozen=True, slots=True)
class SavedEdits:
    """Edits on disk: the project file and the photo for which they were saved."""

    file: Path
    photo: Path
    saved_ns: int = 0
    is_recorded: bool = False  # whether this program wrote the file, and no other since


@dataclass(frozen=True, slots=True)
class Found:
    """The edits of a photo."""

    edits: SavedEdits | None = None  # the newest
    other: SavedEdits | None = None  # the version in the other place, if it differs
    foreign: Path | None = None  # edits of another picture that was at this path


def sidecar_of(photo: str | os.PathLike[str]) -> Path:
    """Return the path of a photo's project: ``portrait.jpg.kogao.json`` in the same folder."""
    path = Path(photo)
    return path.with_name(path.name + SUFFIX)


def own_place(photo: str | os.PathLike[str], folder: Path, picture: str = "") -> Path:
    """Return the path of a photo's project in the user's folder.

    `picture` names an earlier picture at the same path.
    """
    return folder / f"{path_hash(photo)[:32]}{picture and '-'}{picture[:32]}{SUFFIX}"


@dataclass(frozen=True, slots=True)
class Edits:
    """The edits in a folder of the user, and the index of edits in its parent folder."""

    folder: Path

    @staticmethod
    def of_user() -> Edits:
        return Edits(data_folder() / FOLDER)

    @property
    def _index(self) -> Index:
        return Index(self.folder.parent)

    # -- pictures ----------------------------------------------------------------------------------

    def note(self, photo: Photo) -> None:
        """Remember which picture a file holds."""
        stamp = photo.stamp
        if stamp is not None:
            row = (path_key(photo.path), stamp.size, stamp.changed_ns, photo.picture, photo.sha256)
            with suppress(OSError):
                self._index.run(
                    PICTURES, lambda db: db.execute(PICTURES.insert(), row), writes=True
                )

    def names_of(self, *hashes: str) -> frozenset[str]:
        """Return all hashes of the picture that one of these hashes names.

        Version 1.0 named a picture by the hash of the file.
        """
        known = set(filter(None, hashes))
        for one in tuple(known):
            sql = f"SELECT picture, sha256 FROM {PICTURES.name} WHERE picture = ?1 OR sha256 = ?1"
            with suppress(OSError):
                known.update(
                    str(name) for row in self._index.rows(PICTURES, sql, one) for name in row
                )
        return frozenset(known)

    def _names_at(self, path: Path, *, reads: bool) -> frozenset[str]:
        """Return the hashes of the picture at a path; empty if it is missing or not known yet.

        `reads`: whether to read a photo that is not known. Raises OSError.
        """
        stamp = Stamp.of(path.stat())
        sql = (
            f"SELECT picture, sha256 FROM {PICTURES.name} "
            "WHERE path = ? AND size = ? AND changed_ns = ?"
        )
        rows = self._index.rows(PICTURES, sql, path_key(path), stamp.size, stamp.changed_ns)
        if not rows and reads:
            with suppress(UnreadablePhoto):
                photo = read(path)
                self.note(photo)
                rows = [(photo.picture, photo.sha256)]
        return self.names_of(*(name for row in rows for name in row))

    def holds(self, path: Path, photo: Photo) -> bool:
        """Return whether the file at a path holds this picture; it is read if it has changed."""
        with suppress(OSError):
            names = self.names_of(photo.picture, photo.sha256)
            return photo.is_as_read or bool(names & self._names_at(path, reads=True))
        return False

    def name_in(self, project: Project, photo: Photo) -> str:
        """Return the hash in a project that was made from this picture, else the picture's hash."""
        made = project.original.sha256  # empty: not known, so it counts as this picture
        names = self.names_of(photo.picture, photo.sha256)
        return made if not made or made in names else photo.picture

    # -- finding -----------------------------------------------------------------------------------

    def find(self, path: Path, photo: Photo | None = None, *, reads: bool = False) -> Found:
        """Return the edits of a photo.

        Without `photo`, a photo that was never opened is known by its path, size and time. It is
        read only if that may bring edits, or if `reads` is set.
        """
        try:
            return self._find(path, photo, reads)
        except OSError:
            return Found()

    def newest(self, path: Path) -> Path | None:
        """Return the newest project file of a photo."""
        found = self.find(path).edits
        return None if found is None else found.file

    def _find(self, path: Path, photo: Photo | None, reads: bool) -> Found:
        key, beside = path_key(path), sidecar_of(path)
        names = (
            self._names_at(path, reads=reads)
            if photo is None
            else self.names_of(photo.picture, photo.sha256)
        )
        here = self._rows("path = ?", key)
        if not names and not here and not beside.is_file():
            if not self._rows("size = ?", path.stat().st_size):
                return Found()
            names = self._names_at(path, reads=True)
        files = {row.edits.file for row in here}
        for place in (beside, own_place(path, self.folder)):
            if place not in files and place.is_file():
                here.append(self._unlisted(place, path, _picture_of(place) if names else ""))
        ours = [row for row in here if not names or row.picture in names or not row.picture]
        if names:
            is_new = all(row.is_moved for row in ours)
            # Size 0: saved while the photo was missing, so for the picture wherever it is.
            condition = _among("picture", names) + ("" if is_new else " AND size = 0")
            ours += [
                row
                for row in self._rows(condition, *names)
                if row.path != key and not self._is_there(row.edits.photo, names)
            ]
            ours += self._renamed(path, names) if is_new else ()
        ours = sorted(filter(_Row.is_whole, ours), key=lambda row: row.edits.saved_ns)
        for row in reversed(ours):
            if (edits := self._restored(row, ours)) is not None:
                return Found(edits, _differing(edits, [one.edits for one in ours]))
        others = (row.edits for row in here if row not in ours and row.edits.file.is_file())
        last = max(others, key=lambda one: one.saved_ns, default=None)
        return Found(foreign=None if last is None else last.file)

    def _renamed(self, path: Path, names: frozenset[str]) -> Iterator[_Row]:
        """Yield the edits of the picture in a folder whose photo is missing under their name."""
        for file in path.parent.glob(f"*{SUFFIX}"):
            photo = file.with_name(file.name.removesuffix(SUFFIX))
            if not photo.exists() and (made := _picture_of(file)) in names:
                yield self._unlisted(file, photo, made)

    def _unlisted(self, file: Path, photo: Path, made: str) -> _Row:
        """Return the edits in a file that isn't listed here: written elsewhere, or moved since."""
        moved = self._rows("picture = ? AND stamp = ?", made, _stamp(file))
        saved_ns = max((row.edits.saved_ns for row in moved), default=file.stat().st_mtime_ns)
        return _Row(path_key(photo), made, SavedEdits(file, photo, saved_ns, bool(moved)), True)

    def _restored(self, row: _Row, others: list[_Row]) -> SavedEdits | None:
        """Return the edits of a row, in the user's folder if their file is gone or replaced."""
        if row.is_there:
            return row.edits
        data = lzma.decompress(row.project)
        for one in others:
            if one.is_there and one.edits.file.read_bytes() == data:
                return one.edits
        aside = own_place(row.edits.photo, self.folder, row.picture)
        with suppress(OSError):
            self.folder.mkdir(parents=True, exist_ok=True)
            atomic_write(data, aside, private=True)
            return replace(row.edits, file=aside)
        return None

    def _rows(self, condition: str, *values: object) -> list[_Row]:
        sql = (
            "SELECT path, picture, file, saved_ns, stamp, moved, project "
            f"FROM {TABLE.name} WHERE {condition}"
        )
        return [_Row.of(*row) for row in self._index.rows(TABLE, sql, *values)]

    def _is_there(self, path: Path, names: frozenset[str]) -> bool:
        with suppress(OSError):
            return bool(names & self._names_at(path, reads=True))
        return False

    def steps_of(self, edits: SavedEdits, project: Project) -> Iterator[bytes]:
        """Yield the serialised undo steps of a picture, the likeliest first."""
        names = self.names_of(project.original.sha256)
        sql = (
            f"SELECT steps FROM {TABLE.name} WHERE steps NOT NULL AND {_among('picture', names)} "
            "ORDER BY file != ?, path != ?, saved_ns DESC"
        )
        places = path_key(edits.file), path_key(edits.photo)
        with suppress(OSError, lzma.LZMAError):
            for (steps,) in self._index.rows(TABLE, sql, *names, *places):
                yield lzma.decompress(steps)

    # -- saving ------------------------------------------------------------------------------------

    def keep(
        self, project: Project, path: Path, steps: bytes | None = None, *, beside: bool = True
    ) -> Path:
        """Save the edits of a photo beside it, or else in the user's folder; return the file.

        `steps`: serialised undo steps. Edits of another picture in either place are moved into the
        user's folder before. Raises OSError.
        """
        with TOGETHER:
            if beside and path.is_file():  # never below the mount point of a missing drive
                with suppress(OSError):
                    return self._put(project, path, sidecar_of(path), steps)
            self.folder.mkdir(parents=True, exist_ok=True)
            return self._put(project, path, own_place(path, self.folder), steps)

    def _put(self, project: Project, path: Path, file: Path, steps: bytes | None) -> Path:
        picture = project.original.sha256
        self._make_way(path, file, picture)
        save(project, file, private=file.parent == self.folder)
        with suppress(OSError):  # the edits are saved; only undo and the record are missing
            names = self.names_of(picture)
            left = [
                row.path
                for row in self._rows(_among("picture", names), *names)
                if not (row.is_moved or row.path == path_key(path))
                and not self._is_there(row.edits.photo, names)
            ]
            packed = (None if data is None else lzma.compress(data, preset=1)
                      for data in (steps, to_bytes(project)))  # fmt: skip
            size = path.stat().st_size if path.is_file() else 0
            places = path_key(path), picture, path_key(file)
            values = *places, size, time.time_ns(), _stamp(file), 0, *packed

            def change(db: Connection) -> None:
                moved = f"UPDATE {TABLE.name} SET moved = 1 WHERE path = ?"
                db.executemany(moved, [(one,) for one in left])
                db.execute(TABLE.insert(), values)

            self._index.run(TABLE, change, writes=True)
        return file

    def _make_way(self, path: Path, file: Path, picture: str) -> None:
        """Move the edits of another picture aside. Raises OSError."""
        made = _picture_of(file) if file.is_file() else ""
        if not made or made in self.names_of(picture):
            return
        aside, changed_ns = own_place(path, self.folder, made), file.stat().st_mtime_ns
        self.folder.mkdir(parents=True, exist_ok=True)
        atomic_write(file.read_bytes(), aside, private=True)
        row = path_key(path), made, path_key(aside), 0, changed_ns, _stamp(aside), 0, None, None
        names = self.names_of(made)
        copied = (
            f"INSERT OR REPLACE INTO {TABLE.name} "
            f"SELECT path, picture, ?, size, saved_ns, ?, moved, steps, project FROM {TABLE.name} "
            f"WHERE path = ? AND file = ? AND {_among('picture', names)}"
        )
        values = path_key(aside), _stamp(aside), path_key(path), path_key(file), *names
        if not self._index.change(TABLE, copied, *values):
            self._index.change(TABLE, TABLE.insert(), *row)

    def forget(self, path: Path) -> list[Path]:
        """Delete the edits of a path in the user's folder; return the deleted files."""
        own = own_place(path, self.folder)
        start = own.name.removesuffix(SUFFIX)  # also of undo steps of version 1.0
        files = [file for file in self.folder.glob(f"{start}*") if file.is_file()]
        for file in files:
            file.unlink()
        for table in (TABLE, PICTURES):
            sql = f"DELETE FROM {table.name} WHERE path = ?"
            self._index.change(table, sql, path_key(path))
        return files


@dataclass(frozen=True, slots=True)
class _Row:
    """A row of the index of edits."""

    path: bytes
    picture: str
    edits: SavedEdits
    is_there: bool  # whether the file holds edits of the picture
    is_moved: bool = True  # whether the photo has moved to another path with these edits
    project: bytes = b""  # content of the file when it was saved, compressed

    @staticmethod
    def of(
        path: bytes, picture: str, file: bytes, saved_ns: int, stamp: str, moved: int,
        project: bytes | None,
    ) -> _Row:  # fmt: skip
        place, is_recorded, is_there = Path(os.fsdecode(file)), False, False
        with suppress(OSError):
            is_recorded = is_there = stamp == _stamp(place)
            if not is_recorded and _picture_of(place) in ("", picture):  # written elsewhere since
                saved_ns, is_there = place.stat().st_mtime_ns, True
        edits = SavedEdits(place, Path(os.fsdecode(path)), saved_ns, is_recorded)
        return _Row(path, picture, edits, is_there, bool(moved), project or b"")

    def is_whole(self) -> bool:
        """Return whether the edits are in their file or in the index."""
        return self.is_there or bool(self.project)


def _stamp(file: Path) -> str:
    state = file.stat()
    return f"{state.st_size}-{state.st_mtime_ns}"


def _among(column: str, values: Collection[str]) -> str:
    return f"{column} IN ({', '.join('?' * len(values))})"


def _picture_of(file: Path) -> str:
    """Return the picture for which a project was saved; "" for an unknown picture."""
    with suppress(BadFile):
        return load(file).original.sha256
    return ""


def _differing(newest: SavedEdits, others: list[SavedEdits]) -> SavedEdits | None:
    """Return the newest of the other edits of a path, unless this program has replaced them."""
    with suppress(OSError):
        for one in reversed(others):
            if one.file == newest.file or not one.file.is_file():
                continue
            if newest.is_recorded and one.is_recorded:
                continue
            if one.photo == newest.photo and one.file.read_bytes() != newest.file.read_bytes():
                return one
    return None


def _placed(data: Path) -> Iterator[Row]:
    """Yield the edits that records of version 1.0 name, with their undo steps."""
    folder = data / FOLDER
    for file in folder.glob(f"*{_RECORD}"):
        with suppress(BadFile, OSError, ValueError):
            top = json_reader.parse(json_reader.read(file, _MOST_RECORD_BYTES), _MOST_RECORD_BYTES)
            place, photo = (Path(top.field(name).text(4096)) for name in ("file", "photo"))
            picture, saved_ns = load(place).original.sha256, place.stat().st_mtime_ns
            steps = own_place(photo, folder).with_suffix(".steps")
            kept = lzma.compress(steps.read_bytes()) if steps.is_file() else None
            size = int(file.name.split("-")[0])
            values = path_key(photo), picture, path_key(place), size, saved_ns, _stamp(place)
            yield *values, 0, kept, None


PICTURES: Final = IndexTable(
    "pictures",
    ("path", "size", "changed_ns", "picture", "sha256", "PRIMARY KEY (path, size, changed_ns)"),
    ("picture", "sha256"),
)
TABLE: Final = IndexTable(
    "edits",
    (
        *("path", "picture", "file", "size", "saved_ns", "stamp", "moved", "steps"),
        "project",
        "PRIMARY KEY (path, picture, file)",
    ),
    ("picture", "size"),
    _placed,
)
