"""The background near faces: its straight lines, how far the warp bends each, and neighbours."""

from __future__ import annotations

import dataclasses
import threading
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from kogao_core.background.holding import NOTHING_HELD, Held
from kogao_core.background.lines import (
    SEEN_PX,
    BentLine,
    bends,
    off_faces,
    rough_lines,
    shortest_px,
    straight_lines,
)
from kogao_core.background.people import PersonFinder, PersonMask
from kogao_core.base.assets import AssetMissing
from kogao_core.base.geometry import Array, Box, Image, Line, ramp
from kogao_core.base.language import Text
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import ModelRefused
from kogao_core.faces.landmarks.pixels import Pyramid
from kogao_core.projects.sidecar import Applied
from kogao_core.recipe.recipe import Recipe
from kogao_core.warp.domain import Domain
from kogao_core.warp.field import Field

# Hair stands off further than the mask's edge: lines keep so far from people, in sides of a face.
_APART: Final = 0.03
_CUTS: Final = 256  # steps along a line at which it can be cut
_HALF: Final = 0.5
# Lines come and go with noise, the shorter the more: from the shortest to so many lengths more they
# count from nothing to all, the weight of a row being felt over several powers of ten.
_LONGER: Final = 4.0
_SLOWLY: Final = 6
_LENSED: Final = 2  # the same where a lens' correction moves what is behind a head much farther
_HAIR_COUNTS: Final = Text("lines of hair and clothes count as lines of the background")
# Lines so near to one that is let go are its other edge, or itself found a little elsewhere: in the
# shortest line that counts.
_SAME: Final = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Background:
    """What was seen of a photo's background."""

    lines: Array  # (N, 2, 2): ends (x, y) of each straight line, px
    # (M, 2): for each face, points of other people beside it, px.
    neighbours: tuple[Array, ...] = ()
    shortest_px: float = 1.0  # how long a line must be to count
    note: str = ""  # why they may not all be lines of the background; empty where they are
    told: bool = True  # whether people could be told from the background: else no line is held
    # (M, 2, 2): lines that are measured and not held (`lines.rough_lines`), px.
    rough: Array = dataclasses.field(default_factory=lambda: np.zeros((0, 2, 2)))

    def held(self, recipe: Recipe, loose: Sequence[Line] = ()) -> Held:
        """Return what a rendering is to hold."""
        if not self.told:
            return NOTHING_HELD
        free = [self.is_loose(line, loose) for line in self.lines]
        lines = self.lines[~np.array(free, bool)]
        lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
        slowly = _SLOWLY if recipe.lens == "off" else _LENSED
        weights = ramp((lengths / self.shortest_px - 1.0) / _LONGER) ** slowly
        return Held(lines, self.neighbours, weights)

    def toggled(self, line: Line, loose: Sequence[Line]) -> tuple[Line, ...]:
        """Return the lines let go, with one more, or without it where it is one of them."""
        ends, reach = np.array(line), _SAME * self.shortest_px
        others = [one for one in loose if not _is_part_of(ends, np.array(one), reach)]
        return tuple(others) if len(others) < len(loose) else (*loose, line)

    def is_loose(self, line: Array, loose: Sequence[Line]) -> bool:
        """Return whether a line is one of those that the user lets go. `line` (2, 2) px."""
        reach = _SAME * self.shortest_px
        return any(_is_part_of(line, np.array(other), reach) for other in loose)


@dataclass(frozen=True, slots=True)
class Bends:
    """What the meter says."""

    lines: tuple[BentLine, ...]  # the most bent first
    note: str = ""  # see `Background`


class Warped(Protocol):
    """What the meter looks at of a rendering; `kogao_core.pipeline.Rendering` is one."""

    @property
    def field(self) -> Field:
        """The displacement that was drawn."""

    @property
    def unheld(self) -> Field:
        """The displacement as it would be, were nothing held."""

    @property
    def domain(self) -> Domain:
        """Where pixels move."""


class BackgroundFinder:
    """Looks at the background of photos; what it saw of the newest is kept.

    One finder may be shared between threads.
    """

    def __init__(self, people: PersonFinder | None = None) -> None:
        self.people = people or PersonFinder()
        self._lock = threading.Lock()
        self._photo: Callable[[], Image | None] = lambda: None
        self._faces: tuple[tuple[bytes, ...], ...] = ()
        self._newest: Background | None = None

    def find(self, photo: Image, faces: Sequence[Face], others: Sequence[Face] = ()) -> Background:
        """Find straight lines of the background, and neighbours.

        Lines that touch a person are cut there. Where people can't be told from the background,
        only lines on the faces are left out.
        """
        with self._lock:
            keys = tuple(tuple(f.points.tobytes() for f in some) for some in (faces, others))
            if self._newest is None or self._photo() is not photo or keys != self._faces:
                self._newest = self._look(Pyramid(photo), faces, others)
                self._photo, self._faces = weakref.ref(photo), keys
            return self._newest

    def _look(self, photo: Pyramid, faces: Sequence[Face], others: Sequence[Face]) -> Background:
        shortest = shortest_px(photo.image)

        def lines(people: PersonMask | None = None) -> Array:
            found = straight_lines(photo, people)
            return off_faces(found, [face.outline for face in faces])

        note = ""
        try:
            people = self.people.find(photo, faces)
            if not people.looks:
                note = Text(
                    "people couldn't be told from the background, so {hair_counts}",
                    hair_counts=_HAIR_COUNTS,
                )
        except (AssetMissing, ModelRefused):
            why = Text(
                "the network that tells people apart is missing or damaged (see kogao-cli doctor)"
            )
            note = Text("{why}, so {hair_counts}", why=why, hair_counts=_HAIR_COUNTS)
        if note:
            return Background(lines(), (), shortest, note, told=False)
        sharp, grown = lines(people), people.grown(_APART)
        rough = off_faces(rough_lines(photo, sharp, people), [face.outline for face in faces])
        return Background(
            _cut(sharp, grown, shortest),
            people.neighbours(faces, others),
            shortest,
            _missed(people.missed),
            rough=_cut(rough, grown, shortest),
        )


def held_of(photo: Image, done: Applied, finder: BackgroundFinder) -> Held:
    """Return what is to be held where a project, or choices, are done to a photo.

    Without looking, where the recipe holds nothing.
    """
    if not done.faces or not done.recipe.hold_background:
        return NOTHING_HELD
    return finder.find(photo, done.faces, done.others).held(done.recipe, done.loose)


def measure(photo: Image, rendering: Warped, done: Applied, finder: BackgroundFinder) -> Bends:
    """Measure how far a rendering bends the straight lines of its background.

    Result: of the lines near the warp's domain.
    """
    if not done.faces:
        return Bends(())
    found = finder.find(photo, done.faces, done.others)
    holds, bounds = done.recipe.hold_background and found.told, rendering.domain.bounds
    sharp, rough = (
        bends(rendering.field, lines[_touches(lines, bounds)], photo, rendering.unheld)
        for lines in (found.lines, found.rough)
    )
    if holds:
        sharp = [_marked(line, found, done.loose) for line in sharp]
    return Bends(tuple(sorted([*sharp, *rough], key=lambda line: -line.bend_px)), found.note)


def _marked(line: BentLine, found: Background, loose: Sequence[Line]) -> BentLine:
    if found.is_loose(np.array([line.start_px, line.end_px]), loose):
        return dataclasses.replace(line, holding="let go")
    bends_still = line.bend_px >= SEEN_PX
    return dataclasses.replace(line, holding="gave way" if bends_still else "held")


def _touches(lines: Array, box: Box) -> Array:
    """Return which lines come near a box."""
    near = box.grown(max(box.width, box.height) // 4)
    low, high = lines.min(axis=1), lines.max(axis=1)
    return np.asarray(
        (high >= (near.left, near.top)).all(axis=1) & (low < (near.right, near.bottom)).all(axis=1)
    )


def _is_part_of(line: Array, other: Array, reach_px: float) -> bool:
    """Return whether two lines lie on each other, at least in part."""
    along = other[1] - other[0]
    length = float(np.hypot(*along))
    if length == 0.0:
        return False
    along = along / length
    offsets = line - other[0]
    aside = np.abs(offsets @ np.array([-along[1], along[0]]))
    forth = np.sort(offsets @ along)
    return bool(aside.max() <= reach_px and forth[0] < length and forth[1] > 0.0)


def _missed(count: int) -> str:
    if count == 0:
        return ""
    return Text.counted(
        count,
        "one face couldn't be told from the background, so lines there don't count",
        "{n} faces couldn't be told from the background, so lines there don't count",
    )


def _cut(lines: Array, people: PersonMask, shortest: float) -> Array:
    """Return the parts of lines that are long enough and lie on the background."""
    if len(lines) == 0:
        return lines
    t = np.linspace(0.0, 1.0, _CUTS)
    along = lines[:, 1] - lines[:, 0]
    places = lines[:, :1] + t[:, None] * along[:, None]
    free = np.zeros((len(lines), _CUTS + 2), np.int8)
    free[:, 1:-1] = people.at(places) < _HALF  # unknown is not free
    steps = np.diff(free, axis=1)
    line, first = np.nonzero(steps > 0)
    _, behind = np.nonzero(steps < 0)
    parts = np.stack([places[line, first], places[line, behind - 1]], axis=1)
    lengths = np.linalg.norm(parts[:, 1] - parts[:, 0], axis=1)
    return np.asarray(parts[lengths >= shortest])
