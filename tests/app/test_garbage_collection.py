"""Widgets in cycles die on the GUI thread, whichever thread makes the garbage."""

from __future__ import annotations

import gc
import threading
from typing import ClassVar

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
