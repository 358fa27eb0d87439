"""Methods side by side as tables, records and a report of pictures."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from kogao_core.experiments import report
from kogao_core.experiments.methods.base import Method
from kogao_core.experiments.methods.comparing import (
    DIFFERENCE_GAIN,
    SAMPLES_PX,
    Compared,
    Comparison,
    Result,
)
from kogao_core.experiments.report import Html, Made, Table
from kogao_core.experiments.spread import Spread, rounded
from kogao_core.geometry import Image

TITLE: Final = "Methods side by side"
LEAD: Final = (
    "The same landmarks go to the same targets by the methods of the paper's references and of "
    "today's practice: how exactly, how fast, over how many pixels, and does it fold?"
)
_KINDS: Final = {
    "result": "Results",
    "difference": f"Differences to the photo, times {DIFFERENCE_GAIN}",
    "heat": "Displacement",
}


def tables(result: Result) -> list[Table]:
    """Return what each method costs and does, over all photos, then photo by photo."""
    found = _tables("", result.photos)
    if len(result.photos) > 1:
        for photo in result.photos:
            found += _tables(f", {photo.subject.name}", [photo])
    return found


def _tables(of: str, photos: Sequence[Comparison]) -> list[Table]:
    methods = _methods(photos)
    first = methods[0].title if methods else ""
    over = " Medians over the photos." if len(photos) > 1 else ""
    return [
        Table(
            f"What the methods cost{of}",
            ("method", "reference", "library", "fit, ms", "warp, ms", "times the first"),
            [_cost(photos, method) for method in methods],
            f"Median and quartiles of a photo's rounds, methods in turns.{over} The last column "
            f"compares fit and warp together with {first}: the median of the photos' own ratios. "
            "B-splines resample their own domain, the others the whole photo, all bilinearly. Own "
            "rivals are written to be right, not fast: their times say little.",
        ),
        Table(
            f"What the methods do{of}",
            ("method", "landmarks off, px", "largest", "smallest det J", "% folded", "% moved"),
            [_effect(photos, method) for method in methods],
            "Landmarks off: mean and largest. Folded, moved (by more than 1/64 px) and det J: by "
            f"differences between pixels, every one of photos up to {SAMPLES_PX / 1e6:g} "
            f"megapixels.{over}",
        ),
    ]


def _methods(photos: Sequence[Comparison]) -> list[Method]:
    found = {one.method.name: one.method for photo in photos for one in photo.methods}
    return list(found.values())


def _of(photos: Sequence[Comparison], method: Method) -> list[Compared]:
    return [one for photo in photos for one in photo.methods if one.method.name == method.name]


def _cost(photos: Sequence[Comparison], method: Method) -> tuple[str, ...]:
    mine = _of(photos, method)
    return (
        method.title, method.reference, method.library,
        _time([one.fit_ms for one in mine]), _time([one.warp_ms for one in mine]),
        rounded(_times_the_first(photos, method)),
    )  # fmt: skip


def _effect(photos: Sequence[Comparison], method: Method) -> tuple[str, ...]:
    mine = _of(photos, method)

    def median(of: Callable[[Compared], float]) -> float:
        return float(statistics.median(of(one) for one in mine))

    return (
        method.title,
        f"{median(lambda one: one.residual_mean_px):.2f}",
        f"{median(lambda one: one.residual_max_px):.2f}",
        f"{median(lambda one: one.min_det):.2f}",
        f"{100.0 * median(lambda one: one.folded_share):.3f}",
        f"{100.0 * median(lambda one: one.moved_share):.1f}",
    )


def _time(spreads: Sequence[Spread]) -> str:
    if len(spreads) == 1:
        return spreads[0].text()
    return rounded(statistics.median(spread.median for spread in spreads))


def _times_the_first(photos: Sequence[Comparison], method: Method) -> float:
    """Return how many times longer than the first method it takes, median over photos."""
    ratios = []
    for photo in photos:
        whole = {one.method.name: one.fit_ms.median + one.warp_ms.median for one in photo.methods}
        if method.name in whole:
            ratios.append(whole[method.name] / whole[photo.methods[0].method.name])
    return statistics.median(ratios)


def records(result: Result) -> list[dict[str, object]]:
    """Return one flat record for each photo and method."""
    return [_record(photo, one) for photo in result.photos for one in photo.methods]


def _record(photo: Comparison, one: Compared) -> dict[str, object]:
    return {
        "photo": photo.subject.name,
        "faces": len(photo.subject.faces),
        "asked_px": photo.asked_px,
        "method": one.method.name,
        "reference": one.method.reference,
        "library": one.method.library,
        "fit_median_ms": one.fit_ms.median,
        "fit_q1_ms": one.fit_ms.q1,
        "fit_q3_ms": one.fit_ms.q3,
        "warp_median_ms": one.warp_ms.median,
        "warp_q1_ms": one.warp_ms.q1,
        "warp_q3_ms": one.warp_ms.q3,
        "residual_mean_px": one.residual_mean_px,
        "residual_max_px": one.residual_max_px,
        "min_det": one.min_det,
        "folded_share": one.folded_share,
        "moved_share": one.moved_share,
        "largest_px": one.largest_px,
    }


def document(result: Result) -> dict[str, object]:
    """Return everything but the pictures as JSON values."""
    return {
        "experiment": "methods",
        "recipe": result.recipe.to_dict(),
        "repeats": result.repeats,
        "photos": records(result),
    }


def pictures(comparison: Comparison) -> Iterator[tuple[str, Image]]:
    """Yield result, difference and heat of every method at the photo's own size."""
    for one in comparison.methods:
        for kind, pixels in one.pictures.items():
            yield f"{comparison.subject.stem}-{one.method.name}-{kind}.png", pixels


def html(result: Result, made: Made) -> str:
    """Return the report, of `Comparison.views`."""
    recipe, several = result.recipe, len(result.photos) > 1
    what = f"{recipe.percent:g} % of D towards centre {recipe.center:g}; B-splines with lattice "
    blocks: list[Html] = [
        report.paragraph(f"{what}R = {recipe.lattice:g}. {result.repeats} rounds that count."),
        *map(report.table, _tables("", result.photos)),
    ]
    for photo in result.photos:
        blocks += _photo(photo, _tables(f", {photo.subject.name}", [photo]) if several else [])
    return report.page(TITLE, LEAD, blocks, made)


def _photo(photo: Comparison, tables: Sequence[Table]) -> Iterator[Html]:
    name = photo.subject.name
    yield report.heading(name)
    yield from map(report.table, tables)
    original = report.picture(photo.subject.pixels, "The photo", alt=f"{name} as it is")
    for kind, title in _KINDS.items():
        yield report.heading(title, 3)
        if kind == "heat":
            yield report.paragraph(
                "Dark violet stays; yellow moves by the largest distance that a landmark asks for, "
                f"{photo.asked_px:.1f} px, or more."
            )
        figures = [
            report.picture(
                one.pictures[kind], _caption(one, kind), alt=f"{title}: {one.method.title}, {name}"
            )
            for one in photo.methods
        ]
        yield report.side_by_side([original, *figures] if kind == "result" else figures)


def _caption(one: Compared, kind: str) -> str:
    facts = {
        "result": f"landmarks off by {one.residual_mean_px:.2f} px on average",
        "difference": f"smallest det J {one.min_det:.2f}",
        "heat": f"{100.0 * one.moved_share:.0f} % of the image moves, {one.largest_px:.1f} px most",
    }
    return f"{one.method.title}: {facts[kind]}"
