"""What an experiment found: tables, charts and pictures in order, and every figure as data.

Text tables, CSV, JSON and the HTML file (`page`) all follow from one `Report`.
"""

from __future__ import annotations

import json
import os
import platform
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from datetime import datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Final

from kogao_core.base.geometry import Image
from kogao_core.base.language import Text, translated
from kogao_core.base.wording import columns
from kogao_core.batch.measures import table_text
from kogao_core.lab.reports.charts import Chart
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import SETTINGS

PACKAGES: Final = (
    "kogao",
    "numpy",
    "opencv-contrib-python-headless",
    "scipy",
    "SimpleITK",
    "scikit-image",
    "facetweak",
)
NONE: Final = "\N{EN DASH}"
# A sign may stand before it; a dash stands for a number that is missing.
_NUMBER: Final = re.compile("[-+<>\u2212\u00b1\u2264\u2265\u00d7]?\\s?\\.?\\d|[\u2013\u2014]$")


@dataclass(frozen=True, slots=True)
class Table:
    """A table of ready text."""

    caption: str  # what it shows, with units
    header: Sequence[str]  # names of the columns
    rows: Sequence[Sequence[str]]  # one string a column; the first names the row
    note: str = ""  # what the reader must know to read it; shown below

    @property
    def numeric(self) -> list[bool]:
        """Whether each column holds numbers, which are aligned to the right."""
        found = [all(map(_NUMBER.match, one)) for one in zip(*self.rows, strict=True)]
        return found or [False] * len(self.header)

    def __str__(self) -> str:
        """Return the table as text in columns."""
        lines = [self.header, *self.rows]
        widths = [max(map(columns, column)) for column in zip(*lines, strict=True)]
        texts = []
        for line in lines:
            cells = zip(line, widths, self.numeric, strict=True)
            texts.append("  ".join(_padded(*cell) for cell in cells).rstrip())
        return "\n".join([self.caption, *texts, *([self.note] if self.note else [])])


def _padded(text: str, width: int, right: bool) -> str:
    space = " " * (width - columns(text))
    return space + text if right else text + space


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading; 2 opens a section, 3 a part of one."""

    text: str
    level: int = 2


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A picture with its caption."""

    pixels: Image  # (H, W) or (H, W, 3): grey or RGB, uint8; shown reduced
    # Text below it; what it shows, for those who don't see it.
    caption: str
    alt: str
    exact: bool = False  # keep the very pixels (PNG), for masks and maps; JPEG otherwise


@dataclass(frozen=True, slots=True)
class Row:
    """Parts in rows that break with the window; `wide` ones come two to a row."""

    parts: Sequence[Part]
    wide: bool = False


# A text is a paragraph.
Part = str | Heading | Table | Chart | Picture | Row


@dataclass(frozen=True, slots=True)
class Made:
    """How a report came to be."""

    command: str  # the command line, or what was chosen in the editor
    at: datetime  # when, with its time zone
    # Processor, cores, system and versions (`machine`).
    machine: Mapping[str, object]
    # What was asked for but is missing, and why: photos without a face, absent libraries.
    left_out: tuple[str, ...] = ()

    @staticmethod
    def now(command: str, left_out: Sequence[str] = ()) -> Made:
        """Return the record of a report made here and now."""
        return Made(command, datetime.now().astimezone(), machine(), tuple(left_out))

    def to_dict(self) -> dict[str, object]:
        """Return plain JSON values."""
        return {
            "command": self.command,
            "at": self.at.isoformat(timespec="seconds"),
            "machine": dict(self.machine),
            "left_out": list(self.left_out),
        }


@dataclass(frozen=True, slots=True)
class Report:
    """What an experiment found."""

    # Heading, and what was asked, in a sentence or two.
    title: str
    lead: str
    parts: Sequence[Part]  # to read and to look at, in order; the first is something to look at
    records: list[dict[str, object]]  # a flat record for each row of a table to compute with
    document: dict[str, object]  # everything as plain JSON values

    @property
    def tables(self) -> list[Table]:
        """The tables, in order."""
        return list(_tables(self.parts))

    def text(self) -> str:
        """Return the tables as text."""
        return "\n\n".join(map(str, self.tables))

    def csv(self) -> str:
        """Return the records as a CSV file."""
        return table_text([self.records[0], *(record.values() for record in self.records)])

    def json(self, made: Made) -> str:
        """Return everything as a JSON file."""
        content = {**self.document, "made": made.to_dict()}
        return json.dumps(content, indent=1, allow_nan=False) + "\n"


def _tables(parts: Sequence[Part]) -> Iterator[Table]:
    for part in parts:
        if isinstance(part, Table):
            yield part
        elif isinstance(part, Row):
            yield from _tables(part.parts)


def recipe_in_words(recipe: Recipe) -> Text:
    """Return what decides a warp, such as "4 % towards centre 2, chin 50 %, exact fit, ..."."""
    chosen = ("fit", "lattice_unit", "interpolation")
    fit, unit, interpolation = (
        SETTINGS[one].alternative(getattr(recipe, one)).word for one in chosen
    )
    return Text(
        "{amount}, {fit} fit, lattice R = {lattice:g} {unit}, {interpolation}",
        amount=recipe.amount,
        fit=fit,
        lattice=recipe.lattice,
        unit=unit,
        interpolation=interpolation,
    )


def machine() -> dict[str, object]:
    """Return processor, cores and versions, for the head of a report."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load": ", ".join(f"{one:.1f}" for one in os.getloadavg())
        if hasattr(os, "getloadavg")
        else "?",
        "system": platform.platform(),
        "python": platform.python_version(),
        "packages": {name: _version(name) for name in PACKAGES},
    }


def _processor() -> str:
    try:
        with Path("/proc/cpuinfo").open(encoding="utf-8") as stream:
            names = [line.split(":")[1].strip() for line in stream if line.startswith("model name")]
        return names[0] if names else platform.processor()
    except OSError:
        return platform.processor()


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "absent"


def translated_report(report: Report) -> Report:
    """Return a report whose texts are said in the language at work.

    Result: with the same records and document.
    """
    title, lead, parts = map(_said, (report.title, report.lead, report.parts))
    return replace(report, title=title, lead=lead, parts=parts)


def _said(part: Any) -> Any:
    """Translate a text, the texts of a list, or those of a part of a report and of its parts."""
    if isinstance(part, str):
        return translated(part)
    if isinstance(part, list | tuple):
        return [_said(one) for one in part]
    if is_dataclass(part) and not isinstance(part, type):
        return replace(part, **{one.name: _said(getattr(part, one.name)) for one in fields(part)})
    return part
