"""How long the window leaves its events waiting: ``python tests/benchmarks/stalls.py``.

A watchdog ticks every 2 ms on the GUI thread, without a screen, while a large photo is opened,
searched for faces, warped and saved, while 30 faces are found, and while a batch runs. Each act is
done several times and judged by its best, for a busy machine delays some, a block all; ends with 1
where the longest wait is above 100 ms. Beside it stands the most that the thread itself computed
between two ticks, whatever the machine did. ``--megapixels P`` takes another photo than one of 24,
``--json OUT`` writes the figures.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

import cv2
import numpy as np
import photographs
from editing import shown
from kogao_app.features.batch.order import Order
from PySide6.QtCore import QEventLoop, Qt, QTimer
from PySide6.QtWidgets import QApplication
from scenes import KnownFaces, oval_face, textured_photo

from kogao_core.base.threads import take_short_turns
from kogao_core.faces.face import Face, OnFace, ignored
from kogao_core.faces.landmarks import source as landmarks
from kogao_core.recipe.recipe import Recipe

LONGEST_MS = 100.0
ATTEMPTS = 6
BLOCK_S = 0.15
CROWD = 30, 4000, 3000  # faces, px


@dataclass(frozen=True, order=True)
class Wait:
    """How long events waited at most, and what the GUI thread computed between two at most."""

    longest_ms: float
    own_ms: float


class Watchdog:
    """Measures how long the GUI thread leaves its events waiting."""

    def __init__(self) -> None:
        self._longest = self._own = 0.0
        self._last, self._computed = time.perf_counter(), time.thread_time()
        self._timer = QTimer(interval=2, timerType=Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._tick)
        self._timer.start()

    def _tick(self) -> None:
        now, computed = time.perf_counter(), time.thread_time()
        self._longest = max(self._longest, now - self._last)
        self._own = max(self._own, computed - self._computed)
        self._last, self._computed = now, computed

    def stop(self) -> Wait:
        self._tick()
        self._timer.stop()
        return Wait(1e3 * self._longest, 1e3 * self._own)


class Slow(KnownFaces):
    """A source that computes for a while, as the networks do."""

    def find(self, rgb: np.ndarray, on_face: OnFace = ignored) -> list[Face]:
        for _ in range(6):
            cv2.GaussianBlur(rgb, (0, 0), 9)
        return super().find(rgb, on_face)


def wait(busy: Callable[[], bool]) -> None:
    """Handle events until something is over."""
    loop, look = QEventLoop(), QTimer(interval=5)
    look.timeout.connect(lambda: None if busy() else loop.quit())
    look.start()
    loop.exec()


def stall(act: Callable[[], object], busy: Callable[[], bool]) -> Wait:
    """Return the shortest of several longest waits; the first that is short enough ends them."""
    stalls = []
    for _ in range(ATTEMPTS):
        watchdog = Watchdog()
        act()
        wait(busy)
        stalls.append(watchdog.stop())
        if stalls[-1].longest_ms <= LONGEST_MS:
            break
    return min(stalls)


def stalls(app: QApplication, folder: Path, megapixels: float) -> dict[str, Wait]:
    """Return the longest wait of each act."""
    height = round(np.sqrt(megapixels * 1e6 / 3 * 2))
    width = round(height * 3 / 2)
    coarse = np.random.default_rng(3).integers(0, 255, (height // 8, width // 8, 3), np.uint8)
    cv2.imwrite(str(folder / "large.jpg"), cv2.resize(coarse, (width, height)))
    (folder / "in").mkdir()
    for k in range(2):
        cv2.imwrite(str(folder / "in" / f"{k}.jpg"), textured_photo(1200, 900, seed=k))
    source = Slow(oval_face(width, height, size=0.5))
    editor = shown(app, source, folder)
    order = Order((folder / "in",), folder / "out", Recipe(), again=True)
    slider = editor.recipe.panel.percent.slider
    acts = {
        "opening and finding faces": lambda: editor.files.read(folder / "large.jpg"),
        "finding faces": editor.faces.find,
        "rendering": lambda: slider.setValue(slider.value() + slider.pageStep()),
        "saving": lambda: editor.files.save(folder / "copy.jpg"),
    }
    found = {name: stall(act, lambda: editor.busy) for name, act in acts.items()}
    batch = editor.batch
    found["a batch"] = stall(lambda: batch.start(order), lambda: batch.busy)
    crowd = photographs.write(photographs.crowd(*CROWD), folder / "crowd.jpg")
    editor.files.read(crowd)
    wait(lambda: editor.busy)
    editor.faces.use(landmarks())
    found["finding 30 faces"] = stall(editor.faces.find, lambda: editor.busy)
    assert len(editor.document.state.faces) == CROWD[0]
    assert (folder / "copy.jpg").is_file()
    assert order.report.is_file()
    editor.close()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--megapixels", type=float, default=24.0)
    parser.add_argument("--json", type=Path, metavar="OUT")
    options = parser.parse_args()
    take_short_turns()  # as the program does
    app = QApplication([])
    seen = stall(lambda: time.sleep(BLOCK_S), lambda: False).longest_ms
    if seen < 1e3 * BLOCK_S:
        sys.exit(f"the watchdog saw {seen:.0f} ms of a block of {BLOCK_S:g} s: it shows nothing")
    with tempfile.TemporaryDirectory() as name:
        found = stalls(app, Path(name), options.megapixels)
    print(f"{platform.machine()}, {os.cpu_count()} processors, Python {platform.python_version()}")
    for act, one in found.items():
        print(f"{act:28}{one.longest_ms:8.1f} ms, of its own {one.own_ms:.1f}")
    if options.json:
        told = {act: asdict(one) for act, one in found.items()}
        options.json.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    sys.exit(max(found.values()).longest_ms > LONGEST_MS)


if __name__ == "__main__":
    main()
