"""Measure from file to file: ``python tests/benchmarks/end_to_end.py [--quick] [--page P]``.

Every row stands beside its floor: what no program can do without, measured in the same rounds. The
floor is measured twice a round; its ratio to itself is the machine's noise. Real photographs are
used where `KOGAO_SHARED` or ../shared/data has them, made-up ones elsewhere. Needs Linux or macOS.
"""

from __future__ import annotations

import argparse
import functools
import json
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cv2
import numpy as np
import photographs
from paired import Case, Row, beside_floor, into_page, measured, timed
from processes import CLI, EDITOR, Cost, run

from kogao_core.base.machine import machine
from kogao_core.faces.landmarks import MeshSource
from kogao_core.lab.reports.spread import in_turns

_HEAD = ["task", "ratio", "quartiles", "floor / itself", "Kogao", "floor", "unit"]
FLOOR = (sys.executable, str(Path(__file__).with_name("floors.py")))


@dataclass(frozen=True)
class Sizes:
    """How large everything is, and how often it is measured."""

    small: tuple[int, int] = (3840, 2700)  # 10 MP
    group: tuple[int, int] = (4000, 3000)  # 12
    large: tuple[int, int] = (5600, 4480)  # 25
    photos: int = 20
    rounds: int = 7
    few: int = 3  # of what takes minutes

    @staticmethod
    def quick() -> Sizes:
        """Return sizes that only show that everything runs."""
        return Sizes((960, 680), (1200, 900), (1400, 1120), photos=4, rounds=2, few=1)


# -- files ---------------------------------------------------------------------------------------


def warps(sizes: Sizes, folder: Path) -> Iterator[Row]:
    """Yield `kogao-cli warp` from JPEG to JPEG, to PNG and from TIFF to TIFF."""
    ten = photographs.write(photographs.portrait(*sizes.small), folder / "ten.jpg")
    large = photographs.portrait(*sizes.large)
    most = photographs.write(large, folder / "most.jpg")
    deep = photographs.write(large.astype(np.uint16) * 257, folder / "deep.tif")
    cases = (
        ("warp, JPEG to JPEG, 10 MP", ten, ".jpg"),
        ("warp, JPEG to JPEG, 25 MP", most, ".jpg"),
        ("warp, JPEG to PNG, 10 MP", ten, ".png"),
        ("warp, 16-bit TIFF to TIFF, 25 MP", deep, ".tif"),
    )
    for name, source, suffix in cases:
        yield beside_floor(name, *_warp(source, folder / f"out{suffix}"), sizes.rounds)


def _warp(source: Path, out: Path) -> tuple[Case, Case]:
    bare = out.with_stem("bare")
    return (
        lambda: run(*CLI, "warp", source, "-o", out, "--force").wall_ms,
        lambda: run(*FLOOR, "picture", source, bare).wall_ms,
    )


def memory(sizes: Sizes, folder: Path) -> Iterator[Row]:
    """Yield the largest resident size of a warp beside the decoded photo's."""
    photo = photographs.portrait(*sizes.large)
    source, out = photographs.write(photo, folder / "most.jpg"), folder / "out.jpg"
    peaks = [
        run(*CLI, "warp", source, "-o", out, "--force").peak_mb for _ in range(min(3, sizes.rounds))
    ]
    name = "peak memory of warp, 25 MP"
    yield Row(name, "MB", peaks, [photo.nbytes / 1e6] * len(peaks))


def batch(sizes: Sizes, folder: Path) -> Iterator[Row]:
    """Yield a batch's processor time, and what two jobs bring."""
    photos, out = folder / "photos", folder / "out"
    photos.mkdir()
    for number, face in enumerate(photographs.portraits(sizes.photos)):
        height, width = sizes.small[1], round(sizes.small[1] * face.shape[1] / face.shape[0])
        large = cv2.resize(face, (width, height), interpolation=cv2.INTER_CUBIC)
        photographs.write(np.asarray(large), photos / f"{number:02}.jpg")
    bare = folder / "bare"
    bare.mkdir()
    pairs = [file for one in sorted(photos.iterdir()) for file in (one, bare / one.name)]

    def with_jobs(jobs: int) -> Cost:
        return run(*CLI, "batch", photos, "-o", out, "--jobs", jobs, "--force", "--again")

    def per_photo(cost: Cost) -> float:
        return cost.cpu_ms / sizes.photos

    name = f"batch of {sizes.photos}, 10 MP, per photo"
    floor = functools.partial(run, *FLOOR, "picture", *pairs)
    cases = {"one": lambda: with_jobs(1), "two": lambda: with_jobs(2), "floor": floor}
    found: dict[str, list[Cost]] = {case: [] for case in (*cases, "again")}
    for case, _ in in_turns([*cases, "again"], sizes.few, 0):
        found[case].append(cases.get(case, floor)())
    processor = {case: [per_photo(cost) for cost in costs] for case, costs in found.items()}
    yield Row(name, "ms CPU", processor["one"], processor["floor"], processor["again"])
    walls = {case: [cost.wall_ms for cost in costs] for case, costs in found.items()}
    yield Row("batch, one job / two jobs", "ms", walls["one"], walls["two"])


# -- the editor ----------------------------------------------------------------------------------


def editor(sizes: Sizes, folder: Path) -> Iterator[Row]:
    """Yield the editor's start to a painted photo with its faces, and a copy saved from it."""
    most = photographs.write(photographs.portrait(*sizes.large), folder / "most.jpg")
    shot, bare = folder / "shot.png", folder / "bare.png"
    yield beside_floor(
        "editor, start to 25 MP painted",
        lambda: run(*EDITOR, most, "--screenshot", shot).wall_ms,
        lambda: run(*FLOOR, "window", most, bare).wall_ms,
        sizes.rounds,
    )  # fmt: skip
    saves = folder / "saves.json"
    run(*FLOOR, "saves", most, sizes.rounds, saves)
    yield Row("editor, save a copy, JPEG 25 MP", "ms", **json.loads(saves.read_text()))


# -- many faces ----------------------------------------------------------------------------------


def search(sizes: Sizes, _: Path) -> Iterator[Row]:
    """Yield the search for 18 faces, and for the first of 30."""
    source = MeshSource()
    one = photographs.portraits(1)[0][:1000, :1000]
    group = photographs.group(*sizes.group)
    crowd = photographs.crowd(30, *sizes.group)

    def first() -> float:
        heard: list[float] = []
        start = time.perf_counter()
        source.find(crowd, lambda _: heard.append(time.perf_counter()))
        return (heard[0] - start) * 1e3

    alone = timed(functools.partial(source.find, one))
    together = timed(functools.partial(source.find, group))
    cases = {"one": alone, "again": alone, "group": together, "first": first}
    times = measured(cases, sizes.rounds)
    eighteen, again = ([18 * value for value in times[name]] for name in ("one", "again"))
    yield Row("find 18 faces / 18 times one", "ms", times["group"], eighteen, again)
    yield Row("30 faces, the first / one", "ms", times["first"], times["one"])


GROUPS = {"warp": warps, "memory": memory, "batch": batch, "editor": editor, "search": search}


def main() -> None:
    """Measure what was asked for and print it as a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="small pictures, few rounds")
    parser.add_argument("--only", nargs="+", choices=GROUPS, help="not all rows")
    parser.add_argument("--page", type=Path, help="write the table here: docs/measurements.md")
    options = parser.parse_args()
    sizes = Sizes.quick() if options.quick else Sizes()
    rows = []
    print(json.dumps(machine(), indent=1))
    for name, rows_of in GROUPS.items():
        if name in (options.only or GROUPS):
            with tempfile.TemporaryDirectory(prefix="kogao-") as folder:
                for row in rows_of(sizes, Path(folder)):
                    rows.append(row)
                    print(*(f"{cell:>12}" for cell in row.cells[1:]), f"  {row.name}", flush=True)
    if options.page:
        into_page(options.page, "files", [_HEAD, *(row.cells for row in rows)])


if __name__ == "__main__":
    main()
