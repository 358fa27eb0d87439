"""The user's store of originals: photos as they were before they were written over in place."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final

from kogao_core.base.atomic import Pieces, is_aside, put
from kogao_core.base.installed import data_folder
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile, parse

MOST_BYTES: Final = 4 << 30
"""How much the store holds; the oldest originals go first, but never the newest."""
_RECORD: Final = ".json"
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
    """Originals in a folder, each a file ``TIME-HASH.jpg`` with a record beside it."""

    folder: Path  # made when the first original is kept; nobody else may look into it
    # How much it holds; the newest original stays even where it is larger.
    most_bytes: int = MOST_BYTES

    @staticmethod
    def of_user() -> Originals:
        """Return the store of this user."""
        return Originals(data_folder() / "originals")

    @staticmethod
    @contextmanager
    def for_now() -> Iterator[Originals]:
        """Return a store that is gone at the end: whoever made the files has their originals."""
        with tempfile.TemporaryDirectory(prefix="kogao-") as folder:
            yield Originals(Path(folder))

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
            if record.knows(present):
                now = replace(now, original=record.original)
                if record.path == now.path:
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
        self._shed(kept)
        return now.made(present)

    def behind(self, path: Path) -> tuple[Path, str] | None:
        """Return the original of a file that is just as it was written in place, if it is kept.

        Beside it stands what the file was known by when it was read.
        """
        place = Path(os.path.realpath(path))
        present = _sha256([place.read_bytes()])
        found = self._of(place, present)
        return next(((kept, record.read) for kept, record in found if record.made(present)), None)

    def kept(self, path: Path) -> list[Path]:
        """Return what is kept of a file, the newest first.

        There are several where another program has changed it between two times. Raises NoOriginal.
        """
        place = Path(os.path.realpath(path))
        return [kept for kept, _ in self._found(path, place, _present(place))]

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
        data = kept.read_bytes()
        if _sha256([data]) != record.original:
            raise NoOriginal(
                Text(
                    "the original of {path} is damaged ({kept}); take it from a backup",
                    path=path,
                    kept=kept,
                )
            )
        put(data, place, like=None if place.exists() else kept)
        shutil.copystat(kept, place)
        return True

    def _found(self, path: Path, place: Path, present: str) -> list[tuple[Path, Entry]]:
        found = list(self._of(place, present))
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
        for note in sorted(self.folder.glob(f"*{_RECORD}"), reverse=True):
            kept = note.with_suffix("")
            record = _read(note)
            if record is None or not kept.is_file():
                continue
            if record.path == here:
                yield kept, record
            elif present != record.original and record.knows(present):
                moved.append((kept, record))
        yield from moved

    def _shed(self, newest: Path) -> None:
        """Remove the oldest while there is too much; another program may be doing the same."""
        room = self.most_bytes - newest.stat().st_size
        # Those without a record too: whoever was killed left them.
        kept = (
            file for file in self.folder.iterdir() if file.suffix != _RECORD and not is_aside(file)
        )
        for one in sorted((file for file in kept if file != newest), reverse=True):
            with suppress(OSError):
                room -= one.stat().st_size
                if room < 0:
                    _beside(one).unlink(missing_ok=True)
                    one.unlink()


def _present(place: Path) -> str:
    return _sha256([place.read_bytes()]) if place.exists() else ""


def _beside(kept: Path) -> Path:
    return kept.with_name(kept.name + _RECORD)


def _note(kept: Path, record: Entry) -> None:
    put((json.dumps(asdict(record)) + "\n").encode(), _beside(kept))


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
