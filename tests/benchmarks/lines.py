"""How far straight lines beside faces bend, held and not: lines drawn by hand.

``python tests/benchmarks/lines.py [DATA] [--percent 4 8]``

DATA is the folder of photographs, ``KOGAO_SHARED`` or ``../shared/data`` when not given. Lines are
those of ``tests/labels/lines.json``; which of them are held is for the program to find. For each
photo: the bend of its worst line in px, not held and held; what its faces came towards their centre
less than without (0 when no face paid); how far the outline misses its curve, % of the outer
inter-ocular distance; the smallest det J; how far holding moves a corner of eyes or mouth, % of the
face's largest move; what holding took beyond looking, ms. Then how far the nearest edge of
neighbours moves, where there are any.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import kogao_core as kogao
from kogao_core.background.find import BackgroundFinder, held_of
from kogao_core.background.lines import SEEN_PX as SEEN_BEND_PX
from kogao_core.background.lines import bends
from kogao_core.base.geometry import Array, Image
from kogao_core.faces.face import Face
from kogao_core.lab.reports.report import machine
from kogao_core.pipeline import Rendering
from kogao_core.projects.sidecar import Applied
from kogao_core.warp.one_to_one import least_det
from kogao_core.warp.protection import NOTHING

SHARED = Path(os.environ.get("KOGAO_SHARED", Path(__file__).parents[3] / "shared" / "data"))
DRAWN = Path(__file__).resolve().parents[1] / "labels" / "lines.json"
LOST = 0.01  # of an amount, % of D
SEEN_PX = 0.1  # lines that no warp would bend by so much say nothing


@dataclass(frozen=True)
class Seen:
    """What became of the lines of one photo at one percentage."""

    name: str
    free_px: tuple[float, ...]
    held_px: tuple[float, ...]
    lost: float
    missed: tuple[float, float]
    det: tuple[float, float]
    within: float
    took_ms: float
    found_px: Array
    neighbours_px: tuple[float, float]


def seen(
    name: str, photo: Image, faces: Sequence[Face], lines: Array, percent: float,
    finder: BackgroundFinder,
) -> Seen:  # fmt: skip
    """Warp a photo with held lines, and measure."""
    recipe = kogao.Recipe(percent=percent)
    held = held_of(photo, Applied(list(faces), recipe, NOTHING), finder)
    made = kogao.render(photo, faces, recipe, held=held)
    free = kogao.render(photo, faces, kogao.Recipe(percent=percent, hold_background=False))
    both = (free, made)
    found = bends(made.field, finder.find(photo, faces).lines, unheld=made.unheld)
    unit = min(face.interocular_px for face in faces)
    beside = np.vstack([np.zeros((0, 2)), *held.neighbours])
    return Seen(
        name,
        *(tuple(bends(r.field, line[None])[0].bend_px for line in lines) for r in both),
        lost=max(was - now for was, now in zip(free.achieved, made.achieved, strict=True)),
        missed=_pair(100.0 * r.residual.contour_max_px / unit for r in both),
        det=_pair(least_det(r.field) for r in both),
        within=max(_within(made, face, k) for k, face in enumerate(faces)),
        took_ms=made.timings_ms["background"],
        found_px=np.array([(line.unheld_px, line.bend_px) for line in found]).reshape(-1, 2),
        neighbours_px=_pair(
            np.abs(r.field.at(beside)).max(initial=0.0) if len(beside) else 0.0 for r in both
        ),
    )


def _within(made: Rendering, face: Face, number: int) -> float:
    """Return how far holding moves a face's eyes and mouth, % of its largest move."""
    corners = np.vstack([face.eyes, face.mouth])
    moved = np.hypot(*(made.field.at(corners) - made.unheld.at(corners)).T).max()
    return float(100.0 * moved / np.hypot(*made.pairs[number].displacement_px.T).max())


def _pair(values: Iterable[float]) -> tuple[float, float]:
    free, held = (float(value) for value in values)
    return free, held


def table(found: Sequence[Seen], percent: float) -> Iterator[str]:
    """Markdown rows: each photo whose lines the warp would bend, then what all came to."""
    measured = ("bend, px", "outline misses, %", "det J")
    columns = " | held | ".join(measured)
    yield f"| {percent:g} %: photo | lines | {columns} | held |"
    yield "|---|---|---|---|---|---|---|---|"
    for one in found:
        if max(one.free_px) >= SEEN_PX or max(one.held_px) >= SEEN_PX:
            cells = (max(one.free_px), max(one.held_px), *one.missed, *one.det)
            yield f"| {one.name} | {len(one.free_px)} | {' | '.join(f'{c:.2f}' for c in cells)} |"
    free, held = (np.concatenate([getattr(o, n) for o in found]) for n in ("free_px", "held_px"))
    bent = free >= SEEN_PX
    yield f"\n{len(found)} photos, {len(free)} lines; {bent.sum()} would bend by {SEEN_PX} px"
    for name, part in (("not held", free[bent]), ("held", held[bent])):
        middle, high = np.percentile(part, (50, 95))
        yield (
            f"- {name}: median {middle:.2f}, 95 % below {high:.2f}, worst {part.max():.2f} px; "
            f"{(part >= SEEN_BEND_PX).sum()} by {SEEN_BEND_PX} px or more"
        )
    yield f"- worst line that would not bend: {held[~bent].max(initial=0.0):.2f} px"
    was, now = np.vstack([one.found_px for one in found]).T
    bent = was >= SEEN_PX
    yield (
        f"- lines found: {bent.sum()} would bend by {SEEN_PX} px, mean {was[bent].mean():.2f} not "
        f"held, {now[bent].mean():.2f} held; {(now > was + SEEN_PX).sum()} bend more by {SEEN_PX}; "
        f"{(now >= SEEN_BEND_PX).sum()} gave way"
    )
    yield f"- photos whose faces paid: {sum(one.lost > LOST for one in found)}"
    missed = np.array([one.missed for one in found])
    yield "- outline misses, mean: {:.2f} % not held, {:.2f} % held".format(*missed.mean(axis=0))
    within = [one.within for one in found]
    yield f"- eyes and mouth: mean {np.mean(within):.0f} % of the move, most {max(within):.0f}"
    took = [one.took_ms for one in found]
    yield f"- holding took {np.median(took):.0f} ms, most {max(took):.0f}"
    for one in found:
        if one.neighbours_px[0] > 0.0:
            was, now = one.neighbours_px
            yield f"- {one.name}: edges of neighbours move {was:.2f} px not held, {now:.2f} held"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", nargs="?", type=Path, default=SHARED)
    parser.add_argument("--percent", type=float, nargs="+", default=[4.0, 8.0])
    options = parser.parse_args()
    print(json.dumps(machine()))
    finder, source = BackgroundFinder(), kogao.source()
    found: dict[float, list[Seen]] = {percent: [] for percent in options.percent}
    for drawn in json.loads(DRAWN.read_text(encoding="utf-8"))["photos"]:
        photo = kogao.read(options.data / drawn["file"]).pixels
        faces = source.find(photo)
        for percent, rows in found.items():
            lines = np.array(drawn["lines"])
            rows.append(seen(drawn["file"], photo, faces, lines, percent, finder))
    for percent, rows in found.items():
        print("\n".join(table(rows, percent)))


if __name__ == "__main__":
    main()
