"""Our 27 points in templates of 27, 68 and 189 points, both ways.

A template's jaw becomes our outline by equal steps of arc length. The other way most of a larger
template's points aren't ours to know: those are a mean face's, laid over ours, and said to be so.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Final

import numpy as np

from kogao_core.base.geometry import Affine, Array, arc_lengths, frozen
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.base.wording import shown
from kogao_core.faces.face import OUTLINE_POINTS, Face
from kogao_core.faces.landmarks.aam.points import OUTLINE_LABELS
from kogao_core.faces.landmarks.outline import resampled
from kogao_core.projects.interchange.formats import EYES, MOUTH, OWN_NAMES, Line, PointSet

SOURCE: Final = "points"
# Outline, eyes and mouth: numbers from 0, and spans of them, either way.
_NUMBERS: Final = "[0-9]{1,5}(?:-[0-9]{1,5})?(?:,[0-9]{1,5}(?:-[0-9]{1,5})?)*"
_SPEC: Final = re.compile("/".join([f"({_NUMBERS})"] * 3))


@dataclass(frozen=True, slots=True)
class Template:
    """Which of a file's points are the outline, the eye corners and the mouth corners."""

    name: str  # what to call it: the number of its points, or how it was given
    count: int | None  # how many points it has; None for any that has those named
    # Numbers from 0, in the order of `Face`.
    outline: tuple[int, ...]
    eyes: tuple[int, ...]
    mouth: tuple[int, ...]
    lines: tuple[Line, ...] = ()  # how its points are joined

    @property
    def ours(self) -> tuple[int, ...]:
        """The numbers that our landmarks fill."""
        return (*self.outline, *self.eyes, *self.mouth)

    def face(self, points: PointSet) -> Face:
        """Return the face in a template's points; the other points are left out.

        Result: with 21 points on its outline. Raises BadFile.
        """
        if len(points.points) <= max(self.ours):
            raise BadFile(
                Text(
                    "the mapping asks for point {ours}, and the file's end at {count}",
                    ours=max(self.ours),
                    count=len(points.points) - 1,
                )
            )
        line = points.points[list(self.outline)]
        if len(line) != OUTLINE_POINTS or self.count != _OWN:
            line = along(line, OUTLINE_POINTS)
        if not np.linalg.norm(np.diff(line, axis=0), axis=1).all():
            raise BadFile(Text("the outline's points lie on one another"))
        eyes, mouth = points.points[list(self.eyes)], points.points[list(self.mouth)]
        return Face(line, eyes, mouth, source=SOURCE)

    def points(self, face: Face) -> PointSet:
        """Return a face's points in the template; what isn't ours comes from a mean face.

        Result: as many as the template has, px.
        """
        outline = face.outline
        if self.count != _OWN:
            outline = placed(outline, shares_of(means()[self.count or 0][list(self.outline)]))
        elif len(outline) != OUTLINE_POINTS:
            outline = along(outline, OUTLINE_POINTS)
        known = np.vstack([outline, face.eyes, face.mouth])
        found = np.empty_like(known) if self.count == _OWN else self._mean_face_over(known)
        found[list(self.ours)] = known
        return PointSet(found, self.lines)

    def _mean_face_over(self, known: Array) -> Array:
        """Lay the mean face over known points by the affine map that fits them best.

        Of the outline only the chin is asked: how far up an outline goes differs between
        mark-ups, and with it where each of its other points lies.
        """
        mean = means()[self.count or 0]
        rows = [len(self.outline) // 2, *range(len(self.outline), len(known))]
        design = np.column_stack([mean[list(self.ours)][rows], np.ones(len(rows))])
        solved, *_ = np.linalg.lstsq(design, known[rows], rcond=None)
        return Affine(np.asarray(solved[:2].T), np.asarray(solved[2]))(mean)


_OWN: Final = len(OWN_NAMES)


def _span(first: int, last: int) -> tuple[int, ...]:
    return tuple(range(first, last + 1))


TEMPLATES: Final = {
    template.name: template
    for template in (
        Template(
            "27",
            _OWN,
            _span(0, 20),
            _span(21, 24),
            _span(25, 26),
            (Line(_span(0, 20)), Line((21, 22)), Line((23, 24)), Line((25, 26))),
        ),
        Template(
            "68",
            68,
            _span(0, 16),
            (36, 39, 42, 45),
            (48, 54),
            (
                *(Line(_span(*ends)) for ends in ((0, 16), (17, 21), (22, 26), (27, 30), (31, 35))),
                *(Line(_span(*e), True) for e in ((36, 41), (42, 47), (48, 59), (60, 67))),
            ),
        ),
        Template(
            "189",
            189,
            OUTLINE_LABELS,
            (18, 22, 23, 27),
            (87, 93),
            (
                Line(OUTLINE_LABELS),
                Line(_span(134, 144)),
                Line((*_span(18, 22), 30, 29, 28), True),
                Line((*_span(23, 27), 33, 32, 31), True),
                Line((*_span(71, 76), 84, 83), True),
                Line((*_span(77, 82), 86, 85), True),
                Line((*_span(87, 93), 108, 107, 106, 105, 104), True),
            ),
        ),
    )
}


@cache
def means() -> dict[int, Array]:
    """Return the mean face of 189 points, and of 68, by their count.

    Result (count, 2): unit: the outer inter-ocular distance of the 189.
    """
    text = resources.files(__package__).joinpath("mean189.csv").read_text(encoding="ascii")
    full = np.loadtxt(text.splitlines(), delimiter=",", skiprows=1)
    return {189: frozen(full), 68: frozen(_sixty_eight(full))}


def _sixty_eight(full: Array) -> Array:
    """Return the mean of iBUG's points from the 189: near enough to stand in for unknown ones."""
    bridge = [(full[50] + full[56]) / 2.0, (full[54] + full[60]) / 2.0]
    return np.vstack(
        [
            resampled(full[list(OUTLINE_LABELS)], 17),
            full[[*range(71, 76), *range(78, 83)]],
            resampled(np.array(bridge), 4),
            full[[64, 170, 55, 172, 69]],
            full[[18, 19, 21, 22, 30, 28, 23, 24, 26, 27, 33, 31]],
            full[[*range(87, 94), 108, 107, 106, 105, 104]],
            (full[87] + full[94]) / 2.0,
            full[[95, 96, 97]],
            (full[93] + full[98]) / 2.0,
            full[[102, 101, 100]],
        ]
    )


def template(wanted: str) -> Template:
    """Return a template by its number of points, or by a mapping."""
    if wanted in TEMPLATES:
        return TEMPLATES[wanted]
    given = _SPEC.fullmatch(wanted)
    parts = [_numbers(part) for part in given.groups()] if given else [()]
    if len(parts[0]) < 3 or [len(part) for part in parts[1:]] != [EYES, MOUTH]:
        raise ValueError(
            Text(
                "{wanted} is none of {names}, nor a mapping of outline, 4 eye "
                "corners and 2 mouth corners such as 0-16/36,39,42,45/48,54",
                wanted=shown(wanted),
                names=", ".join(TEMPLATES),
            )
        )
    outline, eyes, mouth = parts
    return Template(wanted, None, outline, eyes, mouth)


def _numbers(text: str) -> tuple[int, ...]:
    found: list[int] = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        start, stop = int(first), int(last or first)
        found += range(start, stop + 1) if start <= stop else range(start, stop - 1, -1)
    return tuple(found)


def fitting(points: PointSet) -> Template:
    """Return the template that has as many points. Raises BadFile."""
    count = len(points.points)
    if str(count) not in TEMPLATES:
        raise BadFile(
            Text(
                "{count} points are none of the templates known ({names}); say which "
                "are the outline, the eyes and the mouth (docs/interchange.md)",
                count=count,
                names=", ".join(TEMPLATES),
            )
        )
    return TEMPLATES[str(count)]


_STEPS: Final = 16  # straight pieces between two points of an outline


def along(line: Array, count: int) -> Array:
    """Return `count` points at equal steps along the smooth curve through a line (N, 2), N >= 2.

    The curve is Catmull and Rom's. Steps along the straight pieces would cut every bend: on an oval
    face 1.5 % of the inter-ocular distance are lost from 21 points to 17 and back. Result (count,
    2): the line's ends among them.
    """
    ends = 2.0 * line[[0, -1]] - line[[1, -2]]
    around = np.vstack([ends[:1], line, ends[1:]])
    before, first, last, after = (around[k : len(around) - 3 + k, None] for k in range(4))
    t = (np.arange(_STEPS) / _STEPS)[:, None]
    pieces = first + t / 2.0 * (
        last - before
        + t * (2.0 * before - 5.0 * first + 4.0 * last - after)
        + t**2 * (3.0 * (first - last) + after - before)
    )  # fmt: skip
    return resampled(np.vstack([pieces.reshape(-1, 2), line[-1:]]), count)


def shares_of(line: Array) -> Array:
    """Return how far along a line (N, 2) each of its points lies, 0 to 1.

    Result (N,): from 0 to 1, by length along straight pieces.
    """
    lengths = arc_lengths(line)
    return np.asarray(lengths / lengths[-1])


def placed(line: Array, shares: Array) -> Array:
    """Return the points that lie at shares of the way along the smooth curve through a line.

    `shares` (M,). Result (M, 2).
    """
    even = along(line, _STEPS * len(line))
    return np.column_stack(
        [np.interp(shares, np.linspace(0.0, 1.0, len(even)), even[:, axis]) for axis in (0, 1)]
    )
