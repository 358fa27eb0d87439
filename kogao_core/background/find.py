"""Find the background near faces (lines, edges, neighbours) and measure turned lines."""

from __future__ import annotations

import dataclasses
import math
import threading
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final, Protocol

import numpy as np

from kogao_core.background.edges import Edges, edges_of, no_edges
from kogao_core.background.holding import NOTHING_HELD, Held
from kogao_core.background.lines import (
    SEEN_DEGREES,
    SEEN_LENGTH,
    BackgroundLine,
    long_enough,
    off_faces,
    shortest_px,
    straight_lines,
    turns,
)
from kogao_core.background.people import PersonFinder, PersonMask
from kogao_core.base.assets import AssetMissing
from kogao_core.base.geometry import Array, Box, Image, Line
from kogao_core.base.language import Text
from kogao_core.base.threads import one_blas_thread, parallel_map
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import ModelRefused
from kogao_core.faces.landmarks.pixels import Pyramid
from kogao_core.field.field import Field
from kogao_core.paper.domain import Domain
from kogao_core.projects.sidecar import Applied

# Lines end this far from the mask of people, in sides of a face: hair extends beyond the mask.
_APART: Final = 0.03
_CUTS: Final = 256  # samples along a line where the mask is read
_HALF: Final = 0.5  # places of more opacity are people
_HAIR_COUNTS: Final = Text("lines of hair and clothes count as lines of the background")
# Lines this near to a released line are the same line. Unit: the shortest line that counts.
_SAME: Final = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Background:
    """Lines, edges and neighbours near the faces of a photo."""

    lines: Array  # (N, 2, 2): ends (x, y) of each straight line, px
    # (M, 2): for each face, points of other people beside it, px.
    neighbours: tuple[Array, ...] = ()
    shortest_px: float = 1.0  # length of the shortest line that counts
    note: str = ""  # why some lines may not belong to the background
    told: bool = True  # False: the mask of people is missing, and no edge is held
    edges: tuple[Edges, ...] = ()  # for each face, the edges to hold
    others: tuple[Face, ...] = ()  # faces of other people, who stay in place
    # The newest `Held`, by the released lines.
    newest: dict[tuple[Line, ...], Held] = dataclasses.field(default_factory=dict)

    def held(self, loose: Sequence[Line] = ()) -> Held:
        """Return the edges and neighbours that a rendering must hold, without released lines."""
        if not self.told:
            return NOTHING_HELD
        key = tuple(loose)
        if key not in self.newest:
            lines = np.array(key).reshape(-1, 2, 2)
            edges = (one.without(lines) for one in self.edges)
            self.newest.clear()
            self.newest[key] = Held(tuple(edges), self.neighbours, self.others)
        return self.newest[key]

    def toggled(self, line: Line, loose: Sequence[Line]) -> tuple[Line, ...]:
        """Return the released lines after releasing a line, or holding a released line again."""
        ends, reach = np.array(line), _SAME * self.shortest_px
        others = [one for one in loose if not _is_part_of(ends, np.array(one), reach)]
        return tuple(others) if len(others) < len(loose) else (*loose, line)

    def is_loose(self, line: Array, loose: Sequence[Line]) -> bool:
        """Return whether the user has released a line. `line` (2, 2) px."""
        reach = _SAME * self.shortest_px
        return any(_is_part_of(line, np.array(other), reach) for other in loose)


@dataclass(frozen=True, slots=True)
class MeasuredLines:
    """The lines near the faces and how far each is turned."""

    lines: tuple[BackgroundLine, ...]  # the most turned first
    note: str = ""  # see `Background`

    @property
    def seen(self) -> tuple[BackgroundLine, ...]:
        """The lines that gave way, if an eye sees them: see `SEEN_LENGTH`."""
        turned = tuple(line for line in self.lines if line.holding == "gave way")
        length = math.hypot(*(line.length * line.clearness for line in turned))
        return turned if length >= SEEN_LENGTH else ()

    @property
    def told(self) -> str:
        """Number and turn of the lines that an eye sees; empty if there are none."""
        if not (turned := self.seen):
            return ""
        return Text.counted(
            len({one.number for one in turned}),
            "{n} straight line in the background turns by up to {degrees:.0f}°",
            "{n} straight lines in the background turn by up to {degrees:.0f}°",
            degrees=max(one.turn_degrees for one in turned),
        )


class Warped(Protocol):
    """The parts of `kogao_core.pipeline.Rendering` that `measure` needs."""

    @property
    def field(self) -> Field:
        """Displacement of the result."""

    @property
    def unheld(self) -> Field:
        """Displacement without held lines and neighbours."""

    @property
    def domain(self) -> Domain:
        """Region of moving pixels."""


class BackgroundFinder:
    """Finds the background near faces and caches the newest result. Thread-safe."""

    def __init__(self, people: PersonFinder | None = None) -> None:
        self.people = people or PersonFinder()
        self._lock = threading.Lock()
        self._photo: Callable[[], Image | None] = lambda: None
        self._faces: tuple[tuple[bytes, ...], ...] = ()
        self._newest: Background | None = None

    def find(self, photo: Image, faces: Sequence[Face], others: Sequence[Face] = ()) -> Background:
        """Find straight lines, edges and neighbours.

        Lines end at people. Without a mask of people, only lines on faces are left out.
        """
        with self._lock:
            keys = tuple(tuple(f.points.tobytes() for f in some) for some in (faces, others))
            if self._newest is None or self._photo() is not photo or keys != self._faces:
                with one_blas_thread():
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
        looks = dict(zip(people.whose, people.looks, strict=True))

        def edges(k: int) -> Edges:
            look = looks.get(k)
            return edges_of(photo, look, faces[k].anchor.spacing_px) if look else no_edges()

        def cut_lines() -> Array:
            return _cut(lines(people), people.grown(_APART), shortest)

        tasks: list[Callable[[], Any]] = [
            *(partial(edges, k) for k in range(len(faces))),
            cut_lines,
        ]
        *found, straight = parallel_map(lambda task: task(), tasks)
        return Background(
            straight,
            people.neighbours(faces, others),
            shortest,
            _missed(people.missed),
            edges=tuple(found),
            others=tuple(others),
        )


def held_of(photo: Image, done: Applied, finder: BackgroundFinder) -> Held:
    """Return the edges and neighbours to hold for edits of a photo.

    A recipe that holds nothing starts no search.
    """
    if not done.faces or not done.recipe.hold_background:
        return NOTHING_HELD
    return finder.find(photo, done.faces, done.others).held(done.loose)


def measure(
    photo: Image, rendering: Warped, done: Applied, finder: BackgroundFinder
) -> MeasuredLines:
    """Measure how far a rendering turns the straight lines near the warp's domain."""
    if not done.faces:
        return MeasuredLines(())
    found = finder.find(photo, done.faces, done.others)
    holds, bounds = done.recipe.hold_background and found.told, rendering.domain.bounds
    lines = long_enough(found.lines, photo)
    lines = lines[_touches(lines, bounds)]
    # Like `np.median`, which would import numpy's masked arrays.
    widths_px = sorted(float(np.ptp(face.outline[:, 0])) for face in done.faces)
    face_px = (widths_px[len(widths_px) // 2] + widths_px[(len(widths_px) - 1) // 2]) / 2.0
    turned = turns(rendering.field, lines, photo, face_px, rendering.unheld)
    if holds:
        turned = [_marked(line, found, done.loose) for line in turned]
    return MeasuredLines(tuple(turned), found.note)


def _marked(line: BackgroundLine, found: Background, loose: Sequence[Line]) -> BackgroundLine:
    if found.is_loose(np.array([line.start_px, line.end_px]), loose):
        return dataclasses.replace(line, holding="let go")
    gave_way = line.turn_degrees >= SEEN_DEGREES
    return dataclasses.replace(line, holding="gave way" if gave_way else "held")


def _touches(lines: Array, box: Box) -> Array:
    """Return which lines are near a box, (N,) bool."""
    near = box.grown(max(box.width, box.height) // 4)
    low, high = lines.min(axis=1), lines.max(axis=1)
    return np.asarray(
        (high >= (near.left, near.top)).all(axis=1) & (low < (near.right, near.bottom)).all(axis=1)
    )


def _is_part_of(line: Array, other: Array, reach_px: float) -> bool:
    """Return whether two lines coincide along a part."""
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
    """Return the parts of lines on the background that are at least `shortest` long."""
    if len(lines) == 0:
        return lines
    t = np.linspace(0.0, 1.0, _CUTS)
    along = lines[:, 1] - lines[:, 0]
    places = lines[:, :1] + t[:, None] * along[:, None]
    free = np.zeros((len(lines), _CUTS + 2), np.int8)
    free[:, 1:-1] = people.at(places) < _HALF  # NaN counts as a person
    steps = np.diff(free, axis=1)
    line, first = np.nonzero(steps > 0)
    _, behind = np.nonzero(steps < 0)
    parts = np.stack([places[line, first], places[line, behind - 1]], axis=1)
    lengths = np.linalg.norm(parts[:, 1] - parts[:, 0], axis=1)
    return np.asarray(parts[lengths >= shortest])
