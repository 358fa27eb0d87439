"""Fit the share of "unnatural" answers by warp distance, with intervals.

The module needs scipy, which the extra ``experiments`` installs.
"""

from __future__ import annotations

import random
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt
from scipy.special import chdtrc, expit

from kogao_core.lab.study.design import Group
from kogao_core.lab.study.tally import Answered

Floats = npt.NDArray[np.float64]
RESAMPLES: Final = 400
_SEED: Final = 20110
_LEAST_ANSWERS: Final = 20
_LAPSES: Final = np.array([0.0, 0.01, 0.02, 0.03, 0.05, 0.08])
_ROUNDS: Final = 30
_TESTED: Final = 0.5  # % of D: difference for the required number of raters
# Normal quantiles: two-sided 5 %, and the sum with the quantile of 80 % power.
_TWO_SIDED: Final = 1.959964
_QUANTILES: Final = _TWO_SIDED + 0.841621


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure with its 95 % interval."""

    value: float
    low: float
    high: float

    @staticmethod
    def of(value: float, resampled: Floats) -> Estimate:
        """Return a figure with the percentiles of its resamples."""
        low, high = np.percentile(resampled, (2.5, 97.5))
        return Estimate(float(value), float(low), float(high))


@dataclass(frozen=True, slots=True)
class Curve:
    """Share of "unnatural" by achieved distance x: ``lapse + (1 - 2 lapse) / (1 + e^-(x - m)/s)``.

    `middle` m is the distance with half of the answers "unnatural", `scale` s the inverse slope,
    both in % of D. `lapse` is the share of slips at each end.
    """

    middle: Estimate
    scale: Estimate
    lapse: float
    answers: int
    floor: float = 0.0  # share of guessing, if larger than the lapses

    def at(self, achieved: Floats) -> Floats:
        """Return the share at some distances, 0 to 1."""
        steps = (achieved - self.middle.value) / self.scale.value
        low = max(self.floor, self.lapse)
        return low + (1.0 - self.lapse - low) / (1.0 + np.exp(-steps))


@dataclass(frozen=True, slots=True)
class Curves:
    """The curve of a study and the curves of its groups."""

    whole: Curve
    groups: Mapping[Group, Curve]  # by centre and fit
    # Difference of the middle from the first group, % of D; the interval holds for these faces.
    later: Mapping[Group, Estimate]
    # p of Cochran's Q over the answers of one rater to one face at one requested distance: tests
    # the effect of the centre. None if no rater judged all centres.
    p: float | None
    raters: int
    faces: int
    # Number of raters for a power of 80 %, for a difference of 0.5 % of D and these faces.
    raters_needed: int | None
    resamples: int  # number of resamples for the intervals


def fitted(rows: Sequence[Answered], *, floor: float = 0.0) -> Curves | None:
    """Fit curves to the answers about table 1's pictures and the original photos.

    Intervals of the curves come from draws of raters and of faces, both with replacement (Owen,
    Annals of Applied Statistics 1, 2007, 386-411), because answers of one rater, or about one face,
    are correlated. In a difference between groups the effects of raters and faces cancel, because
    each rater judges each face in each group. Drawing both would count the noise of single answers
    three times, so intervals of differences come from draws of raters alone. None if there are
    fewer than 20 answers, two raters, two faces or two kinds of answers.
    """
    usable = [
        row
        for row in rows
        if row.variant.kind in ("table1", "control") and row.record.answer is not None
        if row.meaning.measured.achieved >= 0.0
    ]
    cells = _Cells(usable, floor)
    if len(usable) < _LEAST_ANSWERS or min(cells.asked.shape[0], cells.faces) < 2:
        return None
    if not 0 < cells.hits.sum() < cells.asked.sum():
        return None
    draw = random.Random(_SEED)
    weights = [cells.resampled(draw) for _ in range(RESAMPLES)]
    of_raters = [cells.resampled(draw, faces=False) for _ in range(RESAMPLES)]
    groups = sorted({group for group in cells.group if group is not None})
    members = {group: np.array([one in (group, None) for one in cells.group]) for group in groups}
    whole, _ = cells.curve(np.ones(len(cells.group), bool), weights)
    by_group = {group: cells.curve(inside, weights)[0] for group, inside in members.items()}
    drawn = {group: cells.curve(inside, of_raters) for group, inside in members.items()}
    raters = cells.asked.shape[0]
    later, needed = _compared(drawn, raters)
    return Curves(whole, by_group, later, _cochran(usable), raters, cells.faces, needed, RESAMPLES)


def _compared(
    found: Mapping[Group, tuple[Curve, Floats]], raters: int
) -> tuple[dict[Group, Estimate], int | None]:
    """Return the differences from the first group, and the number of raters needed."""
    (_, (base, resampled)), *others = found.items()
    later = {
        group: Estimate.of(one.middle.value - base.middle.value, theirs - resampled)
        for group, (one, theirs) in others
    }
    if not others:
        return later, None
    # From the interval: less sensitive to extreme resamples than the standard deviation.
    error = np.mean([(one.high - one.low) / (2.0 * _TWO_SIDED) for one in later.values()])
    return later, int(np.ceil(raters * (_QUANTILES * error / _TESTED) ** 2))


def _cochran(rows: Sequence[Answered]) -> float | None:
    """Return the p of Cochran's Q (Biometrika 37, 1950, 256-266) of the centres."""
    blocks: defaultdict[tuple[object, ...], dict[Group, bool]] = defaultdict(dict)
    for row in rows:
        if row.variant.kind == "table1":
            where = row.key.identity, row.meaning.subject, row.session.rater, row.variant.percent
            blocks[where][row.variant.group] = bool(row.is_unnatural)
    groups = sorted({group for block in blocks.values() for group in block})
    whole = [block for block in blocks.values() if len(block) == len(groups)]
    said = np.array([[block[group] for group in groups] for block in whole], int)
    count = len(groups)
    if count < 2 or not said.size:
        return None
    spread = count * said.sum() - (said.sum(axis=1) ** 2).sum()
    if spread == 0:
        return None
    between = count * (said.sum(axis=0) ** 2).sum() - said.sum() ** 2
    return float(chdtrc(count - 1, (count - 1) * between / spread))


class _Cells:
    """Answers counted by rater and picture."""

    def __init__(self, rows: Sequence[Answered], floor: float) -> None:
        self._floor = floor
        raters = {name: n for n, name in enumerate(sorted({row.session.rater for row in rows}))}
        names = sorted({(row.key.identity, row.record.picture) for row in rows})
        places = {name: n for n, name in enumerate(names)}
        self.hits, self.asked = np.zeros((2, len(raters), len(places)))
        self.achieved = np.zeros(len(places))
        self.group: list[Group | None] = [None] * len(places)
        face_of, faces = np.zeros(len(places), int), dict[tuple[str, int], int]()
        for row in rows:
            place = places[row.key.identity, row.record.picture]
            face = row.key.identity, row.meaning.subject
            face_of[place] = faces.setdefault(face, len(faces))
            self.achieved[place] = row.meaning.measured.achieved
            # The original photo belongs to every group.
            self.group[place] = None if row.variant.kind == "control" else row.variant.group
            self.asked[raters[row.session.rater], place] += 1
            self.hits[raters[row.session.rater], place] += bool(row.is_unnatural)
        self._face_of, self.faces = face_of, len(faces)

    def resampled(self, draw: random.Random, *, faces: bool = True) -> tuple[Floats, Floats]:
        """Return hits and answers of each picture after a draw of raters and, if asked, faces."""

        def counts(n: int) -> npt.NDArray[np.intp]:
            return np.bincount(draw.choices(range(n), k=n), minlength=n)

        rater = counts(len(self.asked))
        weight = counts(self.faces)[self._face_of] if faces else np.ones(len(self._face_of))
        return (rater @ self.hits) * weight, (rater @ self.asked) * weight

    def curve(
        self, inside: npt.NDArray[np.bool_], weights: Sequence[tuple[Floats, Floats]]
    ) -> tuple[Curve, Floats]:
        """Fit the curve of some pictures. Return the curve and the middles of all resamples."""
        hits, asked = (
            np.array([own.sum(axis=0), *drawn])[:, inside]
            for own, drawn in zip((self.hits, self.asked), zip(*weights, strict=True), strict=True)
        )
        middle, scale, lapse = _fitted(self.achieved[inside], hits, asked, self._floor)
        middles, scales = Estimate.of(middle[0], middle[1:]), Estimate.of(scale[0], scale[1:])
        return Curve(middles, scales, float(lapse[0]), int(asked[0].sum()), self._floor), middle[1:]


def _fitted(
    at: Floats, hits: Floats, asked: Floats, floor: float = 0.0
) -> tuple[Floats, Floats, Floats]:
    """Return the maximum-likelihood middle, scale and lapse for each row of hits and answers.

    Fisher scoring of ``a + b x`` for each of a few lapses, vectorised over the rows.
    """
    span = max(float(np.ptp(at)), 1.0)
    x, h, n = at - at.mean(), hits[:, None, :], asked[:, None, :]
    lapse = _LAPSES[:, None]
    low = np.maximum(floor, lapse)
    range_ = 1.0 - lapse - low
    a = np.zeros((len(hits), len(_LAPSES), 1))
    b = np.full_like(a, 8.0 / span)
    for _ in range(_ROUNDS):
        rise = expit(a + b * x)
        share = np.clip(low + range_ * rise, 1e-9, 1.0 - 1e-9)
        steep = np.maximum(range_ * rise * (1.0 - rise), 1e-9)
        score = (h - n * share) * steep / (share * (1.0 - share))
        weight = n * steep**2 / (share * (1.0 - share)) + 1e-9
        w0, w1, w2 = ((weight * x**k).sum(axis=2, keepdims=True) for k in range(3))
        u0, u1 = (score.sum(axis=2, keepdims=True), (score * x).sum(axis=2, keepdims=True))
        inverse = 1.0 / (w0 * w2 - w1 * w1 + 1e-12)
        # Nearly separated answers: limit the steps and the slope.
        a += np.clip((w2 * u0 - w1 * u1) * inverse, -2.0, 2.0)
        b = np.clip(b + (w0 * u1 - w1 * u0) * inverse, 0.5 / span, 100.0 / span)
        a = np.clip(a, -b * 1.5 * span, b * 1.5 * span)
    likelihood = (h * np.log(share) + (n - h) * np.log1p(-share)).sum(axis=2)
    best = np.arange(len(hits)), likelihood.argmax(axis=1), 0
    return at.mean() - (a / b)[best], (1.0 / b)[best], _LAPSES[best[1]]
