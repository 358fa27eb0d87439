"""Measure the warp for the variants of table 1 and figure 11: area, folds, lines, misses.

The paper asked people which pictures look unnatural. This experiment measures the warp itself, for
the same centres and distances, and for four lattice sizes.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Final

import cv2
import numpy as np

from kogao_core.background.lines import long_enough, off_faces, straight_lines, turns
from kogao_core.base.geometry import Array, Box
from kogao_core.base.language import Text
from kogao_core.faces.targets import FacePairs
from kogao_core.field.field import Field, shown_at
from kogao_core.field.one_to_one import largest_det
from kogao_core.lab.experiments.experiment import Experiment, Work
from kogao_core.lab.reports.charts import Chart, Series
from kogao_core.lab.reports.report import NONE, Heading, Part, Report, Row, Table
from kogao_core.lab.study.design import Variant, variants
from kogao_core.lab.subjects import Progress, Subject, no_progress
from kogao_core.paper.table1 import DISTANCES, STUDENTS, SUBJECTS, UNNATURAL
from kogao_core.pipeline import Rendering, render
from kogao_core.recipe.recipe import PAPER, SETTINGS, Recipe

RULES: Final = 16  # ruled lines in each direction
_ROUND: Final = 0.25  # margin around the faces for the ruled lines, relative to the faces' box
_LOCAL_STEPS: Final = 200  # samples of det J along each side of the domain


@dataclass(frozen=True, slots=True, kw_only=True)
class Distortion:
    """Measures of one variant on one photo."""

    photo: str  # name
    variant: Variant  # centre, distance and lattice
    # Mean lattice spacing, and mean warp distance, of the faces.
    spacing_px: float
    warp_px: float
    # Achieved distance towards the centre, mean over the faces, % of D
    # (`kogao_core.field.measures`). The variant has the requested distance.
    achieved: float
    # Area inside the outline after the warp over the area before it, minus 1, in %.
    face_area: float
    # Root mean square of local changes of area, |det J - 1|, where pixels move, in %.
    local_area: float
    # Smallest and largest Jacobian determinant of the backward field, of 8 x 8 samples per lattice
    # cell. Below 1 the picture is stretched, above 1 compressed, at 0 or less folded.
    min_det: float
    max_det: float
    folds: bool  # whether it folds
    # Largest less least movement across a straight line of a grid over and around the faces, % of
    # the distance between the outer eye corners.
    rise: float
    # Largest turn of straight lines found in the photo outside of the faces, such as hair and
    # collars, degrees. None without such a line.
    photo_turn: float | None
    # In % of the distance between the outer eye corners: mean error of the displacement at the
    # targets; largest error of the outline between targets; mean distance of the moved landmarks
    # from the targets.
    residual: float
    contour: float
    landing: float


@dataclass(frozen=True, slots=True)
class DistortionResult:
    """Results for table 1 and figure 11 on some photos, with one recipe."""

    distortions: tuple[Distortion, ...]
    recipe: Recipe

    def of(self, variant: Variant) -> list[Distortion]:
        return [one for one in self.distortions if one.variant == variant]


def measure(
    subject: Subject, recipe: Recipe = PAPER, *, progress: Progress = no_progress
) -> list[Distortion]:
    """Measure one photo at each centre and distance of table 1 and each lattice of figure 11."""
    found = []
    chosen = variants(recipe)
    lines = _LinesOf(subject)
    for done, variant in enumerate(chosen, start=1):
        rendering = render(subject.pixels, subject.faces, variant.recipe(recipe))
        found.append(_distortion(subject, variant, rendering, lines))
        progress(done, len(chosen))
    return found


def _distortion(
    subject: Subject, variant: Variant, rendering: Rendering, lines: _LinesOf
) -> Distortion:
    field, sound, miss = rendering.field, rendering.one_to_one, rendering.residual
    eyes = 100.0 / subject.interocular_px
    outlines = [face.outline for face in subject.faces]
    before = sum(map(_area, outlines))
    after = sum(_area(shown_at(field, outline)) for outline in outlines)
    near = lines.near(rendering.domain.bounds)
    drawn, own = (
        turns(field, some, subject.pixels, subject.interocular_px) for some in (lines.ruled, near)
    )
    return Distortion(
        photo=subject.name,
        variant=variant,
        spacing_px=float(np.mean([a.grid.spacing_px for a in field.lattices])),
        warp_px=float(np.mean([pairs.warp_distance_px for pairs in rendering.pairs])),
        achieved=float(np.mean(rendering.achieved)),
        face_area=100.0 * (after / before - 1.0),
        local_area=100.0 * _local_area(rendering),
        min_det=sound.min_det,
        max_det=largest_det(field),
        folds=sound.folds,
        rise=max(line.rise_permille for line in drawn) / 10.0,
        photo_turn=own[0].turn_degrees if own else None,
        residual=eyes * miss.mean_px,
        contour=eyes * miss.contour_max_px,
        landing=eyes * float(np.mean([_landing_px(field, pairs) for pairs in rendering.pairs])),
    )


def _landing_px(field: Field, pairs: FacePairs) -> float:
    landed = shown_at(field, pairs.source_px, pairs.target_px)
    return float(np.linalg.norm(landed - pairs.target_px, axis=1).mean())


class _LinesOf:
    """Straight lines: a grid over the faces, and lines of the photo outside of the faces."""

    def __init__(self, subject: Subject) -> None:
        self.ruled = _grid(np.vstack([face.points for face in subject.faces]))
        found = long_enough(straight_lines(subject.pixels), subject.pixels)
        self._own = off_faces(found, [face.points for face in subject.faces])

    def near(self, box: Box) -> Array:
        """Return the photo's own lines whose bounding box meets `box`."""
        low, high = self._own.min(axis=1), self._own.max(axis=1)
        over = (low[:, 0] < box.right) & (high[:, 0] >= box.left)
        return np.asarray(self._own[over & (low[:, 1] < box.bottom) & (high[:, 1] >= box.top)])


def _grid(points: Array) -> Array:
    """Return a grid of straight lines over and around points, shape (2 RULES, 2, 2)."""
    low, high = points.min(axis=0), points.max(axis=0)
    low, high = low - _ROUND * (high - low), high + _ROUND * (high - low)
    xs, ys = np.linspace(low, high, RULES).T
    upright = [((x, low[1]), (x, high[1])) for x in xs]
    level = [((low[0], y), (high[0], y)) for y in ys]
    return np.array(upright + level, np.float64)


def _area(outline: Array) -> float:
    return float(cv2.contourArea(outline.astype(np.float32)))


def _local_area(rendering: Rendering) -> float:
    box = rendering.domain.bounds
    if not box.area:
        return 0.0
    xs = np.linspace(box.left, box.right - 1, _LOCAL_STEPS)
    ys = np.linspace(box.top, box.bottom - 1, _LOCAL_STEPS)
    displacement = rendering.field.on_grid(xs, ys)
    moves = np.hypot(displacement[0], displacement[1]) > rendering.threshold_px
    change = rendering.field.det_jacobian(xs, ys)[moves] - 1.0
    return float(np.sqrt(np.square(change).mean())) if change.size else 0.0


_OTHER: Final = Text("Table 1 was measured on warps of the face alone; here the head moves, too.")


@dataclass(frozen=True, slots=True)
class Measure:
    """A number of `Distortion`."""

    name: str  # column in files
    title: Text
    digits: int  # decimals shown
    # Converts the value to a measure of harm: 0 without a warp, growing with the warp.
    harm: Callable[[float], float] = abs
    harm_title: Text | None = None  # if different from the title

    def median(self, found: Sequence[Distortion]) -> float:
        """Return the median over photos; NaN without values."""
        values = [getattr(one, self.name) for one in found]
        known = [float(value) for value in values if value is not None]
        return statistics.median(known) if known else float("nan")

    def text(self, value: float) -> str:
        return NONE if np.isnan(value) else f"{value:.{self.digits}f}"


MEASURES: Final = (
    Measure("achieved", Text("achieved, % of D"), 2),
    Measure("face_area", Text("area of the face, change in %"), 1),
    Measure("local_area", Text("local change of area, rms in %"), 1),
    Measure(
        "min_det", Text("smallest det J, sampled: stretch"), 2,
        lambda det: 1.0 - det, Text("1 - smallest det J"),
    ),
    Measure(
        "max_det", Text("largest det J, sampled: compression"), 2,
        lambda det: det - 1.0, Text("largest det J - 1"),
    ),
    Measure("rise", Text("rise of the worst ruled line, % of the eyes' distance"), 2),
    Measure("photo_turn", Text("turn of the worst line in the photo, degrees"), 2),
    Measure(
        "residual", Text("displacement off at the targets, mean, % of the eyes' distance"), 3
    ),
    Measure(
        "landing", Text("landmarks land off their targets, mean, % of the eyes' distance"), 3
    ),
    Measure("contour", Text("outline off its curve, largest, % of the eyes' distance"), 3),
)  # fmt: skip
_CHARTED: Final = ("local_area", "min_det", "max_det", "rise")


def report(result: DistortionResult) -> Report:
    """Return the report: growth of each measure, tables in the form of table 1, lattice sizes."""
    photos = len({one.photo for one in result.distortions})
    how = Text.counted(
        photos,
        "{fit} fit, {n} photo. All numbers describe the displacement and the movement of "
        "straight lines.",
        "{fit} fit, {n} photos, medians. All numbers describe the displacement and the "
        "movement of straight lines.",
        fit=SETTINGS["fit"].alternative(result.recipe.fit).title,
    )
    records = [_record(one) for one in result.distortions]
    cells = [_published(), *(_in_its_shape(result, measure) for measure in MEASURES)]
    if result.recipe.scope != "face":
        how = Text.joined(" ", [how, _OTHER])
    parts: list[Part] = [
        _chart(result), how, _growth(result),
        Heading(Text("Cell by cell")), Row(cells, wide=True),
        Heading(Text("Lattice size")), _lattices(result),
    ]  # fmt: skip
    return Report(
        Text("Table 1 and the measured distortion"),
        Text(
            "Above a warp distance of 6 %, people suddenly called faces unnatural. Does a measure"
            " of the warp jump there, too?"
        ),
        parts,
        records,
        {
            "experiment": "distortion",
            "recipe": result.recipe.to_dict(),
            "published_unnatural_percent": [list(row) for row in UNNATURAL],
            "face_alone": result.recipe.scope == "face",
            "units": {measure.name: measure.title for measure in MEASURES},
            "distortions": records,
        },
    )


def _header(first: str) -> tuple[str, ...]:
    return (first, *(f"{distance:g} %" for distance in DISTANCES))


def _published() -> Table:
    rows = [(str(k), *(f"{v:.3f}" for v in row)) for k, row in enumerate(UNNATURAL, start=1)]
    caption = Text("Table 1: answers that called the picture unnatural, %")
    note = Text(
        "Published: {subjects} faces, {students} people, warps of the face alone. Columns: "
        "requested warp distance, % of D. The achieved distance follows below.",
        subjects=SUBJECTS,
        students=STUDENTS,
    )
    return Table(caption, _header(Text("centre")), rows, note)


def _medians(result: DistortionResult, measure: Measure) -> list[list[float]]:
    """Return medians over photos, a row for each centre."""
    medians = [measure.median(result.of(v)) for v in variants(result.recipe) if v.kind == "table1"]
    count = len(DISTANCES)
    return [medians[k : k + count] for k in range(0, len(medians), count)]


def _in_its_shape(result: DistortionResult, measure: Measure) -> Table:
    rows = [
        (str(center), *map(measure.text, row))
        for center, row in enumerate(_medians(result, measure), start=1)
    ]
    return Table(measure.title, _header(Text("centre")), rows)


def _harms(result: DistortionResult, measure: Measure) -> list[list[float]]:
    return [[measure.harm(value) for value in row] for row in _medians(result, measure)]


def _relative(rows: Sequence[Sequence[float]]) -> list[float]:
    """Return means over centres, in % of the last mean; NaN if the last mean is 0."""
    means = np.mean(np.asarray(rows, np.float64), axis=0)
    return [float(value) for value in 100.0 * means / (means[-1] or np.nan)]


def _growth(result: DistortionResult) -> Table:
    published = (Text("unnatural answers (table 1)"), *_whole(_relative(UNNATURAL)), "1.00")
    rows = [published]
    for measure in MEASURES:
        harms = _harms(result, measure)
        alike = rank_correlation(np.ravel(harms), np.ravel(UNNATURAL))
        title = measure.harm_title or measure.title
        rows.append((title, *_whole(_relative(harms)), NONE if alike is None else f"{alike:.2f}"))
    header = (
        *_header(Text("mean over the centres, % of the value at 10 %")),
        Text("rank correlation"),
    )
    note = Text(
        "det J of the backward field: below 1 the result is stretched, above 1 compressed. "
        "Even growth reads 20, 40, 60, 80, 100. Rank correlation: Spearman's, of the 20 cells "
        "with table 1; it compares the order, not the jump."
    )
    return Table(Text("Growth of each measure with the warp distance"), header, rows, note)


def _whole(values: Sequence[float]) -> list[str]:
    return [NONE if np.isnan(value) else f"{value:.0f}" for value in values]


def rank_correlation(a: np.ndarray, b: np.ndarray) -> float | None:
    """Return Spearman's rank correlation; None if a value is missing or all are equal."""
    if np.isnan(a).any() or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return None
    return float(np.corrcoef(_ranks(a), _ranks(b))[0, 1])


def _ranks(values: np.ndarray) -> np.ndarray:
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(counts) - (counts - 1) / 2.0)[place])


def _lattices(result: DistortionResult) -> Table:
    sizes = [variant for variant in variants(result.recipe) if variant.kind == "figure11"]
    found = [result.of(variant) for variant in sizes]
    rows = [
        (Text("lattice spacing, px"), *(f"{_median(one, 'spacing_px'):.1f}" for one in found)),
        (Text("lattice spacing / warp distance"), *(_in_warps(one) for one in found)),
        (
            Text("photos that fold"),
            *(
                Text("{folded} of {count}", folded=sum(p.folds for p in one), count=len(one))
                for one in found
            ),
        ),
        *((m.title, *(m.text(m.median(one)) for one in found)) for m in MEASURES),
    ]
    note = Text(
        "At 4 % towards centre 2, medians over the photos. The paper prints no numbers for "
        "figure 11; the sizes are this program's choice. The columns differ in achieved distance, "
        "too."
    )
    header = ("", *(f"R = {variant.lattice:g}" for variant in sizes))
    return Table(Text("Figure 11's question: lattice sizes"), header, rows, note)


def _in_warps(found: Sequence[Distortion]) -> str:
    warp_px = _median(found, "warp_px")
    return f"{_median(found, 'spacing_px') / warp_px:.2f}" if warp_px > 0.0 else NONE


def _median(found: Sequence[Distortion], name: str) -> float:
    return float(statistics.median(getattr(one, name) for one in found))


def _record(one: Distortion) -> dict[str, object]:
    values = asdict(one)
    variant = values.pop("variant")
    center, distance = one.variant.center - 1, one.variant.percent
    on_grid = one.variant.kind == "table1"
    published = UNNATURAL[center][DISTANCES.index(distance)] if on_grid else None
    photo = values.pop("photo")
    return {"photo": photo, **variant, **values, "published_unnatural_percent": published}


def _chart(result: DistortionResult) -> Chart:
    series = [Series(Text("unnatural answers (table 1)"), _relative(UNNATURAL))]
    for measure in MEASURES:
        if measure.name in _CHARTED:
            title = measure.harm_title or measure.title
            series.append(Series(title, _relative(_harms(result, measure))))
    return Chart(
        Text("Growth with the warp distance"), [f"{distance:g}" for distance in DISTANCES],
        Text("% of the value at 10 %"), series, along=Text("warp distance, % of D"),
        caption=Text("Means over the four centres, in % of the value at 10 %."),
    )  # fmt: skip


def _run(work: Work) -> Report:
    found: list[Distortion] = []
    for subject in work.subjects:
        found += measure(subject, work.recipe, progress=work.progress)
    return report(DistortionResult(tuple(found), work.recipe))


EXPERIMENT: Final = Experiment(
    "distortion",
    Text("D&istortion…"),
    Text("Distortion and table 1"),
    Text("Table 1 and figure 11 with measures: area, folds, bent lines, errors at targets."),
    _run,
    takes_percent=False,  # it tries every distance
)
