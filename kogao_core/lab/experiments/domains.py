"""Figures 14 and 15: pixels of each domain, and the error of ignoring small displacements."""

from __future__ import annotations

import dataclasses
import math
import statistics
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Final

import numpy as np

from kogao_core.base.display import reduced, rgb8
from kogao_core.base.geometry import Array, Box, Image
from kogao_core.base.language import Text
from kogao_core.field.field import Field
from kogao_core.lab.experiments.experiment import Experiment, ExperimentOption, Work
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
from kogao_core.lab.reports.spread import Spread, in_turns
from kogao_core.lab.subjects import Progress, Subject, no_progress
from kogao_core.paper.domain import Mask, mask_of
from kogao_core.pipeline import Rendering, render
from kogao_core.recipe.recipe import LOSSLESS_PX, Recipe
from kogao_core.recipe.settings import DOMAINS, DomainName

THRESHOLDS: Final = (0.0, LOSSLESS_PX, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0)  # px
_LEVELS: Final = 255.0
_WORDS: Final = {one.name: one.word for one in DOMAINS}


@dataclass(frozen=True, slots=True)
class Error:
    """Differences between a thresholded result and the result without a threshold."""

    max_levels: float  # largest difference of a pixel, scaled to 0 to 255
    psnr_db: float | None  # peak signal-to-noise ratio over the pixels of the control-point domain
    # Largest step of the displacement between neighbouring pixels caused by the threshold, px.
    seam_px: float


@dataclass(frozen=True, slots=True)
class ThresholdErrors:
    """Results of one threshold."""

    threshold_px: float  # T: smaller displacements are ignored
    pixels: int  # pixels with larger displacements
    cut: Error  # as in section 4.2: no displacement below T
    fade: Error  # as in this program: the displacement fades in over [T, 2T]
    fade_proven: bool  # whether the fade is proven free of folds


@dataclass(frozen=True, eq=False, kw_only=True)
class Domains:
    """The domains of one photo."""

    photo: str  # name
    # Size of the photo, px.
    width: int
    height: int
    faces: int
    counts: dict[DomainName, int]  # pixels of all three domains
    computing_ms: dict[DomainName, Spread]  # computing time by domain
    steps: tuple[ThresholdErrors, ...]  # one for each threshold
    # The photo inside each domain, white outside; RGB, reduced for a report.
    shown: dict[DomainName, Image]
    # (H, W): masks of the domains other than the whole image, with the lossless threshold.
    masks: dict[DomainName, Mask]


def measure(
    subject: Subject,
    recipe: Recipe,
    *,
    thresholds: Sequence[float] = THRESHOLDS,
    repeats: int = 5,
    progress: Progress = no_progress,
) -> Domains:
    """Count and time the domains of one photo, and measure the errors of thresholds."""
    whole = _render(subject, recipe, "control-points")
    image = whole.domain.image
    masks = {one.name: mask_of(whole.field.lattices, image, one.name) for one in DOMAINS}
    compared = _Compared(subject, whole, masks["control-points"])
    steps = []
    for done, threshold_px in enumerate(thresholds, start=1):
        steps.append(compared.step(threshold_px, recipe))
        progress(done, len(thresholds) + 1)
    computing = _times(subject, recipe, repeats)
    progress(len(thresholds) + 1, len(thresholds) + 1)
    return Domains(
        photo=subject.name,
        width=subject.size[0],
        height=subject.size[1],
        faces=len(subject.faces),
        counts={name: int(mask.sum()) for name, mask in masks.items()},
        computing_ms=computing,
        steps=tuple(steps),
        shown={name: _shown(subject, mask) for name, mask in masks.items()},
        masks={name: mask for name, mask in masks.items() if name != "image"},
    )


def _shown(subject: Subject, mask: Mask) -> Image:
    return reduced(np.where(mask[..., None], rgb8(subject.pixels), np.uint8(255)))


def _render(
    subject: Subject, recipe: Recipe, domain: DomainName, threshold_px: float = LOSSLESS_PX
) -> Rendering:
    chosen = dataclasses.replace(recipe, domain=domain, threshold_px=threshold_px)
    return render(subject.pixels, subject.faces, chosen)


def _times(subject: Subject, recipe: Recipe, repeats: int) -> dict[DomainName, Spread]:
    times: dict[DomainName, list[float]] = {one.name: [] for one in DOMAINS}
    for name, counts in in_turns([one.name for one in DOMAINS], repeats, 1):
        rendering = _render(subject, recipe, name)
        if counts:
            times[name].append(sum(rendering.timings_ms.values()))
    return {name: Spread.of(ms) for name, ms in times.items()}


class _Compared:
    """Compares results with and without a threshold inside the control-point domain."""

    def __init__(self, subject: Subject, whole: Rendering, domain: Mask) -> None:
        self.subject, self.box = subject, whole.domain.bounds
        self.domain = domain[self.box.slices]
        self.photo = subject.pixels[self.box.slices]
        self.whole = whole.pixels[self.box.slices]
        self.displacement = _displacement(whole.field, self.box)
        self.length = np.hypot(self.displacement[0], self.displacement[1])

    def step(self, threshold_px: float, recipe: Recipe) -> ThresholdErrors:
        moves = self.length > threshold_px
        cut = np.where(moves if self.whole.ndim == 2 else moves[..., None], self.whole, self.photo)
        rendering = _render(self.subject, recipe, "threshold", threshold_px)
        faded = rendering.pixels[self.box.slices]
        # The guard removes a fade that could fold from the field; such a fade isn't proven.
        refused = rendering.threshold_px < threshold_px
        return ThresholdErrors(
            threshold_px,
            int(moves.sum()),
            self._error(cut, np.where(moves, self.displacement, 0.0)),
            self._error(faded, _displacement(rendering.field, self.box)),
            rendering.one_to_one.edges_proven and not refused,
        )

    def _error(self, pixels: Image, displacement: Array) -> Error:
        white = 1.0 if pixels.dtype == np.float32 else np.iinfo(pixels.dtype).max
        apart = np.abs(pixels.astype(np.float64) - self.whole) * (_LEVELS / white)
        inside = apart[self.domain]
        mean = float(np.square(inside).sum()) / max(1, inside.size)
        psnr = 10.0 * float(np.log10(_LEVELS**2 / mean)) if mean > 0.0 else None
        return Error(
            float(apart.max(initial=0.0)), psnr, _largest_step(displacement - self.displacement)
        )


def _displacement(field: Field, box: Box) -> Array:
    return field.on_grid(np.arange(box.left, box.right), np.arange(box.top, box.bottom))


def _largest_step(change: Array) -> float:
    """Return the largest difference of a (2, H, W) displacement between neighbours, px."""
    along = (np.diff(change, axis=axis) for axis in (1, 2))
    return max(float(np.hypot(step[0], step[1]).max(initial=0.0)) for step in along)


# -- the report ------------------------------------------------------------------------------------


def report(photos: Sequence[Domains], recipe: Recipe) -> Report:
    """Return the report: pixel counts, errors of thresholds, pictures of domains."""
    parts: list[Part] = [
        Row(_curves(photos), wide=True),
        Text("{recipe}.", recipe=recipe_in_words(recipe)),
        _counts(photos),
        _errors(photos),
        Heading(Text("The domains")),
        Text(
            "The domains show the photo; white pixels keep their bytes. A threshold of 1/64 px "
            "changes no byte."
        ),
    ]
    for photo in photos:
        parts += [Heading(photo.photo, 3), Row([_figure(photo, name) for name in photo.shown])]
    records = [_record(photo, step) for photo in photos for step in photo.steps]
    return Report(
        Text("Figures 14 and 15: the reduced domain"),
        Text(
            "Which pixels must the warp process? How large is the error if pixels with small "
            "displacements stay unchanged?"
        ),
        parts,
        records,
        {
            "experiment": "domains",
            "recipe": recipe.to_dict(),
            "photos": [
                {
                    "photo": photo.photo,
                    "counts": photo.counts,
                    "computing_ms": {name: asdict(s) for name, s in photo.computing_ms.items()},
                    "steps": [_record(photo, step) for step in photo.steps],
                }
                for photo in photos
            ],
        },
    )


def _counts(photos: Sequence[Domains]) -> Table:
    groups: list[tuple[str, Sequence[Domains]]] = [(one.photo, [one]) for one in photos]
    if len(groups) > 1:
        groups.insert(0, (Text("median of {count}", count=len(groups)), photos))
    rows: list[tuple[str, ...]] = []
    for called, group in groups:
        for name, word in _WORDS.items():
            cells = _count_cells(group, [one.counts[name] for one in group])
            rows.append((called, word, *cells, _computing(group, name).text()))
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
            "Computing: median and quartiles from landmarks to pixels, domains in turns. Control "
            "points: cells in reach of control points other than zero."
        ),
    )


def _shares(photos: Sequence[Domains], pixels: Sequence[int]) -> list[float]:
    pairs = zip(photos, pixels, strict=True)
    return [100.0 * count / photo.counts["image"] for photo, count in pairs]


def _count_cells(photos: Sequence[Domains], pixels: Sequence[int]) -> tuple[str, ...]:
    share = statistics.median(_shares(photos, pixels))
    return _whole_or_half(statistics.median(pixels)), f"{share:.1f}", f"{100.0 - share:.1f}"


def _computing(photos: Sequence[Domains], name: DomainName) -> Spread:
    """Return the rounds of one photo, or the medians of several photos."""
    spreads = [photo.computing_ms[name] for photo in photos]
    return spreads[0] if len(spreads) == 1 else Spread.of([one.median for one in spreads])


def _errors(photos: Sequence[Domains]) -> Table:
    header = (
        Text("T, px"), Text("% of image"), Text("cut: max"), Text("PSNR, dB"), Text("seam, px"),
        Text("fade: max"), Text("PSNR, dB"), Text("seam, px"), Text("fades proven"),
    )  # fmt: skip
    rows = []
    for steps in _by_threshold(photos):
        share = _median_share(photos, steps)
        proven = sum(step.fade_proven for step in steps)
        rows.append((
            _threshold(steps[0].threshold_px), f"{share:.1f}",
            *_error_cells([step.cut for step in steps]),
            *_error_cells([step.fade for step in steps]),
            Text("{proven} of {count}", proven=proven, count=len(steps)),
        ))  # fmt: skip
    note = Text(
        "Differences to the result without a threshold, medians over the photos. Max: largest "
        "difference of a pixel, of 255. PSNR: over the control-point domain. Seam: largest step "
        "between neighbouring pixels. Cut: no displacement below T, as in the paper. Fade: the "
        "displacement fades in over [T, 2T]. A fade without proof could fold between the samples."
    )
    return Table(Text("Error of each threshold"), header, rows, note)


def _error_cells(errors: list[Error]) -> tuple[str, str, str]:
    psnr = _psnr(errors)
    return (
        _whole_or_half(_levels(errors)),
        NONE if math.isnan(psnr) else f"{psnr:.1f}",
        f"{_seam(errors):.3f}",
    )


def _levels(errors: list[Error]) -> float:
    return statistics.median(error.max_levels for error in errors)


def _psnr(errors: list[Error]) -> float:
    """Return the median; NaN where at least half of the results have no error."""
    found = [math.inf if e.psnr_db is None else e.psnr_db for e in errors]
    middle = statistics.median(found)
    return math.nan if middle == math.inf else middle


def _seam(errors: list[Error]) -> float:
    return statistics.median(error.seam_px for error in errors)


def _whole_or_half(value: float) -> str:
    """Return a median of whole numbers as text; the median may end in .5."""
    return f"{value:.1f}".removesuffix(".0")


def _by_threshold(photos: Sequence[Domains]) -> list[list[ThresholdErrors]]:
    return [list(steps) for steps in zip(*(p.steps for p in photos), strict=True)]


def _median_share(photos: Sequence[Domains], steps: list[ThresholdErrors]) -> float:
    return statistics.median(_shares(photos, [step.pixels for step in steps]))


def _threshold(px: float) -> str:
    return f"{Fraction(px)}" if px < 1.0 else f"{px:g}"


def _record(photo: Domains, step: ThresholdErrors) -> dict[str, object]:
    return {
        **{name: getattr(photo, name) for name in ("photo", "width", "height", "faces")},
        "image_pixels": photo.counts["image"],
        "control_point_pixels": photo.counts["control-points"],
        "threshold_px": step.threshold_px,
        "pixels": step.pixels,
        **{f"cut_{name}": value for name, value in asdict(step.cut).items()},
        **{f"fade_{name}": value for name, value in asdict(step.fade).items()},
        "fade_proven": step.fade_proven,
    }


def pictures(stem: str, masks: Mapping[DomainName, Mask]) -> Iterator[tuple[str, Image]]:
    """Yield the masks as pictures with file names: white pixels are processed."""
    for name, mask in masks.items():
        yield f"{stem}-{name}.png", np.where(mask, np.uint8(255), np.uint8(0))


def _curves(photos: Sequence[Domains]) -> list[Chart]:
    by_threshold = _by_threshold(photos)
    places = [_threshold(steps[0].threshold_px) for steps in by_threshold]

    def errors(of: Callable[[list[Error]], float]) -> list[Series]:
        return [
            Series(word, [of([getattr(s, way) for s in steps]) for steps in by_threshold])
            for way, word in (
                ("cut", Text("cut, as in the paper")),
                ("fade", Text("fade over [T, 2T]")),
            )
        ]

    shares = [_median_share(photos, steps) for steps in by_threshold]
    moved = [Series(Text("pixels displaced by more than T"), shares)]
    charts = (
        (Text("Pixels worked on"), Text("% of the image"), moved),
        (Text("Largest difference"), Text("levels of 255"), errors(_levels)),
        (Text("Signal-to-noise ratio"), Text("PSNR, dB"), errors(_psnr)),
        (Text("Seam"), Text("step between neighbours, px"), errors(_seam)),
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
        share=100.0 * photo.counts[name] / photo.counts["image"],
    )
    return Picture(
        photo.shown[name], caption, Text("{photo}, {caption}", photo=photo.photo, caption=caption)
    )


def _run(work: Work) -> Report:
    photos: list[Domains] = []
    for subject in work.subjects:
        found = measure(subject, work.recipe, progress=work.progress, **work.given)
        work.keep(pictures(subject.stem, found.masks))
        photos.append(dataclasses.replace(found, masks={}))
    return report(photos, work.recipe)


EXPERIMENT: Final = Experiment(
    "domains",
    Text("Reduced &domains…"),
    Text("Reduced domains (figures 14 and 15)"),
    Text("Figures 14 and 15: pixels of the domains, and the error of each threshold."),
    _run,
    (ExperimentOption("repeats", 5, in_window=3),),
)
