"""The rating page from the disk, in a real browser: no blind judgements, no lost answers."""

import dataclasses
import time
from contextlib import closing

import pytest
from browser import Browser
from scenes import oval_face, textured_photo
from timeouts import LONGEST_S

from kogao_core.lab.study import design, making, plan, results
from kogao_core.lab.study import page as pages
from kogao_core.lab.study.design import Conduct, Variant
from kogao_core.lab.study.tally import tally
from kogao_core.lab.subjects import Subject, at_paper_size

KINDS = (
    *(Variant("table1", float(percent), 2, 1.0) for percent in (2, 4, 6)),
    Variant("satisfaction", 4.0, 2, 1.0),
)
# A clock ahead of the frames, so that tests needn't wait for the page's least time.
AHEAD = f"""
const time = performance.now.bind(performance);
performance.now = () => time() + {design.LEAST_MS};
"""
NO_STORAGE = "Object.defineProperty(window, 'localStorage', { get() { throw new Error() } })"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A study of a made-up face, with a practice picture."""
    folder = tmp_path_factory.mktemp("studies") / "faces"
    photo = Subject("a.png", textured_photo(320, 240), (oval_face(320, 240),))
    face = at_paper_size(photo)
    making.make([face], folder, making.Choices(variants=KINDS, seed="s", practice=1), other=face)
    return folder


@pytest.fixture
def folder(made, tmp_path):
    """A copy of the study to write into."""
    copy = tmp_path / "faces"
    copy.mkdir()
    for path in made.iterdir():
        (copy / path.name).hardlink_to(path)
    plan.key_path(copy).hardlink_to(plan.key_path(made))
    return copy


@pytest.fixture
def browse(chromium, folder):
    """Open the page of the study, and begin a session of a rater."""

    def start(
        rater="synthetic", window=(1280, 1000), query="", *, practice=False, script=AHEAD, **conduct
    ):
        study = plan.load_study(folder)
        shown = study.practice if practice else ()
        study = dataclasses.replace(study, practice=shown, conduct=Conduct(**conduct))
        path = folder / making.PAGE_FILE
        path.unlink()
        path.write_text(pages.page(study, folder), encoding="utf-8")
        chromium.afresh()
        chromium.resize(*window)
        chromium.call("Page.addScriptToEvaluateOnNewDocument", source=script)
        chromium.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(folder))
        chromium.open(path.as_uri() + query)
        if rater is not None:
            begin(chromium, rater)
        return chromium

    return start


def begin(page, rater="synthetic"):
    page.ask(f"document.getElementById('rater').value = '{rater}'")
    page.ask("document.querySelector('#begin button').click()")
    page.until("document.getElementById('start').hidden")


def text(page, part):
    return page.ask(f"document.getElementById('{part}').innerText")


def is_hidden(page, part):
    return page.ask(f"document.getElementById('{part}').hidden")


def press(page, *keys):
    """Press keys, each after its picture was painted, and wait until each counts."""
    for key in keys:
        seen(page)
        before = text(page, "place")
        page.press(key)
        page.until(
            f"document.getElementById('place').textContent !== '{before}'"
            " || document.getElementById('judge').hidden"
        )


def seen(page):
    """Wait until the picture was painted: two frames after its layout, as the page counts."""
    page.until("!document.getElementById('picture').hidden")
    page.ask("new Promise((f) => requestAnimationFrame(() => requestAnimationFrame(f)))")
    page.ask("new Promise((f) => requestAnimationFrame(f))")


def click(page, selector):
    """Click with the mouse, for actions that need a user's gesture."""
    x, y = page.ask(
        f"(({{x, y, width, height}}) => [x + width / 2, y + height / 2])"
        f"(document.querySelector('{selector}').getBoundingClientRect())"
    )
    for kind in ("mousePressed", "mouseReleased"):
        page.call(
            "Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1
        )  # fmt: skip


def records(page, folder, rater="synthetic"):
    """Return the records that the browser stores."""
    stored = page.ask(f"stored('{rater}') && file(stored('{rater}'))")
    if stored is None:
        return ()
    path = folder.parent / "stored.jsonl"
    path.write_text(stored)
    return results.load(path).records


def answers(page, folder, rater="synthetic"):
    return [one.answer for one in records(page, folder, rater)]


def asks(page):
    """Whether the browser asks before the page is left."""
    return page.ask("!dispatchEvent(new Event('beforeunload', { cancelable: true }))")


def test_a_session_from_consent_to_the_report(folder, browse):
    page = browse(
        None, query="?PROLIFIC_PID=5F3A&number=1", practice=True, swap_keys=True, break_every=2,
        consent="You may stop.\n\nAt any time.", instructions="Look well.",
        debriefing="It was about chins.", completion_code="ABC-1",
    )  # fmt: skip
    said = page.ask("document.body.innerText")
    assert "You may stop.\n\nAt any time." in said
    assert "Look well." in said
    assert "ABC-1" not in said
    click(page, "#begin button")
    page.ask("new Promise(requestAnimationFrame)")
    assert not is_hidden(page, "start"), "the rater hasn't agreed"
    click(page, "#agree")
    click(page, "#begin button")
    assert text(page, "place") == "Practice 0 of 1"
    assert not asks(page)
    press(page, "j")  # natural, for this rater
    assert "now the study begins" in text(page, "paused")
    click(page, "#resume")
    press(page, "f", "Backspace", "j")
    page.press("f", 2)  # Ctrl+F is no answer
    press(page, "f")
    assert text(page, "paused") == "A break"
    page.press("Enter")
    press(page, "f")
    assert not is_hidden(page, "grades")
    for key in ("f", "j", "Enter"):  # no grades: the slider wasn't moved
        seen(page)
        page.press(key)
    page.ask("document.getElementById('grade').focus()")
    page.press("End")
    page.ask(
        "grade.value = 57, grade.dispatchEvent(new Event('input')),"
        "document.getElementById('enter').click()"
    )
    assert "It was about chins." in text(page, "end")
    assert "Your completion code: ABC-1" in text(page, "end")
    assert asks(page), "the answers aren't saved"
    click(page, "#end .save")
    path, ends = folder / "ratings-5f3a.jsonl", time.monotonic() + LONGEST_S
    # Chromium creates an empty file before the download is complete.
    while not (path.exists() and path.stat().st_size) and time.monotonic() < ends:
        page.until("true")
    assert not asks(page)
    saved = results.load(path)
    assert (saved.rater, saved.keys) == ("5f3a", "jf")
    assert [(one.answer, one.grade, one.back) for one in saved.records] == [
        ("natural", None, False),
        ("unnatural", None, False),
        (None, None, True),
        ("natural", None, False),
        ("unnatural", None, False),
        ("unnatural", None, False),
        (None, 57, False),
    ]
    assert {one.display.shown for one in saved.records if one.display} == {(960, 720)}
    assert {one.display.window for one in saved.records if one.display} == {(1280, 1000)}
    found = tally([(folder, plan.key_path(folder))])
    assert [row.place for row in found.counted] == [2, 3, 4, 5], "practice isn't counted"
    assert found.grades()[0].mean == 57.0
    assert sum(share.hits for share in found.shares().values()) == 2


def test_a_session_goes_on_after_its_browser_was_closed(folder, tmp_path):
    def started():
        page = Browser(tmp_path / "profile", kept=True)
        page.call("Page.addScriptToEvaluateOnNewDocument", source=AHEAD)
        page.open((folder / making.PAGE_FILE).as_uri())
        begin(page)
        return page

    with closing(started()) as page:
        assert text(page, "place") == "Practice 0 of 1"
        press(page, "f")
    with closing(started()) as page:
        assert text(page, "place") == "0 of 4"


def test_a_page_that_is_loaded_again_continues_the_session(folder, browse):
    page = browse()
    press(page, "f")
    page.ask("document.querySelector('#foot .save').click()")  # or the browser asks
    page.open((folder / making.PAGE_FILE).as_uri())
    assert page.ask("document.getElementById('rater').value") == "synthetic"
    begin(page)
    assert text(page, "place") == "1 of 4"


def test_pictures_that_werent_painted_cant_be_judged(folder, browse):
    page = browse()
    seen(page)
    # All in one turn of the page's script: nothing is painted in between.
    page.ask("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'f'}));" * 3)
    assert answers(page, folder) == ["natural"]
    press(page, "j")
    assert answers(page, folder) == ["natural", "unnatural"]
    # Another tab undoes the last answer and gives another answer.
    page.ask("""
        other = stored("synthetic");
        last = other.records[1];
        other.records.push({ n: 3, picture: last.picture, back: true });
        other.records.push({ ...last, n: 4, answer: "natural" });
        store("synthetic", other);
    """)
    seen(page)
    page.press("f")
    seen(page)
    assert "continued in another window" in text(page, "problem"), "although the picture is shown"
    assert answers(page, folder) == ["natural", "unnatural", None, "natural"]


# A clock that the test sets; the picture is painted at 1,000 ms.
SET_CLOCK = """
performance.now = () => 1000;
requestAnimationFrame = ((frame) => (act) => frame(() => act(1000)))(requestAnimationFrame);
"""


def set_clock(page, ms):
    page.ask(f"performance.now = () => {ms}")


def test_times_of_answers(folder, browse):
    page = browse(script=SET_CLOCK)
    seen(page)
    set_clock(page, 1000 + design.LEAST_MS - 1)
    page.press("f")
    assert records(page, folder) == ()
    set_clock(page, 1300)
    page.ask("document.hasFocus = () => false, dispatchEvent(new Event('blur'))")
    set_clock(page, 2800)
    page.ask("delete document.hasFocus, dispatchEvent(new Event('focus'))")
    set_clock(page, 2500 + design.LEAST_MS)
    page.press("j")
    (record,) = records(page, folder)
    assert (record.took_ms, record.away_ms) == (design.LEAST_MS, 1500)


def shown(page):
    """Return width and height of the picture on the screen, CSS px."""
    return page.ask("(({width, height}) => [width, height])(document.getElementById('picture'))")


def test_a_session_keeps_its_scale_or_waits(folder, browse):
    page = browse(window=(1100, 800))
    press(page, "f")
    page.resize(1900, 1200)
    press(page, "f")
    page.resize(700, 500)
    page.until("!document.getElementById('trouble').hidden")
    assert "larger" in text(page, "problem")
    page.press("f")
    page.resize(1100, 800, ratio=2.0)
    press(page, "f")
    seen(page)
    assert shown(page) == [720, 540], "grades are asked at the same size"
    assert [(one.display.shown, one.display.ratio) for one in records(page, folder)] == [
        ((720, 540), 1.0),
        ((720, 540), 1.0),
        ((720, 540), 2.0),
    ]
    page.resize(1900, 1200)
    begin(page)
    seen(page)
    assert shown(page) == [720, 540], "a continued session, too"


def test_a_screen_that_is_too_small_is_refused_with_the_reason(browse):
    page = browse(None, size="640px")
    page.call(
        "Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=3.0,
        mobile=True, screenWidth=390, screenHeight=844,
    )  # fmt: skip
    begin(page)
    page.until("!document.getElementById('trouble').hidden")
    assert text(page, "problem").startswith(
        "This screen is too small for this study: the pictures need 640 \N{MULTIPLICATION SIGN} 480"
    )
    assert "390 \N{MULTIPLICATION SIGN} 844" in text(page, "problem")
    page.press("f")
    assert not asks(page)


def test_without_the_full_screen_nothing_is_judged(folder, browse):
    page = browse(None, (1366, 768), full_screen=True)
    page.ask("document.getElementById('rater').value = 'synthetic'")
    click(page, "#begin button")
    page.until("document.fullscreenElement")
    press(page, "f")
    page.ask("document.exitFullscreen()")
    page.until("!document.getElementById('trouble').hidden")
    page.press("f")
    assert "needs the full screen" in text(page, "problem")
    click(page, "#full")
    page.until("document.fullscreenElement")
    press(page, "j")
    assert answers(page, folder) == ["natural", "unnatural"]


def test_a_missing_picture_is_named(folder, browse):
    for path in folder.glob("*.jpg"):
        path.unlink()
    page = browse()
    page.until("!document.getElementById('trouble').hidden")
    assert "is missing" in text(page, "problem")
    page.press("f")
    assert records(page, folder) == ()


def test_a_code_in_the_address_that_no_report_reads_is_refused(browse):
    page = browse(None, query="?rater=A_1")
    click(page, "#begin button")
    page.ask("new Promise(requestAnimationFrame)")
    assert not is_hidden(page, "start")
    begin(page, "a-1")


@pytest.mark.parametrize("script", [AHEAD, f"{AHEAD}; {NO_STORAGE}"], ids=["", "no storage"])
def test_withdrawn_answers_are_deleted_and_the_debriefing_is_shown(browse, script):
    page = browse(None, script=script, debriefing="It was about chins.", completion_code="ABC-1")
    assert is_hidden(page, "warning") == (script == AHEAD)
    begin(page)
    press(page, "f")
    page.ask("window.confirm = () => false")
    page.ask("document.querySelector('#foot .withdraw').click()")
    press(page, "j")
    assert text(page, "place") == "2 of 4"
    page.ask("window.confirm = () => true")
    page.ask("document.querySelector('#foot .withdraw').click()")
    assert "Your answers have been deleted." in text(page, "end")
    assert "It was about chins." in text(page, "end")
    assert "ABC-1" not in text(page, "end")
    assert page.ask("document.querySelectorAll('#end button').length") == 0
    assert page.ask("stored('synthetic')") is None
    assert not asks(page)
    page.press("Backspace")
    assert "Your answers have been deleted." in text(page, "end")


def test_the_page_hints_at_nothing_and_asks_nobody(folder, browse):
    page = browse()
    seen(page)
    said = page.ask("document.documentElement.outerHTML.replace(/<script>.*<.script>/s, '')")
    for word in ("a.png", "lattice", "centre", "warp", "percent"):
        assert word not in said.replace("max-width: 100%", "")
    loaded = page.ask("performance.getEntriesByType('resource').map((one) => one.name)")
    assert all(one.startswith((folder.as_uri(), "data:")) for one in loaded)
    refused = page.ask(
        "new Promise((done) => {"
        "addEventListener('securitypolicyviolation', (one) => done(one.effectiveDirective));"
        "fetch('http://127.0.0.2:9/').catch(() => {}) })"
    )
    assert refused == "connect-src"
