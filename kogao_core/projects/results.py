"""The results that Kogao made, so that it doesn't retouch a photo twice."""

from __future__ import annotations

import glob
import hashlib
import json
import logging
import os
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from kogao_core.base.index import Index, IndexTable, Row, path_hash
from kogao_core.base.installed import data_folder
from kogao_core.base.json_reader import BadFile, parse
from kogao_core.base.language import Text, translated
from kogao_core.base.wording import printable
from kogao_core.photo.formats import READABLE, suffix_of
from kogao_core.photo.metadata import rating
from kogao_core.photo.picture import sha256_of

REPORT: Final = "kogao-batch.jsonl"
"""File name of a batch's report, in the folder of the results."""
MARK: Final = "_kogao"
"""End of the stem that Kogao suggests for a copy."""
_MARKED: Final = re.compile(rf"(.+){MARK}(?:[ _-]?\d+|\(\d+\))?")
_MAX_LINE_BYTES: Final = 1 << 12
_HEX: Final = 64
_FIELDS: Final = ("source", "name", "size", "sha256", "edit")
_LOG: Final = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Provenance:
    """A result and the photo it was made from, if that was found."""

    path: Path
    source: Path | None = None

    @property
    def why(self) -> Text:
        """A sentence that says that the file is a result."""
        if self.source is None:
            return Text("{name} is one of Kogao's own results", name=self.path.name)
        return Text(
            "{name} is Kogao's own result of {source}", name=self.path.name, source=self.source.name
        )


@dataclass(frozen=True, slots=True)
class Results:
    """The results on record, in the index of a data folder.

    A row has hashes instead of paths, so that it names no photo: SHA-256 of the path and of the
    name of the photo; size and SHA-256 of the result, 0 and "" if it equals the photo; SHA-256 of
    the project that was applied, "" for settings alone.
    """

    folder: Path

    @staticmethod
    def of_user() -> Results:
        return Results(data_folder())

    def add(self, source: Path, result: Path, edit: str = "") -> None:
        """Add a result; do nothing if the index can't be written."""
        with suppress(OSError):
            size, digest = result.stat().st_size, sha256_of(result)
            if source.stat().st_size == size and sha256_of(source) == digest:
                size, digest = 0, ""
            row = (*hashes_of(source), size, digest, edit)
            Index(self.folder).change(TABLE, TABLE.insert(), *row)

    def edits_of(self, photo: Path) -> set[str]:
        """Return the hashes of the projects that results of a photo were saved with."""
        return {str(edit) for (edit,) in self._rows("edit", "source = ?", hashes_of(photo)[0])}

    def forget(self, photo: Path) -> int:
        """Remove the rows about a photo and about a file as a result; return how many."""
        own = hashes_of(photo)[0], sha256_of(photo) if photo.is_file() else "-"
        sql = f"DELETE FROM {TABLE.name} WHERE source = ? OR sha256 = ?"
        return Index(self.folder).change(TABLE, sql, *own)

    def origin(self, path: Path) -> Provenance | None:
        """Return the origin of a result, or None for a photo.

        A result is recognised by its bytes, the report of its batch, its edit record or its name.
        """
        try:
            size = path.stat().st_size
            if self._rows("1", "size = ? AND sha256 != '' LIMIT 1", size):
                for row in self._rows("source, name", "sha256 = ? LIMIT 1", sha256_of(path)):
                    return Provenance(path, _photo_of(row, path))
            report = path.with_name(REPORT)
            if report.is_file():
                source = _sources(report, report.stat().st_mtime_ns).get(path.name)
                if source is not None:
                    places = (Path(source), path.with_name(Path(source).name))
                    return Provenance(path, _first_photo(places, path))
            marked = _MARKED.fullmatch(path.stem)
            if marked is not None or rating.is_ours(path):
                return Provenance(path, _namesake(path, marked[1]) if marked else None)
        except OSError:  # the caller finds out when it reads the file
            pass
        return None

    def _rows(self, columns: str, condition: str, value: object) -> list[Row]:
        sql = f"SELECT {columns} FROM {TABLE.name} WHERE {condition}"
        try:
            return Index(self.folder).rows(TABLE, sql, value)
        except OSError:
            return []


def _listed(folder: Path) -> Iterator[Row]:
    """Yield the lines of the list of version 1.0; log a warning about damaged ones."""
    file = folder / "results.jsonl"
    lines = file.read_bytes().splitlines() if file.is_file() else []
    damaged = 0
    for line in lines:
        try:
            node = parse(line, _MAX_LINE_BYTES).only(_FIELDS)
            source, name, sha256, edit = (
                node.field(one).text(_HEX) for one in _FIELDS if one != "size"
            )
            yield source, name, node.field("size").whole(0, 1 << 53), sha256, edit
        except BadFile:
            damaged += 1
    if damaged:
        text = Text.counted(damaged, "{file}: skipped {n} damaged line",
                            "{file}: skipped {n} damaged lines", file=file)  # fmt: skip
        _LOG.warning("%s", printable(translated(text)))


TABLE: Final = IndexTable("results", _FIELDS, ("source", "size", "sha256"), _listed)


@lru_cache(maxsize=16)
def _sources(report: Path, _: int) -> dict[str, str]:
    """Return the paths of the photos of a batch by the names of their results."""
    return {
        Path(str(entry.get("output"))).name: str(entry.get("source"))
        for entry in objects_in(report)
        if entry.get("status") == "done"
    }


def objects_in(file: Path) -> list[dict[str, Any]]:
    """Return the objects in a file of JSON lines; skip damaged lines."""
    found = []
    for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            entry = json.loads(line)
        except (ValueError, RecursionError):
            continue
        if isinstance(entry, dict):
            found.append(entry)
    return found


def hashes_of(photo: Path) -> tuple[str, str]:
    """Return the SHA-256 of the real path and of the name of a photo."""
    name = os.fsencode(Path(os.path.realpath(photo)).name)
    return path_hash(photo), hashlib.sha256(name).hexdigest()


def _photo_of(row: Row, path: Path) -> Path | None:
    """Return the photo of a result: where it was, if near the result, or by its name beside it."""
    near: list[Path] = []
    for folder in (path.parent, path.parent.parent):
        with suppress(OSError):
            near += folder.iterdir()
    hashes = {one: hashes_of(one) for one in near if suffix_of(one) in READABLE}
    places = [one for one in hashes if hashes[one][0] == row[0]]
    beside = [one for one in hashes if (one.parent, hashes[one][1]) == (path.parent, row[1])]
    return _first_photo([*places, *beside], path)


def _first_photo(places: Iterable[Path], result: Path) -> Path | None:
    return next((one for one in places if one != result and one.is_file()), None)


def _namesake(path: Path, stem: str) -> Path | None:
    """Return the photo beside a result that has the result's name without the mark."""
    same = path.with_name(stem + path.suffix)
    others = sorted(path.parent.glob(f"{glob.escape(stem)}.*"))
    return _first_photo((one for one in (same, *others) if suffix_of(one) in READABLE), path)
