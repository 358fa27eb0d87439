"""Reports hold everything themselves, say it in accessible HTML, and let no text become markup."""

import base64
import dataclasses
import hashlib
import json
import re
from datetime import UTC, datetime
from html.parser import HTMLParser

import numpy as np
import pytest

from kogao_core.base.wording import columns
from kogao_core.lab.reports.charts import HEIGHT, WIDTH, Chart, Series, svg
from kogao_core.lab.reports.report import (
    Heading,
    Made,
    Picture,
    Report,
    Row,
    Table,
    recipe_in_words,
)
from kogao_core.lab.reports.report import page as page_of
from kogao_core.recipe.recipe import PAPER

NASTY = "<script>alert('1')</script> & \"quotes\""
MADE = Made(
    f"kogao-cli experiment {NASTY}",
    datetime(2026, 11, 21, 15, 4, tzinfo=UTC),
    {"cores": 2, "packages": {"numpy": "2.4.6"}},
    ("bad.jpg: no face",),
)


class PageReader(HTMLParser):
    """Collects elements with their attributes, and all text."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.words = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.words.append(data)

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


@pytest.fixture(scope="module")
def page():
    pixels = np.random.default_rng(3).integers(0, 256, (30, 40, 3), np.uint8)
    chart = Chart(NASTY, [NASTY], NASTY, [Series(NASTY, [1.0])], along=NASTY, caption=NASTY)
    parts = [
        Heading(NASTY),
        NASTY,
        Table(NASTY, ("a", NASTY), [("x", NASTY), ("y", "1")], NASTY),
        Row([Picture(pixels, NASTY, NASTY)]),
        chart,
    ]
    return page_of(Report(NASTY, NASTY, parts, [], {}), MADE)


def test_text_stays_text(page):
    read = PageReader(page)
    assert not read.all("script")
    assert sum(NASTY in words for words in read.words) >= 9


def test_nothing_is_asked_of_the_network(page):
    read = PageReader(page)
    for _, attributes in read.elements:
        for name in ("src", "href", "action", "srcset", "data", "poster"):
            assert attributes.get(name, "data:").startswith("data:")
    assert not re.search(r"url\(|@import", page)
    (policy,) = [m["content"] for m in read.all("meta") if "http-equiv" in m]
    style = re.search("<style>(.*)</style>", page, re.DOTALL)[1]
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    assert "default-src 'none'" in policy
    assert f"'sha256-{digest}'" in policy


def test_tables_and_pictures_speak(page):
    read = PageReader(page)
    assert read.all("html")[0]["lang"] == "en"
    assert len(read.all("table")) == len(read.all("caption"))
    assert {cell["scope"] for cell in read.all("th")} == {"col", "row"}
    assert all(image["alt"] for image in read.all("img"))
    assert all(chart["role"] == "img" and chart["aria-label"] for chart in read.all("svg"))
    assert [name for name, _ in read.elements if name in ("h1", "h2")].count("h1") == 1


def test_it_tells_how_it_was_made(page):
    words = " ".join(PageReader(page).words)
    for part in ("2026-11-21 15:04 UTC", "numpy", "2.4.6", "bad.jpg: no face", MADE.command):
        assert part in words


def test_a_table_reads_as_text():
    text = str(Table("Caption", ("name", "ms"), [("first", "1.5"), ("second", "12.25")], "Note."))
    assert text == "Caption\nname       ms\nfirst     1.5\nsecond  12.25\nNote."


def test_figures_stand_in_one_column_beside_wide_letters():
    text = str(Table("表", ("手法", "設定、ms"), [("従来手法", "1.5"), ("Wdr", "12.25")]))
    lines = text.split("\n")[1:]
    assert lines == ["手法      設定、ms", "従来手法       1.5", "Wdr          12.25"]
    assert {columns(line) for line in lines} == {18}


def test_a_chart_keeps_inside_and_leaves_gaps():
    curve = [0.0, 3.0, float("nan"), 7.3, float("inf"), 2.0]
    drawn = svg(Chart("t", [str(k) for k in range(6)], "y", [Series("one", curve)], "x", "c"))
    placed = [(float(c.get("cx")), float(c.get("cy"))) for c in drawn.iter("circle")]
    assert len(placed) == 4 + 2  # and the key's two
    assert all(0 <= x <= WIDTH and 0 <= y <= HEIGHT + 20 for x, y in placed)
    low, high = placed[0][1], placed[2][1]
    assert high < placed[1][1] < low  # larger is higher up


def test_lines_differ_by_more_than_colour():
    drawn = svg(
        Chart("t", ["a", "b"], "y", [Series(str(k), [1.0, 2.0]) for k in range(4)], "x", "c")
    )
    looks = [n.get("stroke-dasharray") for n in drawn.iter() if n.get("class", "").startswith("l")]
    assert len(set(looks)) == 4


def test_intervals_are_error_bars_round_their_values():
    series = [Series(name, [2.0, 5.0], [(1.0, 4.0), (4.5, 9.0)]) for name in ("one", "two")]
    drawn = svg(Chart("t", ["a", "b"], "y", series, "x", "c"))
    bars = [n.get("d") for n in drawn.iter() if n.get("class", "").startswith("whisker")]
    assert len(bars) == 4
    assert len(set(bars)) == 4, "those of one place lie beside each other"


def test_what_a_chart_shows_can_be_heard():
    drawn = svg(Chart("Speed", ["a", "b"], "ms", [Series("here", [1.5, float("nan")])], "x", "c"))
    assert drawn.get("aria-label") == "Speed. here: a 1.50"


def test_a_report_is_text_records_and_data():
    table = Table("Caption", ("name", "ms"), [("first", "1.5")])
    report = Report("t", "l", ["words", Row([table]), table], [{"a": 1, "b": None}], {"c": 2})
    assert report.text() == "\n\n".join([str(table)] * 2)
    assert report.csv() == "a,b\n1,\n"
    how = dataclasses.asdict(MADE) | {
        "at": "2026-11-21T15:04:00+00:00",
        "left_out": list(MADE.left_out),
    }
    assert json.loads(report.json(MADE)) == {"c": 2, "made": how}


def test_a_recipe_in_words_tells_all_that_decides_where_a_face_goes():
    plain = recipe_in_words(PAPER)
    assert plain.startswith("4 % towards centre 2, face only, approximation fit, lattice R = 1")
    others = {"chin_length": 5.0, "even_out": 30.0, "scope": "head"}
    for name, value in others.items():
        assert recipe_in_words(dataclasses.replace(PAPER, **{name: value})) != plain
