"""Fit, time and measure methods on the same points of the same photo."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any, Final, NamedTuple

import cv2
import numpy as np

from kogao_core.base.display import reduced, rgb8
from kogao_core.base.geometry import Array, Box, Image
from kogao_core.base.installed import adding
from kogao_core.base.language import Text
from kogao_core.base.threads import one_blas_thread
from kogao_core.lab.methods import METHODS, Method, Warp, WarpTask
from kogao_core.lab.reports.spread import Spread, in_turns
from kogao_core.lab.subjects import Progress, Subject, no_progress, psnr_db, white_of
from kogao_core.recipe.recipe import LOSSLESS_PX, Recipe
from kogao_core.warp.field import shown_at

SAMPLES_PX: Final = 2_000_000  # of a photo at most are sampled for folds, domain and heat
DIFFERENCE_GAIN: Final = 4
_QUICK: Final = " (quick)"  # behind the name of a method that is run as anyone would
_ROUND: Final = 0.35  # of the faces' size is shown round them


@dataclass(frozen=True, eq=False)
class Compared:
    """One method on one photo."""

    method: Method  # which
    # From points to the fitted method, and from there to all pixels, to the letter.
    fit_ms: Spread
    warp_ms: Spread
    processor_ms: Spread  # of both, what all threads took of the processors
    # How far the displacement at the targets is from the one asked for there.
    residual_mean_px: float
    residual_max_px: float
    landing_mean_px: float  # how far landmarks land from their targets
    # Smallest and largest Jacobian determinant by central differences on the sampled pixels: the
    # map goes backward, so that below 1 the picture is stretched and above 1 compressed.
    min_det: float
    max_det: float
    # Parts of the image, 0 to 1, that fold, and that move by more than 1/64 px.
    folded_share: float
    moved_share: float
    largest_px: float  # largest displacement
    # As anyone would run it (`Method.quick`): all of it, and its result against the one to the
    # letter; None for methods that are run so anyway. No PSNR is: not a byte differs.
    quick_ms: Spread | None = None
    quick_processor_ms: Spread | None = None
    quick_psnr_db: float | None = None
    # ``result``, ``difference`` (to the photo, times `DIFFERENCE_GAIN`) and ``heat``; RGB.
    pictures: dict[str, Image] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Comparison:
    """All methods on one photo."""

    subject: Subject  # photo and faces
    asked_px: float  # largest displacement that a landmark asks for: the bright end of the heat
    methods: tuple[Compared, ...]  # one for each that could be fitted

    def views(self) -> Comparison:
        """Return the comparison with pictures cut to the faces and reduced for a report."""
        cut = _round_faces(self.subject)
        seen = tuple(
            dataclasses.replace(
                one, pictures={k: reduced(p[cut.slices]).copy() for k, p in one.pictures.items()}
            )
            for one in self.methods
        )
        photo = reduced(rgb8(self.subject.pixels)[cut.slices]).copy()
        return Comparison(dataclasses.replace(self.subject, pixels=photo), self.asked_px, seen)


def missing(methods: Sequence[Method] = METHODS) -> list[str]:
    """Return a sentence for each method whose library is absent."""
    return [
        Text(
            "{method} needs {library}, which is absent: {how}",
            method=method.title,
            library=method.library,
            how=adding("experiments"),
        )
        for method in methods
        if not _is_here(method)
    ]


def _is_here(method: Method) -> bool:
    return not method.needs or find_spec(method.needs) is not None


def measure(
    subject: Subject,
    recipe: Recipe,
    *,
    methods: Sequence[Method] = METHODS,
    repeats: int = 3,
    warm_up: int = 1,
    progress: Progress = no_progress,
) -> tuple[Comparison, list[str]]:
    """Compare methods on one photo, in turns; those whose library is absent stay out.

    Result: and a sentence for each method that can't be fitted to these points.
    """
    with one_blas_thread():
        task = WarpTask.of(subject.pixels, subject.faces, recipe)
        fitted, failed = _fitted([method for method in methods if _is_here(method)], task)
        fits = {method.name: method.fit for method, _ in fitted}
        fits |= {method.name + _QUICK: method.quick for method, _ in fitted if method.quick}
        times: dict[str, list[_Times]] = {name: [] for name in fits}
        results: dict[str, Image] = {}
        looks: dict[str, tuple[dict[str, float], Image]] = {}
        asked_px = float(np.linalg.norm(task.displacement_px, axis=1).max())
        step = max(1, int(np.ceil(np.sqrt(task.image.area / SAMPLES_PX))))
        # A run that doesn't count may leave its displacement, which then isn't asked for again.
        moved = np.empty((2, *subject.pixels.shape[:2])) if warm_up and step == 1 else None
        runs = len(fits) * (repeats + warm_up)
        for done, (name, counts) in enumerate(in_turns(list(fits), repeats, warm_up), start=1):
            kept = None if counts or name in looks or name.endswith(_QUICK) else moved
            took, results[name] = _time_once(fits[name], task, subject.pixels, kept)
            if kept is not None:
                looks[name] = _look(kept, step, asked_px)
            if counts:
                times[name].append(took)
            progress(done, runs)
        found = []
        for method, warp in fitted:
            look = looks.get(method.name)
            if look is None:
                ends = task.image.right, task.image.bottom
                sampled = warp.on_grid(*(np.arange(0, end, step) for end in ends))
                look = _look(sampled, step, asked_px)
            result, mine = results[method.name], times[method.name]
            one = _compared(method, warp, task, subject.pixels, result, mine, look)
            if quick := times.get(method.name + _QUICK):
                one = dataclasses.replace(
                    one,
                    quick_ms=Spread.of([took.fit_ms + took.warp_ms for took in quick]),
                    quick_processor_ms=Spread.of([took.processor_ms for took in quick]),
                    quick_psnr_db=psnr_db(
                        result.astype(np.float64) - results[method.name + _QUICK], white_of(result)
                    ),
                )
            found.append(one)
        return Comparison(subject, asked_px, tuple(found)), [
            Text("{photo}: {problem}", photo=subject.name, problem=one) for one in failed
        ]


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


def _time_once(
    fit: Callable[[WarpTask], Warp], task: WarpTask, photo: Image, moved: Array | None
) -> tuple[_Times, Image]:
    processor, start = time.process_time(), time.perf_counter()
    warp = fit(task)
    fitted = time.perf_counter()
    result = warp.pixels(photo, moved)
    ends = fitted - start, time.perf_counter() - fitted, time.process_time() - processor
    return _Times(*(1e3 * seconds for seconds in ends)), result


def _compared(
    method: Method,
    warp: Warp,
    task: WarpTask,
    photo: Image,
    result: Image,
    times: Sequence[_Times],
    look: tuple[dict[str, Any], Image],
) -> Compared:
    misses = np.linalg.norm(warp.at(task.target_px) - task.displacement_px, axis=1)
    landed = shown_at(warp, task.target_px + task.displacement_px, task.target_px)
    figures, heat = look
    return Compared(
        method,
        Spread.of([one.fit_ms for one in times]),
        Spread.of([one.warp_ms for one in times]),
        Spread.of([one.processor_ms for one in times]),
        float(misses.mean()),
        float(misses.max()),
        float(np.linalg.norm(landed - task.target_px, axis=1).mean()),
        pictures=_pictures(rgb8(photo), rgb8(result), heat),
        **figures,
    )


def _look(displacement: Array, step_px: int, asked_px: float) -> tuple[dict[str, float], Image]:
    """Return figures of `Compared`, and the heat, of a displacement of every so many pixels."""
    length, det = np.hypot(displacement[0], displacement[1]), _det(displacement, step_px)
    figures = {
        "min_det": float(det.min()),
        "max_det": float(det.max()),
        "folded_share": float((det <= 0.0).mean()),
        "moved_share": float((length > LOSSLESS_PX).mean()),
        "largest_px": float(length.max()),
    }
    levels = np.clip(255.0 * length / max(asked_px, 1e-9), 0.0, 255.0)
    return figures, levels.astype(np.uint8)


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
    """Return the part of a photo with all its faces and some room."""
    points = np.vstack([face.points for face in subject.faces])
    low, high = points.min(axis=0), points.max(axis=0)
    room = _ROUND * float((high - low).max())
    left, top = np.floor(low - room).astype(int).tolist()
    right, bottom = np.ceil(high + room).astype(int).tolist()
    return Box(left, top, right, bottom).clipped(Box.of(subject.pixels))
