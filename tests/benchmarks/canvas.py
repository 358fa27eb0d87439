"""How long the canvas takes to paint a photo: ``python tests/benchmarks/canvas.py [MEGAPIXELS]``.

Prints the median paint of the whole viewport in ms and as a ratio to one full bilinear
``cv2.remap`` of the photo with a ready map, the unit of all benchmarks here.
"""

from __future__ import annotations

import dataclasses
import itertools
import os
import statistics
import sys
import time
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

import cv2
import numpy as np
from colours import profile
from kogao_app.canvas.photo_canvas import PhotoCanvas
from kogao_app.document import Document, State
from kogao_app.render.colour import screen_colours
from kogao_app.render.live import Surface
from kogao_app.render.pictures import PicturePyramid
from kogao_app.view_state import ViewState
from PySide6.QtCore import QPointF
from PySide6.QtGui import QImage, QPainter
from PySide6.QtWidgets import QApplication

from kogao_core.faces.face import Face
from kogao_core.photo import Photo

REPEATS = 15
SIZE = (1920, 1080)


def median_ms(action) -> float:
    laps = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        action()
        laps.append((time.perf_counter() - start) * 1e3)
    return statistics.median(laps)


def face_of(width: int, height: int) -> Face:
    angle = np.deg2rad(np.linspace(205, -25, 21))
    radius = 0.22 * height
    x, y = width / 2 + 0.78 * radius * np.cos(angle), 0.48 * height + radius * np.sin(angle)
    eyes = [(width / 2 + f * radius, 0.45 * height) for f in (-0.47, -0.19, 0.19, 0.47)]
    mouth = [(width / 2 + f * radius, 0.6 * height) for f in (-0.25, 0.25)]
    return Face(np.column_stack([x, y]), eyes, mouth)


def main() -> None:
    megapixels = float(sys.argv[1]) if len(sys.argv) > 1 else 45.0
    width = int(np.sqrt(megapixels * 1e6 * 1.5)) // 4 * 4
    height = int(width / 1.5)
    small = np.random.default_rng(0).integers(0, 255, (height // 4, width // 4, 3), np.uint8)
    pixels = cv2.resize(small, (width, height), interpolation=cv2.INTER_CUBIC)
    xs, ys = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    xs += 0.3
    unit = median_ms(lambda: cv2.remap(pixels, xs, ys, cv2.INTER_LINEAR))
    print(f"{width} x {height}, one full remap {unit:.1f} ms; viewport {SIZE[0]} x {SIZE[1]}")

    app = QApplication.instance() or QApplication([])
    state = State(faces=(face_of(width, height),))
    photo = PicturePyramid(pixels)
    document = Document()
    document.pyramid = photo
    document.restore(state)
    view = ViewState(document)
    canvas = PhotoCanvas(view)
    canvas.resize(*SIZE)
    canvas.show()
    canvas.open(photo)
    app.processEvents()
    full = Surface(photo)
    view.frame = full.render(1, state)
    full.shown()
    canvas.photo.show_full(view.frame)
    target = QImage(*SIZE, QImage.Format.Format_RGB32)

    def paint() -> None:
        painter = QPainter(target)
        canvas.render(painter)
        painter.end()

    def report(name: str) -> None:
        paint()
        lap = median_ms(paint)
        print(f"{name:<34} {lap:6.1f} ms   {lap / unit:.3f}")

    usual = {"landmarks", "targets", "centre", "folds"}
    middle = QPointF(SIZE[0] / 2, SIZE[1] / 2)
    for words, visible in (("photo alone", set()), ("usual overlays", usual)):
        view.switched = visible
        canvas.fit()
        report(f"{words}, fitted")
        for zoom in (0.33, 0.5, 1.0, 2.0, 8.0):
            canvas.zoom_to(zoom, middle)
            report(f"{words}, {zoom:.0%}")
    canvas.fit()
    for name in ("displacement", "lattice", "domains", "heat", "jacobian"):
        view.switched = {name}
        report(f"{name}, fitted")
    view.switched = usual
    for way in ("wipe", "difference"):
        view.compare = way
        report(f"{way}, fitted")
    view.compare, view.loupe, view.cursor = "off", True, np.array([width / 2, height / 2])
    report("loupe, fitted")
    view.loupe = False
    preview = Surface(photo)

    steps = itertools.count()

    def gesture() -> None:
        # Another distance each time, or there would be nothing to warp.
        moved = dataclasses.replace(state.recipe, percent=4.0 + next(steps) % 7 / 10)
        document.restore(dataclasses.replace(state, recipe=moved))
        view.frame = preview.render(2, view.state, canvas.visible_part())
        preview.shown()
        canvas.photo.show_preview(view.frame)
        paint()

    gesture()
    lap = median_ms(gesture)
    print(f"{'gesture to paint, fitted':<34} {lap:6.1f} ms   {lap / unit:.3f}")

    # The same with a wide-gamut photo, whose colours are turned into the screen's.
    show = screen_colours(
        Photo(pixels, Path("wide"), "TIFF", icc_profile=profile("Adobe RGB"))
    ).show

    def once(name: str, action) -> None:
        start = time.perf_counter()
        action()
        lap = (time.perf_counter() - start) * 1e3
        print(f"{name:<34} {lap:6.1f} ms   {lap / unit:.3f}")

    once("levels of the photo", lambda: PicturePyramid(pixels))
    wide = PicturePyramid(pixels, show)
    once("levels in the screen's colours", lambda: PicturePyramid(pixels, show))
    for words, levels in (("as it is", photo), ("wide", wide)):
        surface = Surface(levels)
        for revision in (1, 2):  # fills both buffers
            surface.render(revision, state)
            surface.shown()
        laps = []
        for _ in range(REPEATS):
            moved = dataclasses.replace(state.recipe, percent=4.0 + next(steps) % 7 / 10)
            frame = surface.render(3, dataclasses.replace(state, recipe=moved))
            surface.shown()
            laps.append(frame.took_ms)
        lap = statistics.median(laps)
        print(f"{f'whole photo, {words}':<34} {lap:6.1f} ms   {lap / unit:.3f}")
    canvas.open(wide)
    preview = Surface(wide)
    gesture()
    lap = median_ms(gesture)
    print(f"{'gesture to paint, fitted, wide':<34} {lap:6.1f} ms   {lap / unit:.3f}")


if __name__ == "__main__":
    main()
