"""The page of a rating session in a real browser: nothing is judged unseen, nothing is lost."""

import contextlib
import time

import pytest
from scenes import oval_face, textured_photo
from timeouts import LONGEST_S

from kogao_core.lab.study import making, plan, results
from kogao_core.lab.study import page as pages
from kogao_core.lab.study.design import Conduct, Rules, Variant
from kogao_core.lab.study.server import Server
from kogao_core.lab.study.tally import tally
from kogao_core.lab.subjects import Subject, at_paper_size

KINDS = (
    *(Variant("table1", float(percent), 2, 1.0) for percent in (2, 4, 6)),
    Variant("satisfaction", 4.0, 2, 1.0),
)
LEAST_MS = 30  # after which the page takes an answer; 200 in a study


@pytest.fixture(autouse=True, scope="module")
def quick():
    """Let raters answer sooner than in a study."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pages, "LEAST_MS", LEAST_MS)
        yield


def make(folder, **choices):
    """Make a study of a made-up face."""
    face = at_paper_size(Subject("a.png", textured_photo(320, 240), (oval_face(320, 240),)))
    choices = making.Choices(rules=Rules(least_ms=LEAST_MS), **choices)
    making.make([face], folder, choices, other=face)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studies") / "faces"
    make(folder, variants=KINDS, seed="s")
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
def browse(chromium):
    def start(address, rater="synthetic", size=(1280, 1000)):
        chromium.afresh()
        chromium.resize(*size)
        chromium.open(address)
        if rater is not None:
            begin(chromium, rater)
        return chromium

    return start


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
        with counts(browser):
            browser.press(key)


@contextlib.contextmanager
def counts(browser):
    """Wait until an answer given here counts."""
    before = place(browser)
    yield
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
    browser.until(f"performance.now() > {browser.ask('performance.now()') + LEAST_MS}")


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


def test_a_lost_browser_loses_no_answer(study, address, browse):
    press(browse(address), "f", "j")
    assert [one.answer for one in log(study).records] == ["natural", "unnatural"]
    again = browse(address)
    assert place(again) == "2 of 4"
    press(again, "f")
    assert [one.answer for one in log(study).records] == ["natural", "unnatural", "natural"]


def test_pictures_that_nobody_has_seen_cant_be_judged(study, address, browse):
    page = browse(address)
    # Each picture gets an answer in the same turn of the script that lays it out, before painting.
    key = "document.dispatchEvent(new KeyboardEvent('keydown', {key: 'f'}))"
    page.ask(f"new MutationObserver(() => {key}).observe(picture, {{attributes: true}})")
    press(page, "f", "j")
    assert [one.answer for one in log(study).records] == ["natural", "unnatural"]


def test_an_answer_before_the_least_time_isnt_taken(study, address, browse):
    page = browse(address, None)
    page.ask("performance.now = ((now) => () => now() / 1000)(performance.now.bind(performance))")
    page.ask(
        "requestAnimationFrame = ((paint) => (act) => paint(() => act(performance.now())))"
        "(requestAnimationFrame), null"
    )
    begin(page, "synthetic")
    page.until("!document.getElementById('picture').hidden")
    # As early as can be, again and again until the page has shown a picture for a while.
    for _ in range(30):
        page.press("f")
        page.ask("new Promise(requestAnimationFrame)")
    assert log(study).records == ()


def test_time_in_another_tab_isnt_counted(study, address, browse):
    page = browse(address, None)
    began = page.ask("performance.now()")
    begin(page, "synthetic")
    seen(page)
    page.ask("document.hasFocus = () => false, dispatchEvent(new Event('blur'))")
    left = page.ask("performance.now()")
    page.until(f"performance.now() > {left + 500}")
    page.ask("delete document.hasFocus, dispatchEvent(new Event('focus'))")
    press(page, "j")
    (record,) = log(study).records
    assert record.away_ms >= 490
    assert LEAST_MS <= record.took_ms <= page.ask("performance.now()") - began - record.away_ms


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
    assert page.ask("document.getElementById('rater').value") == "r-1"
    begin(page, "r-1")
    assert place(page) == "2 of 4"
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


@pytest.mark.parametrize("served", [True, False])
def test_withdrawn_answers_are_deleted_and_the_debriefing_is_shown(study, address, browse, served):
    page = browse(address if served else (study / making.PAGE_FILE).as_uri())
    press(page, "f")
    page.ask("window.confirm = () => false")
    page.ask("document.querySelector('#foot .withdraw').click()")
    press(page, "j")
    page.ask("window.confirm = () => true")
    page.ask("document.querySelector('#foot .withdraw').click()")
    page.until("!document.getElementById('end').hidden")
    assert "Your answers have been deleted." in page.ask("document.body.innerText")
    assert page.ask("document.querySelectorAll('#end button').length") == 0
    assert page.ask("Object.keys(localStorage).filter((k) => k.includes('ratings')).length") == 0
    assert not list((study / plan.RATINGS_FOLDER).glob("*"))
    page.press("Backspace")
    assert "Your answers have been deleted." in page.ask("document.body.innerText")


# ---- how a session is held ------------------------------------------------------------------


@pytest.fixture
def held(tmp_path, browse):
    """Serve a study that is held in some way, and open its page."""
    servers = []

    def start(window=(1366, 768), query="", practice=0, **conduct):
        folder = tmp_path / "held"
        variants = (*KINDS[:3], Variant("control", 0.0, 2, 1.0))
        make(folder, variants=variants, practice=practice, conduct=Conduct(**conduct))
        servers.append(Server(folder))
        servers[-1].start()
        return browse(servers[-1].address + query, None, window), folder

    yield start
    for server in servers:
        server.stop()


def click(page, selector):
    """Click as a hand would: what needs a gesture has one."""
    x, y = page.ask(
        f"(({{x, y, width, height}}) => [x + width / 2, y + height / 2])"
        f"(document.querySelector('{selector}').getBoundingClientRect())"
    )
    for kind in ("mousePressed", "mouseReleased"):
        page.call(
            "Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1
        )  # fmt: skip


def test_a_screen_that_is_too_small_is_refused_with_the_reason(held):
    page, folder = held((390, 844), size="640px")
    page.call(
        "Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=3.0,
        mobile=True, screenWidth=390, screenHeight=844,
    )  # fmt: skip
    click(page, "#begin button")
    page.until("!document.getElementById('trouble').hidden")
    said = page.ask("document.getElementById('problem').textContent")
    assert said.startswith(
        "This screen is too small for this study: the pictures need 640 \N{MULTIPLICATION SIGN} 480"
    )
    assert "390 \N{MULTIPLICATION SIGN} 844" in said
    page.press("f")
    (path,) = (folder / plan.RATINGS_FOLDER).iterdir()
    assert results.load(path).records == ()


def test_without_the_full_screen_nothing_is_judged(held):
    page, folder = held(full_screen=True, size="640px")
    click(page, "#begin button")
    page.until("document.fullscreenElement")
    press(page, "f")
    page.ask("document.exitFullscreen()")
    page.until("!document.fullscreenElement && document.getElementById('picture').hidden")
    page.press("f")
    assert "needs the full screen" in page.ask("document.getElementById('problem').textContent")
    click(page, "#full")
    page.until("document.fullscreenElement")
    press(page, "j")
    (path,) = (folder / plan.RATINGS_FOLDER).iterdir()
    assert [one.answer for one in results.load(path).records] == ["natural", "unnatural"]


def test_a_session_from_consent_to_its_code_for_whoever_pays(held):
    page, folder = held(
        query="?PROLIFIC_PID=5F3A&number=1", practice=1, swap_keys=True, break_every=2,
        consent="You may stop.\n\nAt any time.", instructions="Look well.",
        debriefing="It was about chins.", completion_code="ABC-1",
    )  # fmt: skip
    text = page.ask("document.body.innerText")
    assert "You may stop.\n\nAt any time." in text
    assert "Look well." in text
    assert "ABC-1" not in text
    click(page, "#begin button")
    page.ask("new Promise(requestAnimationFrame)")
    assert not page.ask("document.getElementById('start').hidden"), "nobody has agreed yet"
    click(page, "#agree")
    click(page, "#begin button")
    page.until("!document.getElementById('judge').hidden")
    assert place(page) == "Practice 0 of 1"
    path = folder / plan.RATINGS_FOLDER / "5f3a.jsonl"
    seen(page)
    page.press("j")  # natural, for this rater
    page.until("!document.getElementById('pause').hidden")
    assert "now the study begins" in page.ask("document.getElementById('paused').textContent")
    click(page, "#resume")
    press(page, "j")
    seen(page)
    page.press("f")
    page.until("!document.getElementById('pause').hidden")
    assert page.ask("document.getElementById('paused').textContent") == "A break"
    page.press("Enter")
    page.until("!document.getElementById('judge').hidden")
    press(page, "f", "f")
    page.until("!document.getElementById('end').hidden")
    said = page.ask("document.getElementById('end').innerText")
    assert "It was about chins." in said
    assert "Your completion code: ABC-1" in said
    logged = results.load(path)
    assert logged.keys == "jf"
    found = [one.answer for one in logged.records]
    assert found == ["natural", "natural", "unnatural", "unnatural", "unnatural"]
    counted = tally([(folder, plan.key_path(folder))])
    assert [row.place for row in counted.answers] == [2, 3, 4, 5], "practice isn't counted"
    assert counted.subjects == 1
