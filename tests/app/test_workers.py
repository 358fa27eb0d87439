"""A lane runs one job at a time and only the newest request."""

import threading

import pytest
from kogao_app.features.batch import Batch
from kogao_app.features.experiments import Experiments
from kogao_app.features.together import Together
from kogao_app.workers import Lane
from PySide6.QtCore import QThreadPool
from timeouts import LONGEST_S

pytestmark = pytest.mark.usefixtures("qapp")


@pytest.fixture
def pool():
    pool = QThreadPool()
    yield pool
    assert pool.waitForDone(round(1000 * LONGEST_S))


@pytest.fixture
def problems():
    return []


@pytest.fixture
def lane(pool, problems):
    return Lane(pool, problems.append)


def fail():
    raise ValueError("no good")


def test_only_the_newest_waiting_request_runs(qtbot, lane):
    gate, results = threading.Event(), []
    lane.done.connect(results.append)
    lane.submit(lambda: gate.wait(LONGEST_S) and "first")
    for number in range(5):
        lane.submit(lambda number=number: number)
    assert lane.busy
    gate.set()
    qtbot.waitUntil(lambda: not lane.busy)
    assert results == ["first", 4]


def test_a_dropped_result_is_not_delivered_but_the_next_one_is(qtbot, lane):
    gate, results = threading.Event(), []
    lane.done.connect(results.append)
    lane.submit(lambda: gate.wait(LONGEST_S) and "stale")
    lane.submit(lambda: "waiting")
    lane.drop()
    lane.submit(lambda: "fresh")
    gate.set()
    qtbot.waitUntil(lambda: not lane.busy)
    assert results == ["fresh"]


def test_a_listener_that_submits_starts_nothing_while_others_still_listen(qtbot, pool, lane):
    order = []
    lane.done.connect(lambda name: name == "a" and lane.submit(lambda: order.append("run b")))

    def listen(name):
        assert pool.waitForDone(round(1000 * LONGEST_S))
        order.append(f"shown {name}")

    lane.done.connect(listen)
    lane.submit(lambda: "a")
    qtbot.waitUntil(lambda: not lane.busy)
    assert order == ["shown a", "run b", "shown None"]


def test_an_exception_is_handed_over_and_the_lane_goes_on(qtbot, lane, problems):
    results = []
    lane.done.connect(results.append)
    lane.submit(fail)
    qtbot.waitUntil(lambda: not lane.busy)
    assert [str(problem) for problem in problems] == ["no good"]
    lane.submit(lambda: "next")
    qtbot.waitUntil(lambda: not lane.busy)
    assert results == ["next"]


def test_a_handler_that_raises_holds_nothing_up(qtbot, pool):
    def handle(problem):
        raise problem

    results, lane = [], Lane(pool, handle)
    lane.done.connect(results.append)
    with qtbot.captureExceptions() as caught:
        lane.submit(fail)
        lane.submit(lambda: "next")
        qtbot.waitUntil(lambda: not lane.busy)
    assert [str(problem) for _, problem, _ in caught] == ["no good"]
    assert results == ["next"]


def test_whatever_fails_is_said_in_the_window(opened):
    opened.window.actions_by_name[
        "overlay-straight"
    ].trigger()  # whose failures are of interest while it shows
    opened.settle()
    lanes = [
        one
        for one in opened.editor.findChildren(Lane)
        if not isinstance(one.parent(), Together)  # reads only while its window is open
    ]
    # These have windows of their own, which their own tests look at; thumbnails stay blank.
    elsewhere = [
        *opened.editor.findChild(Batch).findChildren(Lane),
        *opened.editor.findChild(Experiments).findChildren(Lane),
        opened.editor.strip._drawing,
    ]
    silent = []
    for lane in lanes:
        opened.window.bar.clear()
        lane.submit(fail)
        opened.qtbot.waitUntil(lambda lane=lane: not lane.busy)
        if lane not in elsewhere and "no good" not in opened.say().lower():
            silent.append(type(lane.parent()).__name__)
    assert len(lanes) > len(elsewhere)
    assert silent == []


def test_the_editor_is_busy_while_any_lane_is(opened):
    opened.settle()
    lanes = opened.editor.findChildren(Lane)
    idle = []
    for lane in lanes:
        gate = threading.Event()
        lane.submit(gate.wait)
        if not opened.editor.busy:
            idle.append(type(lane.parent()).__name__)
        # What comes of it is nothing that the listeners know.
        lane.drop()
        gate.set()
        opened.settle()
    assert lanes
    assert idle == []
