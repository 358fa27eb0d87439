"""Make the sample portraits: averages of many labelled faces, none of a real person.

``python -m resources.training.averages FRLL_FOLDER resources/samples``

Each face is aligned to the mean shape by a similarity, then warped by this program's multilevel
B-spline fit of the 189 labels. The pixels are averaged.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.additions.fit import fit
from kogao_core.base.atomic import atomic_write
from kogao_core.base.geometry import Array, Box, Image
from kogao_core.faces.face import Anchor
from kogao_core.faces.landmarks.aam.points import similarity
from kogao_core.faces.targets import FacePairs
from kogao_core.field.field import Field
from kogao_core.paper.domain import reduce
from kogao_core.recipe.recipe import Recipe
from kogao_core.resample.canvas import Canvas

COARSE_SPACING_PX: Final = 128.0
JPEG_QUALITY: Final = 93
GROUPS: Final[dict[str, Callable[[str], bool]]] = {
    "average": lambda _gender: True,
    "women": lambda gender: gender == "female",
    "men": lambda gender: gender == "male",
}


@dataclass(frozen=True, slots=True, eq=False)
class Portrait:
    """One labelled photograph: BGR pixels (H, W, 3), points (189, 2) in px, gender as recorded."""

    pixels: Image
    points: Array
    gender: str


def load(folder: Path) -> list[Portrait]:
    """Read the neutral faces of a folder with ``people.csv`` and ``NNN_neutral.jpg/.csv``."""
    with (folder / "people.csv").open(encoding="utf-8", newline="") as stream:
        genders = {row["id"]: row["face_gender"] for row in csv.DictReader(stream)}
    portraits = []
    for person, gender in sorted(genders.items()):
        pixels = cv2.imread(str(folder / f"{person}_neutral.jpg"), cv2.IMREAD_COLOR)
        if pixels is None:
            raise FileNotFoundError(f"{person}_neutral.jpg is missing in {folder}")
        points = np.loadtxt(folder / f"{person}_neutral.csv", delimiter=",", skiprows=1)
        portraits.append(Portrait(pixels, points, gender))
    return portraits


def mean_shape(shapes: Iterable[Array]) -> Array:
    """Return the mean of shapes (N, 2), each aligned to the mean; two iterations."""
    stack = np.array(list(shapes))
    mean = stack.mean(axis=0)
    for _ in range(2):
        mean = np.mean([similarity(shape, mean)(shape) for shape in stack], axis=0)
    return np.asarray(mean)


def lay_on(portrait: Portrait, shape: Array) -> Image:
    """Warp a portrait so that its points fall on `shape`, on a canvas of its own size."""
    height, width = portrait.pixels.shape[:2]
    onto = similarity(portrait.points, shape)
    aligned = cv2.warpAffine(
        portrait.pixels,
        onto.opencv,
        (width, height),
        flags=cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_REPLICATE,
    )
    pairs = FacePairs(onto(portrait.points), shape, shape.mean(axis=0))
    anchor = Anchor((float(pairs.center_px[0]), float(pairs.center_px[1])), COARSE_SPACING_PX)
    field = Field(fit([pairs], [anchor], [Recipe(fit="multilevel")]))
    canvas = Canvas(aligned)
    canvas.warp(field, reduce(field.lattices, Box.of(aligned), "control-points"), "cubic")
    return canvas.pixels


def average(portraits: list[Portrait]) -> Image:
    """Return the mean picture of portraits warped to their mean shape, uint8."""
    shape = mean_shape(portrait.points for portrait in portraits)
    total = np.zeros(portraits[0].pixels.shape, np.float64)
    for portrait in portraits:
        total += lay_on(portrait, shape)
    return np.asarray(np.round(total / len(portraits)), np.uint8)


def main(arguments: list[str]) -> None:
    """Write ``average.jpg``, ``women.jpg`` and ``men.jpg`` into the second folder."""
    source, target = map(Path, arguments)
    portraits = load(source)
    target.mkdir(parents=True, exist_ok=True)
    for name, belongs in GROUPS.items():
        chosen = [portrait for portrait in portraits if belongs(portrait.gender)]
        print(f"{name}: the mean of {len(chosen)} faces")
        quality = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
        atomic_write(
            cv2.imencode(".jpg", average(chosen), quality)[1].tobytes(), target / f"{name}.jpg"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
