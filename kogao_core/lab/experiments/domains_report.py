"""Figures 14 and 15 as a report: bars, curves, tables, pictures."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from fractions import Fraction
from typing import Final

import numpy as np

from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.lab.experiments.domains import Domains, DomainsResult, Error, ThresholdErrors
from kogao_core.lab.reports.charts import Chart, Series
from kogao_core.lab.reports.report import (
    NONE,
    Heading,
    Part,
    Picture,
    Report,
    Row,
    Table,
    recipe_in_words,
)
from kogao_core.lab.reports.spread import Spread
from kogao_core.recipe.settings import DOMAINS, DomainName
from kogao_core.warp.domain import Mask

_TITLE: Final = Text("Figures 14 and 15: the reduced domain")
_LEAD: Final = Text(
    "Which pixels does the warp have to work on, and what does it cost the "
    "picture when pixels that move only a little are left where they are?"
)
_WORDS: Final = {one.name: one.word for one in DOMAINS}


def report(result: DomainsResult) -> Report:
    """Return pixel counts photo by photo, the errors of each threshold, and the domains."""
    parts: list[Part] = [
        Row(_bars(result), wide=True),
        Text("{recipe}.", recipe=recipe_in_words(result.recipe)),
        _counts(result),
        Heading(Text("What a threshold costs the picture")),
        Row(_curves(result), wide=True),
        _errors(result),
        Heading(Text("The domains")),
        Text(
            "What is worked on shows the photo; white pixels keep their bytes. The "
            "threshold is 1/64 px, which changes no byte."
        ),
    ]
    for photo in result.photos:
        parts += [Heading(photo.photo, 3), Row([_figure(photo, name) for name in photo.shown])]
    return Report(_TITLE, _LEAD, parts, _records(result), _document(result))


def _bars(result: DomainsResult) -> list[Chart]:
    shares = [[_share(photo, name) for photo in result.photos] for name in _WORDS]
    spreads = [_computing(result.photos, name) for name in _WORDS]
    pixels = Series(Text("pixels worked on"), list(map(statistics.median, shares)))
    computing = Series(
        Text("computing"), [one.median for one in spreads], [(one.q1, one.q3) for one in spreads]
    )
    words = list(_WORDS.values())
    of = "" if len(result.photos) == 1 else Text(", {count} photos", count=len(result.photos))
    return [
        Chart(
            Text("Pixels to be worked on"), words, Text("% of the image"), [pixels], bars=True,
            caption=Text("Pixels of each domain: median{of}.", of=of),
        ),
        Chart(
            Text("Computing time"), words, "ms", [computing], bars=True,
            caption=Text("From landmarks to pixels: median and quartiles{of}.", of=of),
        ),
    ]  # fmt: skip


def _counts(result: DomainsResult) -> Table:
    groups = [(photo.photo, [photo]) for photo in result.photos]
    if len(groups) > 1:
        groups.insert(0, (Text("median of {count}", count=len(groups)), [*result.photos]))
    rows: list[tuple[str, ...]] = []
    for called, photos in groups:
        rows += [_row(called, photos, name) for name in _WORDS]
        rows.append(_literal_row(called, photos))
    return Table(
        Text("Pixels to be worked on"),
        (
            Text("photo"),
            Text("domain"),
            Text("pixels"),
            Text("% of image"),
            Text("% saved"),
            Text("computing, ms"),
        ),
        rows,
        Text(
            "Computing: median and quartiles of all stages from landmarks to pixels, "
            "domains in turns. Section 4.1 to the letter counts what the 4 x 4 control points "
            "round each target reach, zero or not; control points, what those reach that aren't "
            "zero."
        ),
    )


def _share(photo: Domains, name: DomainName) -> float:
    return 100.0 * photo.counts[name] / photo.counts["image"]


def _row(called: str, photos: Sequence[Domains], name: DomainName) -> tuple[str, ...]:
    pixels = statistics.median(photo.counts[name] for photo in photos)
    share = statistics.median(_share(photo, name) for photo in photos)
    return (
        called, _WORDS[name], _whole_or_half(pixels), f"{share:.1f}", f"{100.0 - share:.1f}",
        _computing(photos, name).text(),
    )  # fmt: skip


def _literal_row(called: str, photos: Sequence[Domains]) -> tuple[str, ...]:
    pixels = statistics.median(photo.literal for photo in photos)
    share = statistics.median(100.0 * p.literal / p.counts["image"] for p in photos)
    what = Text("section 4.1 to the letter")
    return called, what, _whole_or_half(pixels), f"{share:.1f}", f"{100.0 - share:.1f}", NONE


def _computing(photos: Sequence[Domains], name: DomainName) -> Spread:
    """Return the rounds of one photo, or the medians of several."""
    spreads = [photo.computing_ms[name] for photo in photos]
    return spreads[0] if len(spreads) == 1 else Spread.of([one.median for one in spreads])


def _errors(result: DomainsResult) -> Table:
    header = (
        Text("T, px"), Text("% of image"), Text("cut: max"), Text("PSNR, dB"), Text("seam, px"),
        Text("fade: max"), Text("PSNR, dB"), Text("seam, px"), Text("fades proven"),
    )  # fmt: skip
    rows = []
    for steps in _by_threshold(result):
        share = statistics.median(_shares(result, steps))
        proven = sum(step.fade_proven for step in steps)
        rows.append((
            _threshold(steps[0].threshold_px), f"{share:.1f}",
            *_error_cells([step.cut for step in steps]),
            *_error_cells([step.fade for step in steps]),
            Text("{proven} of {count}", proven=proven, count=len(steps)),
        ))  # fmt: skip
    note = Text(
        "Against the result without a threshold; medians over the photos. Max: "
        "largest difference of a pixel, of 255. PSNR: over the control-point "
        "domain; a dash where no byte differs. Seam: largest step that the "
        "threshold brings in between neighbouring pixels. Cut: as in the paper, "
        "pixels below T aren't moved; fade: the move comes in over [T, 2T]. A "
        "fade that isn't proven could fold in bands thinner than the samples."
    )
    return Table(Text("Error that each threshold causes"), header, rows, note)


def _error_cells(errors: list[Error]) -> tuple[str, str, str]:
    psnr = _psnr(errors)
    return (
        _whole_or_half(statistics.median(error.max_levels for error in errors)),
        NONE if psnr is None else f"{psnr:.1f}",
        f"{statistics.median(error.seam_px for error in errors):.3f}",
    )


def _psnr(errors: list[Error]) -> float | None:
    """Return the median; None where at least half of the results have no error."""
    found = [float("inf") if e.psnr_db is None else e.psnr_db for e in errors]
    middle = statistics.median(found)
    return None if middle == float("inf") else middle


def _whole_or_half(value: float) -> str:
    """Return a median of whole numbers, which an even number of photos can put between two."""
    return f"{value:.1f}".removesuffix(".0")


def _by_threshold(result: DomainsResult) -> list[list[ThresholdErrors]]:
    return [list(steps) for steps in zip(*(p.steps for p in result.photos), strict=True)]


def _shares(result: DomainsResult, steps: list[ThresholdErrors]) -> list[float]:
    pairs = zip(result.photos, steps, strict=True)
    return [100.0 * step.pixels / photo.counts["image"] for photo, step in pairs]


def _threshold(px: float) -> str:
    return f"{Fraction(px)}" if px < 1.0 else f"{px:g}"


def _records(result: DomainsResult) -> list[dict[str, object]]:
    return [_record(photo, step) for photo in result.photos for step in photo.steps]


def _record(photo: Domains, step: ThresholdErrors) -> dict[str, object]:
    return {
        "photo": photo.photo,
        "width": photo.width,
        "height": photo.height,
        "faces": photo.faces,
        "image_pixels": photo.counts["image"],
        "control_point_pixels": photo.counts["control-points"],
        "section_4_1_pixels": photo.literal,
        "threshold_px": step.threshold_px,
        "pixels": step.pixels,
        **{f"cut_{name}": value for name, value in asdict(step.cut).items()},
        **{f"fade_{name}": value for name, value in asdict(step.fade).items()},
        "fade_proven": step.fade_proven,
    }


def _document(result: DomainsResult) -> dict[str, object]:
    return {
        "experiment": "domains",
        "recipe": result.recipe.to_dict(),
        "photos": [
            {
                "photo": photo.photo,
                "counts": photo.counts,
                "section_4_1_pixels": photo.literal,
                "computing_ms": {name: asdict(s) for name, s in photo.computing_ms.items()},
                "steps": [_record(photo, step) for step in photo.steps],
            }
            for photo in result.photos
        ],
    }


def pictures(stem: str, masks: Mapping[DomainName, Mask]) -> Iterator[tuple[str, Image]]:
    """Yield masks as pictures with their files' names: white is worked on, black stays."""
    for name, mask in masks.items():
        yield f"{stem}-{name}.png", np.where(mask, np.uint8(255), np.uint8(0))


def _curves(result: DomainsResult) -> list[Chart]:
    by_threshold = _by_threshold(result)
    places = [_threshold(steps[0].threshold_px) for steps in by_threshold]

    def errors(of: Callable[[list[Error]], float]) -> list[Series]:
        return [
            Series(
                Text("cut, as in the paper"), [of([s.cut for s in steps]) for steps in by_threshold]
            ),
            Series(
                Text("fade over [T, 2T]"), [of([s.fade for s in steps]) for steps in by_threshold]
            ),
        ]

    def median(name: str) -> Callable[[list[Error]], float]:
        return lambda found: statistics.median(getattr(error, name) for error in found)

    shares = [statistics.median(_shares(result, steps)) for steps in by_threshold]
    charts = (
        (
            Text("Pixels worked on"),
            Text("% of the image"),
            [Series(Text("pixels that move by more than T"), shares)],
        ),
        (Text("Largest difference"), Text("levels of 255"), errors(median("max_levels"))),
        (
            Text("Signal-to-noise ratio"),
            Text("PSNR, dB"),
            errors(lambda e: _psnr(e) or float("nan")),
        ),
        (Text("Seam"), Text("step between neighbours, px"), errors(median("seam_px"))),
    )
    return [
        Chart(
            title, places, unit, series, along=Text("threshold T, px"),
            caption=Text("{title}; medians over the photos.", title=title),
        )
        for title, unit, series in charts
    ]  # fmt: skip


def _figure(photo: Domains, name: DomainName) -> Picture:
    which = next(one.description for one in DOMAINS if one.name == name)
    caption = Text(
        "{which}: {count} pixels, {share:.1f} % of the image",
        which=which,
        count=photo.counts[name],
        share=_share(photo, name),
    )
    return Picture(
        photo.shown[name], caption, Text("{photo}, {caption}", photo=photo.photo, caption=caption)
    )
