"""Edit at random for long: ``python tests/benchmarks/soak.py [--edits N] [--megapixels P]``.

A random user works on one photo in the real editor, without a screen. Every few edits the picture
must equal a fresh render of the same state, and memory must not grow: the mean resident size of the
last tenth is compared with that of the second tenth (the first one fills caches). It is taken
after the allocator was asked to give back what is free: glibc keeps much of it in the arenas of
threads, which isn't a leak; that size is printed, too. Ends with 1 when a picture differed or
memory grew by 5 % or more. Needs Linux with glibc.
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import os
import platform
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

import cv2
import numpy as np
from editing import settle, shown
from kogao_app.editor import Editor
from PySide6.QtWidgets import QApplication
from scenes import KnownFaces, oval_face
from soaking import RandomUser, equals_a_fresh_render

MOST_GROWTH = 0.05
SETTLE_EVERY = 20


def resident_mib() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def given_back() -> None:
    """Let go of all that nobody uses."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--edits", type=int, default=10_000)
    parser.add_argument("--megapixels", type=float, default=12.0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    height = round(np.sqrt(options.megapixels * 1e6 / 4 * 3))
    width = round(height * 4 / 3)
    app = QApplication([])
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        small = np.random.default_rng(0).integers(0, 255, (height // 8, width // 8, 3), np.uint8)
        cv2.imwrite(str(place / "photo.png"), cv2.resize(small, (width, height)))
        face = oval_face(width, height, size=0.5)
        editor = shown(app, KnownFaces(face), place)
        editor.files.read(place / "photo.png")
        settle(app, editor)
        code = soak(app, editor, RandomUser(editor, face, options.seed), options.edits)
        editor.close()
    return code


def soak(app: QApplication, editor: Editor, user: RandomUser, edits: int) -> int:
    print(f"{platform.machine()}, {os.cpu_count()} processors, Python {platform.python_version()}")
    start, sizes, checked, wrong = time.perf_counter(), [], 0, 0
    for number in range(1, edits + 1):
        user.edit()
        app.processEvents()
        if number % SETTLE_EVERY and number != edits:
            continue
        settle(app, editor)
        checked += 1
        wrong += not equals_a_fresh_render(editor)
        kept = resident_mib()
        given_back()
        sizes.append(resident_mib())
        if number * 20 // edits > (number - SETTLE_EVERY) * 20 // edits:
            steps, took = editor.document.undo.count(), time.perf_counter() - start
            print(
                f"{number:6} edits {took:6.0f} s {sizes[-1]:7.1f} MiB "
                f"({kept:.1f} with what is free), {steps} undo steps"
            )
            sys.stdout.flush()
    tenth = max(1, len(sizes) // 10)
    before, after = np.mean(sizes[tenth : 2 * tenth]), np.mean(sizes[-tenth:])
    growth = after / before - 1.0
    kinds = ", ".join(f"{count} {name}" for name, count in sorted(user.counts.items()))
    print(f"{edits} edits: {kinds}")
    print(f"{checked} pictures compared with a fresh render, {wrong} differ")
    print(f"resident size {before:.1f} -> {after:.1f} MiB: {growth:+.1%}")
    return int(wrong > 0 or growth >= MOST_GROWTH)


if __name__ == "__main__":
    sys.exit(main())
