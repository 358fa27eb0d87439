"""The user's store of originals: photos as they were before they were written over in place."""

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

from kogao_core.base.atomic import Pieces, aside, is_aside, put
from kogao_core.base.delta import applied, difference
from kogao_core.base.installed import data_folder
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile, parse

MOST_BYTES: Final = 4 << 30
"""How much the store holds; the oldest originals go first, but never the newest."""
_RECORD, _DELTA = ".json", ".delta"
_MOST_OF_WHOLE: Final = 0.8  # what a delta may take; else only the whole file is kept
_HEX: Final = 64
_LONGEST_RECORD: Final = 1 << 12


class NoOriginal(Exception):
    """A file's original isn't kept; the message says what to do."""


class ChangedSince(NoOriginal):
    """What others have written there since would be lost."""


@dataclass(frozen=True, slots=True)
class Entry:
    """What is known of an original."""

    path: str  # SHA-256 of where it lay, at the end of all links: paths may hold any bytes
    # SHA-256 of its bytes, of those that lay there when it was last written over, and of those it
    # was written over with.
    original: str
    before: str
    result: str
    read: str  # what the program that wrote it knew the file by when it read it; of any form

    def knows(self, present: str) -> bool:
        """Return whether bytes of this hash are the original or this program's own."""
        return present in (self.before, self.result)

    def made(self, present: str) -> bool:
        """Return whether bytes of this hash are this program's own."""
        return self.knows(present) and present != self.original

    def has(self, present: str) -> bool:
        """Return whether bytes of this hash can go: they are kept, or can be made again."""
        return self.knows(present) or present == self.original


@dataclass(frozen=True, slots=True)
class Originals:
    """Originals in a folder, each a file ``TIME-HASH.jpg`` with a record beside it.

    Beside it lies, too, what makes it of its result: while there is room both are kept, then that
    alone, which takes a part of it. A record whose original has gone tells that there was one.
    """

    folder: Path  # made when the first original is kept; nobody else may look into it
    # How much it holds; the newest original stays even where it is larger.
    most_bytes: int = MOST_BYTES

    @staticmethod
    def of_user() -> Originals:
        """Return the store of this user."""
        return Originals(data_folder() / "originals")

    @contextmanager
    def for_now(self) -> Iterator[Originals]:
        """Return a store within this one, gone at the end: whoever made the files keeps them."""
        self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with aside(self.folder) as folder:
            yield Originals(folder)

    def keep(self, path: Path, pieces: Pieces, read: str = "") -> bool:
        """Keep a file that is about to be written over with `pieces`, which come from one `read`.

        What this program itself had written there is no original: the first one is kept, and the
        new result is noted beside it. Of a result that was moved or copied, so is the original.
        Result: whether this program itself had written what lies there.
        """
        place = Path(os.path.realpath(path))
        data, source = place.read_bytes(), place
        present, result = _sha256([data]), _sha256(pieces)
        now = Entry(_of_path(place), present, present, result, read)
        for kept, record in self._of(place, present):
            if record.knows(present) and _make_whole(kept, record, data):
                now = replace(now, original=record.original)
                if record.path == now.path:
                    _beside(kept, _DELTA).unlink(missing_ok=True)  # of another result
                    _note(kept, now)
                    return now.made(present)
                data, source = kept.read_bytes(), kept
                break
        self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        seconds, rest = divmod(time.time_ns(), 10**9)
        moment = time.strftime("%Y%m%dT%H%M%S", time.gmtime(seconds))
        kept = self.folder / f"{moment}.{rest:09}-{now.original[:16]}{place.suffix}"
        put(data, kept, like=source)
        shutil.copystat(source, kept)
        _note(kept, now)
        return now.made(present)

    def settle(self, path: Path) -> int:
        """Note, once a result lies there, in what its original differs; then see to the room.

        Result: how many photos' only original had to go.
        """
        place = Path(os.path.realpath(path))
        new = place.read_bytes()
        here, present = _of_path(place), _sha256([new])
        for kept, record in self._of(place, present):
            if (record.path, record.result) == (here, present) and kept.is_file():
                old = kept.read_bytes()
                delta = difference(old, new)
                if len(delta) <= _MOST_OF_WHOLE * len(old) and applied(delta, new) == old:
                    put(delta, _beside(kept, _DELTA), like=kept)
                    shutil.copystat(kept, _beside(kept, _DELTA))
                return self._shed(kept)
        return 0

    def behind(self, path: Path) -> tuple[Path, str] | None:
        """Return the original of a file that is just as it was written in place, if it is kept.

        Beside it stands what the file was known by when it was read.
        """
        place = Path(os.path.realpath(path))
        data = place.read_bytes()
        present = _sha256([data])
        for kept, record in self._of(place, present):
            if record.made(present) and _make_whole(kept, record, data):
                return kept, record.read
        return None

    def kept(self, path: Path) -> list[Path]:
        """Return what is kept of a file, the newest first.

        There are several where another program has changed it between two times. Raises NoOriginal.
        """
        place = Path(os.path.realpath(path))
        found = self._found(path, place, _present(place))
        return [kept if kept.is_file() else _beside(kept, _DELTA) for kept, _ in found]

    def restore(self, path: Path, number: int | None = None, *, force: bool = False) -> bool:
        """Bring a file's original back, byte for byte; tell whether there was anything to do.

        Raises NoOriginal, ChangedSince.
        """
        place = Path(os.path.realpath(path))
        present = _present(place)
        found = self._found(path, place, present)
        if number is not None and not 1 <= number <= len(found):
            raise NoOriginal(
                Text(
                    "there is no original {number} of {path}; name one of 1 to {most}",
                    number=number,
                    path=path,
                    most=len(found),
                )
            )
        its_own = next((one for one in found if one[1].has(present)), None)
        kept, record = found[number - 1] if number is not None else its_own or found[0]
        if present == record.original:
            return False
        if present and its_own is None and not force:
            raise ChangedSince(
                Text(
                    "{path} has changed since it was written in place; force=True "
                    "brings the original back all the same",
                    path=path,
                )
            )
        is_whole = kept.is_file()
        if not is_whole and present != record.result:
            raise NoOriginal(
                Text(
                    "of the original of {path} only what differs from the result is kept, and "
                    "there is another file now; bring the result back there first",
                    path=path,
                )
            )
        data = kept.read_bytes() if is_whole else _from_delta(kept, place.read_bytes())
        if _sha256([data]) != record.original:
            raise NoOriginal(
                Text(
                    "the original of {path} is damaged ({kept}); take it from a backup",
                    path=path,
                    kept=kept,
                )
            )
        about = kept if is_whole else _beside(kept, _DELTA)
        put(data, place, like=None if place.exists() else about)
        shutil.copystat(about, place)
        return True

    def _found(self, path: Path, place: Path, present: str) -> list[tuple[Path, Entry]]:
        found = list(self._of(place, present))
        if not found and any(record.path == _of_path(place) for _, record in self._records()):
            raise NoOriginal(
                Text(
                    "the original of {path} has made room for newer ones: {folder} holds "
                    "{most:.1f} GB; take it from a backup",
                    path=path,
                    folder=self.folder,
                    most=self.most_bytes / 1e9,
                )
            )
        if not found:
            raise NoOriginal(
                Text(
                    "no original of {path} is kept in {folder}; name a file that was "
                    "changed in place, by the name it had then if it has been moved "
                    "and changed since",
                    path=path,
                    folder=self.folder,
                )
            )
        return found

    def _of(self, place: Path, present: str) -> Iterator[tuple[Path, Entry]]:
        """Yield what is kept of a place, then of what was written elsewhere; the newest first.

        Elsewhere is where a file lay that was moved here, known by the hash of what is present.
        """
        here, moved = _of_path(place), []
        for kept, record in self._records():
            if not (kept.is_file() or _beside(kept, _DELTA).is_file()):
                continue
            if record.path == here:
                yield kept, record
            elif present != record.original and record.knows(present):
                moved.append((kept, record))
        yield from moved

    def _records(self) -> Iterator[tuple[Path, Entry]]:
        """Yield where each original lies, or lay, with what is known of it; the newest first."""
        for note in sorted(self.folder.glob(f"*{_RECORD}"), reverse=True):
            record = _read(note)
            if record is not None:
                yield note.with_suffix(""), record

    def _shed(self, newest: Path) -> int:
        """Remove the oldest while there is too much; another program may be doing the same.

        Whole files that can be made again go first; the records of all others stay, to tell of
        them. Result: how many others went.
        """
        kept = sorted(
            (one for one in self.folder.iterdir() if one.suffix != _RECORD and not is_aside(one)),
            key=lambda one: (not _beside(one, _DELTA).exists(), one.name),
        )
        over, lost = sum(map(_size, kept)) - self.most_bytes, 0
        for one in kept:
            if over > 0 and not one.name.startswith(newest.name):
                over -= _size(one)
                lost += not _beside(one, _DELTA).exists()
                with suppress(OSError):
                    one.unlink()
        return lost


def _present(place: Path) -> str:
    return _sha256([place.read_bytes()]) if place.exists() else ""


def _size(file: Path) -> int:
    try:
        return file.stat().st_size
    except OSError:  # another program was quicker
        return 0


def _beside(kept: Path, suffix: str) -> Path:
    return kept.with_name(kept.name + suffix)


def _from_delta(kept: Path, result: bytes) -> bytes:
    """Return an original from what it differs in; of another result come other bytes, or none."""
    try:
        return applied(_beside(kept, _DELTA).read_bytes(), result)
    except (OSError, ValueError):
        return b""


def _make_whole(kept: Path, record: Entry, result: bytes) -> bool:
    """See that an original lies there as a file; tell whether it does."""
    if kept.is_file():
        return True
    data = result if _sha256([result]) == record.original else _from_delta(kept, result)
    if _sha256([data]) != record.original:
        return False
    put(data, kept, like=_beside(kept, _DELTA))
    shutil.copystat(_beside(kept, _DELTA), kept)
    return True


def _note(kept: Path, record: Entry) -> None:
    put((json.dumps(asdict(record)) + "\n").encode(), _beside(kept, _RECORD))


def _read(file: Path) -> Entry | None:
    """Return a record, or None where it is gone or isn't one."""
    try:
        node = parse(file.read_bytes(), _LONGEST_RECORD).only(Entry.__slots__)
        return Entry(*(node.field(name).text(_HEX) for name in Entry.__slots__))
    except (BadFile, OSError):
        return None


def _sha256(pieces: Pieces) -> str:
    digest = hashlib.sha256()
    for piece in pieces:
        digest.update(piece)
    return digest.hexdigest()


def _of_path(place: Path) -> str:
    return _sha256([os.fsencode(place)])
