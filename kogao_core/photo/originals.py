"""Store of original photos, copied before Kogao overwrites a photo in place."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final
from urllib.parse import quote_from_bytes, unquote_to_bytes

from kogao_core.base.atomic import Chunks, atomic_write, temporary_folder
from kogao_core.base.index import Index, IndexTable, Row, locked
from kogao_core.base.installed import data_folder
from kogao_core.base.json_reader import BadFile, parse
from kogao_core.base.language import Text, TextError
from kogao_core.photo.picture import sha256_of

LIMIT_BYTES: Final = 10**10
"""Default size limit of the store."""
_RECORD: Final = ".json"
# Fields of a record, in the order of `StoredOriginal`.
_FIELDS: Final = ("path", "file", "version", "original", "results")
FOLDER: Final = "originals"
"""Name of the store's folder, in the user's data folder."""
_WAIT_S: Final = 60.0  # for another program that changes a photo in place
_HEX: Final = 64
_MAX_RESULTS: Final = 200
_MAX_RECORD_BYTES: Final = 1 << 16


class NoOriginal(TextError):
    """No stored original can be restored; the message says what to do."""


class ChangedSince(NoOriginal):
    """Another program changed the file; a restore would lose those changes."""


class StoreFull(Exception):
    """The store is full; more room requires deleting the only original of a photo."""


@dataclass(frozen=True, slots=True)
class StoredOriginal:
    """An original in the store: a copy of the photo and its record, which is empty if damaged."""

    file: Path  # the copy; the record lies next to the copy, as JSON
    path: str = ""  # of the photo, absolute and percent-encoded: a path may contain any bytes
    identity: str = ""  # device, inode and modification time of the last result (`_identity`)
    version: str = ""  # version of the photo used for the last result; any text
    original: str = ""  # SHA-256 of the original
    results: tuple[str, ...] = ()  # SHA-256 of each result written over the photo, newest last

    @property
    def photo(self) -> Path | None:
        """Path of the photo that was overwritten; None if the record lacks it."""
        path = Path(os.fsdecode(unquote_to_bytes(self.path)))
        return path if path.is_absolute() else None

    def is_redundant(self) -> bool:
        """Return whether the photo is identical to the original again."""
        with suppress(OSError):
            return (
                self.photo is not None
                and self.photo.stat().st_size == self.file.stat().st_size
                and _hash_of(self.photo) == self.original
            )
        return False


@dataclass(frozen=True, slots=True)
class Originals:
    """Originals in a folder, each a file ``TIME-HASH.jpg`` with a record ``TIME-HASH.jpg.json``.

    The index of the parent folder has the records, too, and is filled from them when it is new.

    An original belongs to one photo, identified by path and by the file (device, inode,
    modification time) written by Kogao. The hash of a result doesn't identify the original: two
    photos can have equal results. The record of an evicted original stays in the store.
    """

    folder: Path  # created with the first original; accessible only to this user
    limit_bytes: int = LIMIT_BYTES
    evicts: bool = False  # remove the oldest originals when full, instead of raising StoreFull

    @staticmethod
    def of_user(*, evicts: bool = False) -> Originals:
        return Originals(data_folder() / FOLDER, evicts=evicts)

    @contextmanager
    def temporary(self) -> Iterator[Originals]:
        """Yield a store in a subfolder that is deleted on exit."""
        self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with temporary_folder(self.folder) as folder:
            yield Originals(folder / self.folder.name)

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keep other programs from changing photos in place meanwhile. Raises OSError."""
        with locked(self.folder.parent / "locks", self.folder.name, wait_s=_WAIT_S):
            yield

    def keep(self, path: Path, result: Chunks, version: str = "") -> int:
        """Store the file at `path` before `result` overwrites it; return how many were evicted.

        The original of a photo that Kogao overwrote before stays the original. Raises OSError,
        StoreFull.
        """
        place = _real(path)
        present, new = _hash_of(place), _sha256(result)
        own = (one for one in self._of_path(place) if one.original == present)
        known = self.find(path) or next((one for one in own if one.file.is_file()), None)
        if known and known.photo == place:
            if _hash_of(known.file) != known.original:
                if present != known.original:
                    raise OSError(errno.EIO, Text("the stored original is damaged"))
                atomic_write(place.read_bytes(), known.file, like=place)
            results = (*known.results, new)[-_MAX_RESULTS:]
            self._record(replace(known, version=version, results=results))
            return 0
        source = place if known is None else known.file
        data = source.read_bytes()
        evicted = self._make_room(len(data), source)
        self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        seconds, rest = divmod(time.time_ns(), 10**9)
        moment, digest = time.strftime("%Y%m%dT%H%M%S", time.gmtime(seconds)), _sha256([data])
        file = self.folder / f"{moment}.{rest:09}-{digest[:16]}{place.suffix}"
        atomic_write(data, file, like=source)
        shutil.copystat(source, file)
        results = (new,) if known is None else (present, new)
        encoded = quote_from_bytes(os.fsencode(place))
        self._record(StoredOriginal(file, encoded, _identity(place), version, digest, results))
        return evicted

    def note_written(self, path: Path) -> None:
        """Record the identity of the result at `path`."""
        place = _real(path)
        present = _hash_of(place)
        for one in self._of_path(place):
            if one.results[-1:] == (present,):
                self._record(replace(one, identity=_identity(place)))
                return

    def find(self, path: Path) -> StoredOriginal | None:
        """Return the original of the result at `path`. None: no original or several match."""
        place = _real(path)
        fits = sorted(self._certain(place, _hash_of(place)), key=lambda one: one.photo != place)
        return next((one for one in fits if one.file.is_file()), None)

    def all(self) -> list[StoredOriginal]:
        """Return all originals, the newest first, and the records of evicted originals."""
        return self._where("1")

    def _where(self, condition: str, *values: object) -> list[StoredOriginal]:
        sql = f"SELECT * FROM {TABLE.name} WHERE {condition} ORDER BY file DESC"
        rows = self._index.rows(TABLE, sql, *values)
        return [
            StoredOriginal(self.folder / file, *texts)
            for file, *texts in ((*row[:-1], tuple(row[-1].split())) for row in rows)
        ]

    @property
    def _index(self) -> Index:
        return Index(self.folder.parent)

    def _of_path(self, place: Path) -> list[StoredOriginal]:
        return self._where("path = ?", quote_from_bytes(os.fsencode(place)))

    def _of_result(self, digest: str) -> list[StoredOriginal]:
        return self._where("instr(results, ?)", digest) if digest else []

    def _of_file(self, place: Path) -> list[StoredOriginal]:
        return self._where("identity = ?", identity) if (identity := _identity(place)) else []

    def _record(self, one: StoredOriginal) -> None:
        _write_record(one)
        self._index.change(TABLE, TABLE.insert(), *_row(one))

    def of(self, path: Path) -> list[StoredOriginal]:
        """Return all possible originals of a file, the newest first.

        Match by path, by file identity or by the hash of a result.
        """
        place = _real(path)
        present = _hash_of(place)
        own = self._of_path(place) + self._of_file(place) + self._of_result(present)
        own += self._where("original = ?", present)
        shared = {result for one in own for result in one.results}
        found = {one.file: one for result in shared for one in self._of_result(result)}
        return [found[file] for file in sorted(found, reverse=True) if file.is_file()]

    def restore(self, path: Path, number: int | None = None, *, force: bool = False) -> bool:
        """Restore the original of a file, byte for byte. Return False if already restored.

        `number` selects an original from the list `of(path)`, from 1. Raises NoOriginal,
        ChangedSince.
        """
        place = _real(path)
        present = _hash_of(place)
        listed = self.of(path)
        if not listed:  # a record that an interrupted program or version 1.0 has left
            self._index.refill(TABLE)
            listed = self.of(path)
        if number is not None and number > len(listed):
            raise NoOriginal(
                "there is no original {number} of {path}; kogao-cli originals lists {count}",
                number=number,
                path=path,
                count=len(listed),
            )
        chosen = listed[number - 1] if number else self._only(path, present, listed)
        if present == chosen.original:
            return False
        # With a number, restore may overwrite any file that the store knows.
        known = {one for each in listed for one in (each.original, *each.results)}
        if present and not force and present not in (known if number else chosen.results):
            raise ChangedSince(
                "{path} has changed since Kogao wrote it; use force to lose the changes", path=path
            )
        data = chosen.file.read_bytes()
        if _sha256([data]) != chosen.original:
            raise NoOriginal(
                "the original of {path} is damaged ({kept}); take it from a backup",
                path=path,
                kept=chosen.file,
            )
        atomic_write(data, place, like=None if place.exists() else chosen.file)
        shutil.copystat(chosen.file, place)
        return True

    def forget(self, path: Path) -> int:
        """Delete all originals of a path or of the file at that path. Return the count.

        `path` may also be a file in the store. The records of evicted originals are deleted too.
        """
        place = _real(path)
        stored = self._where("file = ?", place.name) if place.parent == _real(self.folder) else []
        own = {one.file: one for one in self._of_path(place) + self._of_file(place) + stored}
        count = sum(file.is_file() for file in own)
        for file in own:
            file.unlink(missing_ok=True)
            _record_of(file).unlink(missing_ok=True)
            self._index.change(TABLE, f"DELETE FROM {TABLE.name} WHERE file = ?", file.name)
        return count

    def _only(self, path: Path, present: str, listed: list[StoredOriginal]) -> StoredOriginal:
        """Return the only original of a file. Raises NoOriginal."""
        place = _real(path)
        own = self._of_path(place)
        found = self._certain(place, present) or [one for one in own if one.original == present]
        if not found and not self._of_result(present):
            found = own if len({one.original for one in own}) == 1 else []
        stored = [one for one in found if one.file.is_file() or one.original == present]
        if stored:
            return stored[0]
        if listed and not found:
            raise NoOriginal(
                "{count} stored originals may be that of {path}; kogao-cli originals lists "
                "them, and restore --original N brings one back",
                count=len(listed),
                path=path,
            )
        if found or own:
            raise NoOriginal(
                "the original of {path} was deleted to make room; take it from a backup", path=path
            )
        raise NoOriginal(
            "no original of {path} is kept in {folder}; kogao-cli originals lists all",
            path=path,
            folder=self.folder,
        )

    def _certain(self, place: Path, present: str) -> list[StoredOriginal]:
        """Return the unambiguous originals of the result at `place`, all with the same hash.

        `present` is the hash of the file there. If two photos have equal results, device, inode and
        modification time decide. A copy of a result counts as the result only if the result is no
        longer at the recorded path.
        """
        identity = _identity(place)
        fits = self._of_result(present)
        same = {one.original for one in fits if one.identity == identity}
        here = {one.original for one in fits if one.photo == place}
        moved = {one.original for one in fits if _identity(one.photo) != one.identity}
        if len({one.original for one in fits}) == 1:
            certain = here | same | moved
        else:
            certain = same if here <= same else set()
        return [one for one in fits if {one.original} == certain]

    def _bytes(self) -> int:
        """Return the size of all originals, by one look into the folder."""
        with suppress(OSError), os.scandir(self.folder) as files:
            return sum(one.stat().st_size for one in files if not one.name.endswith(_RECORD))
        return 0

    def _make_room(self, count: int, needed: Path) -> int:
        """Make room for `count` bytes. Return the number of evicted originals. Raises StoreFull.

        Delete redundant originals first. Never delete the file `needed` or a record.
        """
        over, evicted = self._bytes() + count - self.limit_bytes, 0
        if over <= 0:
            return 0
        stored = [one for one in reversed(self.all()) if one.file.is_file()]  # the oldest first
        redundant = [one for one in stored if over > 0 and one.is_redundant()]
        for one in (*redundant, *stored):
            if over > 0 and one.file.is_file() and one.file != needed:
                if one not in redundant and not self.evicts:
                    raise StoreFull
                over -= _size(one)
                evicted += one not in redundant
                one.file.unlink(missing_ok=True)
        return evicted


def _size(original: StoredOriginal) -> int:
    with suppress(OSError):  # another program removed it
        return original.file.stat().st_size
    return 0


def _record_of(original: Path) -> Path:
    return original.with_name(original.name + _RECORD)


def _real(path: Path) -> Path:
    return Path(os.path.realpath(path))


def _identity(place: Path | None) -> str:
    """Return device, inode and modification time of a file; "" if there is none.

    The modification time distinguishes a file from a later file with the same inode.
    """
    with suppress(OSError):
        if place is not None:
            state = place.stat()
            return f"{state.st_dev}-{state.st_ino}-{state.st_mtime_ns}"
    return ""


def _write_record(one: StoredOriginal) -> None:
    values = one.path, one.identity, one.version, one.original, one.results
    data = json.dumps(dict(zip(_FIELDS, values, strict=True))) + "\n"
    atomic_write(data.encode(), _record_of(one.file), private=True)


def _read(original: Path) -> StoredOriginal:
    """Return an original with its record, or without a record that is missing or damaged."""
    with suppress(BadFile, OSError):
        node = parse(_record_of(original).read_bytes(), _MAX_RECORD_BYTES).only(_FIELDS)
        path, identity, version, digest = (
            node.field(name).text(_MAX_RECORD_BYTES) for name in _FIELDS[:-1]
        )
        results = tuple(one.text(_HEX) for one in node.field("results").items(_MAX_RESULTS))
        return StoredOriginal(original, path, identity, version, digest, results)
    return StoredOriginal(original)


def _row(one: StoredOriginal) -> Row:
    texts = one.path, one.identity, one.version, one.original
    return one.file.name, *texts, " ".join(one.results)


def _recorded(data: Path) -> Iterator[Row]:
    """Yield the originals of a data folder, with their records."""
    with suppress(OSError):
        files = {one for one in (data / FOLDER).iterdir() if one.is_file()}
        names = {one.with_suffix("") if one.suffix == _RECORD else one for one in files}
        yield from (_row(_read(one)) for one in names)


TABLE: Final = IndexTable(
    "originals",
    ("file PRIMARY KEY", "path", "identity", "version", "original", "results"),
    ("path", "identity", "original"),
    _recorded,
)


def _sha256(pieces: Chunks) -> str:
    digest = hashlib.sha256()
    for piece in pieces:
        digest.update(piece)
    return digest.hexdigest()


def _hash_of(place: Path) -> str:
    """Return the SHA-256 of a file, or "" if there is none."""
    return sha256_of(place) if place.is_file() else ""
