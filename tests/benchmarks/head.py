"""What a warp does to a head, to eyes and mouth, and to the photo.

``python tests/benchmarks/head.py [PHOTO ...] [--percent 4 8 10] [--scope head]``

PHOTO are portraits of one face; those of ``KOGAO_SHARED`` or ``../shared/data`` when not given.
Median and worst decile of:

- width, chin: width at mid forehead, and distance from the eyes to the chin, after / before;
- skull: width at mid forehead over height from the eyes to the top of the hair, after / before;
- strip: width of the strip from the outline to 1.25 half widths at ear height, change in %;
- det J: the smallest;
- sag: of a straight bar from outline to outline on the eye line, % of the outer eye distance (iod);
- outside: farthest read outside the photo, % of iod;
- missed: landmarks off their targets, % of iod;
- changed: share of the photo's 16 x 16 blocks, %.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np
from photographs import SHARED
from scenes import read_outside_px

import kogao_core as kogao
from kogao_core.background.find import BackgroundFinder, held_of
from kogao_core.base.geometry import Array, Box, Image
from kogao_core.faces.face import Face
from kogao_core.faces.head import HeadFrame
from kogao_core.faces.landmarks.pixels import Pyramid
from kogao_core.field.field import shown_at
from kogao_core.field.one_to_one import least_det
from kogao_core.field.protection import NOTHING
from kogao_core.pipeline import Rendering
from kogao_core.projects.sidecar import Applied
from kogao_core.recipe.recipe import SETTINGS

COLUMNS = ("width", "chin", "skull", "strip", "det J", "sag", "outside", "missed", "changed")
LOW_IS_WORSE = {"skull", "det J"}


def of_one_face(files: Sequence[Path]) -> Iterator[tuple[Image, Face]]:
    """Yield the photos with a face, and the largest there."""
    source = kogao.source()
    for file in files:
        photo = kogao.read(file).pixels
        faces = source.find(photo)
        if faces:
            yield photo, max(faces, key=lambda face: face.interocular_px)


def rendered(photo: Image, face: Face, recipe: kogao.Recipe, finder: BackgroundFinder) -> Rendering:
    """Warp one face as the command does."""
    held = held_of(photo, Applied([face], recipe, NOTHING), finder)
    return kogao.render(photo, [face], recipe, held=held)


def hair_px(photo: Image, face: Face, finder: BackgroundFinder) -> float:
    """Return how far the hair reaches above the eyes along the head's axis, px."""
    people, down = finder.people.find(Pyramid(photo), [face]), HeadFrame.of(face).down
    far = np.arange(0.5, 2.0, 0.01) * HeadFrame.of(face).height_px
    seen = people.at((face.eye_center - far[:, None] * down)[None])[0]
    off = np.flatnonzero(~(seen > 0.5))
    return float(far[off[0] - 1]) if len(off) and off[0] else np.nan


def figures(photo: Image, face: Face, made: Rendering, hair: float) -> list[float]:
    """Return a value for each of `COLUMNS`."""
    field, (pairs,) = made.field, made.pairs
    below = HeadFrame.of(face).down
    right = np.array([below[1], -below[0]])
    outline, eye, iod = face.outline, face.eye_center, face.interocular_px
    down = face.mouth_center - eye
    aside = (outline - outline.mean(axis=0)) @ right
    half = float(np.abs(aside).max())
    strips, ends = [], []
    for sign in (-1, 1):
        side = outline[aside * sign > 0]
        at = side[np.argmin(np.abs((side - eye - 0.35 * down) @ below))]
        shown = shown_at(field, np.stack([at, at + 0.25 * sign * half * right]))
        strips.append(100.0 * (_length(shown) / (0.25 * half) - 1.0))
        ends.append(side[np.argmin((side - eye) @ below)])
    chin = float(((outline - eye) @ below).max())
    line = 0.6 * chin if face.forehead is None else float((eye - face.forehead[6]) @ below)
    middle = eye - 0.5 * line * below
    brow = np.stack([middle + 0.8 * sign * half * right for sign in (-1, 1)])
    width, to_chin, to_hair = (
        _length(shown_at(field, ends)) / _length(ends)
        for ends in (brow, *(np.stack([eye, eye + far * below]) for far in (chin, -hair)))
    )
    bar = shown_at(field, np.linspace(*ends, 60))
    chord = (bar[-1] - bar[0]) / _length(bar[[0, -1]])
    missed = np.abs(field.at(pairs.target_px) - pairs.displacement_px).max()
    return [
        *(width, to_chin, width / to_hair),
        float(np.mean(strips)),
        least_det(field),
        100.0 * float(np.abs((bar - bar[0]) @ [-chord[1], chord[0]]).max()) / iod,
        100.0 * read_outside_px(field, Box.of(photo)) / iod,
        100.0 * float(missed) / iod,
        100.0 * float(_blocks(photo != made.pixels).mean()),
    ]


def _length(ends: Array) -> float:
    return float(np.hypot(*(ends[-1] - ends[0])))


def _blocks(changed: Image) -> Image:
    changed = changed.reshape(*changed.shape[:2], -1).any(axis=2)
    rows, columns = (16 * (side // 16) for side in changed.shape)
    blocks = changed[:rows, :columns].reshape(rows // 16, 16, columns // 16, 16)
    return np.asarray(blocks.any(axis=(1, 3)))


def main() -> None:
    """Measure, and print."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("photos", nargs="*", type=Path)
    asked.add_argument("--percent", nargs="+", type=float, default=[4.0, 8.0, 10.0])
    asked.add_argument("--scope", choices=SETTINGS["scope"].choices, default="head")
    given = asked.parse_args()
    files = given.photos or sorted((SHARED / "portraits").glob("*.jpg"))
    base = kogao.Recipe(percent=4.0, scope=given.scope)
    rows: dict[float, list[list[float]]] = {percent: [] for percent in given.percent}
    found, finder = list(of_one_face(files)), BackgroundFinder()
    for photo, face in found:
        hair = hair_px(photo, face, finder)
        for percent, table in rows.items():
            recipe = dataclasses.replace(base, percent=percent)
            table.append(figures(photo, face, rendered(photo, face, recipe, finder), hair))
    print(f"{len(found)} portraits, {given.scope}: median (worst decile)")
    print(" " * 5, *(f"{name:>16}" for name in COLUMNS))
    for percent, table in rows.items():
        values = np.array(table)
        worst = [10 if name in LOW_IS_WORSE else 90 for name in COLUMNS]
        cells = [
            f"{np.nanmedian(column):7.3f} ({np.nanpercentile(column, at):6.3f})"
            for column, at in zip(values.T, worst, strict=True)
        ]
        print(f"{percent:4g}%", *cells)


if __name__ == "__main__":
    main()
