"""Distortion in the shape of table 1, with the published answers beside."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Final

import numpy as np

from kogao_core.base.language import Text
from kogao_core.faces.naturalness import DISTANCES, STUDENTS, SUBJECTS, UNNATURAL
from kogao_core.lab.experiments.distortion import Distortion, DistortionResult, shown
from kogao_core.lab.reports.charts import Chart, Series
from kogao_core.lab.reports.report import NONE, Heading, Part, Report, Row, Table
from kogao_core.recipe.settings import SETTINGS

_TITLE: Final = Text("Table 1 beside numbers: what the warp distorts")
_LEAD: Final = Text(
    "Above a warp distance of 6 % people suddenly called faces unnatural. Does "
    "anything that can be measured in the warp jump there, too?"
)
_OTHER: Final = Text(
    "Table 1 was measured with the face alone moved; here what surrounds the face goes along, or "
    "eyes and mouth keep their shape."
)


@dataclass(frozen=True, slots=True)
class Measure:
    """A number of `Distortion`."""

    name: str  # of the column in files
    # What people read, within a sentence and above a table.
    title: Text
    heading: Text
    digits: int  # decimals shown
    # Turns it into something that is 0 without a warp and grows with it.
    harm: Callable[[float], float] = abs

    def median(self, found: Sequence[Distortion]) -> float:
        """Return the median over photos; NaN where none has a value."""
        values = [getattr(one, self.name) for one in found]
        known = [float(value) for value in values if value is not None]
        return statistics.median(known) if known else float("nan")

    def text(self, value: float) -> str:
        """Return it as people read it."""
        return NONE if np.isnan(value) else f"{value:.{self.digits}f}"


MEASURES: Final = (
    Measure("achieved", Text("achieved, % of D"), Text("Achieved, % of D"), 2),
    Measure(
        "face_area", Text("area of the face, change in %"), Text("Area of the face, change in %"), 1
    ),
    Measure(
        "local_area",
        Text("local change of area, rms in %"),
        Text("Local change of area, rms in %"),
        1,
    ),
    Measure(
        "min_det",
        Text("smallest det J, sampled: stretch"),
        Text("Smallest det J of the samples (stretched the most)"),
        2,
        lambda det: 1.0 - det,
    ),
    Measure(
        "max_det",
        Text("largest det J, sampled: compression"),
        Text("Largest det J of the samples (compressed the most)"),
        2,
        lambda det: det - 1.0,
    ),
    Measure(
        "bend",
        Text("bend of the worst ruled line, % of the eyes' distance"),
        Text("Bend of the worst ruled line, % of the eyes' distance"),
        2,
    ),
    Measure(
        "photo_bend",
        Text("bend of the worst line in the photo, % of the eyes' distance"),
        Text("Bend of the worst line in the photo, % of the eyes' distance"),
        2,
    ),
    Measure(
        "residual",
        Text("displacement off at the targets, mean, % of the eyes' distance"),
        Text("Displacement off at the targets, mean, % of the eyes' distance"),
        3,
    ),
    Measure(
        "landing",
        Text("landmarks land off their targets, mean, % of the eyes' distance"),
        Text("Landmarks land off their targets, mean, % of the eyes' distance"),
        3,
    ),
    Measure(
        "contour",
        Text("outline off its curve, largest, % of the eyes' distance"),
        Text("Outline off its curve, largest, % of the eyes' distance"),
        3,
    ),
)
_CHARTED: Final = {
    "local_area": Text("local change of area, rms in %"),
    "min_det": Text("1 - smallest det J"),
    "max_det": Text("largest det J - 1"),
    "bend": Text("bend of the worst ruled line"),
}


def report(result: DistortionResult) -> Report:
    """Return how each measure grows, table 1 and each in its shape, and the lattice sizes."""
    photos = len({one.photo for one in result.distortions})
    how = Text.counted(
        photos,
        "{fit} fit, {n} photo. Nothing here looks at a face: these are numbers of the "
        "displacement, and of straight lines that it bends.",
        "{fit} fit, {n} photos, medians. Nothing here looks at a face: these are numbers of the "
        "displacement, and of straight lines that it bends.",
        fit=SETTINGS["fit"].alternative(result.recipe.fit).title,
    )
    cells = [_published(), *(_in_its_shape(result, measure) for measure in MEASURES)]
    if not result.recipe.face_alone:
        how = Text.joined(" ", [how, _OTHER])
    parts: list[Part] = [
        _chart(result), how, _growth(result),
        Heading(Text("Cell by cell")), Row(cells, wide=True),
        Heading(Text("Lattice size")), _lattices(result),
    ]  # fmt: skip
    return Report(_TITLE, _LEAD, parts, _records(result), _document(result))


def _header(first: str) -> tuple[str, ...]:
    return (first, *(f"{distance:g} %" for distance in DISTANCES))


def _published() -> Table:
    rows = [(str(k), *(f"{v:.3f}" for v in row)) for k, row in enumerate(UNNATURAL, start=1)]
    caption = Text("Table 1: answers that called the picture unnatural, %")
    note = Text(
        "Published: {subjects} faces, which moved alone; {students} people. Columns: warp distance "
        "asked for, in % of D; what the fit makes of it follows.",
        subjects=SUBJECTS,
        students=STUDENTS,
    )
    return Table(caption, _header(Text("centre")), rows, note)


def _grid(result: DistortionResult, measure: Measure) -> list[list[float]]:
    """Return medians over photos, a row for each centre."""
    medians = [measure.median(result.of(v)) for v in shown(result.recipe) if v.kind == "table1"]
    count = len(DISTANCES)
    return [medians[k : k + count] for k in range(0, len(medians), count)]


def _in_its_shape(result: DistortionResult, measure: Measure) -> Table:
    rows = [
        (str(center), *map(measure.text, row))
        for center, row in enumerate(_grid(result, measure), start=1)
    ]
    return Table(measure.heading, _header(Text("centre")), rows)


def _harms(result: DistortionResult, measure: Measure) -> list[list[float]]:
    return [[measure.harm(value) for value in row] for row in _grid(result, measure)]


def _relative(rows: Sequence[Sequence[float]]) -> list[float]:
    """Return means over centres, in % of the last; NaN where that is nothing."""
    means = np.mean(np.asarray(rows, np.float64), axis=0)
    return [float(value) for value in 100.0 * means / (means[-1] or np.nan)]


def _growth(result: DistortionResult) -> Table:
    published = (Text("unnatural answers (table 1)"), *_whole(_relative(UNNATURAL)), "1.00")
    rows = [published]
    for measure in MEASURES:
        harms = _harms(result, measure)
        alike = rank_correlation(np.ravel(harms), np.ravel(UNNATURAL))
        title = _CHARTED.get(measure.name, measure.title)
        rows.append((title, *_whole(_relative(harms)), NONE if alike is None else f"{alike:.2f}"))
    header = (
        *_header(Text("mean over the centres, % of its value at 10 %")),
        Text("rank correlation"),
    )
    note = Text(
        "The field says where each pixel is read: where det J is below 1 the result is stretched, "
        "above 1 compressed. A number that grows evenly reads 20, 40, 60, 80, 100. Rank "
        "correlation: Spearman's, of the 20 cells with table 1; it says whether the order "
        "agrees, not the jump. Photos without a straight line beside the face "
        "don't count for that row."
    )
    return Table(Text("How each grows with the warp distance"), header, rows, note)


def _whole(values: Sequence[float]) -> list[str]:
    return [NONE if np.isnan(value) else f"{value:.0f}" for value in values]


def rank_correlation(a: np.ndarray, b: np.ndarray) -> float | None:
    """Return Spearman's rank correlation; None where a value is missing or all are equal."""
    if np.isnan(a).any() or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return None
    return float(np.corrcoef(_ranks(a), _ranks(b))[0, 1])


def _ranks(values: np.ndarray) -> np.ndarray:
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(counts) - (counts - 1) / 2.0)[place])


def _lattices(result: DistortionResult) -> Table:
    sizes = [variant for variant in shown(result.recipe) if variant.kind == "figure11"]
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
        "At 4 % towards centre 2, medians over the photos. The paper prints no "
        "numbers for figure 11; it says that nobody called a face unnatural once "
        "the lattice size exceeded the warp distance. The four sizes are this "
        "program's choice. They achieve different distances, so what differs "
        "between the columns is size and distance together."
    )
    header = ("", *(f"R = {variant.lattice:g}" for variant in sizes))
    return Table(Text("Figure 11's question: lattice sizes"), header, rows, note)


def _in_warps(found: Sequence[Distortion]) -> str:
    warp_px = _median(found, "warp_px")
    return f"{_median(found, 'spacing_px') / warp_px:.2f}" if warp_px > 0.0 else NONE


def _median(found: Sequence[Distortion], name: str) -> float:
    return float(statistics.median(getattr(one, name) for one in found))


def _records(result: DistortionResult) -> list[dict[str, object]]:
    return [_record(one) for one in result.distortions]


def _record(one: Distortion) -> dict[str, object]:
    values = asdict(one)
    variant = values.pop("variant")
    center, distance = one.variant.center - 1, one.variant.percent
    on_grid = one.variant.kind == "table1"
    published = UNNATURAL[center][DISTANCES.index(distance)] if on_grid else None
    photo = values.pop("photo")
    return {"photo": photo, **variant, **values, "published_unnatural_percent": published}


def _document(result: DistortionResult) -> dict[str, object]:
    return {
        "experiment": "distortion",
        "recipe": result.recipe.to_dict(),
        "published_unnatural_percent": [list(row) for row in UNNATURAL],
        "face_alone": result.recipe.face_alone,
        "units": {measure.name: measure.title for measure in MEASURES},
        "distortions": _records(result),
    }


def _chart(result: DistortionResult) -> Chart:
    series = [Series(Text("unnatural answers (table 1)"), _relative(UNNATURAL))]
    for measure in MEASURES:
        if measure.name in _CHARTED:
            series.append(Series(_CHARTED[measure.name], _relative(_harms(result, measure))))
    return Chart(
        Text("Growth with the warp distance"), [f"{distance:g}" for distance in DISTANCES],
        Text("% of the value at 10 %"), series, along=Text("warp distance, % of D"),
        caption=Text("Means over the four centres, in % of the value at 10 %."),
    )  # fmt: skip
