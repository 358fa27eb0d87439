"""Report of the method comparison: tables and pictures."""

from __future__ import annotations

import dataclasses
import statistics
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Final

from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.lab.experiments import methods
from kogao_core.lab.experiments.experiment import Experiment, ExperimentOption, Work
from kogao_core.lab.experiments.methods import DIFFERENCE_GAIN, SAMPLES_PX, Compared, Comparison
from kogao_core.lab.reports.report import Heading, Part, Picture, Report, Row, Table
from kogao_core.lab.reports.spread import Spread, in_columns, rounded
from kogao_core.recipe.recipe import Recipe

# Photos are compared in classes of the longer side, px: ratios of times depend on the size.
_CLASSES_PX: Final = (0, 640, 1280, 2560, 5120, 10**6)
_Rows = Sequence[tuple[Comparison, Compared]]  # a method's results, with those of its photo
_FIGURES: Final = (
    *("residual_mean_px", "residual_max_px", "landing_mean_px", "min_det"),
    *("max_det", "folded_share", "moved_share", "largest_px"),
)
_KINDS: Final = {
    "result": Text("Result"),
    "difference": Text("Difference to the photo, times {gain}", gain=DIFFERENCE_GAIN),
    "heat": Text("Displacement"),
}


def report(photos: Sequence[Comparison], recipe: Recipe, repeats: int) -> Report:
    """Return tables of costs and effects for each class of photo sizes, then pictures."""
    # Only landmarks and targets are the same for all methods, so the faces move alone.
    recipe = dataclasses.replace(recipe, scope="face")
    parts: list[Part] = [
        Text(
            "{amount}; B-splines with lattice R = {lattice:g}. {repeats} rounds.",
            amount=recipe.amount,
            lattice=recipe.lattice,
            repeats=repeats,
        ),
    ]
    for least, most in pairwise(_CLASSES_PX):
        if mine := [photo for photo in photos if least < photo.longer_side_px <= most]:
            parts += _tables(_of_size(mine), mine)
    for photo in photos:
        parts += _photo(photo)
    records = [_record(photo, one) for photo in photos for one in photo.methods]
    document: dict[str, object] = {
        "experiment": "methods",
        "recipe": recipe.to_dict(),
        "repeats": repeats,
        "photos": records,
    }
    return Report(
        Text("Methods side by side"),
        Text(
            "The paper's method, methods of the paper's references and newer methods move the "
            "same landmarks to the same targets. The report compares accuracy, speed, moved "
            "pixels and folds."
        ),
        parts,
        records,
        document,
    )


def _of_size(photos: Sequence[Comparison]) -> Text:
    sides = [photo.longer_side_px for photo in photos]
    return Text.counted(
        len(photos),
        "{n} photo of {least} px",
        "{n} photos of {least} to {most} px",
        least=min(sides),
        most=max(sides),
    )


def _tables(of: str, photos: Sequence[Comparison]) -> list[Table]:
    by_method: dict[str, list[tuple[Comparison, Compared]]] = {}
    for photo in photos:
        for one in photo.methods:
            by_method.setdefault(one.method.name, []).append((photo, one))
    rows = list(by_method.values())
    method = Text("method"), lambda mine: mine[0][1].method.title
    first = photos[0].methods[0].method.title
    over = Text(" Medians over the photos.") if len(photos) > 1 else ""
    return [
        Table.of(
            Text("Computing time: {of}", of=of),
            rows,
            [
                method,
                (Text("reference"), lambda mine: mine[0][1].method.reference),
                (Text("fit, ms"), _time("fit_ms")),
                (Text("warp, ms"), _time("warp_ms")),
                (Text("processor, ms"), _time("processor_ms")),
                (Text("times the first"), _times_the_first),
            ],
            Text(
                "Median and quartiles of a photo's rounds, methods in turns.{over} Times the "
                "first: processor time against {first}; depends on the size of the picture. "
                "B-spline fits resample the engine's domain; all others compute a grid of at most "
                "8 px and resample the box that moves by more than 1/64 px. All resample "
                "bilinearly.",
                over=over,
                first=first,
            ),
        ),
        Table.of(
            Text("Accuracy and effect: {of}", of=of),
            rows,
            [
                method,
                (Text("off at targets, px"), _median("residual_mean_px", 2)),
                (Text("largest"), _median("residual_max_px", 2)),
                (Text("landmarks land off, px"), _median("landing_mean_px", 2)),
                (Text("smallest det J"), _median("min_det", 2)),
                (Text("largest det J"), _median("max_det", 2)),
                (Text("% folded"), _median("folded_share", 3, 100.0)),
                (Text("% moved"), _median("moved_share", 1, 100.0)),
            ],
            Text(
                "Off at targets: difference to the requested displacement, mean and largest. The "
                "map goes backward: det J below 1 is stretch, above 1 compression. Folded, moved "
                "(by more than 1/64 px) and det J: by differences between pixels, every pixel of "
                "photos up to {most:g} megapixels.{over}",
                most=SAMPLES_PX / 1e6,
                over=over,
            ),
        ),
    ]


def _median(name: str, digits: int, unit: float = 1.0) -> Callable[[_Rows], str]:
    def cell(mine: _Rows) -> str:
        return f"{unit * statistics.median(getattr(one, name) for _, one in mine):.{digits}f}"

    return cell


def _time(clock: str) -> Callable[[_Rows], str]:
    """Return the rounds of one photo, or the median of several photos."""

    def cell(mine: _Rows) -> str:
        spreads: list[Spread] = [getattr(one, clock) for _, one in mine]
        if len(spreads) == 1:
            return spreads[0].text()
        return rounded(statistics.median(spread.median for spread in spreads))

    return cell


def _times_the_first(mine: _Rows) -> str:
    """Return the processor time relative to the first method, median over photos."""
    ratios = (one.processor_ms.median / photo.methods[0].processor_ms.median for photo, one in mine)
    return rounded(statistics.median(ratios))


def _record(photo: Comparison, one: Compared) -> dict[str, object]:
    return {
        "photo": photo.subject.name,
        "faces": len(photo.subject.faces),
        "longer_side_px": photo.longer_side_px,
        "asked_px": photo.asked_px,
        "method": one.method.name,
        "reference": one.method.reference,
        **in_columns("fit", one.fit_ms),
        **in_columns("warp", one.warp_ms),
        "processor_median_ms": one.processor_ms.median,
        **{name: getattr(one, name) for name in _FIGURES},
    }


def pictures(comparison: Comparison) -> Iterator[tuple[str, Image]]:
    """Yield result, difference and heat map of every method in the photo's size."""
    for one in comparison.methods:
        for kind, pixels in one.pictures.items():
            yield f"{comparison.subject.stem}-{one.method.name}-{kind}.png", pixels


def _photo(photo: Comparison) -> Iterator[Part]:
    name = photo.subject.name
    yield Heading(name)
    original = Picture(photo.subject.pixels, Text("The photo"), Text("{name} as it is", name=name))
    for kind, title in _KINDS.items():
        yield Heading(title, 3)
        if kind == "heat":
            yield Text(
                "Dark violet does not move; yellow moves by {asked_px:.1f} px, the largest "
                "requested distance of a landmark, or more.",
                asked_px=photo.asked_px,
            )
        figures = [
            Picture(
                one.pictures[kind],
                one.method.title,
                Text(
                    "{title}: {method}, {photo}", title=title, method=one.method.title, photo=name
                ),
            )
            for one in photo.methods
        ]
        yield Row([original, *figures] if kind == "result" else figures)


def _run(work: Work) -> Report:
    photos = []
    for subject in work.subjects:
        comparison, failed = methods.measure(
            subject, work.recipe, progress=work.progress, **work.given
        )
        for sentence in failed:
            work.leave_out(sentence)
        work.keep(pictures(comparison))
        photos.append(comparison.views())
    return report(photos, work.recipe, work.given["repeats"])


EXPERIMENT: Final = Experiment(
    "methods",
    Text("&Methods side by side…"),
    Text("Methods side by side"),
    Text("Compare B-splines with other warps: speed, accuracy, folds, domain, pictures."),
    _run,
    (ExperimentOption("repeats", 3, in_window=2),),
)
