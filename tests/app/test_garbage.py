"""Widgets in cycles die on the GUI thread, whichever thread makes the garbage."""

from __future__ import annotations

import gc
import threading
from typing import ClassVar

from kogao_app.garbage import Collector
from PySide6.QtCore import QObject

ENOUGH = 100_000


class Cycle:
    """Garbage that tells which thread collects it."""

    collected_by: ClassVar[set[int]] = set()

    def __init__(self) -> None:
        self.me = self

    def __del__(self) -> None:
        self.collected_by.add(threading.get_ident())


def litter() -> None:
    for _ in range(ENOUGH):
        Cycle()


def test_a_worker_collects_nothing(qtbot) -> None:
    owner = QObject()
    collector = Collector(owner)
    Cycle.collected_by.clear()
    worker = threading.Thread(target=litter)
    worker.start()
    worker.join()
    assert not Cycle.collected_by
    qtbot.waitUntil(lambda: bool(Cycle.collected_by), timeout=5000)
    assert Cycle.collected_by == {threading.get_ident()}
    collector.stop()
    assert gc.isenabled()
