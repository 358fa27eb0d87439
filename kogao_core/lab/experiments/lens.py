"""What a wide lens does to a face at the edge, and what the correction leaves of it.

Aiming a camera elsewhere is a homography: a face photographed on the axis, put through it, is
exactly that face at the edge of a wide photo, and the right correction gives it back but for its
place and size. So the truth is known for any photo of a face that was on the axis.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Final, Literal

import cv2
import numpy as np

from kogao_core.background.holding import NOTHING_HELD, Held
from kogao_core.background.lines import bends
from kogao_core.base.geometry import Array, Box, Image
from kogao_core.base.language import Text
from kogao_core.faces.face import Face, LandmarkSource
from kogao_core.lab.experiments.experiment import Experiment, Work
from kogao_core.lab.reports.report import NONE, Part, Picture, Report, Row, Table, recipe_in_words
from kogao_core.lab.subjects import Progress, Subject, no_progress
from kogao_core.pipeline import Rendering, render
from kogao_core.recipe.recipe import Recipe
from kogao_core.warp.field import shown_at
from kogao_core.warp.lens import Head, focal_px

Scene = Literal["alone", "near", "cut", "touching"]
FRAME: Final = (1800, 1200)  # px: a whole photo of 3 : 2
FOCALS_MM: Final = (26.0, 35.0)
SHARES: Final = (0.4, 0.6, 0.85)  # of the half width, from the middle to the face
SIZES: Final = (0.06, 0.1)  # a face's width, of the photo's
_DOWN: Final = -0.15  # of the half height: above the middle
_CUT: Final = 0.99  # of the half width: the edge goes through the face
# Where others stand, in face widths from the one at the edge, and a little lower each.
_BESIDE: Final = ((0.0, 0.0), (1.5, 0.3), (3.0, -0.3))
# In face widths from the face's middle: lines beside the head, and a neighbour's edge.
_LINES: Final = (-2.2, -1.3, 1.3)
_NEIGHBOUR: Final = -1.6
_PER_PX: Final = 1000.0
_SCENES: Final[dict[Scene, Text]] = {
    "alone": Text("with room"),
    "near": Text("its hair at the edge"),
    "cut": Text("cut by the edge"),
    "touching": Text("one of three that touch"),
}
SHOWN: Final = (Text("as the lens draws it"), Text("corrected"), Text("on the axis"))


@dataclass(frozen=True, slots=True)
class Stretch:
    """One face at one place of a wide photo."""

    photo: str  # its name
    scene: Scene
    focal_mm: float  # 35-mm equivalent
    share: float  # of the half width
    size: float  # of the photo's width
    # What is left of the truth after the best similarity, % of the distance of the eyes.
    before_percent: float
    after_percent: float  # by landmarks that are known
    found_percent: float | None  # by landmarks found in the wide photo; None where none were
    # Width over height against the truth, %.
    aspect_before_percent: float
    aspect_after_percent: float
    min_det: float
    folds: int
    bent_per_mille: float | None  # the most bent line beside the head, 1/1000 of the face's width
    dragged_px: float | None  # a neighbour beside it, at 1000 px of height


def measure(
    subject: Subject, source: LandmarkSource, recipe: Recipe, *, progress: Progress = no_progress
) -> list[Stretch]:
    """Put the largest face of a photo, taken to be on the axis, at places of a wide photo."""
    truth = max(subject.faces, key=lambda face: face.interocular_px)
    found, places = [], list(_places(truth))
    for done, place in enumerate(places, start=1):
        found.append(_measured(subject, truth, place, source, recipe))
        progress(done, len(places))
    return found


def shown(subject: Subject, recipe: Recipe) -> list[Image]:
    """Return the largest face at the edge of 26 mm: before, after, and the truth, side by side."""
    truth = max(subject.faces, key=lambda face: face.interocular_px)
    place = _Place(truth, "alone", FOCALS_MM[0], SHARES[-1] - 0.05, SIZES[-1])
    wide = place.drawn(subject.pixels)
    made = _rendered(wide, place, recipe)
    x, y = place.face.anchor.origin_px
    half = 1.1 * SIZES[-1] * FRAME[0]
    left, top, right, bottom = (round(v) for v in (x - half, y - half, x + half, y + half))
    box = Box(left, top, right, bottom).clipped(Box.of(wide))
    scale = place.scale * np.hypot(1.0, np.hypot(*place.off_px) / place.focal_px)
    origin = np.asarray(truth.anchor.origin_px)
    onto = np.column_stack([scale * np.eye(2), (x - box.left, y - box.top) - scale * origin])
    on_axis = cv2.warpAffine(
        subject.pixels, onto, (box.width, box.height), flags=cv2.INTER_AREA,
        borderMode=cv2.BORDER_REPLICATE,
    )  # fmt: skip
    return [wide[box.slices], made.pixels[box.slices], np.asarray(on_axis)]


@dataclass(frozen=True, eq=False)
class _Place:
    """Where a face lies in a wide photo."""

    truth: Face
    scene: Scene
    focal_mm: float
    share: float
    size: float
    aside: tuple[float, float] = (0.0, 0.0)  # in face widths, towards the middle and down

    @property
    def focal_px(self) -> float:
        return focal_px(self.focal_mm, Box(0, 0, *FRAME))

    @property
    def off_px(self) -> Array:
        """Away from the photo's middle."""
        width = self.size * FRAME[0]
        x, y = self.share * FRAME[0] / 2.0, _DOWN * FRAME[1] / 2.0
        return np.array([x - self.aside[0] * width, y + self.aside[1] * width])

    @property
    def scale(self) -> float:
        return self.size * FRAME[0] / float(np.ptp(self.truth.outline[:, 0]))

    @property
    def homography(self) -> Array:
        """From the photo with the face on the axis to the wide one, (3, 3)."""
        f, off = self.focal_px, self.off_px
        to = np.array([*off, f]) / np.hypot(np.hypot(*off), f)
        axis = np.cross([0.0, 0.0, 1.0], to)
        turn, _ = cv2.Rodrigues(axis / np.linalg.norm(axis) * np.arccos(to[2]))
        lens, middle = np.diag([f, f, 1.0]), (np.array(FRAME) - 1.0) / 2.0
        on_axis = np.diag([self.scale, self.scale, 1.0]) @ _shift(
            -np.asarray(self.truth.anchor.origin_px)
        )
        return np.asarray(_shift(middle) @ lens @ turn @ np.linalg.inv(lens) @ on_axis)

    @property
    def face(self) -> Face:
        """The face as the wide photo has it, by its landmarks."""
        truth = self.truth
        outline, eyes, mouth = map(self._through, (truth.outline, truth.eyes, truth.mouth))
        return Face(outline, eyes, mouth)

    @property
    def has_room(self) -> bool:
        """Whether all of the head, with its hair, lies in the photo."""
        head = Head(self.face, self.focal_px, Box(0, 0, *FRAME))
        return head.room_px >= head.radius_px

    def _through(self, points: Array) -> Array:
        seen = np.column_stack([points, np.ones(len(points))]) @ self.homography.T
        return np.asarray(seen[:, :2] / seen[:, 2:])

    def drawn(self, pixels: Image) -> Image:
        """Return the wide photo."""
        return np.asarray(
            cv2.warpPerspective(
                pixels, self.homography, FRAME, flags=cv2.INTER_AREA,
                borderMode=cv2.BORDER_REPLICATE,
            )
        )  # fmt: skip


def _shift(by: Array) -> Array:
    return np.array([[1.0, 0.0, by[0]], [0.0, 1.0, by[1]], [0.0, 0.0, 1.0]])


def _places(truth: Face) -> Iterator[_Place]:
    for focal_mm in FOCALS_MM:
        for size in SIZES:
            for share in SHARES:
                place = _Place(truth, "alone", focal_mm, share, size)
                yield place if place.has_room else dataclasses.replace(place, scene="near")
            yield _Place(truth, "cut", focal_mm, _CUT, size)
            yield _Place(truth, "touching", focal_mm, SHARES[-1], size)


def _measured(
    subject: Subject, truth: Face, place: _Place, source: LandmarkSource, recipe: Recipe
) -> Stretch:
    blank = np.zeros((FRAME[1], FRAME[0]), np.uint8)
    others = [
        dataclasses.replace(place, aside=aside).face
        for aside in _BESIDE[1:]
        if place.scene == "touching"
    ]
    made = _rendered(blank, place, recipe, others)
    before, after = place.face.points, shown_at(made.field, place.face.points)
    seen = _inside(before)
    found, bent, dragged = None, None, None
    if place.scene in ("alone", "near"):
        if place.size == SIZES[-1]:
            found = _by_found(subject, truth, place, source, recipe)
        bent, dragged = _beside(blank, place, recipe)
    return Stretch(
        subject.name, place.scene, place.focal_mm, place.share, place.size,
        _residual(truth, before, seen), _residual(truth, after, seen), found,
        _aspect(truth, before), _aspect(truth, after), made.one_to_one.min_det,
        len(made.one_to_one.folded_cells), bent, dragged,
    )  # fmt: skip


def _rendered(
    pixels: Image,
    place: _Place,
    recipe: Recipe,
    others: Sequence[Face] = (),
    held: Held = NOTHING_HELD,
    face: Face | None = None,
) -> Rendering:
    chosen = dataclasses.replace(recipe, percent=0.0, lens=place.focal_mm, lens_amount=100.0)
    return render(pixels, [face or place.face, *others], chosen, held=held)


def _by_found(
    subject: Subject, truth: Face, place: _Place, source: LandmarkSource, recipe: Recipe
) -> float | None:
    """Return what is left where landmarks are those that are found in the wide photo."""
    wide = place.drawn(subject.pixels)
    faces = source.find(wide)
    near = [
        one for one in faces if np.hypot(*(one.middle - place.face.middle)) < one.interocular_px
    ]
    if not near:
        return None
    made = _rendered(wide, place, recipe, face=near[0])
    points = place.face.points
    return _residual(truth, shown_at(made.field, points), _inside(points))


def _beside(blank: Image, place: _Place, recipe: Recipe) -> tuple[float, float]:
    """Return how far lines beside the head bend, and how far somebody beside it is dragged."""
    (x, y), width = place.face.anchor.origin_px, place.size * FRAME[0]
    places = [x + at * width for at in _LINES if 0.0 <= x + at * width < FRAME[0] - 1.0]
    lines = np.array([[(at, y - 4.0 * width), (at, y + 4.0 * width)] for at in places])
    made = _rendered(blank, place, recipe, held=Held(lines))
    bent = max(line.bend_px for line in bends(made.field, lines, blank, made.unheld))
    edge = np.linspace(-1.0, 2.0, 61)[:, None] * width
    beside = np.column_stack([np.full(len(edge), x + _NEIGHBOUR * width), y + edge[:, 0]])
    made = _rendered(blank, place, recipe, held=Held(neighbours=(beside,)))
    dragged = np.hypot(*made.field.at(beside).T).max()
    return _PER_PX * bent / width, float(dragged) * _PER_PX / FRAME[1]


def _inside(points: Array) -> Array:
    return np.asarray(((points >= 0.0) & (points <= np.array(FRAME) - 1.0)).all(axis=1))


def _residual(truth: Face, after: Array, seen: Array) -> float:
    """Return what is left after the best similarity, % of the distance of the outer eye corners."""
    p, q = (points[seen] - points[seen].mean(axis=0) for points in (truth.points, after))
    a, b = p[:, 0] + 1j * p[:, 1], q[:, 0] + 1j * q[:, 1]
    turn = np.vdot(a, b) / np.vdot(a, a)
    left = np.sqrt((np.abs(b - turn * a) ** 2).mean()) / np.abs(turn)
    return 100.0 * float(left) / truth.interocular_px


def _aspect(truth: Face, after: Array) -> float:
    """Return width over height against the truth, %."""
    (x, y), (u, v) = np.ptp(after, axis=0), np.ptp(truth.points, axis=0)
    return 100.0 * float(x / y / (u / v) - 1.0)


# -- the report ------------------------------------------------------------------------------------


def report(stretches: Sequence[Stretch], recipe: Recipe, seen: Sequence[Image]) -> Report:
    """Return what is left by scene, focal length and place, photos together.

    `seen` are pictures of the first photo, as `shown` makes them.
    """
    name = stretches[0].photo
    pictures = [
        Picture(pixels, Text("{photo}, {what}", photo=name, what=what), what)
        for what, pixels in zip(SHOWN, seen, strict=True)
    ]
    records = [asdict(one) for one in stretches]
    parts: list[Part] = [
        Row(pictures),
        Text("{recipe}.", recipe=recipe_in_words(recipe)),
        _table(stretches),
    ]
    return Report(
        Text("A face at the edge of a wide photo"),
        Text(
            "A face that was photographed on the axis is put at the edge of a wide photo by the "
            "homography of a camera aimed elsewhere; how far does the correction bring it back?"
        ),
        parts,
        records,
        {"experiment": "lens", "recipe": recipe.to_dict(), "stretches": records},
        {Text("At the edge"): list(zip(SHOWN, seen, strict=True))},
    )


def _table(stretches: Sequence[Stretch]) -> Table:
    groups: dict[tuple[Scene, float, float], list[Stretch]] = {}
    for one in stretches:
        groups.setdefault((one.scene, one.focal_mm, one.share), []).append(one)
    return Table.of(
        Text("A face that the lens stretched, before and after: median (worst)"),
        groups.values(),
        [
            (Text("face"), lambda group: _SCENES[group[0].scene]),
            (Text("mm"), lambda group: f"{group[0].focal_mm:.0f}"),
            (Text("% of the half width"), lambda group: f"{100.0 * group[0].share:.0f}"),
            (Text("residual before, %"), _spread("before_percent")),
            (Text("after, known points"), _spread("after_percent")),
            (Text("after, found points"), _spread("found_percent")),
            (Text("aspect before, %"), _spread("aspect_before_percent")),
            (Text("after"), _spread("aspect_after_percent")),
            (Text("least det J"), lambda group: f"{min(one.min_det for one in group):.2f}"),
            (Text("lines, 1/1000"), _spread("bent_per_mille")),
            (Text("neighbours, px"), _spread("dragged_px")),
        ],
        Text(
            "Residual: after the best similarity, of the landmarks in the photo, % of the distance "
            "of the outer eye corners. Aspect: width over height. Lines: the most bent one beside "
            "the head, of the face's width. Neighbours: at 1000 px of height."
        ),
    )


def _spread(name: str) -> Callable[[Sequence[Stretch]], str]:
    def text(group: Sequence[Stretch]) -> str:
        figures = [getattr(one, name) for one in group]
        values = [value for value in figures if value is not None]
        return f"{np.median(values):.2f} ({max(values, key=abs):.2f})" if values else NONE

    return text


def _run(work: Work) -> Report:
    found: list[Stretch] = []
    seen: list[Image] = []
    for subject in work.subjects:
        seen = seen or shown(subject, work.recipe)
        found += measure(subject, work.source(), work.recipe, progress=work.progress)
    return report(found, work.recipe, seen)


EXPERIMENT: Final = Experiment(
    "lens",
    Text("A face at the &edge of a wide photo…"),
    Text("How far a lens stretches this face there, and what its correction leaves"),
    Text("A face at the edge of a wide photo"),
    Text("Bring a face back that a wide lens stretched at the edge: what is left of the truth."),
    _run,
    takes_percent=False,
    recipe=Recipe(),
)
