"""How well people are told from the background, what it costs, and what the bend meter counts.

``python tests/benchmarks/person.py [DATA] [--percent 4] [--pictures DIR]``

DATA is the folder of photographs, ``KOGAO_SHARED`` or ``../shared/data`` when not given. Masks are
compared with those drawn by hand in ``tests/labels/people.json``, within the region drawn there.
Distances are from the drawn edge to the mask's, in % of the outer inter-ocular distance.
``--pictures`` draws both edges, and every line that the meter calls bent: real people, keep them.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

import kogao_core as kogao
from kogao_core.background.find import BackgroundFinder, measure
from kogao_core.background.lines import SEEN_PX, BentLine, bends, beside, straight_lines
from kogao_core.background.people import PersonFinder
from kogao_core.base.geometry import Array, Box, Image
from kogao_core.faces.face import Face
from kogao_core.lab.reports.report import machine
from kogao_core.projects.project import sha256_of
from kogao_core.projects.sidecar import Applied
from kogao_core.warp.protection import NOTHING

SHARED = Path(os.environ.get("KOGAO_SHARED", Path(__file__).parents[3] / "shared" / "data"))
DRAWN = Path(__file__).resolve().parents[1] / "labels" / "people.json"
NEAR = 0.35  # of the inter-ocular distance: so near to the outline the edge is "at the face"
CLOSE = 5.0  # an edge found within so many % counts as right
ROUNDS = 9
MILLIONS = 12.0
BUSY = tuple(f"portraits/p{n}.jpg" for n in ("002", "034", "064"))  # bricks, checks, boards
FOLDERS = ("portraits", "headshots", "large", "groups")


@dataclass(frozen=True)
class Agreement:
    """How a mask and one drawn by hand agree."""

    name: str
    group: bool
    overlap: float
    edge: float
    at_face: float
    right: float


def compared(drawn: dict[str, Any], photo: Image, faces: Sequence[Face], pictures: Path | None):
    """Compare the mask of a photo's faces with what was drawn in one region."""
    box = Box(*drawn["region"])
    x, y = np.meshgrid(np.arange(box.left, box.right), np.arange(box.top, box.bottom))
    shown = PersonFinder().find(photo, faces).at(np.stack([x, y], axis=-1).astype(float))
    known, found = ~np.isnan(shown), np.nan_to_num(shown) > 0.5
    origin = np.array([box.left, box.top])
    people = np.zeros(found.shape, np.uint8)
    for corners in drawn["polygons"]:
        cv2.fillPoly(people, [np.rint(8.0 * (np.array(corners) - origin)).astype(int)], 1, shift=3)
    wanted = people > 0
    here = [face for face in faces if _within(face, box)]
    unit = float(np.mean([face.interocular_px for face in here]))
    away = _distance(_edge(found)) * 100.0 / unit
    edge = _edge(wanted) & known
    dots = np.zeros(found.shape, bool)
    for at in np.rint(np.vstack([face.outline for face in here]) - origin).astype(int):
        if (at >= 0).all() and (at < found.shape[::-1]).all():
            dots[at[1], at[0]] = True
    at_face = edge & (_distance(dots) < NEAR * unit)
    if pictures is not None:
        _draw(photo[box.slices], (wanted, found), pictures / f"{_name(drawn, box)}.png")
    return Agreement(
        _name(drawn, box),
        len(here) > 1 or drawn["file"].startswith("groups"),
        float((wanted & found & known).sum() / ((wanted | found) & known).sum()),
        float(away[edge].mean()),
        float(away[at_face].mean()) if at_face.any() else np.nan,
        100.0 * float((away[edge] < CLOSE).mean()),
    )


def _name(drawn: dict[str, Any], box: Box) -> str:
    return f"{Path(drawn['file']).stem}-{box.left}"


def _within(face: Face, box: Box) -> bool:
    x, y = face.anchor.origin_px
    return box.left < x < box.right and box.top < y < box.bottom


def _edge(people: Image) -> Image:
    """Return the pixels on whose other side it changes, but for the picture's border."""
    edge = np.zeros(people.shape, bool)
    edge[1:-1, 1:-1] = (people[1:-1, 1:-1] != people[1:-1, :-2]) | (
        people[1:-1, 1:-1] != people[:-2, 1:-1]
    )
    return edge


def _distance(marked: Image) -> Array:
    return np.asarray(cv2.distanceTransform((~marked).astype(np.uint8), cv2.DIST_L2, 5), float)


def _draw(picture: Image, masks: Sequence[Image], file: Path) -> None:
    canvas = cv2.cvtColor(np.ascontiguousarray(picture), cv2.COLOR_RGB2BGR)
    for mask, color in zip(masks, ((255, 255, 0), (0, 0, 255)), strict=True):
        edges, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(canvas, edges, -1, color, 1)
    cv2.imwrite(str(file), canvas)


def table(agreements: Sequence[Agreement]) -> Iterator[str]:
    """Markdown rows: each region, then means."""
    yield "| region | IoU | edge off by, % | at the face, % | edge within 5 %, % |"
    yield "|---|---|---|---|---|"
    means = [("portraits", False), ("groups", True)]
    rows = [(one.name, [one]) for one in agreements]
    rows += [
        (f"mean of {name}", [a for a in agreements if a.group == kind]) for name, kind in means
    ]
    for name, group in rows:
        cells = [(a.overlap, a.edge, a.at_face, a.right) for a in group]
        overlap, edge, _, right = np.mean(cells, axis=0)
        near = [a.at_face for a in group if not np.isnan(a.at_face)]
        at_face = f"{np.mean(near):.1f}" if near else "-"
        yield f"| {name} | {overlap:.3f} | {edge:.1f} | {at_face} | {right:.0f} |"


def cost(photo: Image, faces: Sequence[Face]) -> str:
    """Time of the processor for the first mask of a photo, and with its lines, one thread."""
    people, background, threads = PersonFinder(), BackgroundFinder(), cv2.getNumThreads()
    took: dict[str, list[float]] = {"mask": [], "mask and lines": []}
    cv2.setNumThreads(1)
    for _ in range(ROUNDS + 1):  # the first reads the network
        for what, find in zip(took, (people.find, background.find), strict=True):
            again = photo.copy()  # or it would remember
            begin = time.process_time()
            find(again, faces)
            took[what].append(1e3 * (time.process_time() - begin))
    cv2.setNumThreads(threads)
    millions = photo.shape[0] * photo.shape[1] / 1e6
    told = (
        "{} {:.0f} ms ({:.0f} to {:.0f})".format(what, *np.percentile(times[1:], (50, 25, 75)))
        for what, times in took.items()
    )
    return f"{millions:.1f} MP, {len(faces)} faces: {', '.join(told)}"


def enlarged(photo: Image, millions: float) -> Image:
    """Return a photo of so many million pixels."""
    scale = float(np.sqrt(1e6 * millions / (photo.shape[0] * photo.shape[1])))
    return np.asarray(cv2.resize(photo, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC))


def counted(
    photo: Image, faces: Sequence[Face], percent: float, finder: BackgroundFinder
) -> tuple[int, list[BentLine]]:
    """Return how many lines beside the faces bend visibly, and those of the background."""
    recipe = kogao.Recipe(percent=percent, hold_background=False)
    rendering = kogao.render(photo, faces, recipe)
    lines = beside(straight_lines(photo), [f.outline for f in faces])
    all_of_them = [line for line in bends(rendering.field, lines) if line.bend_px >= SEEN_PX]
    done = Applied(list(faces), recipe, NOTHING)
    found = measure(photo, rendering, done, finder).lines
    return len(all_of_them), [line for line in found if line.bend_px >= SEEN_PX]


def _draw_line(photo: Image, line: BentLine, file: Path) -> None:
    canvas = cv2.cvtColor(np.ascontiguousarray(photo[..., :3]), cv2.COLOR_RGB2BGR)
    ends = [tuple(round(at) for at in end) for end in (line.start_px, line.end_px)]
    cv2.line(canvas, ends[0], ends[1], (0, 0, 255), max(2, photo.shape[1] // 400))
    cv2.imwrite(str(file), canvas)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", nargs="?", type=Path, default=SHARED)
    parser.add_argument("--percent", type=float, default=4.0, help="warp distance of the meter")
    parser.add_argument("--pictures", type=Path, help="folder for pictures")
    options = parser.parse_args()
    if options.pictures is not None:
        options.pictures.mkdir(parents=True, exist_ok=True)
    print(json.dumps(machine()))
    agreements, found = [], {}
    for drawn in json.loads(DRAWN.read_text(encoding="utf-8"))["masks"]:
        file = options.data / drawn["file"]
        if sha256_of(file) != drawn["sha256"]:
            raise SystemExit(f"{file} is another picture than the one that was drawn on")
        if file not in found:
            photo = kogao.read(file).pixels
            found[file] = photo, kogao.find(photo)
        agreements.append(compared(drawn, *found[file], options.pictures))
    print("\n".join(table(agreements)))
    for name in ("portraits/p064.jpg", "large/p03.jpg", "groups/g2.jpg"):
        photo = kogao.read(options.data / name).pixels
        print(f"{name}: {cost(photo, kogao.find(photo))}")
    for name in BUSY:
        photo = enlarged(kogao.read(options.data / name).pixels, MILLIONS)
        print(f"{name} enlarged: {cost(photo, kogao.find(photo))}")
    finder = BackgroundFinder()
    for folder in FOLDERS:
        before, lines = 0, 0
        for file in sorted((options.data / folder).glob("*.jpg")):
            photo = kogao.read(file).pixels
            faces = kogao.find(photo)
            if not faces:
                continue
            beside_faces, bent = counted(photo, faces, options.percent, finder)
            before, lines = before + beside_faces, lines + len(bent)
            for number, line in enumerate(bent if options.pictures else ()):
                _draw_line(photo, line, options.pictures / f"bent-{file.stem}-{number}.png")
        print(
            f"{folder}, {options.percent:g} %: {before} lines beside faces bend by {SEEN_PX} px or "
            f"more, {lines} of the background"
        )


if __name__ == "__main__":
    main()
