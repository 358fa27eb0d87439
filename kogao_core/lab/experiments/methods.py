"""Fit, time and measure methods on the same points of the same photo."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import cv2
import numpy as np

from kogao_core.base.display import reduced, rgb8
from kogao_core.base.geometry import Array, Box, Image
from kogao_core.base.language import Text
from kogao_core.base.threads import one_blas_thread
from kogao_core.field.field import shown_at
from kogao_core.lab.methods import METHODS, Method, Warp, WarpTask
from kogao_core.lab.reports.spread import Spread, in_turns, processor_ms
from kogao_core.lab.subjects import Progress, Subject, no_progress
from kogao_core.recipe.recipe import LOSSLESS_PX, Recipe

SAMPLES_PX: Final = 2_000_000  # limit of pixels per photo sampled for folds, domain and heat map
DIFFERENCE_GAIN: Final = 4
_ROUND: Final = 0.35  # margin around the faces in report pictures, relative to their size


@dataclass(frozen=True, eq=False)
class Compared:
    """Results of one method on one photo."""

    method: Method
    fit_ms: Spread  # from landmarks to the fitted method
    warp_ms: Spread  # from the fitted method to all pixels
    processor_ms: Spread  # processor time of both, all threads
    # Difference between the displacement at the targets and the requested displacement.
    residual_mean_px: float
    residual_max_px: float
    landing_mean_px: float  # mean distance of the moved landmarks from their targets
    # Jacobian determinant by central differences. The map goes backward: below 1 the picture is
    # stretched, above 1 compressed, at 0 or less it folds.
    min_det: float
    max_det: float
    # Shares of the image, 0 to 1, that fold, and that move by more than LOSSLESS_PX.
    folded_share: float
    moved_share: float
    largest_px: float  # largest displacement
    # ``result``, ``difference`` (to the photo, times `DIFFERENCE_GAIN`) and ``heat``; RGB.
    pictures: dict[str, Image] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Comparison:
    """All methods on one photo."""

    subject: Subject  # photo and faces
    asked_px: float  # largest requested displacement of a landmark: the bright end of the heat map
    methods: tuple[Compared, ...]  # the methods that could be fitted
    longer_side_px: int  # of the photo

    def views(self) -> Comparison:
        """Return the comparison with pictures cropped to the faces and reduced for a report."""
        cut = _round_faces(self.subject)
        seen = tuple(
            dataclasses.replace(
                one, pictures={k: reduced(p[cut.slices]).copy() for k, p in one.pictures.items()}
            )
            for one in self.methods
        )
        photo = reduced(rgb8(self.subject.pixels)[cut.slices]).copy()
        subject = dataclasses.replace(self.subject, pixels=photo)
        return dataclasses.replace(self, subject=subject, methods=seen)


def measure(
    subject: Subject,
    recipe: Recipe,
    *,
    methods: Sequence[Method] = METHODS,
    repeats: int = 3,
    warm_up: int = 1,
    progress: Progress = no_progress,
) -> tuple[Comparison, list[str]]:
    """Compare methods on one photo, in turns.

    Result: the comparison, and a sentence for each method that can't be fitted to these points.
    """
    with one_blas_thread():
        task = WarpTask.of(subject.pixels, subject.faces, recipe)
        fitted, failed = _fitted(methods, task)
        times: dict[str, list[_Times]] = {method.name: [] for method, _ in fitted}
        fits = {method.name: method.fit for method, _ in fitted}
        runs = len(fits) * (repeats + warm_up)
        for done, (name, counts) in enumerate(in_turns(list(fits), repeats, warm_up), start=1):
            took = _time_once(fits[name], task, subject.pixels)
            if counts:
                times[name].append(took)
            progress(done, runs)
        found = [
            _compared(method, warp, task, subject.pixels, times[method.name])
            for method, warp in fitted
        ]
        asked_px = float(np.linalg.norm(task.displacement_px, axis=1).max())
        problems: list[str] = [
            Text("{photo}: {problem}", photo=subject.name, problem=one) for one in failed
        ]
        return Comparison(subject, asked_px, tuple(found), max(subject.size)), problems


def _fitted(
    methods: Sequence[Method], task: WarpTask
) -> tuple[list[tuple[Method, Warp]], list[str]]:
    fitted = []
    failed: list[str] = []
    for method in methods:
        try:
            fitted.append((method, method.fit(task)))
        except (ValueError, np.linalg.LinAlgError) as error:
            failed.append(
                Text(
                    "{method} can't be fitted to these points ({error})",
                    method=method.title,
                    error=error,
                )
            )
    return fitted, failed


class _Times(NamedTuple):
    fit_ms: float
    warp_ms: float
    processor_ms: float


def _time_once(fit: Callable[[WarpTask], Warp], task: WarpTask, photo: Image) -> _Times:
    def run() -> tuple[float, float]:
        start = time.perf_counter()
        warp = fit(task)
        fitted = time.perf_counter()
        warp.pixels(photo)
        return 1e3 * (fitted - start), 1e3 * (time.perf_counter() - fitted)

    wall_ms, took_ms = processor_ms(run)
    return _Times(*wall_ms, took_ms)


def _compared(
    method: Method, warp: Warp, task: WarpTask, photo: Image, times: Sequence[_Times]
) -> Compared:
    misses = np.linalg.norm(warp.at(task.target_px) - task.displacement_px, axis=1)
    landed = shown_at(warp, task.target_px + task.displacement_px, task.target_px)
    step_px = max(1, int(np.ceil(np.sqrt(task.image.area / SAMPLES_PX))))
    ends = task.image.right, task.image.bottom
    displacement = warp.on_grid(*(np.arange(0, end, step_px) for end in ends))
    length, det = np.hypot(displacement[0], displacement[1]), _det(displacement, step_px)
    asked_px = float(np.linalg.norm(task.displacement_px, axis=1).max())
    heat = np.clip(255.0 * length / max(asked_px, 1e-9), 0.0, 255.0).astype(np.uint8)
    return Compared(
        method,
        Spread.of([one.fit_ms for one in times]),
        Spread.of([one.warp_ms for one in times]),
        Spread.of([one.processor_ms for one in times]),
        float(misses.mean()),
        float(misses.max()),
        float(np.linalg.norm(landed - task.target_px, axis=1).mean()),
        float(det.min()),
        float(det.max()),
        float((det <= 0.0).mean()),
        float((length > LOSSLESS_PX).mean()),
        float(length.max()),
        _pictures(rgb8(photo), rgb8(warp.pixels(photo)), heat),
    )


def _det(displacement: Array, step_px: int) -> Array:
    """Return det J of ``x + displacement`` by central differences, shape (H, W)."""
    (x_y, x_x), (y_y, y_x) = (np.gradient(part, float(step_px)) for part in displacement)
    return np.asarray((1.0 + x_x) * (1.0 + y_y) - x_y * y_x)


def _pictures(photo: Image, result: Image, heat: Image) -> dict[str, Image]:
    difference = cv2.convertScaleAbs(cv2.absdiff(result, photo), alpha=DIFFERENCE_GAIN)
    whole = cv2.resize(heat, photo.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    colours = cv2.cvtColor(cv2.applyColorMap(whole, cv2.COLORMAP_VIRIDIS), cv2.COLOR_BGR2RGB)
    return {"result": result, "difference": np.asarray(difference), "heat": colours}


def _round_faces(subject: Subject) -> Box:
    """Return the part of a photo with all faces and a margin."""
    points = np.vstack([face.points for face in subject.faces])
    low, high = points.min(axis=0), points.max(axis=0)
    room = _ROUND * float((high - low).max())
    left, top = np.floor(low - room).astype(int).tolist()
    right, bottom = np.ceil(high + room).astype(int).tolist()
    return Box(left, top, right, bottom).clipped(Box.of(subject.pixels))
