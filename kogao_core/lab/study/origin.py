"""Where a study comes from, for its key: photos, landmarks, program, day; and what it achieved."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final

import numpy as np

from kogao_core import __version__
from kogao_core.base.strict import Node
from kogao_core.base.wording import printable
from kogao_core.lab.subjects import Subject
from kogao_core.pipeline import Rendering
from kogao_core.recipe.recipe import Recipe

_MOST_POINTS: Final = 1000
_LARGEST: Final = 1e9
_DIGITS: Final = 2  # decimals of landmarks, px at the paper's size


@dataclass(frozen=True, slots=True)
class Origin:
    """How a study came to be."""

    program: str  # version of Kogao
    made: str  # when, ISO 8601 in UTC
    landmarks: str  # name of the landmark source; empty where faces came from elsewhere

    @staticmethod
    def now(landmarks: str) -> Origin:
        """Return the origin of a study that this program makes at this moment."""
        return Origin(__version__, datetime.now(UTC).isoformat(timespec="seconds"), landmarks)

    @staticmethod
    def parse(node: Node) -> Origin:
        """Read what a key holds."""
        node.only(("program", "made", "landmarks"))
        program, made, landmarks = (
            node.field(name).text(200) for name in ("program", "made", "landmarks")
        )
        return Origin(program, made, landmarks)


@dataclass(frozen=True, slots=True)
class PhotoRecord:
    """One face of a study."""

    name: str  # its photo's file name
    sha256: str = ""  # of that file; empty where there was none
    points: tuple[tuple[float, float], ...] = ()  # landmarks in px of its pictures, unwarped

    @staticmethod
    def of(subject: Subject) -> PhotoRecord:
        """Return what a key holds of a subject; letters that can't be printed become '?'."""
        name = printable(subject.name)
        points = [(float(x), float(y)) for x, y in _points(subject)]
        return PhotoRecord(name, subject.sha256, tuple(points))

    @staticmethod
    def parse(node: Node) -> PhotoRecord:
        """Read what a key holds."""
        node.only(("name", "sha256", "points"))
        points = [
            [one.number(-_LARGEST, _LARGEST) for one in point.items(2)]
            for point in node.field("points").items(_MOST_POINTS)
        ]
        if any(len(point) != 2 for point in points):
            node.field("points").refuse("must be pairs of x and y")
        return PhotoRecord(
            node.field("name").text(4096),
            node.field("sha256").text(64),
            tuple((x, y) for x, y in points),
        )


@dataclass(frozen=True, slots=True)
class PictureFigures:
    """What a picture's warp amounts to."""

    # How far the landmarks came towards the centre, % of D (`kogao_core.warp.measures`).
    achieved: float
    # Lattice spacing in mean warp distances, the paper's R in figures 10 and 11.
    lattice_in_warps: float | None
    # What the recipe asked for, % of D, where that was chosen so that something else is achieved.
    asked: float | None = None

    @staticmethod
    def of(rendering: Rendering) -> PictureFigures:
        """Return what the rendering of one face amounts to."""
        (pairs,), (lattice,) = rendering.pairs, rendering.field.lattices
        moved = pairs.warp_distance_px
        return PictureFigures(
            round(rendering.achieved[0], 4),
            round(lattice.grid.spacing_px / moved, 4) if moved > 0.0 else None,
        )

    @staticmethod
    def parse(node: Node) -> PictureFigures:
        """Read what a key holds."""
        ratio, asked = (
            None if one.value is None else one.number(-_LARGEST, _LARGEST)
            for one in (node.field("lattice_in_warps"), node.field("asked"))
        )
        return PictureFigures(node.field("achieved").number(-100.0, 100.0), ratio, asked)


def digest(subject: Subject, recipe: Recipe) -> str:
    """Return the SHA-256 of what all pictures of a subject follow from: pixels, landmarks, recipe.

    Another photo, other landmarks or another recipe have another one, whatever their names.
    """
    content: dict[str, Any] = {
        "shape": subject.pixels.shape,
        "points": _points(subject).tolist(),
        "recipe": recipe.to_dict(),
    }
    total = hashlib.sha256(json.dumps(content, sort_keys=True).encode())
    total.update(np.ascontiguousarray(subject.pixels).tobytes())
    return total.hexdigest()


def _points(subject: Subject) -> np.ndarray:
    # The sum turns -0.0 into 0.0, which is the same place.
    return np.round(np.vstack([face.points for face in subject.faces]), _DIGITS) + 0.0
