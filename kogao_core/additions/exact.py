"""The exact fit: every landmark lands on its target (`docs/decisions/06`). Not in the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array
from kogao_core.paper.fit import Problem, Support, approximate
from kogao_core.paper.lattice import Lattice, groups

# Largest norm of the control points of the exact fit, relative to the approximation's. The limit
# prevents huge control points for moves that the lattice can hardly express. Over the sliders'
# range a face far from the photo's edge needs 0.9 to 1.54.
MOST_NORM_RATIO: Final = 1.6
# Least ridge, relative to the largest eigenvalue: too small to change the fit at single landmarks.
_LEAST_RIDGE: Final = 1e-9
_BISECTIONS: Final = 40  # steps of the search for the ridge


def exact(
    problems: Sequence[Problem], tolerances: Sequence[Array] = (), norms: Sequence[float] = ()
) -> list[Lattice]:
    """Interpolate every landmark of every face with the smallest possible control points.

    Solves ``phi = A' (A A' + r I)^-1 z`` on the control points of `approximate`. Overlapping faces
    are solved together, so landmarks stay exact in the overlap. The ridge r is close to zero. If
    the landmarks request more than the lattice can express, r grows, and all landmarks miss their
    targets by a little. `tolerances` (N,) per problem: points with 0 are interpolated, a larger
    one permits a larger error. `norms`: of the control points that approximate each face's whole
    displacement, px; by default of `problems`. Result: in the order of `problems`.
    """
    tolerances = tolerances or [np.zeros(len(problem.target_px)) for problem in problems]
    norms = norms or [norm_px(problem) for problem in problems]
    lattices = [problem.support.empty for problem in problems]
    for group in groups(lattices):
        solved = _solve_together(
            [problems[k] for k in group], [tolerances[k] for k in group], [norms[k] for k in group]
        )
        for k, lattice in zip(group, solved, strict=True):
            lattices[k] = lattice
    return lattices


def norm_px(problem: Problem) -> float:
    """Return the norm of the control points that approximate a problem's displacement, px."""
    return float(np.linalg.norm(approximate(problem).phi))


def _solve_together(
    problems: list[Problem], tolerances: list[Array], norms: list[float]
) -> list[Lattice]:
    targets = np.vstack([problem.target_px for problem in problems])
    displacements = np.vstack([problem.displacement_px for problem in problems])
    supports = [problem.support for problem in problems]
    # Like `np.unique`, which would import numpy's masked arrays.
    reached = [np.flatnonzero(np.bincount(support.nodes.ravel())) for support in supports]
    designs = [
        _design(support, targets, nodes) for support, nodes in zip(supports, reached, strict=True)
    ]
    longest = MOST_NORM_RATIO * np.sqrt(sum(norm**2 for norm in norms))
    solution = _ridge_solution(designs, displacements, np.concatenate(tolerances), longest)
    ends = np.cumsum([len(nodes) for nodes in reached])
    lattices = []
    for support, nodes, part in zip(supports, reached, np.split(solution, ends[:-1]), strict=True):
        phi = np.zeros((support.size, 2))
        phi[nodes] = part
        lattices.append(support.lattice(phi))
    return lattices


def _design(support: Support, points_px: Array, nodes: npt.NDArray[np.int64]) -> _Design:
    """Return the weights of `nodes` at the points within reach of a support."""
    rows = np.flatnonzero(support.empty.reaches(points_px))
    bx, by = support.empty.weights_at(*points_px[rows].T)
    j, i = np.divmod(nodes, support.shape[1])
    return _Design(rows, by[:, j] * bx[:, i])


@dataclass(frozen=True, slots=True, eq=False)
class _Design:
    """The part of A of one lattice: weights (M, nodes) at the points with indices `rows` (M,).

    All other points are out of reach; with many faces these are nearly all points.
    """

    rows: npt.NDArray[np.int64]
    weights: Array


def _ridge_solution(
    designs: Sequence[_Design], displacements: Array, tolerance: Array, longest: float
) -> Array:
    """Return the smallest phi with ``A phi = displacements``, or the best with norm <= `longest`.

    Rows with a tolerance r minimise ``|phi|^2 + |A phi - z|^2 / r``.
    """
    most = max(float((part.weights**2).sum(axis=1).max(initial=0.0)) for part in designs)
    if tolerance.any():
        scale = np.sqrt(_LEAST_RIDGE * most / (_LEAST_RIDGE * most + tolerance))
        designs = [_Design(d.rows, d.weights * scale[d.rows, None]) for d in designs]
        displacements = displacements * scale[:, None]
    # A' (A A' + r I)^-1 z = (A' A + r I)^-1 A' z: solve with the smaller matrix.
    many = len(displacements) > sum(part.weights.shape[1] for part in designs)
    matrix = (_inner if many else _outer)(designs, len(displacements))
    wanted = _transposed(designs, displacements) if many else displacements
    least = _LEAST_RIDGE * (most if tolerance.any() else np.linalg.eigvalsh(matrix)[-1])
    solved = np.asarray(np.linalg.solve(matrix + least * np.eye(len(matrix)), wanted), np.float64)
    phi = solved if many else _transposed(designs, solved)
    if (phi**2).sum() <= longest**2:
        return np.asarray(phi)
    solved = _short_solution(matrix, wanted, longest, many)
    return np.asarray(solved if many else _transposed(designs, solved))


def _short_solution(matrix: Array, wanted: Array, longest: float, many: bool) -> Array:
    """Solve with the smallest ridge that gives phi of norm <= `longest`."""
    values, vectors = np.linalg.eigh(matrix)
    values, wanted = np.maximum(values, 0.0), vectors.T @ wanted
    energy = (1.0 if many else values) * (wanted**2).sum(axis=1)
    low, high = np.log(_LEAST_RIDGE * values[-1]), np.log(10.0 * values[-1])
    for _ in range(_BISECTIONS):
        ridge = np.exp((low + high) / 2.0)
        if (energy / (values + ridge) ** 2).sum() > longest**2:
            low = np.log(ridge)
        else:
            high = np.log(ridge)
    return np.asarray(vectors @ (wanted / (values + ridge)[:, None]))


def _outer(designs: Sequence[_Design], points: int) -> Array:
    """Return A A', shape (points, points)."""
    total: Array = np.zeros((points, points))
    for part in designs:
        total[np.ix_(part.rows, part.rows)] += part.weights @ part.weights.T
    return total


def _inner(designs: Sequence[_Design], points: int) -> Array:
    """Return A' A, shape (nodes, nodes)."""
    whole: Array = np.zeros((points, sum(part.weights.shape[1] for part in designs)))
    start = 0
    for part in designs:
        end = start + part.weights.shape[1]
        whole[part.rows, start:end] = part.weights
        start = end
    return np.asarray(whole.T @ whole)


def _transposed(designs: Sequence[_Design], values: Array) -> Array:
    """Return A' z for values z at the points, shape (nodes, 2)."""
    return np.vstack([part.weights.T @ values[part.rows] for part in designs])
