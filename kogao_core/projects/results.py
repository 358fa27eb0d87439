"""Results that this program has made, so that none is taken for a photo and retouched twice."""

from __future__ import annotations

import glob
import json
import os
import re
from collections import defaultdict
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from kogao_core.base.atomic import appended, put
from kogao_core.base.installed import data_folder
from kogao_core.base.language import Text
from kogao_core.photo.formats import READABLE
from kogao_core.photo.metadata import glance
from kogao_core.projects.project import sha256_of

NAME: Final = "results.jsonl"
"""Of the list, in the user's data folder."""
REPORT: Final = "kogao-batch.jsonl"
"""Of a batch's report, in the folder of its results."""
MARK: Final = "_kogao"
"""Ends the name that is suggested for a copy, before the suffix."""
_MARKED: Final = re.compile(rf"(.+){MARK}(?:[ _-]?\d+|\(\d+\))?")
_MOST_BYTES: Final = 8 << 20


@dataclass(frozen=True, slots=True)
class Result:
    """A line of the list."""

    source: str  # the photo it was made from
    result: str  # where it was written
    # Of its bytes, by which it is known wherever it goes; a result that equals its photo has none.
    size: int
    sha256: str
    edit: str = ""  # hash of the project that was done; empty for settings alone


@dataclass(frozen=True, slots=True)
class Provenance:
    """What is known of where a result comes from: its photo, if that is there."""

    path: Path
    source: Path | None = None

    @property
    def why(self) -> Text:
        """A sentence for whoever asked for it to be worked on."""
        if self.source is None:
            return Text("{name} is one of Kogao's own results", name=self.path.name)
        return Text(
            "{name} is Kogao's own result of {source}",
            name=self.path.name,
            source=self.source.name,
        )


@dataclass(frozen=True, slots=True)
class Results:
    """The list of results, a file of JSON lines that programs add to at once."""

    file: Path

    @staticmethod
    def of_user() -> Results:
        """Return this user's list."""
        return Results(data_folder() / NAME)

    def add(self, source: Path, result: Path, edit: str = "") -> None:
        """Add a result; a list that can't be written loses nobody a picture."""
        with suppress(OSError):
            size, digest = result.stat().st_size, sha256_of(result)
            if source.stat().st_size == size and sha256_of(source) == digest:
                size, digest = 0, ""
            line = Result(os.path.realpath(source), os.path.realpath(result), size, digest, edit)
            if self.file.is_file() and self.file.stat().st_size > _MOST_BYTES:
                kept = self.file.read_bytes().splitlines(keepends=True)
                put(kept[len(kept) // 2 :], self.file)
            with appended(self.file) as lines:
                lines.write(json.dumps(asdict(line)).encode() + b"\n")

    def of(self, photo: Path) -> list[Result]:
        """Return the results of a photo that are still there."""
        made = self._read()[0].get(os.path.realpath(photo), [])
        return [one for one in made if os.path.exists(one.result)]

    def origin(self, path: Path) -> Provenance | None:
        """Return where a result comes from; None for a photo.

        It is known by its bytes, by the report of the batch that made it, by its edit record, or
        by its name.
        """
        try:
            made = self._read()[1].get(path.stat().st_size, [])
            digest = sha256_of(path) if made else ""
            for one in made:
                if one.sha256 == digest:
                    return Provenance(path, _there(Path(one.source), path))
            report = path.with_name(REPORT)
            if report.is_file():
                source = _outputs(report, report.stat().st_mtime_ns).get(path.name)
                if source is not None:
                    return Provenance(path, _there(Path(source), path))
            marked = _MARKED.fullmatch(path.stem)
            if marked is not None or glance.is_ours(path):
                return Provenance(path, _namesake(path, marked[1]) if marked else None)
        except OSError:  # whoever reads it finds a sentence
            pass
        return None

    def _read(self) -> _Index:
        try:
            return _index(self.file, self.file.stat().st_mtime_ns)
        except OSError:
            return {}, {}


# Results by their photos, and by their sizes.
_Index = tuple[dict[str, list[Result]], dict[int, list[Result]]]


@lru_cache(maxsize=2)
def _index(file: Path, _: int) -> _Index:
    by_source, by_size = defaultdict[str, list[Result]](list), defaultdict[int, list[Result]](list)
    for entry in objects_in(file):
        try:
            one = Result(**entry)
        except TypeError:  # of another version
            continue
        by_source[one.source].append(one)
        if one.sha256:
            by_size[one.size].append(one)
    return by_source, by_size


@lru_cache(maxsize=16)
def _outputs(report: Path, _: int) -> dict[str, str]:
    """Return the photos that a batch has worked on, by the names of their results."""
    return {
        Path(str(entry.get("output"))).name: str(entry.get("source"))
        for entry in objects_in(report)
        if entry.get("status") == "done"
    }


def objects_in(file: Path) -> list[dict[str, Any]]:
    """Return the objects in a file of JSON lines; damaged lines don't count."""
    found = []
    for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            entry = json.loads(line)
        except (ValueError, RecursionError):
            continue
        if isinstance(entry, dict):
            found.append(entry)
    return found


def _there(source: Path, path: Path) -> Path | None:
    """Return a photo where it was, or beside its result."""
    places = (source, path.with_name(source.name))
    return next((one for one in places if one != path and one.is_file()), None)


def _namesake(path: Path, stem: str) -> Path | None:
    """Return the photo beside a result whose name it bears."""
    same = path.with_name(stem + path.suffix)
    others = sorted(path.parent.glob(f"{glob.escape(stem)}.*"))
    photos = [one for one in (same, *others) if one.suffix.lower() in READABLE and one.is_file()]
    return photos[0] if photos else None
