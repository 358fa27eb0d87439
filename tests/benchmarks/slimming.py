"""Compare formulas that slim a face, all at the same dose.

``python tests/benchmarks/slimming.py FOLDER OUT``

FOLDER has ``portraits`` (every fifth photo is measured) and ``synthetic`` (faces of the picture).
OUT is the picture of docs/slimming.md; the table is printed. The strength of each formula is
searched so that the outline becomes narrower by `DOSE` % on average from cheek to jaw.
"""

from __future__ import annotations

import dataclasses
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs" / "pictures"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cv2
import numpy as np
from bent import bend_px
from make import FACES

import kogao_core as kogao
from kogao_core.background.find import BackgroundFinder, held_of
from kogao_core.base.geometry import Array, Box, Image
from kogao_core.faces.face import Face
from kogao_core.field.field import shown_at
from kogao_core.field.protection import NOTHING
from kogao_core.lab.methods import MOVING_LEAST_SQUARES, THIN_PLATE, Interpolated, WarpTask
from kogao_core.projects.sidecar import Applied
from kogao_core.recipe.recipe import PAPER, Recipe

DOSE = 4.0  # % narrower, mean of the widths of rows 3 to 7 of the outline
SHOWN_DOSE = 8.0
SIDE_PX = 900  # larger photos are reduced
STEP_PX = 2
STEPS = 4
HIGHER_IS_BETTER = {"smallest det J", "pixels kept, %"}
COLUMNS = (
    *("dose, %", "uneven, %", "ear strip, %", "eye shape, %", "spectacles, %", "edge, %"),
    *("line, px", "smallest det J", "pixels kept, %", "processor, ms"),
)


def gridded(at: Callable[[Array], Array], photo: Image) -> tuple[Any, Image]:
    """Evaluate a displacement on a grid of `STEP_PX` and resample; return both."""
    field = Interpolated.of(at, Box.of(photo), STEP_PX)
    return field, field.pixels(photo)


def curves(photo: Image, face: Face, strength: float) -> tuple[Any, Image]:
    """Pull nine outline points towards the nose, one after another, as live filters do."""
    eye, down = face.eye_center, face.mouth_center - face.eye_center
    ends = ((2, 0.1), (18, 0.1), (4, 0.3), (16, 0.3), (6, 0.5), (14, 0.5), (8, 0.65), (12, 0.65))

    def at(points: Array) -> Array:
        moved = np.array(points, np.float64)
        for row, along in (*ends, (10, 0.65)):
            pull = eye + along * down - face.outline[row]
            near = 1.0 - np.hypot(*(moved - face.outline[row]).T) / np.hypot(*pull)
            moved -= strength / 100.0 * pull * np.clip(near, 0.0, 1.0)[:, None]
        return moved - points

    return gridded(at, photo)


def translation(photo: Image, face: Face, strength: float) -> tuple[Any, Image]:
    """Translate two discs at the jaw towards the nose (Gustafsson 1993, with a linear fade)."""
    nose = (face.eye_center + 2.0 * face.mouth_center) / 3.0

    def at(points: Array) -> Array:
        moved = np.array(points, np.float64)
        for row, lower in ((5, 8), (15, 12)):
            start, pull = face.outline[row], nose - face.outline[row]
            radius = np.hypot(*(face.outline[lower] - start))
            away = np.hypot(*(moved - start).T)
            inside = np.maximum(radius**2 - away**2, 0.0)
            ratio = inside / (inside + 10.0 / max(strength, 1e-9) * (pull @ pull))
            fade = ratio**2 * np.clip(1.0 - away / radius, 0.0, 1.0)
            moved -= fade[:, None] * pull
        return moved - points

    return gridded(at, photo)


def by_kogao(recipe: Recipe, photo: Image, face: Face, strength: float) -> tuple[Any, Image]:
    """Warp with a recipe of Kogao; includes the search for background lines."""
    recipe = dataclasses.replace(recipe, percent=strength)
    held = held_of(photo, Applied([face], recipe, NOTHING), BackgroundFinder())
    made = kogao.render(photo, [face], recipe, held=held)
    return made.field, made.pixels


def by_method(method: Any, photo: Image, face: Face, strength: float) -> tuple[Any, Image]:
    """Move the landmarks of the paper to their targets by a method of the lab."""
    recipe = dataclasses.replace(PAPER, percent=strength)
    made = method.fit(WarpTask.of(photo, [face], recipe))
    return made, made.pixels(photo)


WARPS = {
    "Kogao, default": partial(by_kogao, Recipe()),
    "Kogao, face only (the paper)": partial(by_kogao, PAPER),
    "live filters: nine curves": curves,
    "local translation": translation,
    "moving least squares": partial(by_method, MOVING_LEAST_SQUARES),
    "thin plate spline": partial(by_method, THIN_PLATE),
}


def length(ends: Array) -> float:
    return float(np.hypot(*(ends[-1] - ends[0])))


def stretched(field: Any, ends: Array) -> float:
    """Return how much longer the distance of two points becomes, %."""
    return 100.0 * (length(shown_at(field, ends)) / length(ends) - 1.0)


def narrowing(field: Any, face: Face) -> Array:
    """Return how much narrower five rows of the outline become, %."""
    return np.array([-stretched(field, face.outline[[k, 20 - k]]) for k in range(3, 8)])


def strength_of(warp: Any, photo: Image, face: Face, wanted: float) -> float:
    """Return the strength, at most 15, that comes nearest to a dose."""
    strength = wanted
    for _ in range(STEPS):
        found = narrowing(warp(photo, face, strength)[0], face).mean()
        # The dose grows with the strength or with its square.
        strength = min(15.0, strength * float(wanted / max(found, 0.1)) ** 0.75)
    return strength


def measured(warp: Any, photo: Image, face: Face, lines: Array) -> list[float]:
    """Return a value for each of `COLUMNS`, at the dose `DOSE`."""
    strength = strength_of(warp, photo, face, DOSE)
    start = time.process_time()
    field, pixels = warp(photo, face, strength)
    took = time.process_time() - start
    x, y = field.on_grid(*(np.arange(float(side)) for side in photo.shape[1::-1]))
    (xy, xx), (yy, yx) = np.gradient(x), np.gradient(y)
    outline, eye, iod = face.outline, face.eye_center, face.interocular_px
    ears = outline[[2, 18]]
    away = 0.25 * (ears - ears.mean(axis=0))
    strips = [stretched(field, np.stack(ends)) for ends in zip(ears, ears + away, strict=True)]
    shapes, turn = [], np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    for corners in (face.eyes[:2], face.eyes[2:]):
        ring = circle * length(corners) / 2.0
        shown = shown_at(field, ring + corners.mean(0))
        size = np.linalg.svd(np.linalg.lstsq(ring, shown - shown.mean(0), rcond=None)[0])[1]
        shapes.append(100.0 * float(size[0] / size[1] - 1.0))
    across = (face.eyes[3] - face.eyes[0]) / length(face.eyes[[0, 3]])
    bar = shown_at(field, eye + np.outer(np.linspace(-0.5, 0.5, 60), length(ears) * across))
    chord = (bar[-1] - bar[0]) / length(bar)
    outside = max(-y[0].min(), y[-1].max(), -x[:, 0].min(), x[:, -1].max(), 0.0)
    narrower = narrowing(field, face)
    return [
        float(narrower.mean()), float(np.ptp(narrower)),
        float(np.mean(np.abs(strips))), max(shapes),
        100.0 * float(np.abs((bar - bar[0]) @ [-chord[1], chord[0]]).max()) / iod,
        100.0 * float(outside) / iod,
        1000.0 / len(photo) * bend_px(field, lines) if len(lines) else np.nan,
        float(((1.0 + xx) * (1.0 + yy) - xy * yx).min()),
        100.0 * float((pixels == photo).all(axis=2).mean()), 1000.0 * took,
    ]  # fmt: skip


def prepared(photo: Image, source: Any) -> tuple[Image, Face]:
    """Return the photo, at most `SIDE_PX` large, and its largest face."""
    scale = min(1.0, SIDE_PX / max(photo.shape[:2]))
    small = cv2.resize(photo[..., :3], None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return small, max(source.find(small), key=lambda face: face.interocular_px)


def picture(folder: Path, source: Any) -> Image:
    """Return generated faces, one row each: the original, then each warp at `SHOWN_DOSE`."""
    rows = []
    for number in (4, 1):
        photo, face = prepared(FACES[number].pixels(folder / "synthetic"), source)
        shown = [photo]
        for warp in WARPS.values():
            shown.append(warp(photo, face, strength_of(warp, photo, face, SHOWN_DOSE))[1])
        rows.append([cv2.resize(one, (170, 170), interpolation=cv2.INTER_AREA) for one in shown])
    return cv2.vconcat([np.hstack(row) for row in rows])


def table(values: Array) -> str:
    """Return the Markdown table of values (photos, warps, columns)."""
    lines = ["| | " + " | ".join(COLUMNS) + " |", "|---" * (len(COLUMNS) + 1) + "|"]
    for number, name in enumerate(WARPS):
        cells = []
        for column, title in enumerate(COLUMNS):
            found, at = values[:, number, column], 10 if title in HIGHER_IS_BETTER else 90
            middle, worst = np.round(np.nanpercentile(found, (50, at)), 2) + 0.0
            cells.append(f"{middle:.3g} ({worst:.3g})")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    """Measure, print the table, and write the picture."""
    folder, out = map(Path, sys.argv[1:3])
    cv2.setNumThreads(1)
    source, rows = kogao.source(), []
    for file in sorted((folder / "portraits").glob("*.jpg"))[::5]:
        photo, face = prepared(kogao.read(file).pixels, source)
        lines = BackgroundFinder().find(photo, [face]).lines
        rows.append([measured(warp, photo, face, lines) for warp in WARPS.values()])
    print(f"{len(rows)} portraits: median (worst decile)\n\n{table(np.array(rows))}")
    shown = cv2.cvtColor(picture(folder, source), cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(out), shown, [cv2.IMWRITE_JPEG_QUALITY, 82])


if __name__ == "__main__":
    main()
