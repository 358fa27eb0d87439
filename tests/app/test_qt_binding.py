"""The binding under the editor; see docs/decisions/14 and 35."""

from __future__ import annotations

import gc
import sys
import threading
from typing import ClassVar

from PySide6.QtCore import QObject

ENOUGH = 100_000


def test_calls_that_return_nothing_keep_none_alive():
    """PySide6 6.12.0 on Python 3.11 lost a reference to None with each: soon the program aborts."""
    thing = QObject()
    gc.collect()  # what it might let go of meanwhile holds None, too
    before = sys.getrefcount(None)
    for _ in range(500):
        thing.setObjectName("name")
    assert abs(sys.getrefcount(None) - before) < 100


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


def test_while_an_editor_is_open_a_worker_collects_nothing(empty) -> None:
    Cycle.collected_by.clear()
    worker = threading.Thread(target=litter)
    worker.start()
    worker.join()
    assert not Cycle.collected_by
    empty.qtbot.waitUntil(lambda: bool(Cycle.collected_by))
    assert Cycle.collected_by == {threading.get_ident()}
    empty.editor.close()
    assert gc.isenabled()
