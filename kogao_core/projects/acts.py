"""Settings applied to many photos as one act: undone, redone, or finished after a kill."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from sqlite3 import Connection
from typing import Any, Final

from kogao_core.base.index import Index, IndexTable, path_key

_MOST: Final = 50  # acts in the index
_BEGUN: Final = 2  # added to `applied` while the edits of a photo are written


@dataclass(frozen=True, slots=True)
class ActPhoto:
    """One photo of an act."""

    act: int
    path: Path
    wrote: str  # SHA-256 of the edits that the act wrote last, or is about to write; "" before
    applied: bool  # whether the settings are in the edits; if begun: will be
    is_begun: bool  # whether the program ended while it wrote the edits
    wanted: bool  # whether the settings are to be applied, or undone
    settings: Mapping[str, Any]  # fields of a recipe by name
    before: bytes  # if begun: the project before the edits were written


@dataclass(frozen=True, slots=True)
class Acts:
    """The acts in the index of a data folder. Each belongs to an undo step of an open photo."""

    folder: Path

    @property
    def _index(self) -> Index:
        return Index(self.folder)

    def begin(
        self,
        source: Path,
        step: int,
        text: str,
        settings: Mapping[str, Any],
        photos: Iterable[Path],
    ) -> int:
        """Add an act that belongs to undo step `step` of `source`; return the number of the act."""
        act, fields = time.time_ns(), json.dumps(settings)
        start = act, path_key(source), step, text, fields
        rows = [(*start, path_key(photo), "", 0, 1, b"") for photo in photos]

        def change(db: Connection) -> None:
            db.execute("DELETE FROM acts WHERE source = ? AND step >= ?", (path_key(source), step))
            newest = "SELECT DISTINCT act FROM acts ORDER BY act DESC LIMIT ?"
            db.execute(f"DELETE FROM acts WHERE act NOT IN ({newest})", (_MOST,))
            db.executemany(TABLE.insert(), rows)

        self._index.run(TABLE, change, writes=True)
        return act

    def of(self, source: Path) -> dict[tuple[int, str], int]:
        """Return the acts of a photo by index and text of their undo steps."""
        sql = "SELECT DISTINCT step, text, act FROM acts WHERE source = ?"
        return {(step, text): act for step, text, act in self._rows(sql, path_key(source))}

    def turn(self, act: int, wanted: bool) -> list[ActPhoto]:
        """Return the photos of an act that are to be changed so that it is applied, or undone."""
        self._index.change(TABLE, "UPDATE acts SET wanted = ? WHERE act = ?", wanted, act)
        sql = (
            "SELECT photo, wrote, applied, settings, before FROM acts "
            "WHERE act = ? AND applied != wanted ORDER BY rowid"
        )
        return [
            ActPhoto(act, Path(os.fsdecode(photo)), wrote, bool(applied % _BEGUN),
                     applied >= _BEGUN, wanted, json.loads(settings), before)
            for photo, wrote, applied, settings, before in self._rows(sql, act)
        ]  # fmt: skip

    def note(self, photo: ActPhoto, wrote: str, before: bytes = b"") -> None:
        """Record what was written; with `before`, what is about to be."""
        sql = "UPDATE acts SET wrote = ?, applied = ?, before = ? WHERE act = ? AND photo = ?"
        state = photo.wanted + _BEGUN * bool(before)
        self._index.change(TABLE, sql, wrote, state, before, photo.act, path_key(photo.path))

    def drop(self, photo: ActPhoto) -> None:
        sql = "DELETE FROM acts WHERE act = ? AND photo = ?"
        self._index.change(TABLE, sql, photo.act, path_key(photo.path))

    def leave(self, act: int) -> None:
        """End an act as it is; photos that were not changed leave it."""
        self._index.change(TABLE, "DELETE FROM acts WHERE act = ? AND wrote = ''", act)
        sql = "UPDATE acts SET applied = applied % ?, wanted = applied % ? WHERE act = ?"
        self._index.change(TABLE, sql, _BEGUN, _BEGUN, act)

    def unfinished(self) -> tuple[int, bool, int, int] | None:
        """Return the newest act that a program left in the middle.

        Result: number of the act, whether it was to be applied, changed photos, all photos.
        """
        sql = (
            "SELECT act, wanted, SUM(applied = wanted), COUNT(*) FROM acts GROUP BY act "
            "HAVING SUM(applied != wanted) ORDER BY act DESC LIMIT 1"
        )
        return next(iter(self._rows(sql)), None)

    def forget(self, photo: Path) -> int:
        """Delete what the acts have about a photo; return the number of rows."""
        sql = "DELETE FROM acts WHERE source = ?1 OR photo = ?1"
        return self._index.change(TABLE, sql, path_key(photo))

    def _rows(self, sql: str, *values: object) -> list[tuple[Any, ...]]:
        return self._index.rows(TABLE, sql, *values)


TABLE: Final = IndexTable(
    "acts",
    (
        *("act", "source", "step", "text", "settings", "photo", "wrote", "applied", "wanted"),
        "before",
        "PRIMARY KEY (act, photo)",
    ),
    ("source", "photo"),
)
