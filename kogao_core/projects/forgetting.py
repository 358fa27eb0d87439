"""List and delete what Kogao keeps about photos in the user's data folder."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from kogao_core.base.index import Index, IndexTable, path_key
from kogao_core.base.installed import data_folder
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.photo import originals
from kogao_core.photo.originals import Originals
from kogao_core.projects import acts, edits, project
from kogao_core.projects.acts import Acts
from kogao_core.projects.edits import FOLDER, SUFFIX, Edits
from kogao_core.projects.results import Results, hashes_of

_EDITS, _NAMES = Text("edits"), Text("names and hashes")
# What the index has about a photo: the column of its path, and the SQL of size and time (ns).
_ROWS: Final[tuple[tuple[IndexTable, str, str, str, Text], ...]] = (
    (edits.TABLE, "path", "IFNULL(LENGTH(steps), 0) + IFNULL(LENGTH(project), 0)", "saved_ns",
     _EDITS),
    (edits.PICTURES, "path", "LENGTH(picture) + LENGTH(sha256)", "changed_ns", _NAMES),
    (acts.TABLE, "photo", "LENGTH(settings)", "act", _NAMES),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Forgotten:
    """Counts of what was deleted."""

    originals: int
    edits: int  # files: the project and its undo steps, and what a crash left
    results: int  # lines of the list


@dataclass
class KeptPhoto:
    """What is kept about a photo; of a file in the data folder, if its photo isn't known."""

    photo: Path
    what: dict[Text, None]  # kinds, in order
    size: int = 0  # bytes
    newest_ns: int = 0  # time of the newest part


def kept(data: Path | None = None) -> list[KeptPhoto]:
    """Return what is kept about each photo, by path. Raises OSError."""
    found = dict[Path, KeptPhoto]()
    for path, what, size, time_ns in _kept(data or data_folder()):
        one = found.setdefault(path, KeptPhoto(path, {}))
        one.what[what] = None
        one.size, one.newest_ns = one.size + size, max(one.newest_ns, time_ns)
    return [found[path] for path in sorted(found)]


def _kept(data: Path) -> Iterator[tuple[Path, Text, int, int]]:
    index = Index(data)
    for table, column, size, time_ns, what in _ROWS:
        sql = f"SELECT {column}, {size}, {time_ns} FROM {table.name}"
        for path, count, when in index.rows(table, sql):
            yield Path(os.fsdecode(path)), what, count, when
    owners: dict[bytes, bytes] = dict(
        index.rows(edits.TABLE, f"SELECT file, path FROM {edits.TABLE.name}")
    )
    stored = {one.file: one.photo for one in Originals(data / originals.FOLDER).all()}
    files = [(file, file, Text("original")) for file in stored]
    files += [(file, file, _EDITS) for file in (data / FOLDER).glob(f"*{SUFFIX}")]
    for file, owner, what in files:
        with suppress(OSError):
            at, owned = file.stat(), owners.get(path_key(file))
            photo = stored.get(file) or (owned and Path(os.fsdecode(owned)))
            yield photo or owner, what, at.st_size, at.st_mtime_ns
    for file, about in _recovered(data / "recovery"):
        yield about, Text("unsaved changes"), file.stat().st_size, file.stat().st_mtime_ns


def forget(photos: Iterable[Path], data: Path | None = None) -> list[Forgotten]:
    """Delete the originals, edits and listed results of photos; files beside the photos stay.

    A photo may be a file of the data folder that `kept` lists. Raises OSError.
    """
    data, names, needles = data or data_folder(), set[str](), set[str]()
    gone = []
    try:
        for photo in photos:
            known = {str(photo), os.path.realpath(photo)}
            needles |= {*known, *(json.dumps(one)[1:-1] for one in known), hashes_of(photo)[0]}
            names.add(photo.name)
            gone.append(_forget(photo, data))
    finally:  # also if a photo fails: the ones before leave no trace
        for pattern in ("*.jsonl", "exports/*.jsonl", f"{FOLDER}/*.place"):
            _redact(data, pattern, needles)
        _redact(data, "kogao.log*", needles | names)
        Index(data).compact()
    return gone


def _forget(photo: Path, data: Path) -> Forgotten:
    """Delete what the index and files of their own have about a photo."""
    real = Path(os.path.realpath(photo))
    results = Results(data).forget(photo)
    count = Originals(data / originals.FOLDER).forget(photo)
    files = Edits(data / FOLDER).forget(photo)
    Acts(data).forget(photo)
    files += [file for file, about in _recovered(data / "recovery") if _is_same(about, real)]
    files += [real] if real.parent == Path(os.path.realpath(data / FOLDER)) else []
    for file in files:
        file.unlink(missing_ok=True)
    return Forgotten(count, len(files), results)


def _redact(data: Path, pattern: str, needles: set[str]) -> None:
    """Delete the lines with one of these texts from files; delete files that are then empty."""
    wanted = [os.fsencode(needle) for needle in needles]
    for file in data.glob(pattern):
        lines = file.read_bytes().splitlines(keepends=True)
        left = [line for line in lines if not any(needle in line for needle in wanted)]
        if not left:
            file.unlink()
        elif left != lines:
            file.write_bytes(b"".join(left))


def _recovered(folder: Path) -> Iterator[tuple[Path, Path]]:
    """Yield the recovery files and the photos that they are about."""
    for file in folder.glob("*.json"):
        with suppress(BadFile):  # damaged
            yield file, Path(project.load(file).original.path)


def _is_same(path: Path, real: Path) -> bool:
    return Path(os.path.realpath(path)) == real
