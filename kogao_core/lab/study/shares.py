"""Shares of "unnatural" answers, with intervals for raters and faces that differ.

The 95 % interval of a share contains each p with ``|share - p| <= t sqrt(V(p))``, a score interval
like that of Wilson (J. Amer. Statist. Assoc. 22, 1927, 209-212), with ::

    V(p) = c_rater / R + c_face / F + (p (1 - p) - c_rater - c_face) / n

for n answers of R raters about F faces. With unequal numbers ``n_i`` of answers, R and F are
``n² / sum(n_i²)``. ``c`` is the covariance of two answers of one rater, or about one face, if a
normal latent variable above a threshold means "unnatural" (Pearson, Phil. Trans. R. Soc. A 195,
1900, 1-47). t is Student's, with the degrees of freedom of Satterthwaite (Biometrics Bulletin 2,
1946, 110-114). Without correlations, this is Wilson's interval. An interval from a single face or
rater holds for that face or rater only.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Final, NamedTuple

import numpy as np

_NORMAL: Final = NormalDist()
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_LARGEST_CORRELATION: Final = 0.99
_HALVINGS: Final = 40


class Judgement(NamedTuple):
    """One answer about one kind of picture."""

    rater: Hashable
    face: Hashable
    is_unnatural: bool


class _Squares(NamedTuple):
    """Sums of squared numbers of answers."""

    rater: int
    face: int
    cell: int  # by rater and face

    @staticmethod
    def of(rows: Sequence[Judgement]) -> _Squares:
        keys = ([row.rater for row in rows], [row.face for row in rows], [row[:2] for row in rows])
        return _Squares(*(sum(n * n for n in Counter(key).values()) for key in keys))

    def pairs(self, which: int) -> int:
        """Ordered pairs of answers by one rater about two faces (0), or the reverse (1)."""
        return self[which] - self.cell

    def unrelated(self, answers: int) -> int:
        """Ordered pairs of answers by two raters about two faces."""
        return answers**2 - self.rater - self.face + self.cell


@dataclass(frozen=True, slots=True)
class Correlations:
    """Correlations of the latent variables of two answers, 0 to 0.99."""

    rater: float = 0.0  # of one rater about two faces
    face: float = 0.0  # of two raters about one face

    @staticmethod
    def of(kinds: Iterable[Sequence[Judgement]]) -> Correlations:
        """Estimate the correlations from the answers about some kinds of pictures, by moments.

        Pairs of answers by one rater, or about one face, are both "unnatural" more often than
        unrelated pairs. A study with a single face or rater has no unrelated pairs: 0.
        """
        found = []
        for rows in kinds:
            hits = [row for row in rows if row.is_unnatural]
            squares, of_hits = _Squares.of(rows), _Squares.of(hits)
            if unrelated := squares.unrelated(len(rows)):
                both = of_hits.unrelated(len(hits)) / unrelated
                found.append((len(hits) / len(rows), squares, of_hits, both))

        def estimate(which: int) -> float:
            excess = sum(
                of_hits.pairs(which) - both * squares.pairs(which)
                for _, squares, of_hits, both in found
            )

            def is_low(correlation: float) -> bool:
                expected = (
                    squares.pairs(which) * _covariance(share, correlation)
                    for share, squares, *_ in found
                )
                return sum(expected) < excess

            return _boundary(is_low, 0.0, _LARGEST_CORRELATION)

        return Correlations(estimate(0), estimate(1))


@dataclass(frozen=True, slots=True)
class Share:
    """A share of "unnatural" answers, 0 to 1."""

    judgements: tuple[Judgement, ...] = ()
    correlations: Correlations = Correlations()

    @property
    def hits(self) -> int:
        """Number of "unnatural" answers."""
        return sum(row.is_unnatural for row in self.judgements)

    @property
    def answers(self) -> int:
        return len(self.judgements)

    @property
    def value(self) -> float:
        """The share; NaN without answers."""
        return self.hits / self.answers if self.answers else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """The ends of the 95 % interval; 0 and 1 without answers."""
        if not self.answers:
            return 0.0, 1.0
        share, n = self.value, self.answers
        squares = _Squares.of(self.judgements)
        raters, faces = n * n / squares.rater, n * n / squares.face

        def is_inside(p: float) -> bool:
            rater = _covariance(p, self.correlations.rater)
            face = _covariance(p, self.correlations.face)
            parts = ((rater / raters, raters), (face / faces, faces))
            rest = max(p * (1.0 - p) - rater - face, 0.0) / n
            variance = rest + sum(part for part, _ in parts)
            # 1 / degrees of freedom; the variance of independent answers is known for each p.
            spread = sum(part * part / max(count - 1.0, 1.0) for part, count in parts)
            inverse = spread / variance**2 if variance else 0.0
            return abs(share - p) <= _student(inverse) * math.sqrt(variance)

        return _boundary(is_inside, share, 0.0), _boundary(is_inside, share, 1.0)


def _covariance(p: float, correlation: float) -> float:
    """Return the covariance of two indicators of share p for normal variables of a correlation.

    The derivative of the bivariate normal distribution by the correlation is the density (Plackett,
    Biometrika 41, 1954, 351-360); the integral over the arcsine is smooth.
    """
    if not 0.0 < p < 1.0:
        return 0.0
    threshold, half = _NORMAL.inv_cdf(p), math.asin(correlation) / 2.0
    density = np.exp(-(threshold**2) / (1.0 + np.sin(half * (_NODES + 1.0)))) / (2.0 * math.pi)
    return float(half * (_WEIGHTS @ density))


def _student(inverse: float) -> float:
    """Return the 97.5 % quantile of Student's t for 1 / degrees of freedom, 0 to 1.

    Cornish and Fisher's expansion; 3.17 at 3 degrees of freedom (exact: 3.18).
    """
    z, i = _NORMAL.inv_cdf(0.975), min(inverse, 1.0)
    return (
        z
        + (z**3 + z) / 4.0 * i
        + (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0 * i**2
        + (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0 * i**3
    )


def _boundary(holds: Callable[[float], bool], inside: float, outside: float) -> float:
    """Return the end of the range from `inside` towards `outside` in which a condition holds."""
    if holds(outside):
        return outside
    for _ in range(_HALVINGS):
        middle = (inside + outside) / 2.0
        inside, outside = (middle, outside) if holds(middle) else (inside, middle)
    return inside
