"""Store of original photos, copied before Kogao overwrites a photo in place."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final
from urllib.parse import quote_from_bytes, unquote_to_bytes

from kogao_core.base.atomic import Pieces, aside, is_aside, put
from kogao_core.base.installed import data_folder
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile, Node, parse

LIMIT_BYTES: Final = 10**10
"""Default size limit of the store."""
_RECORD: Final = ".json"
_DELTA: Final = ".delta"  # file of the older format, not read any more
_OLD_FIELDS: Final = ("path", "original", "before", "result", "read")
_UNKNOWN: Final = "unknown"  # `file` of a record of the older format
_HEX: Final = 64
_MAX_RESULTS: Final = 200
_MAX_RECORD_BYTES: Final = 1 << 16


class NoOriginal(Exception):
    """No stored original can be restored; the message says what to do."""


class ChangedSince(NoOriginal):
    """Another program changed the file; a restore would lose those changes."""


class StoreFull(Exception):
    """The store is full; more room requires deleting the only original of a photo."""


@dataclass(frozen=True, slots=True)
class OriginalRecord:
    """Metadata of a stored original, saved as JSON in the same folder."""

    path: str  # of the photo, absolute and percent-encoded: a path may contain any bytes
    file: str  # device, inode and modification time of the last result (`_identity`)
    version: str  # version of the photo used for the last result; any text
    original: str  # SHA-256 of the original
    results: tuple[str, ...]  # SHA-256 of each result written over the photo, newest last


@dataclass(frozen=True, slots=True)
class StoredOriginal:
    """An original in the store: a copy of the photo, and a record unless damaged."""

    file: Path
    record: OriginalRecord | None

    @property
    def photo(self) -> Path | None:
        """Path of the photo that was overwritten; None if the record lacks it."""
        path = Path(os.fsdecode(unquote_to_bytes(self.record.path))) if self.record else Path()
        return path if path.is_absolute() else None

    def is_of(self, place: Path) -> bool:
        """Return whether the photo that was overwritten lay at `place`."""
        hashed = self.record is not None and self.record.path == _sha256([os.fsencode(place)])
        return self.photo == place or hashed

    @property
    def original(self) -> str:
        """SHA-256 of the original; "" without a record."""
        return "" if self.record is None else self.record.original

    @property
    def results(self) -> tuple[str, ...]:
        """SHA-256 of each result written over the photo."""
        return () if self.record is None else self.record.results

    def is_redundant(self) -> bool:
        """Return whether the photo is identical to the original again."""
        with suppress(OSError):
            return (
                self.photo is not None
                and self.photo.stat().st_size == self.file.stat().st_size
                and _hash_of(self.photo) == self.original
            )
        return False

    def remove(self) -> None:
        """Delete the original and its record."""
        delta = self.file.with_name(self.file.name + _DELTA)
        for file in (self.file, delta, _record_of(self.file)):
            file.unlink(missing_ok=True)


@dataclass(frozen=True, slots=True)
class Originals:
    """Originals in a folder, each a file ``TIME-HASH.jpg`` with a record ``TIME-HASH.jpg.json``.

    An original belongs to one photo, identified by path and by the file (device, inode,
    modification time) written by Kogao. The hash of a result doesn't identify the original: two
    photos can have equal results. The record of an evicted original stays in the store.
    """

    folder: Path  # created with the first original; accessible only to this user
    limit_bytes: int = LIMIT_BYTES
    evicts: bool = False  # remove the oldest originals when full, instead of raising StoreFull

    @staticmethod
    def of_user(*, evicts: bool = False) -> Originals:
        """Return the store of this user."""
        return Originals(data_folder() / "originals", evicts=evicts)

    @contextmanager
    def temporary(self) -> Iterator[Originals]:
        """Yield a store in a subfolder that is deleted on exit."""
        self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with aside(self.folder) as folder:
            yield Originals(folder)

    def keep(self, path: Path, result: Pieces, version: str = "") -> int:
        """Store the file at `path` before `result` overwrites it; return how many were evicted.

        The original of a photo that Kogao overwrote before stays the original. Raises OSError,
        StoreFull.
        """
        place = _real(path)
        present, new = _hash_of(place), _sha256(result)
        own = (one for one in self.all() if one.is_of(place) and one.original == present)
        known = self.find(path) or next((one for one in own if one.file.is_file()), None)
        encoded = quote_from_bytes(os.fsencode(place))
        if known and known.record and known.is_of(place):
            results = (*known.results, new)[-_MAX_RESULTS:]
            record = replace(known.record, path=encoded, version=version, results=results)
            _write_record(replace(known, record=record))
            return 0
        source = place if known is None else known.file
        data = source.read_bytes()
        evicted = self._make_room(len(data), source)
        self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        seconds, rest = divmod(time.time_ns(), 10**9)
        moment, digest = time.strftime("%Y%m%dT%H%M%S", time.gmtime(seconds)), _sha256([data])
        file = self.folder / f"{moment}.{rest:09}-{digest[:16]}{place.suffix}"
        put(data, file, like=source)
        shutil.copystat(source, file)
        results = (new,) if known is None else (present, new)
        _write_record(
            StoredOriginal(
                file, OriginalRecord(encoded, _identity(place), version, digest, results)
            )
        )
        return evicted

    def note_written(self, path: Path) -> None:
        """Record the identity of the result at `path`."""
        place = _real(path)
        present = _hash_of(place)
        for one in self.all():
            if one.record and one.is_of(place) and one.results[-1] == present:
                _write_record(replace(one, record=replace(one.record, file=_identity(place))))
                return

    def find(self, path: Path) -> StoredOriginal | None:
        """Return the original of the result at `path`. None: no original or several match."""
        place = _real(path)
        fits = sorted(self._certain(place), key=lambda one: not one.is_of(place))
        return next((one for one in fits if one.file.is_file()), None)

    def all(self) -> list[StoredOriginal]:
        """Return all originals, the newest first, and the records of evicted originals."""
        with suppress(OSError):
            files = {one for one in self.folder.iterdir() if one.is_file() and not is_aside(one)}
            files = {one for one in files if one.suffix != _DELTA}
            names = {one if one.suffix != _RECORD else one.with_suffix("") for one in files}
            return [StoredOriginal(one, _read_record(one)) for one in sorted(names, reverse=True)]
        return []

    def of(self, path: Path) -> list[StoredOriginal]:
        """Return all possible originals of a file, the newest first.

        Match by path, by file identity or by the hash of a result.
        """
        place, every = _real(path), self.all()
        present, identity = _hash_of(place), _identity(place)
        own = [
            one
            for one in every
            if one.is_of(place)
            or (one.record and one.record.file == identity)
            or present in (one.original, *one.results)
        ]
        shared = {result for one in own for result in one.results}
        return [one for one in every if one.file.is_file() and shared.intersection(one.results)]

    def restore(self, path: Path, number: int | None = None, *, force: bool = False) -> bool:
        """Restore the original of a file, byte for byte. Return False if already restored.

        `number` selects an original from the list `of(path)`, from 1. Raises NoOriginal,
        ChangedSince.
        """
        place = _real(path)
        present, listed = _hash_of(place), self.of(path)
        if number is not None and number > len(listed):
            raise NoOriginal(
                Text("there is no original {number} of {path}; kogao-cli originals lists {count}",
                     number=number, path=path, count=len(listed))
            )  # fmt: skip
        chosen = listed[number - 1] if number else self._only(path, present, listed)
        if present == chosen.original:
            return False
        # With a number, restore may overwrite any file that the store knows.
        known = {hash_ for one in listed for hash_ in (one.original, *one.results)}
        known = known if number else set(chosen.results)
        if present and present not in known and not force:
            raise ChangedSince(
                Text("{path} has changed since it was written in place; force=True restores the "
                     "original all the same",
                     path=path)
            )  # fmt: skip
        data = chosen.file.read_bytes()
        if _sha256([data]) != chosen.original:
            raise NoOriginal(
                Text("the original of {path} is damaged ({kept}); take it from a backup",
                     path=path, kept=chosen.file)
            )  # fmt: skip
        put(data, place, like=None if place.exists() else chosen.file)
        shutil.copystat(chosen.file, place)
        return True

    def forget(self, path: Path) -> int:
        """Delete all originals of a path or of the file at that path. Return the count.

        `path` may also be a file in the store. The records of evicted originals are deleted too.
        """
        place, count = _real(path), 0
        identity = _identity(place)
        for one in self.all():
            is_same = one.record is not None and one.record.file == identity
            if place == one.file or one.is_of(place) or is_same:
                count += one.file.is_file()
                one.remove()
        return count

    def _only(self, path: Path, present: str, listed: list[StoredOriginal]) -> StoredOriginal:
        """Return the only original of a file. Raises NoOriginal."""
        place = _real(path)
        own = [one for one in self.all() if one.is_of(place)]
        found = self._certain(place) or [one for one in own if one.original == present]
        if not found and not any(present in one.results for one in self.all()):
            found = own if len({one.original for one in own}) == 1 else []
        stored = [one for one in found if one.file.is_file() or one.original == present]
        if stored:
            return stored[0]
        if listed and not found:
            raise NoOriginal(
                Text("{count} stored originals may be that of {path}; kogao-cli originals lists "
                     "them, and restore --original N brings one back",
                     count=len(listed), path=path)
            )  # fmt: skip
        if found or own:
            raise NoOriginal(
                Text("the original of {path} was deleted to make room; take it from a backup",
                     path=path)
            )  # fmt: skip
        raise NoOriginal(
            Text("no original of {path} is kept in {folder}; kogao-cli originals lists all",
                 path=path, folder=self.folder)
        )  # fmt: skip

    def _certain(self, place: Path) -> list[StoredOriginal]:
        """Return the unambiguous originals of the result at `place`, all with the same hash.

        If two photos have equal results, device, inode and modification time decide. A copy of a
        result counts as the result only if the result is no longer at the recorded path.
        """
        present, identity = _hash_of(place), _identity(place)
        fits = [(one, one.record) for one in self.all() if one.record and present in one.results]
        same = {one.original for one, record in fits if record.file == identity}
        here = {one.original for one, _ in fits if one.is_of(place)}
        moved = {one.original for one, record in fits if _identity(one.photo) != record.file}
        if len({one.original for one, _ in fits}) == 1:
            certain = here | same | moved
        else:
            certain = same if here <= same else set()
        return [one for one, _ in fits if {one.original} == certain]

    def _make_room(self, count: int, needed: Path) -> int:
        """Make room for `count` bytes. Return the number of evicted originals. Raises StoreFull.

        Delete redundant originals first. Never delete the file `needed` or a record.
        """
        stored = [one for one in reversed(self.all()) if one.file.is_file()]  # the oldest first
        over, evicted = sum(map(_size, stored)) + count - self.limit_bytes, 0
        for one in (*filter(StoredOriginal.is_redundant, stored if over > 0 else ()), *stored):
            if over > 0 and one.file.is_file() and one.file != needed:
                is_redundant = one.is_redundant()
                if not is_redundant and not self.evicts:
                    raise StoreFull
                over -= _size(one)
                evicted += not is_redundant
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
    try:
        state = place.stat() if place else None
    except OSError:
        state = None
    if state is None:
        return ""
    return f"{state.st_dev}-{state.st_ino}-{state.st_mtime_ns}"


def _write_record(original: StoredOriginal) -> None:
    assert original.record is not None
    data = (json.dumps(asdict(original.record)) + "\n").encode()
    put(data, _record_of(original.file), private=True)


def _read_record(original: Path) -> OriginalRecord | None:
    """Return the record of an original, or None if it is missing or damaged."""
    try:
        data = _record_of(original).read_bytes()
        node = parse(data, _MAX_RECORD_BYTES)
        if "before" in node.only((*OriginalRecord.__slots__, *_OLD_FIELDS)).value:
            return _old_record(node)
        texts = {
            name: node.field(name).text(_MAX_RECORD_BYTES) for name in OriginalRecord.__slots__[:-1]
        }
        results = [one.text(_HEX) for one in node.field("results").items(_MAX_RESULTS)]
        return OriginalRecord(**texts, results=tuple(results))
    except (BadFile, OSError):
        return None


def _old_record(node: Node) -> OriginalRecord:
    """Return a record of the format before November 2026. Raises BadFile."""
    path, digest, before, result, version = (node.field(one).text(_HEX) for one in _OLD_FIELDS)
    results = (result,) if before in (digest, result) else (before, result)
    return OriginalRecord(path, _UNKNOWN, version, digest, results)


def _sha256(pieces: Pieces) -> str:
    digest = hashlib.sha256()
    for piece in pieces:
        digest.update(piece)
    return digest.hexdigest()


def _hash_of(place: Path) -> str:
    """Return the SHA-256 of a file, or "" if there is none."""
    return _sha256([place.read_bytes()]) if place.is_file() else ""
