"""A report as one HTML file: charts, pictures, tables, and how it was made.

The file asks nothing of the network: pictures are data URIs, and a content security policy
forbids the rest.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Callable, Iterable, Mapping
from importlib import resources
from xml.etree.ElementTree import Element

from kogao_core.base.display import data_uri, reduced
from kogao_core.base.language import language, tr, translated
from kogao_core.lab.reports.charts import Chart, svg
from kogao_core.lab.reports.markup import element, html
from kogao_core.lab.reports.report import (
    Heading,
    Made,
    Part,
    Picture,
    Report,
    Row,
    Table,
    translated_report,
)


def files(report: Report, made: Made) -> Mapping[str, Callable[[], str]]:
    """Return what makes the text of each kind of file."""
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
    return (
        "<!doctype html>\n"
        + html(element("html", head, body, lang=language().replace("_", "-")))
        + "\n"
    )


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
            source = data_uri(shown, exact=part.exact)
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
