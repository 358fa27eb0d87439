"""Figures 14 and 15: which pixels need work, and what leaving out small moves costs."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.base.display import reduced, rgb8
from kogao_core.base.geometry import Array, Box, Image
from kogao_core.lab.reports.spread import Spread, in_turns
from kogao_core.lab.subjects import Progress, Subject, no_progress
from kogao_core.pipeline import Rendering, render
from kogao_core.recipe.recipe import LOSSLESS_PX, Recipe
from kogao_core.recipe.settings import DOMAINS, DomainName
from kogao_core.warp.domain import Mask, mask_of, pixel_counts
from kogao_core.warp.field import Field
from kogao_core.warp.lattice import ORDER

THRESHOLDS: Final = (0.0, LOSSLESS_PX, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0)  # px
_LEVELS: Final = 255.0


@dataclass(frozen=True, slots=True)
class Error:
    """How a thresholded result differs from the one without a threshold."""

    max_levels: float  # largest difference of a pixel, 0 to 255 whatever the photo's depth
    psnr_db: float | None  # peak signal-to-noise ratio over the pixels of the control-point domain
    # Largest step that the threshold brings into the displacement between neighbouring pixels.
    seam_px: float


@dataclass(frozen=True, slots=True)
class ThresholdErrors:
    """One threshold."""

    threshold_px: float  # T: pixels that move by no more stay
    pixels: int  # pixels that move by more
    cut: Error  # as section 4.2 has it: below T a pixel isn't moved at all
    fade: Error  # as this program has it: the displacement fades in over [T, 2T]
    fade_proven: bool  # whether that fade is proven not to fold


@dataclass(frozen=True, eq=False)
class Domains:
    """The domains of one photo."""

    photo: str  # its name
    # What was worked on, px.
    width: int
    height: int
    faces: int
    counts: dict[DomainName, int]  # pixels of all three domains
    literal: int  # pixels of section 4.1 to the letter, see `literal_pixels`
    computing_ms: dict[DomainName, Spread]  # time that a warp of each domain takes
    steps: tuple[ThresholdErrors, ...]  # one for each threshold
    # The photo where each domain works on it and white elsewhere; RGB, reduced for a report.
    shown: dict[DomainName, Image]
    # (H, W): pixels to work on in each but the whole image, with the lossless threshold.
    masks: dict[DomainName, Mask]

    def without_masks(self) -> Domains:
        """Return what a report needs, which is small."""
        return dataclasses.replace(self, masks={})


@dataclass(frozen=True, slots=True)
class DomainsResult:
    """Figures 14 and 15 for some photos, made with one recipe."""

    photos: tuple[Domains, ...]
    recipe: Recipe


def measure(
    subject: Subject,
    recipe: Recipe,
    *,
    thresholds: Sequence[float] = THRESHOLDS,
    repeats: int = 5,
    progress: Progress = no_progress,
) -> Domains:
    """Count the domains of one photo, time them in turns, and compare thresholds with none."""
    whole = _render(subject, recipe, "control-points")
    image = whole.domain.image
    masks = {one.name: mask_of(whole.field, image, one.name) for one in DOMAINS}
    compared = _Compared(subject, whole, masks["control-points"])
    steps = []
    for done, threshold_px in enumerate(thresholds, start=1):
        steps.append(compared.step(threshold_px, recipe))
        progress(done, len(thresholds) + 1)
    computing = _times(subject, recipe, repeats)
    progress(len(thresholds) + 1, len(thresholds) + 1)
    return Domains(
        subject.name, *subject.size, len(subject.faces),
        {name: int(mask.sum()) for name, mask in masks.items()}, literal_pixels(whole), computing,
        tuple(steps),
        {name: _shown(subject, mask) for name, mask in masks.items()},
        {name: mask for name, mask in masks.items() if name != "image"},
    )  # fmt: skip


def literal_pixels(rendering: Rendering) -> int:
    """Count the pixels of section 4.1 to the letter.

    Those in cells that the 4 x 4 control points round a target reach, whatever they hold; ours are
    those that a control point which isn't zero reaches.
    """
    lattices = []
    for lattice, pairs in zip(rendering.field.lattices, rendering.pairs, strict=True):
        (i, _), (j, _) = (lattice.grid.locate(pairs.target_px[:, axis], axis) for axis in (0, 1))
        phi = np.zeros((np.ptp(j) + ORDER, np.ptp(i) + ORDER, 2))
        for row, column in zip(j - j.min(), i - i.min(), strict=True):
            phi[row : row + ORDER, column : column + ORDER] = 1.0
        first = int(i.min()) - 1, int(j.min()) - 1
        lattices.append(dataclasses.replace(lattice, first=first, phi=phi))
    return pixel_counts(Field(tuple(lattices)), rendering.domain.image, 0.0)["control-points"]


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
    """Results with a threshold against the one without, inside the control-point domain."""

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
        # A fade that the guard refused isn't in the field any more, which says nothing for it.
        refused = rendering.threshold_px < threshold_px
        return ThresholdErrors(
            threshold_px,
            int(moves.sum()),
            self._error(cut, np.where(moves, self.displacement, 0.0)),
            self._error(faded, _displacement(rendering.field, self.box)),
            rendering.one_to_one.edges_proven and not refused,
        )

    def _error(self, pixels: Image, displacement: Array) -> Error:
        apart = np.abs(pixels.astype(np.float64) - self.whole) * (_LEVELS / _depth(pixels))
        mean = float(np.square(apart[self.domain]).sum()) / max(1, apart[self.domain].size)
        psnr_db = 10.0 * float(np.log10(_LEVELS**2 / mean)) if mean > 0.0 else None
        return Error(
            float(apart.max(initial=0.0)), psnr_db, _largest_step(displacement - self.displacement)
        )


def _displacement(field: Field, box: Box) -> Array:
    return field.on_grid(np.arange(box.left, box.right), np.arange(box.top, box.bottom))


def _depth(pixels: Image) -> float:
    return 1.0 if pixels.dtype == np.float32 else float(np.iinfo(pixels.dtype).max)


def _largest_step(change: Array) -> float:
    """Return the largest difference of a (2, H, W) displacement between neighbours, px."""
    along = (np.diff(change, axis=axis) for axis in (1, 2))
    return max(float(np.hypot(step[0], step[1]).max(initial=0.0)) for step in along)
