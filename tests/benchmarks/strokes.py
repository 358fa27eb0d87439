"""Strokes of push and restore in the editor: ``python tests/benchmarks/strokes.py PHOTO OUT.json``.

Opens the photo in the real editor, without a screen, draws strokes at the jaw fitted and at 1:1,
and takes the time from each move of the mouse to the picture with it painted: the clock's and the
processors', ms. In turns with steps of the amount, which is drawn the same way.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np
from editing import open_copy, settle, shown
from PySide6.QtCore import QEvent, QEventLoop, QObject, QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from kogao_core.base.threads import take_short_turns
from kogao_core.faces.landmarks import source

STROKES = 4
MOVES = 8
STEP = QPoint(-3, 1)


class Paints(QObject):
    """Counts the paints of a widget."""

    count = 0

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: ARG002, N802
        """Count them."""
        self.count += event.type() == QEvent.Type.Paint
        return False


def main(photo: str, out: str) -> None:
    """Write the times of every move."""
    take_short_turns()  # as the program does
    app = QApplication([])
    found: dict[str, list[tuple[float, float]]] = {}
    with tempfile.TemporaryDirectory() as name:
        editor = shown(app, source(), Path(name))
        open_copy(app, editor, photo, Path(name))
        canvas, live, view = editor.window.canvas, editor.live, editor.view
        live._rest.setInterval(60_000)  # a gesture that goes on: no whole photo beside its previews
        paints = Paints()
        canvas.viewport().installEventFilter(paints)

        def timed(what: str, act: Callable[[], object]) -> None:
            begun, cpu, seen = time.perf_counter(), time.process_time(), paints.count
            act()
            wanted = live._revision
            while (view.frame.revision < wanted or paints.count == seen) and (
                time.perf_counter() - begun < 5
            ):
                seen = paints.count if view.frame.revision < wanted else seen
                app.processEvents(QEventLoop.ProcessEventsFlag.WaitForMoreEvents)
            both = time.perf_counter() - begun, time.process_time() - cpu
            found.setdefault(what, []).append((both[0] * 1e3, both[1] * 1e3))

        for zoom in ("fitted", "1:1"):
            jaw = view.state.faces[0].outline[4]
            if zoom == "1:1":
                canvas.zoom_to(1.0, canvas.to_screen(jaw))
            for stroke in range(STROKES):
                kind = ("push", "restore")[stroke % 2]
                editor.protect.take(kind)
                at = canvas.to_screen(jaw).toPoint() + QPoint(0, 4 * stroke)
                QTest.mousePress(canvas.viewport(), Qt.MouseButton.LeftButton, pos=at)
                for move in range(1, MOVES + 1):
                    place = at + STEP * move
                    timed(f"{kind}, {zoom}", partial(QTest.mouseMove, canvas.viewport(), place))
                QTest.mouseRelease(canvas.viewport(), Qt.MouseButton.LeftButton, pos=place)
                settle(app, editor)
                for step in range(MOVES):
                    percent = 4.05 + 0.1 * (step + stroke % 2 * MOVES)
                    timed(f"amount, {zoom}", partial(editor.recipe.set_field, "percent", percent))
                editor.document.commit()
                settle(app, editor)
        shares = view.frame.rendering.brush_shares
        sound = view.frame.rendering.one_to_one
        editor.close()
    for what, times in found.items():
        wall, cpu = np.percentile(times, (50, 90, 100), axis=0).T
        print(f"{what:14} wall {wall.round(1)}  processors {cpu.round(1)}  ({len(times)} moves)")
    print(f"shares {shares}, smallest det J {sound.min_det:.2f}, folds {len(sound.folded_cells)}")
    Path(out).write_text(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
