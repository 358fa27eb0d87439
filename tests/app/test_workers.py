"""A lane runs one job at a time and only the newest request."""

from __future__ import annotations

import threading

import pytest
from kogao_app.workers import Lane
from PySide6.QtCore import QThreadPool

pytestmark = pytest.mark.usefixtures("qapp")


@pytest.fixture
def pool():
    pool = QThreadPool()
    yield pool
    assert pool.waitForDone(10_000)


@pytest.fixture
def lane(pool):
    return Lane(pool)


def test_only_the_newest_waiting_request_runs(qtbot, lane):
    gate, results = threading.Event(), []
    lane.done.connect(results.append)
    lane.submit(lambda: gate.wait(10) and "first")
    for number in range(5):
        lane.submit(lambda number=number: number)
    assert lane.busy
    gate.set()
    qtbot.waitUntil(lambda: not lane.busy)
    assert results == ["first", 4]


def test_a_dropped_result_is_not_delivered_but_the_next_one_is(qtbot, lane):
    gate, results = threading.Event(), []
    lane.done.connect(results.append)
    lane.submit(lambda: gate.wait(10) and "stale")
    lane.submit(lambda: "waiting")
    lane.drop()
    lane.submit(lambda: "fresh")
    gate.set()
    qtbot.waitUntil(lambda: not lane.busy)
    assert results == ["fresh"]


def test_the_next_job_starts_after_the_listeners_are_done(qtbot, lane):
    order = []
    lane.done.connect(lambda name: order.append(f"shown {name}"))
    lane.submit(lambda: order.append("run a") or "a")
    lane.submit(lambda: order.append("run b") or "b")
    qtbot.waitUntil(lambda: not lane.busy)
    assert order == ["run a", "shown a", "run b", "shown b"]


def test_an_exception_is_delivered(qtbot, lane):
    def fail():
        raise ValueError("no good")

    with qtbot.waitSignal(lane.failed) as caught:
        lane.submit(fail)
    assert str(caught.args[0]) == "no good"
    assert not lane.busy
