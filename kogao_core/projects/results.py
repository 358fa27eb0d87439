"""List of the results that Kogao made, so that it doesn't retouch a photo twice."""

from __future__ import annotations

import glob
import hashlib
import json
import logging
import os
import re
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from kogao_core.base.atomic import appended, atomic_write
from kogao_core.base.installed import data_folder
from kogao_core.base.json_reader import BadFile, parse
from kogao_core.base.language import Text, translated
from kogao_core.base.wording import printable
from kogao_core.photo.formats import READABLE
from kogao_core.photo.metadata import rating
from kogao_core.projects.project import sha256_of

NAME: Final = "results.jsonl"
"""File name of the list, in the user's data folder."""
REPORT: Final = "kogao-batch.jsonl"
"""File name of a batch's report, in the folder of the results."""
MARK: Final = "_kogao"
"""End of the stem that Kogao suggests for a copy."""
_MARKED: Final = re.compile(rf"(.+){MARK}(?:[ _-]?\d+|\(\d+\))?")
_MAX_BYTES: Final = 8 << 20
_MAX_LINE_BYTES: Final = 1 << 12
_HEX: Final = 64
_LOG: Final = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Result:
    """A line of the list. It has hashes instead of paths, so that it names no photo."""

    source: str  # SHA-256 of the path of the photo
    name: str  # SHA-256 of the name of the photo
    size: int  # of the result in bytes; 0 if the result equals the photo
    sha256: str  # of the result; empty if it equals the photo
    edit: str = ""  # SHA-256 of the project that was applied; empty for settings alone


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
            "{name} is Kogao's own result of {source}",
            name=self.path.name,
            source=self.source.name,
        )


@dataclass(frozen=True, slots=True)
class Results:
    """The list of results, a file of JSON lines to which several programs may append at once."""

    file: Path

    @staticmethod
    def of_user() -> Results:
        """Return the list of this user."""
        return Results(data_folder() / NAME)

    def add(self, source: Path, result: Path, edit: str = "") -> None:
        """Add a result; do nothing if the list can't be written."""
        with suppress(OSError):
            size, digest = result.stat().st_size, sha256_of(result)
            if source.stat().st_size == size and sha256_of(source) == digest:
                size, digest = 0, ""
            line = Result(*_hashes(source), size, digest, edit)
            if self.file.is_file() and self.file.stat().st_size > _MAX_BYTES:
                lines = self.file.read_bytes().splitlines(keepends=True)
                atomic_write(lines[len(lines) // 2 :], self.file, private=True)
            with appended(self.file) as file:
                self.file.chmod(0o600)
                file.write(json.dumps(asdict(line)).encode() + b"\n")

    def edits_of(self, photo: Path) -> set[str]:
        """Return the hashes of the projects that results of a photo were saved with."""
        return {one.edit for one in self._read() if one.source == _hashes(photo)[0]}

    def forget(self, photo: Path) -> int:
        """Remove the lines about a photo and about a file as a result; return how many."""
        lines, digest = self._read(), sha256_of(photo) if photo.is_file() else None
        kept = [one for one in lines if one.source != _hashes(photo)[0] and one.sha256 != digest]
        if len(kept) < len(lines):
            atomic_write(
                [json.dumps(asdict(one)).encode() + b"\n" for one in kept], self.file, private=True
            )
        return len(lines) - len(kept)

    def origin(self, path: Path) -> Provenance | None:
        """Return the origin of a result, or None for a photo.

        A result is recognised by its bytes, the report of its batch, its edit record or its name.
        """
        try:
            size = path.stat().st_size
            same_size = [one for one in self._read() if one.sha256 and one.size == size]
            digest = sha256_of(path) if same_size else ""
            for one in same_size:
                if one.sha256 == digest:
                    return Provenance(path, _photo_of(one, path))
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

    def _read(self) -> list[Result]:
        try:
            return _lines(self.file, self.file.stat().st_mtime_ns)
        except OSError:
            return []


@lru_cache(maxsize=2)
def _lines(file: Path, _: int) -> list[Result]:
    """Return the lines of a list; log a warning about damaged ones."""
    lines = file.read_bytes().splitlines()
    read = [one for one in map(_line, lines) if one is not None]
    if len(read) < len(lines):
        count = len(lines) - len(read)
        text = Text.counted(count, "{file}: skipped {n} damaged line",
                            "{file}: skipped {n} damaged lines", file=file)  # fmt: skip
        _LOG.warning("%s", printable(translated(text)))
    return read


def _line(line: bytes) -> Result | None:
    """Return a line of the list, or None if it is damaged."""
    try:
        node = parse(line, _MAX_LINE_BYTES).only(Result.__slots__)
        hashes = {one: node.field(one).text(_HEX) for one in Result.__slots__ if one != "size"}
        return Result(size=node.field("size").whole(0, 1 << 53), **hashes)
    except BadFile:
        return None


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


def _hashes(photo: Path) -> tuple[str, str]:
    """Return the SHA-256 of the real path and of the name of a photo."""
    place = Path(os.path.realpath(photo))
    path, name = (hashlib.sha256(os.fsencode(text)).hexdigest() for text in (place, place.name))
    return path, name


def _photo_of(line: Result, path: Path) -> Path | None:
    """Return the photo of a result: where it was, if near the result, or by its name beside it."""
    near: list[Path] = []
    for folder in (path.parent, path.parent.parent):
        with suppress(OSError):
            near += folder.iterdir()
    hashes = {one: _hashes(one) for one in near if one.suffix.lower() in READABLE}
    places = [one for one in hashes if hashes[one][0] == line.source]
    beside = [one for one in hashes if (one.parent, hashes[one][1]) == (path.parent, line.name)]
    return _first_photo([*places, *beside], path)


def _first_photo(places: Iterable[Path], result: Path) -> Path | None:
    return next((one for one in places if one != result and one.is_file()), None)


def _namesake(path: Path, stem: str) -> Path | None:
    """Return the photo beside a result that has the result's name without the mark."""
    same = path.with_name(stem + path.suffix)
    others = sorted(path.parent.glob(f"{glob.escape(stem)}.*"))
    return _first_photo((one for one in (same, *others) if one.suffix.lower() in READABLE), path)
