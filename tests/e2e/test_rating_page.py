"""The page of a rating session in a real browser: nothing is judged unseen, nothing is lost."""

import time

import pytest
from browser import Browser
from scenes import oval_face, textured_photo
from timeouts import LONGEST_S

from kogao_core.lab.study import making, plan, quality, results
from kogao_core.lab.study.server import Server
from kogao_core.lab.study.tally import tally
from kogao_core.lab.study.variants import Variant
from kogao_core.lab.subjects import Subject, at_paper_size

KINDS = (
    *(Variant("table1", float(percent), 2, 1.0) for percent in (2, 4, 6)),
    Variant("satisfaction", 4.0, 2, 1.0),
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A study of a made-up face."""
    folder = tmp_path_factory.mktemp("studies") / "faces"
    photo = Subject("a.png", textured_photo(320, 240), (oval_face(320, 240),))
    making.make([at_paper_size(photo)], folder, making.Choices(variants=KINDS, seed="s"))
    return folder


@pytest.fixture
def study(made, tmp_path):
    """A copy of it to write into."""
    copy = tmp_path / "faces"
    copy.mkdir()
    for path in made.iterdir():
        (copy / path.name).hardlink_to(path)
    plan.key_path(copy).hardlink_to(plan.key_path(made))
    return copy


@pytest.fixture
def address(study):
    server = Server(study)
    server.start()
    yield server.address
    server.stop()


@pytest.fixture
def browse(tmp_path):
    browsers = []

    def start(address, rater="synthetic", size=(1280, 1000)):
        # Of a killed one's, something may hold its profile for a moment.
        browsers.append(Browser(tmp_path / f"profile {len(browsers)}"))
        browsers[-1].resize(*size)
        browsers[-1].open(address)
        begin(browsers[-1], rater)
        return browsers[-1]

    yield start
    for browser in browsers:
        browser.kill()


def begin(browser, rater):
    browser.ask(f"document.getElementById('rater').value = '{rater}'")
    browser.ask("document.querySelector('#begin button').click()")
    browser.until("document.getElementById('start').hidden")


def place(browser):
    return browser.ask("document.getElementById('place').textContent")


def press(browser, *keys):
    """Press keys, each when the picture is on the screen, and wait until it counts."""
    for key in keys:
        seen(browser)
        before = place(browser)
        browser.press(key)
        browser.until(
            f"document.getElementById('place').textContent !== '{before}'"
            " || document.getElementById('judge').hidden"
        )


def seen(browser):
    """Wait until the picture was painted: two frames after it is laid out, as the page counts."""
    browser.until("!document.getElementById('picture').hidden")
    browser.ask("new Promise((f) => requestAnimationFrame(() => requestAnimationFrame(f)))")
    browser.ask("new Promise((f) => requestAnimationFrame(f))")
    # The page takes no answer before its least time has passed.
    browser.until(f"performance.now() > {browser.ask('performance.now()') + quality.LEAST_MS}")


def log(study):
    return results.load(study / plan.RATINGS_FOLDER / "synthetic.jsonl")


def test_a_session_by_keys_to_the_report(study, address, browse):
    page = browse(address)
    press(page, "f", "j", "Backspace", "f")
    page.press("f", 2)  # Ctrl+F answers nothing
    press(page, "j")
    assert page.ask("document.getElementById('grades').hidden") is False
    for key in ("f", "j", "Enter"):  # none of them grades, and an untouched slider is no grade
        seen(page)
        page.press(key)
    page.ask("document.getElementById('grade').focus()")
    page.press("End")
    page.ask(
        "grade.value = 57, grade.dispatchEvent(new Event('input')),"
        "document.getElementById('enter').click()"
    )
    page.until("!document.getElementById('end').hidden")
    said = [(one.answer, one.grade, one.back) for one in log(study).records]
    assert said == [
        ("natural", None, False),
        ("unnatural", None, False),
        (None, None, True),
        ("natural", None, False),
        ("unnatural", None, False),
        (None, 57, False),
    ]
    held = log(study)
    assert {one.display.shown for one in held.records if one.display} == {(960, 720)}
    assert {one.display.window for one in held.records if one.display} == {(1280, 1000)}
    found = tally([(study, plan.key_path(study))])
    assert found.grades()[0].mean == 57.0
    assert sum(share.hits for share in found.shares().values()) == 1


def test_a_killed_browser_loses_no_answer(study, address, browse):
    page = browse(address)
    press(page, "f", "j")
    page.kill()
    assert [one.answer for one in log(study).records] == ["natural", "unnatural"]
    again = browse(address)
    assert place(again) == "2 of 4"
    press(again, "f")
    assert [one.answer for one in log(study).records] == ["natural", "unnatural", "natural"]


def test_pictures_that_nobody_has_seen_cant_be_judged(study, address, browse):
    page = browse(address)
    press(page, "f")
    seen(page)
    # All in one turn of the page's script: nothing is painted in between.
    key = "document.dispatchEvent(new KeyboardEvent('keydown', {key: 'f'}));"
    page.ask(key * 3)
    page.until("document.getElementById('place').textContent === '2 of 4'")
    assert len(log(study).records) == 2
    press(page, "j")
    assert [one.answer for one in log(study).records] == ["natural", "natural", "unnatural"]


def test_an_answer_before_the_least_time_isnt_taken(study, address, browse):
    page = browse(address)
    page.ask("performance.now = ((now) => () => now() / 1000)(performance.now.bind(performance))")
    page.until("!document.getElementById('picture').hidden")
    # As early as can be, again and again until the page has shown a picture for a while.
    for _ in range(30):
        page.press("f")
        page.ask("new Promise(requestAnimationFrame)")
    assert log(study).records == ()


def test_time_in_another_tab_isnt_counted(study, address, browse):
    page = browse(address)
    seen(page)
    page.ask("document.hasFocus = () => false, dispatchEvent(new Event('blur'))")
    left = page.ask("performance.now()")
    page.until(f"performance.now() > {left + 1500}")
    page.ask("delete document.hasFocus, dispatchEvent(new Event('focus'))")
    press(page, "j")
    (record,) = log(study).records
    assert record.away_ms >= 1490
    whole = page.ask("performance.now()")
    assert quality.LEAST_MS <= record.took_ms <= whole - record.away_ms


def shown(page):
    """Width and height of the picture on the screen, CSS px; None while it is hidden."""
    return page.ask(
        "(({hidden, width, height}) => hidden ? null : [width, height])"
        "(document.getElementById('picture'))"
    )


def test_a_session_keeps_its_scale_or_waits(study, address, browse):
    page = browse(address, size=(1000, 800))
    press(page, "f")
    assert shown(page) == [720, 540]
    page.resize(1900, 1200)
    press(page, "f")
    assert shown(page) == [720, 540], "a larger window changes nothing"
    page.resize(700, 500)
    page.until("document.getElementById('picture').hidden")
    assert "larger" in page.ask("document.getElementById('trouble').textContent")
    page.press("f")
    assert len(log(study).records) == 2
    page.resize(1000, 800, ratio=2.0)
    press(page, "f")
    seen(page)
    assert shown(page) == [720, 540], "grades are asked at the same size"
    assert [(one.display.shown, one.display.ratio) for one in log(study).records] == [
        ((720, 540), 1.0),
        ((720, 540), 1.0),
        ((720, 540), 2.0),
    ]
    page.kill()
    again = browse(address, size=(1900, 1200))
    seen(again)
    assert shown(again) == [720, 540], "nor does a session that goes on tomorrow"


def test_what_is_wrong_is_said(study, address, browse):
    for path in study.glob("*.jpg"):
        path.unlink()
    page = browse(address)
    page.until("!document.getElementById('trouble').hidden")
    assert "is missing" in page.ask("document.getElementById('trouble').textContent")
    page.press("f")
    assert log(study).records == ()
    page.open(address)
    page.ask("document.getElementById('rater').removeAttribute('pattern')")
    page.ask("rater.value = '../x', document.querySelector('#begin button').click()")
    page.until("!document.getElementById('warning').hidden")


def test_the_page_from_the_disk_saves_what_the_report_reads(study, browse, tmp_path):
    page = browse((study / making.PAGE_FILE).as_uri(), "r-1")
    page.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    press(page, "f", "j")
    page.open((study / making.PAGE_FILE).as_uri())
    assert page.ask("document.querySelector('#sessions button').textContent") == "r-1: 2 of 4"
    begin(page, "r-1")
    press(page, "Backspace", "f", "f", "s")
    page.ask("document.querySelector('#end .save').click()")
    path = tmp_path / "ratings-r-1.jsonl"
    ends = time.monotonic() + LONGEST_S
    # Chromium holds the name with an empty file until the download is whole.
    while not (path.exists() and path.stat().st_size) and time.monotonic() < ends:
        page.until("true")
    held = results.load(path)
    assert held.rater == "r-1"
    kept = held.session(plan.load_study(study)).answered
    assert [one.answer for one in kept] == ["natural", "natural", "natural", None]
    assert not (study / plan.RATINGS_FOLDER).exists()


def test_the_page_hints_at_nothing_and_asks_nobody_else(address, browse):
    page = browse(address)
    seen(page)
    said = page.ask("document.documentElement.outerHTML.replace(/<script>.*<.script>/s, '')")
    for word in ("a.png", "lattice", "centre", "warp", "percent"):
        assert word not in said.replace("max-width: 100%", "")
    origin = address.rsplit("/", 2)[0]
    asked = page.ask("performance.getEntriesByType('resource').map((one) => one.name)")
    assert asked
    assert all(one.startswith((origin, "data:")) for one in asked)
    refused = page.ask("fetch('http://127.0.0.2:9/').then(() => 'reached', () => 'refused')")
    assert refused == "refused"
