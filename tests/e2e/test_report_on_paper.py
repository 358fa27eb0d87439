"""A report on A4, in a real browser: no column is lost and no scroll bar is printed."""

import base64
import re
from datetime import UTC, datetime

import pytest

from kogao_core.lab.reports.charts import Chart, Series
from kogao_core.lab.reports.report import Heading, Made, Report, Row, Table, page

# What a page of A4 has between its margins, CSS px.
_A4_PX = (688, 1017)
WIDE = Table(
    "As wide as they come",
    ("photo", "width", "height", "faces", "domain, % of image", "conventional, ms", "wdr, ms",
     "wdr / conventional", "finding, ms"),
    [["portrait-of-somebody.jpg", "4000", "3000", "1", "13.4",
      "123.4 (119.0\N{EN DASH}131.2)", "45.6 (41.0\N{EN DASH}52.1)", "0.37",
      "812.5 (799.1\N{EN DASH}850.0)"]] * 60,
)  # fmt: skip
NARROW = Table("Narrow", ("a", *"bcdef"), [["1", *["12.345"] * 5]] * 4)


@pytest.fixture(scope="module")
def printed(chromium, tmp_path_factory):
    file = tmp_path_factory.mktemp("report") / "r.html"
    chart = Chart("t", ["a", "b"], "ms", [Series("here", [1.0, 2.0])], "x", "c")
    parts = [Row([chart] * 2, wide=True), WIDE, Heading("Parts"), Row([NARROW] * 3, wide=True)]
    made = Made("a command", datetime(2026, 11, 21, tzinfo=UTC), {"cores": 2})
    file.write_text(page(Report("Title", "Lead", parts, [], {}), made))
    chromium.afresh()
    chromium.call("Emulation.setEmulatedMedia", media="print")
    chromium.resize(*_A4_PX)
    chromium.open(file.as_uri())
    return chromium


def test_every_column_is_on_the_paper(printed):
    """A cell, word or picture that reaches over the margin would be cut off."""
    assert printed.ask("document.querySelectorAll('td').length") > 9 * 50
    right = "Math.max(...[...document.querySelectorAll('main *')].map({}))"
    assert printed.ask(right.format("(one) => one.getBoundingClientRect().right")) <= _A4_PX[0]
    assert printed.ask(right.format("(one) => one.scrollWidth - one.clientWidth")) <= 0
    scrolls = "getComputedStyle(document.querySelector('.scroll')).overflowX"
    assert printed.ask(scrolls) == "visible"


def test_the_file_for_the_printer_is_a4(printed):
    data = base64.b64decode(printed.call("Page.printToPDF", preferCSSPageSize=True)["data"])
    assert data.startswith(b"%PDF")
    boxes = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", data)
    assert len(boxes) >= 2
    assert {tuple(round(float(side)) for side in box) for box in boxes} <= {(595, 842), (596, 842)}
