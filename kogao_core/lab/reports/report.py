"""Report of an experiment: tables, charts, pictures and data.

A `Report` is saved as text, CSV, JSON or one HTML file. The HTML file makes no network requests:
pictures are data URIs, and a content security policy blocks all others.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, is_dataclass, replace
from datetime import datetime
from importlib import resources
from typing import Any, Final, TypeVar
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from kogao_core.base.display import data_uri, reduced
from kogao_core.base.geometry import Image
from kogao_core.base.language import Text, language, tr, translated
from kogao_core.base.machine import machine
from kogao_core.base.wording import columns
from kogao_core.batch.measures import table_text
from kogao_core.lab.reports.charts import Chart, element, svg
from kogao_core.recipe.recipe import SETTINGS, Recipe

NONE: Final = "\N{EN DASH}"
Item = TypeVar("Item")  # the item of a table row
# Numbers may have a sign; a dash is a missing number.
_NUMBER: Final = re.compile("[-+<>\u2212\u00b1\u2264\u2265\u00d7]?\\s?\\.?\\d|[\u2013\u2014]$")


@dataclass(frozen=True, slots=True)
class Table:
    """A table of ready text."""

    caption: str  # content, with units
    header: Sequence[str]  # names of the columns
    rows: Sequence[Sequence[str]]  # one string per column; the first names the row
    note: str = ""  # explanation below the table

    @staticmethod
    def of(
        caption: str,
        items: Iterable[Item],
        columns: Sequence[tuple[str, Callable[[Item], str]]],
        note: str = "",
    ) -> Table:
        """Return a table with a row for each item; a column is a name and a function."""
        rows = [tuple(fill(one) for _, fill in columns) for one in items]
        return Table(caption, [name for name, _ in columns], rows, note)

    @property
    def numeric(self) -> list[bool]:
        """Whether each column holds numbers, which are aligned to the right."""
        found = [all(map(_NUMBER.match, one)) for one in zip(*self.rows, strict=True)]
        return found or [False] * len(self.header)

    def __str__(self) -> str:
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
    """A heading of level 2 (section) or 3."""

    text: str
    level: int = 2


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A picture with its caption."""

    pixels: Image  # (H, W) or (H, W, 3): grey or RGB, uint8; shown reduced
    # Text below the picture, and alternative text for screen readers.
    caption: str
    alt: str


@dataclass(frozen=True, slots=True)
class Row:
    """Parts side by side, wrapped to the window; at most two per row if `wide`."""

    parts: Sequence[Part]
    wide: bool = False


# A text is a paragraph.
Part = str | Heading | Table | Chart | Picture | Row


@dataclass(frozen=True, slots=True)
class Made:
    """Origin of a report: command, time, machine, omissions."""

    command: str  # command line, or menu entry of the editor
    at: datetime  # time, with the time zone
    # Processor, cores, system and versions (`machine`).
    machine: Mapping[str, object]
    # Sentences about skipped photos and methods.
    left_out: tuple[str, ...] = ()

    @staticmethod
    def now(command: str, left_out: Sequence[str] = ()) -> Made:
        """Return the origin for a report made now on this machine."""
        return Made(command, datetime.now().astimezone(), machine(), tuple(left_out))


@dataclass(frozen=True, slots=True)
class Report:
    """Results of an experiment."""

    # Heading, and the question in one or two sentences.
    title: str
    lead: str
    parts: Sequence[Part]  # contents in order; the first is a picture or chart
    records: list[dict[str, object]]  # rows of the CSV file
    document: dict[str, object]  # content of the JSON file

    @property
    def tables(self) -> list[Table]:
        return list(_tables(self.parts))

    def text(self) -> str:
        return "\n\n".join(map(str, self.tables))

    def csv(self) -> str:
        return table_text([self.records[0], *(record.values() for record in self.records)])

    def json(self, made: Made) -> str:
        how = asdict(made) | {"at": made.at.isoformat(timespec="seconds")}
        content = {**self.document, "made": how}
        return json.dumps(content, indent=1, allow_nan=False) + "\n"


def _tables(parts: Sequence[Part]) -> Iterator[Table]:
    for part in parts:
        if isinstance(part, Table):
            yield part
        elif isinstance(part, Row):
            yield from _tables(part.parts)


def recipe_in_words(recipe: Recipe) -> Text:
    """Return the settings as text, such as "4 % towards centre 2, exact fit, ..."."""
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


def translated_report(report: Report) -> Report:
    """Return a copy of the report in the current language.

    Result: with the same records and document.
    """
    title, lead, parts = map(_said, (report.title, report.lead, report.parts))
    return replace(report, title=title, lead=lead, parts=parts)


def _said(part: Any) -> Any:
    """Translate a text, a list of texts, or all texts of a part."""
    if isinstance(part, str):
        return translated(part)
    if isinstance(part, list | tuple):
        return [_said(one) for one in part]
    if is_dataclass(part) and not isinstance(part, type):
        return replace(part, **{one.name: _said(getattr(part, one.name)) for one in fields(part)})
    return part


def files(report: Report, made: Made) -> Mapping[str, Callable[[], str]]:
    """Return a function per file type that returns the text of the file."""
    return {
        "json": lambda: report.json(made),
        "csv": report.csv,
        "html": lambda: page(report, made),
    }


def page(report: Report, made: Made) -> str:
    """Return the HTML file of a report, in the user's language."""
    report = translated_report(report)
    style = resources.files(__package__).joinpath("style.css").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    policy = f"default-src 'none'; img-src data:; style-src 'sha256-{digest}'; base-uri 'none'"
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", http_equiv="Content-Security-Policy", content=policy),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("link", rel="icon", href="data:,"),
        element("title", report.title),
        element("style", style),
    )
    parts = [*report.parts, *_how_made(made)]
    title, lead = element("h1", report.title), element("p", report.lead, class_="lead")
    body = element("body", element("main", title, lead, *map(_shown, parts)))
    whole = element("html", head, body, lang=language().replace("_", "-"))
    return f"<!doctype html>\n{ElementTree.tostring(whole, encoding='unicode', method='html')}\n"


def _shown(part: Part | Element) -> Element:
    match part:
        case str():
            return element("p", part)
        case Heading(text, level):
            return element(f"h{level}", text)
        case Table():
            return _table(part)
        case Chart():
            return _figure(svg(part), part.caption)
        case Picture():
            shown = reduced(part.pixels)
            height, width = shown.shape[:2]
            source = data_uri(shown)
            image = element("img", src=source, alt=part.alt, width=str(width), height=str(height))
            return _figure(image, part.caption)
        case Row(parts, wide):
            return element("div", *map(_shown, parts), class_="row wide" if wide else "row")
        case Element():
            return part


def _table(table: Table) -> Element:
    classes = ["number" if numeric else "" for numeric in table.numeric]
    head = element("tr", *_cells(table.header, classes, "col"))
    rows = [
        element("tr", *_cells(row[:1], classes, "row"), *_cells(row[1:], classes[1:]))
        for row in table.rows
    ]
    whole = element(
        "table", element("caption", table.caption), element("thead", head), element("tbody", *rows)
    )
    scroll = element(
        "div", whole, class_="scroll", tabindex="0", role="region", aria_label=table.caption
    )
    notes = [element("p", table.note, class_="note")] if table.note else []
    return element("div", scroll, *notes, class_="table")


def _cells(texts: Iterable[str], classes: Iterable[str], scope: str = "") -> list[Element]:
    tag = "th" if scope else "td"
    cells = zip(texts, classes, strict=False)
    return [element(tag, text, scope=scope, class_=kind) for text, kind in cells]


def _figure(content: Element, caption: str) -> Element:
    return element("figure", content, element("figcaption", caption))


def _how_made(made: Made) -> list[Part | Element]:
    rows = [(name, str(value)) for name, value in made.machine.items() if name != "packages"]
    packages = made.machine.get("packages")
    if isinstance(packages, Mapping):
        rows += [(str(name), str(version)) for name, version in packages.items()]
    when = (tr("made"), made.at.strftime("%Y-%m-%d %H:%M %Z"))
    record = Table(tr("Machine and versions"), (tr("what"), tr("value")), [when, *rows])
    left_out: list[Part | Element] = [
        Heading(tr("Left out")),
        element("ul", *(element("li", translated(sentence)) for sentence in made.left_out)),
    ]
    how: list[Part | Element] = [
        Heading(tr("How this was made")),
        element("pre", made.command),
        record,
    ]
    return left_out + how if made.left_out else how
