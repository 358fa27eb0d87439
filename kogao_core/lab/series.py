"""Photos of one person brought to one result: each gets the amount that its own jaw needs."""

from __future__ import annotations

import dataclasses
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.base.atomic import put
from kogao_core.base.geometry import Affine, Box, Image
from kogao_core.base.language import Text
from kogao_core.faces.face import Face, LandmarkSource
from kogao_core.faces.targets import matching
from kogao_core.faces.zones import turn
from kogao_core.lab.reports.charts import Chart, Series
from kogao_core.lab.reports.report import NONE, Part, Report, Table
from kogao_core.lab.subjects import Progress, no_progress
from kogao_core.photo import MAX_MEGAPIXELS, Photo, UnreadablePhoto, read, write
from kogao_core.photo.formats import READ_ONLY
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import SETTINGS, Recipe
from kogao_core.warp.measures import measures, moved

# A head that is turned farther shows its jaw narrower than it is (`zones.turn`).
MOST_TURNED: Final = 0.2
_STEPS: Final = 20
_CLOSE: Final = 1e-6  # of the ratio
# Other views of the same photo, in which landmarks come out a little otherwise: scale and turn.
_VIEWS: Final = ((0.85, 0.0), (1.15, 0.0), (1.0, -4.0), (1.0, 4.0))


@dataclass(frozen=True, eq=False)
class Shot:
    """One photo of the person."""

    name: str
    pixels: Image
    face: Face
    others: tuple[Face, ...] = ()  # the same face as it was found in other views of the photo


@dataclass(frozen=True, slots=True)
class Brought:
    """What brings one photo to the result of all."""

    name: str
    before: float  # jaw width in shares of the eyes' distance (`FaceMeasures.jaw_to_eyes`)
    equal: float  # the same after the amount that was asked of all
    after: float  # and after the amount that this photo gets
    percent: float  # that amount, % of D
    # The least and largest amount that the landmarks of other views ask for; None without any.
    interval: tuple[float, float] | None

    @property
    def limited(self) -> bool:
        """Whether the amount ended at the largest or the least that there is."""
        return abs(self.percent) >= (SETTINGS["percent"].within or (0.0, 0.0))[1]


def views(face: Face, pixels: Image, source: LandmarkSource) -> tuple[Face, ...]:
    """Find a face in other views of its photo, mirrored and not. Result: px of the photo."""
    height, width = pixels.shape[:2]
    middle = np.array([(width - 1) / 2.0, (height - 1) / 2.0])
    found = []
    for scale, degrees in _VIEWS:
        there = Affine.similarity(scale, degrees, (0.0, 0.0))
        there = dataclasses.replace(there, shift=middle - there.matrix @ middle)
        seen = cv2.warpAffine(
            pixels, there.opencv, (width, height), borderMode=cv2.BORDER_REPLICATE
        )
        faces = [one.mapped(there.inverse) for one in source.find(np.asarray(seen))]
        place = matching(face, faces)
        if place is not None:
            found.append(faces[place])
    return tuple(found)


def bring(shots: Sequence[Shot], recipe: Recipe) -> tuple[float, list[Brought]]:
    """Bring photos to the result that the recipe's amount has in the median photo.

    Result: jaw width in shares of the eyes' distance, and what each photo gets.
    """
    equal = [ratio(shot.face, shot.pixels, recipe) for shot in shots]
    goal = statistics.median(equal)
    brought = []
    for shot, mine in zip(shots, equal, strict=True):
        percent = solve(shot.face, shot.pixels, recipe, goal)
        asked = [solve(other, shot.pixels, recipe, goal) for other in shot.others]
        brought.append(
            Brought(
                shot.name,
                measures(shot.face).jaw_to_eyes,
                mine,
                ratio(shot.face, shot.pixels, dataclasses.replace(recipe, percent=percent)),
                percent,
                (min(percent, *asked), max(percent, *asked)) if asked else None,
            )
        )
    return goal, brought


def ratio(face: Face, pixels: Image, recipe: Recipe) -> float:
    """Return the jaw width in shares of the eyes' distance that a recipe makes of a face."""
    box = Box.of(pixels)
    # Of the field alone nothing depends on the pixels: a picture of the same size costs nothing.
    rendering = render(np.broadcast_to(np.uint8(0), (box.height, box.width)), [face], recipe)
    return measures(moved(face, rendering.field, rendering.pairs[0])).jaw_to_eyes


def solve(face: Face, pixels: Image, recipe: Recipe, goal: float) -> float:
    """Return the amount, % of D, at which a face's jaw has the width asked for.

    Result: within the range of the recipe; its end where the goal lies beyond. The larger the
    amount, the narrower the jaw, so the goal stays between the ends of a false position.
    """
    low, high = SETTINGS["percent"].within or (0.0, 0.0)
    misses = [
        ratio(face, pixels, dataclasses.replace(recipe, percent=end)) - goal for end in (low, high)
    ]
    if misses[0] <= 0.0 or misses[1] >= 0.0:
        return low if misses[0] <= 0.0 else high
    percent, last = low, 0.0
    for _ in range(_STEPS):
        percent = low + (high - low) * misses[0] / (misses[0] - misses[1])
        miss = ratio(face, pixels, dataclasses.replace(recipe, percent=percent)) - goal
        if abs(miss) < _CLOSE * goal:
            break
        # The Illinois rule: an end that stays twice counts half, or it would stay for good.
        if miss > 0.0:
            low, misses = percent, [miss, misses[1] / (2.0 if last > 0.0 else 1.0)]
        else:
            high, misses = percent, [misses[0] / (2.0 if last < 0.0 else 1.0), miss]
        last = miss
    return percent


def one_result(
    photos: Sequence[Path],
    folder: Path,
    recipe: Recipe,
    source: LandmarkSource,
    *,
    find: Callable[[Photo], Sequence[Face]] | None = None,
    force: bool = False,
    max_megapixels: float = MAX_MEGAPIXELS,
    progress: Progress = no_progress,
) -> tuple[list[Brought], list[str]]:
    """Bring photos of one person to one result, and write them and ``series.csv`` into a folder.

    `find` has the faces of a photo in place of a search. Result: what each gets, and a sentence for
    each photo that was left out. Raises ValueError if fewer than two are left, CannotWrite.
    """
    recipe = dataclasses.replace(recipe, hold_background=False)
    shots: list[tuple[Photo, Shot]] = []
    left_out: list[str] = []
    for done, path in enumerate(photos):
        try:
            photo = read(path, max_megapixels=max_megapixels)
            faces = source.find(photo.pixels) if find is None else find(photo)
        except (UnreadablePhoto, ValueError) as problem:
            left_out.append(Text("{photo} is left out: {why}", photo=path.name, why=problem))
            continue
        face = max(faces, key=lambda one: one.interocular_px, default=None)
        if face is None:
            left_out.append(Text("{photo} is left out: no face found", photo=path.name))
        elif turn(face) > MOST_TURNED:
            why = Text("{photo} is left out: the head is turned too far", photo=path.name)
            left_out.append(why)
        else:
            others = views(face, photo.pixels, source) if find is None else ()
            shots.append((photo, Shot(path.name, photo.pixels, face, others)))
        progress(done + 1, len(photos) + 1)
    if len(shots) < 2:
        raise ValueError(
            Text(
                "one result takes at least two photos of a person seen from the front; {left_out}",
                left_out=Text.joined("; ", left_out),
            )
        )
    _, brought = bring([shot for _, shot in shots], recipe)
    folder.mkdir(parents=True, exist_ok=True)
    for (photo, shot), one in zip(shots, brought, strict=True):
        own = dataclasses.replace(recipe, percent=one.percent)
        pixels = render(photo.pixels, [shot.face], own).pixels
        suffix = ".jpg" if photo.path.suffix.lower() in READ_ONLY else photo.path.suffix
        write(
            photo, pixels, folder / f"{photo.path.stem}_{one.percent:+06.2f}{suffix}", force=force
        )
    put(report(brought, recipe).csv().encode(), folder / "series.csv")
    progress(len(photos) + 1, len(photos) + 1)
    return brought, left_out


def _record(one: Brought) -> dict[str, object]:
    least, largest = one.interval or (None, None)
    return {
        "photo": one.name,
        "jaw_to_eyes_before": one.before,
        "jaw_to_eyes_equal_dose": one.equal,
        "jaw_to_eyes_after": one.after,
        "percent": one.percent,
        "percent_least": least,
        "percent_largest": largest,
    }


def report(brought: Sequence[Brought], recipe: Recipe) -> Report:
    """Return what each photo gets, and how far the results lie apart."""
    records = [_record(one) for one in brought]
    document: dict[str, object] = {
        "experiment": "series",
        "recipe": recipe.to_dict(),
        "photos": records,
    }
    lead = Text("Photos of one person, each brought to the same jaw width beside the eyes.")
    parts: list[Part] = [_chart(brought), _table(brought)]
    return Report(Text("One person, one result"), lead, parts, records, document)


def _chart(brought: Sequence[Brought]) -> Chart:
    series = (
        Series(Text("same amount"), [one.equal for one in brought]),
        Series(Text("own amount"), [one.after for one in brought]),
    )
    names = [one.name[:24] for one in brought]
    return Chart(
        Text("Jaw width after the warp"), names, Text("shares of the eyes' distance"), series,
        bars=True,
    )  # fmt: skip


def _table(brought: Sequence[Brought]) -> Table:
    spreads = [
        f"{100.0 * statistics.pstdev([getattr(one, name) for one in brought]):.2f}"
        for name in ("before", "equal", "after")
    ]
    limited = Text.joined(", ", [one.name for one in brought if one.limited])
    note = Text(
        "Jaw width at the mouth in shares of the distance between the outer eye corners. Spread of "
        "these (standard deviation, in hundredths): {before} before, {equal} after the same amount "
        "for all, {after} after each one's own. Interval: the amounts that the landmarks found in "
        "four other views of the same photo, scaled and turned, ask for.",
        **dict(zip(("before", "equal", "after"), spreads, strict=True)),
    )
    if limited:
        text = Text("The goal lies beyond the largest amount for {photos}.", photos=limited)
        note = Text.joined(" ", [note, text])
    return Table.of(
        Text("One person, one result"),
        brought,
        [
            (Text("photo"), lambda one: one.name),
            (Text("before"), lambda one: f"{one.before:.3f}"),
            (Text("same amount"), lambda one: f"{one.equal:.3f}"),
            (Text("own amount"), lambda one: f"{one.after:.3f}"),
            (Text("own amount, % of D"), lambda one: f"{one.percent:.2f}"),
            (
                Text("interval, % of D"),
                lambda one: "{:.2f} .. {:.2f}".format(*one.interval) if one.interval else NONE,
            ),
        ],
        note,
    )
