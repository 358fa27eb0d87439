"""The stages of `pipeline.render` and their laps; every clock in the program reads these names."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from kogao_core.base.language import Text

# In their order, and what people call them.
STAGES: Final = {
    "targets": Text("targets"),
    "lattice": Text("lattice"),
    "guard": Text("guard"),
    "background": Text("background"),
    "brush": Text("brush"),
    "domain": Text("domain"),
    "copy": Text("copy"),
    "warp": Text("warp"),
}


class Stopwatch:
    """Wall-clock time by stage name, in ms."""

    def __init__(self) -> None:
        self.laps_ms: dict[str, float] = {}

    @contextmanager
    def lap(self, stage: str) -> Iterator[None]:
        """Add the time of the ``with`` block to `stage`."""
        start = time.perf_counter()
        try:
            yield
        finally:
            elapsed = (time.perf_counter() - start) * 1e3
            self.laps_ms[stage] = self.laps_ms.get(stage, 0.0) + elapsed
