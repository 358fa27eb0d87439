"""Measure the warp engine: ``python tests/benchmarks/engine.py [--quick] [--page P]``.

The unit is one full `cv2.remap` of the same image with a ready map, in the same process.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import statistics
import sys
import tracemalloc
from collections.abc import Callable, Iterator
from itertools import count, cycle
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from paired import Row, into_page, take_turns
from scenes import oval_face, textured_photo

from kogao_core.base.geometry import Image
from kogao_core.base.machine import machine
from kogao_core.faces.face import Face
from kogao_core.field.field import Field
from kogao_core.pipeline import Rendering, render
from kogao_core.recipe.recipe import Recipe
from kogao_core.resample.canvas import Canvas

SIZES = {"12 MP": (4000, 3000), "24 MP": (6000, 4000)}
FACE_HEIGHT = 0.45
LINEAR = Recipe(interpolation="bilinear")
CUBIC = Recipe(interpolation="cubic")


class Bench:
    """One picture with its face, ready map and warm buffers."""

    def __init__(self, width: int, height: int, dtype: type = np.uint8) -> None:
        self.photo = textured_photo(width, height, 3, dtype)
        self.face = oval_face(width, height, size=FACE_HEIGHT)
        self.canvas = Canvas(self.photo)
        self.result = np.empty_like(self.photo)
        self.turns = count()

    def full_remap(self, flag: int = cv2.INTER_LINEAR) -> object:
        """One full remap with a map that is ready: the unit of every ratio."""
        x = np.arange(self.photo.shape[1], dtype=np.float32) + np.float32(0.3)
        y = np.arange(self.photo.shape[0], dtype=np.float32)[:, None] + np.float32(0.3)
        shape = self.photo.shape[:2]
        maps = [np.ascontiguousarray(np.broadcast_to(axis, shape)) for axis in (x, y)]
        border = cv2.BORDER_REPLICATE
        return lambda: cv2.remap(self.photo, *maps, flag, dst=self.result, borderMode=border)

    def ours(self, recipe: Recipe, threads: int = 2, faces: list[Face] | None = None) -> object:
        """Fit to pixels in place, two percentages in turns: no pixel is read where it was."""
        chosen = faces or [self.face]

        def run() -> Rendering:
            percent = recipe.percent - 0.5 + next(self.turns) % 2
            turn = dataclasses.replace(recipe, percent=percent)
            return render(self.photo, chosen, turn, canvas=self.canvas, threads=threads)

        return run

    def drag(self, recipe: Recipe) -> object:
        """The chin moves by a few pixels and back, in place."""
        moved = self.face.with_outline_point(10, self.face.outline[10] + (4.0, 3.0))
        faces = cycle((self.face, moved))
        canvas = Canvas(self.photo)
        return lambda: render(self.photo, [next(faces)], recipe, canvas=canvas, threads=2)

    def with_copy(self) -> object:
        """A full copy into a warm buffer, then the warp in place."""
        warp = self.ours(LINEAR)

        def run() -> None:
            np.copyto(self.result, self.photo)
            warp()

        return run


def main() -> None:
    """Run all measurements and print them as a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="small pictures, few rounds")
    parser.add_argument("--page", type=Path, help="write the table here: docs/measurements.md")
    options = parser.parse_args()
    rounds = 3 if options.quick else 15
    sizes = {name: _shrunk(size, options.quick) for name, size in SIZES.items()}
    table = _table(speed(sizes, rounds), memory_share(*sizes["24 MP"]), sharpness())
    print(json.dumps(machine(), indent=1))
    for row in table:
        print(f"{row[0]:40s} {row[1]:>8s} {row[2]:>17s} {row[3]:>9s}")
    if options.page:
        into_page(options.page, "engine", table)


def _table(rows: list[Row], share: float, kept: dict[str, float]) -> list[list[str]]:
    table = [["case", "ratio", "quartiles", "ms"]]
    for row in rows:
        quartiles = f"{row.by_round.q1:.2f} to {row.by_round.q3:.2f}"
        ms = f"{statistics.median(row.ours):.1f}"
        table.append([row.name, f"{row.ratio:.2f}", quartiles, ms])
    figures = {"working memory, of the image's bytes": share}
    figures |= {f"detail kept where pixels move, {kernel}": part for kernel, part in kept.items()}
    return [*table, *([name, f"{value:.3f}", "", ""] for name, value in figures.items())]


def _shrunk(size: tuple[int, int], quick: bool) -> tuple[int, int]:
    return (size[0] // 4, size[1] // 4) if quick else size


def speed(sizes: dict[str, tuple[int, int]], rounds: int) -> list[Row]:
    """Return the times of the engine beside the unit, and of older ways beside the engine."""
    bench = Bench(*sizes["24 MP"])
    proxy = Bench(1620, 1080)
    many = [oval_face(*sizes["24 MP"], center=c, size=0.2) for c in _spots(*sizes["24 MP"])]
    cases = {
        "unit": bench.full_remap(),
        "cubic unit": bench.full_remap(cv2.INTER_CUBIC),
        "bilinear, 2 threads": bench.ours(LINEAR),
        "bilinear, 1 thread": bench.ours(LINEAR, 1),
        "bilinear, 4 threads": bench.ours(LINEAR, 4),
        "cubic, 2 threads": bench.ours(CUBIC),
        "with a full copy": bench.with_copy(),
        "drag, approximation": bench.drag(Recipe(interpolation="bilinear", fit="approximation")),
        "drag, multilevel": bench.drag(Recipe(interpolation="bilinear", fit="multilevel")),
        "drag, exact": bench.drag(LINEAR),
        "cubic, drag, exact": bench.drag(CUBIC),
        "slider step on the proxy": proxy.ours(LINEAR),
        "five faces": bench.ours(LINEAR, faces=many),
        "conventional": conventional(bench.photo, bench.ours(LINEAR)().field),
    }
    times = take_turns(cases, rounds)
    rows = []
    for name in list(cases)[2:]:
        unit = "cubic unit" if name.startswith("cubic,") else "unit"
        rows.append(Row(name, "ms", times[name], times[unit]))
    ours = times["bilinear, 2 threads"]
    rows.append(Row("conventional / ours", "ms", times["conventional"], ours))
    return [*rows, *_readings(sizes["12 MP"], rounds), *_other_depths(sizes["24 MP"], rounds)]


def conventional(photo: Image, field: Field) -> Callable[[], object]:
    """The whole image's map by two matrix products, and one full remap."""
    height, width = photo.shape[:2]
    result = np.empty_like(photo)
    lattice = field.lattices[0]

    def run() -> object:
        axes = np.arange(float(width)), np.arange(float(height))
        bx, by = (weights.astype(np.float32) for weights in lattice.weights_at(*axes))
        phi = lattice.phi.astype(np.float32)
        x = (by @ phi[..., 0]) @ bx.T
        x += np.arange(width, dtype=np.float32)
        y = (by @ phi[..., 1]) @ bx.T
        y += np.arange(height, dtype=np.float32)[:, None]
        border = cv2.BORDER_REPLICATE
        return cv2.remap(photo, x, y, cv2.INTER_LINEAR, dst=result, borderMode=border)

    return run


def _spots(width: int, height: int) -> list[tuple[float, float]]:
    return [(width * x, height * y) for x in (0.2, 0.5, 0.8) for y in (0.25, 0.75)][:5]


def group(width: int, height: int) -> list[Face]:
    """Return 18 faces in three rows, as large and as close as in a photo of a group.

    Each is 3.4 % of the photo's width and 1.3 of its own widths from the next, the medians of a
    photograph of 18 people: lattices of a row reach into each other.
    """
    return [
        oval_face(width, height, center=(width * x, height * y), size=0.058)
        for y in (0.4, 0.49, 0.58)
        for x in np.linspace(0.3, 0.525, 6)
    ]


def _readings(size: tuple[int, int], rounds: int) -> Iterator[Row]:
    """Yield what a group's photo takes, beside a full cubic remap and what is then read off it."""
    bench = Bench(*size)
    for name, faces in (("18 faces", group(*size)), ("one face", [bench.face])):
        draw = bench.ours(CUBIC, faces=faces)
        cases = {
            "unit": bench.full_remap(cv2.INTER_CUBIC),
            "draw": draw,
            "draw and read": lambda draw=draw: _read(draw()),
        }
        times = take_turns(cases, rounds)
        both = zip(times["draw and read"], times["draw"], strict=True)
        read = [max(0.0, with_readings - alone) for with_readings, alone in both]
        yield Row(f"{name}, 12 MP, cubic", "ms", times["draw"], times["unit"])
        yield Row(f"{name}, readings / drawing", "ms", read, times["draw"])


def _read(rendering: Rendering) -> object:
    return rendering.one_to_one, rendering.residual, rendering.achieved, rendering.pixel_counts


def _other_depths(size: tuple[int, int], rounds: int) -> Iterator[Row]:
    for dtype in (np.uint16, np.float32):
        bench = Bench(*size, dtype)
        times = take_turns({"unit": bench.full_remap(), "ours": bench.ours(LINEAR)}, rounds)
        yield Row(f"bilinear, {np.dtype(dtype).name}", "ms", times["ours"], times["unit"])


def memory_share(width: int, height: int) -> float:
    """Return the peak of what a warp allocates, in image sizes."""
    bench = Bench(width, height)
    warp = bench.ours(LINEAR)
    warp()
    tracemalloc.start()
    warp()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return float(peak / bench.photo.nbytes)


def sharpness() -> dict[str, float]:
    """Return the high-frequency energy kept where pixels move, against an exact warp of waves."""
    width, height = 1500, 1000
    face = oval_face(width, height, size=0.7)
    figures = {}
    for kernel in ("bilinear", "cubic", "lanczos4"):
        still = np.stack(np.meshgrid(np.arange(width), np.arange(height)))
        result = render(_waves(still), [face], Recipe(interpolation=kernel))
        displacement = result.field.on_grid(np.arange(width), np.arange(height))
        exact = _waves(still + displacement)
        moved = np.hypot(*displacement) > 1.0
        figures[kernel] = (
            _fine_energy(result.pixels)[moved].sum() / _fine_energy(exact)[moved].sum()
        )
    return figures


def _waves(at: np.ndarray) -> Image:
    """Sum waves of 4 to 64 px in all directions, with the 1/f fall-off of photographs, uint8."""
    rng = np.random.default_rng(11)
    total = np.zeros(at.shape[1:])
    for length in np.geomspace(4.0, 64.0, 40):
        angle, phase = rng.uniform(0, 2 * np.pi, 2)
        along = (at[0] * np.cos(angle) + at[1] * np.sin(angle)) * 2 * np.pi / length
        total += length / 64.0 * np.sin(along + phase)
    return np.clip(128 + 30 * total, 0, 255).round().astype(np.uint8)


def _fine_energy(picture: Image) -> np.ndarray:
    sharp = picture.astype(np.float64)
    return (sharp - cv2.GaussianBlur(sharp, (0, 0), 2.0)) ** 2


if __name__ == "__main__":
    main()
