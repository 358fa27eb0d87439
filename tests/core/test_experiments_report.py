"""Reports hold everything themselves, say it in accessible HTML, and let no text become markup."""

import base64
import hashlib
import re
from datetime import UTC, datetime
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest

from kogao_core.experiments import report
from kogao_core.experiments.charts import HEIGHT, WIDTH, Axis, Line, line_chart
from kogao_core.experiments.report import Made, Table
from kogao_core.experiments.style import STYLE

NASTY = "<script>alert('1')</script> & \"quotes\""
MADE = Made(
    f"kogao-cli experiment {NASTY}",
    datetime(2026, 11, 21, 15, 4, tzinfo=UTC),
    {"cores": 2, "packages": {"numpy": "2.4.6"}},
    ("bad.jpg: no face",),
)


class Reader(HTMLParser):
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
    blocks = [
        report.heading(NASTY),
        report.paragraph(NASTY),
        report.listing([NASTY]),
        report.table(Table(NASTY, ("a", NASTY), [("x", NASTY), ("y", "1")], NASTY)),
        report.side_by_side([report.picture(pixels, NASTY, alt=NASTY)]),
        report.chart(line_chart(NASTY, Axis(NASTY, [NASTY]), NASTY, [Line(NASTY, [1.0])]), NASTY),
    ]
    return report.page(NASTY, NASTY, blocks, MADE)


def test_text_stays_text(page):
    read = Reader(page)
    assert not read.all("script")
    assert sum(NASTY in words for words in read.words) >= 12


def test_nothing_is_asked_of_the_network(page):
    read = Reader(page)
    for _, attributes in read.elements:
        for name in ("src", "href", "action", "srcset", "data", "poster"):
            assert attributes.get(name, "data:").startswith("data:")
    assert not re.search(r"url\(|@import", page)
    (policy,) = [m["content"] for m in read.all("meta") if "http-equiv" in m]
    digest = base64.b64encode(hashlib.sha256(STYLE.encode()).digest()).decode()
    assert "default-src 'none'" in policy
    assert f"'sha256-{digest}'" in policy
    assert f"<style>{STYLE}</style>" in page


def test_tables_and_pictures_speak(page):
    read = Reader(page)
    assert read.all("html")[0]["lang"] == "en"
    assert len(read.all("table")) == len(read.all("caption"))
    assert {cell["scope"] for cell in read.all("th")} == {"col", "row"}
    assert all(image["alt"] for image in read.all("img"))
    assert all(chart["role"] == "img" and chart["aria-label"] for chart in read.all("svg"))
    assert [name for name, _ in read.elements if name in ("h1", "h2")].count("h1") == 1


def test_it_tells_how_it_was_made(page):
    words = " ".join(Reader(page).words)
    for part in ("2026-11-21 15:04 UTC", "numpy", "2.4.6", "bad.jpg: no face", MADE.command):
        assert part in words


def test_exact_pictures_keep_their_pixels():
    import cv2

    mask = np.random.default_rng(4).integers(0, 2, (50, 70)).astype(np.uint8) * 255
    source = Reader(report.picture(mask, "m", alt="m", exact=True)).all("img")[0]["src"]
    data = np.frombuffer(base64.b64decode(source.split(",")[1]), np.uint8)
    np.testing.assert_array_equal(cv2.imdecode(data, cv2.IMREAD_GRAYSCALE), mask)


def test_a_table_reads_as_text():
    text = str(Table("Caption", ("name", "ms"), [("first", "1.5"), ("second", "12.25")], "Note."))
    assert text == "Caption\nname       ms\nfirst     1.5\nsecond  12.25\nNote."


def test_a_chart_keeps_inside_and_leaves_gaps():
    curve = [0.0, 3.0, float("nan"), 7.3, float("inf"), 2.0]
    ticks = [str(k) for k in range(6)]
    svg = ElementTree.fromstring(line_chart("t", Axis("x", ticks), "y", [Line("one", curve)]))
    circles = [node for node in svg.iter() if node.tag.endswith("circle")]
    placed = [(float(c.get("cx")), float(c.get("cy"))) for c in circles]
    assert len(placed) == 4 + 2  # and the key's two
    assert all(0 <= x <= WIDTH and 0 <= y <= HEIGHT + 20 for x, y in placed)
    low, high = placed[0][1], placed[2][1]
    assert high < placed[1][1] < low  # larger is higher up


def test_lines_differ_by_more_than_colour():
    lines = [Line(str(k), [1.0, 2.0]) for k in range(4)]
    svg = ElementTree.fromstring(line_chart("t", Axis("x", ["a", "b"]), "y", lines))
    looks = [n.get("stroke-dasharray") for n in svg.iter() if n.get("class", "").startswith("line")]
    assert len(set(looks)) == 4
