"""Sections 2.1, 2.2 and 3.3: fit control points to landmark pairs, by one of three fits.

The paper fits coordinates. Here the control points store the *displacement* ``source - target`` and
are fitted at the targets. The displacement is exactly zero beyond the reach of all landmarks, and
the field is directly the backward map for resampling.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import repeat
from typing import Final, assert_never

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Array, Box
from kogao_core.base.language import Text
from kogao_core.faces.face import Anchor
from kogao_core.faces.targets import Pairs
from kogao_core.recipe.recipe import LOSSLESS_PX, Recipe
from kogao_core.warp.field import Field
from kogao_core.warp.frame import zero_on_edges
from kogao_core.warp.lattice import ORDER, Grid, Lattice, basis, groups
from kogao_core.warp.limits import MOST_CONTROL_POINTS, MOST_TOGETHER, OutOfBounds
from kogao_core.warp.surround import HeadDisplacement

MULTILEVEL_STEPS: Final = 3  # halvings of the lattice at most: R, R/2, R/4, R/8
MIN_SPACING_PX: Final = 1.0  # least lattice spacing, px
# Least lattice spacing, in landmark spacings. At this spacing each landmark has control points of
# its own. Without the limit, a warp distance of 0 would need infinitely many control points.
LEAST_SPACINGS: Final = 0.05
# The fade is bounded on lattices with this many times finer spacing.
_FINER_PROOF: Final = 4.0
# Largest norm of the control points of the exact fit, relative to the approximation's. The limit
# prevents huge control points for moves that the lattice can hardly express. Over the sliders'
# range a face far from the photo's edge needs 0.9 to 1.54.
MOST_NORM_RATIO: Final = 1.6
# Least ridge, relative to the largest eigenvalue: too small to change the fit at single landmarks.
_LEAST_RIDGE: Final = 1e-9
_BISECTIONS: Final = 40  # steps of the search for the ridge
# Number of rounds, each a fit of the landmarks and a projection onto still photo edges.
_ROUNDS: Final = 2
_NO_FEATURES: Final = (np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
# Control points are multiples of 1/4096 px, so that a drag of one landmark leaves distant control
# points exactly unchanged.
QUANTUM_PX: Final = 2.0**-12


_Request = tuple[Pairs, Anchor, Grid, Recipe, HeadDisplacement | None]


@dataclass(frozen=True, eq=False)
class Problem:
    """The displacements (N, 2) requested from a face's lattice at the targets (N, 2), both px.

    The first `landmark_count` points are landmarks, the next `features` points are round eyes and
    mouth. Points with `tolerance` 0 are interpolated; a larger tolerance permits a larger error.
    `least_px` is the finest lattice spacing for `multilevel`. The lattice starts as `surround`, and
    moves nothing across the edges of `photo`. `around_px` is the box that the surround displaces,
    (2, 2).
    """

    grid: Grid
    target_px: Array
    displacement_px: Array
    landmark_count: int
    least_px: float = 0.0
    features: int = 0
    tolerance: Array | float = 0.0
    surround: Lattice | None = None
    photo: Box | None = None
    around_px: Array | None = None
    known_norm: float | None = None

    @cached_property
    def support(self) -> _Support:
        """The control points within reach of the problem's points."""
        return _Support(self)

    @cached_property
    def coefficient_norm(self) -> float:
        """Norm of the control points that approximate the complete displacement, px."""
        return (
            float(np.linalg.norm(approximate(self).phi))
            if self.known_norm is None
            else self.known_norm
        )

    @cached_property
    def reached_nodes(self) -> npt.NDArray[np.int64]:
        """Indices of the control points within reach of landmarks and features."""
        # Like `np.unique`, which would import numpy's masked arrays.
        moving = self.landmark_count + self.features
        return np.flatnonzero(np.bincount(self.support.nodes[:moving].ravel()))

    def requesting(self, displacement_px: Array) -> Problem:
        """Return the problem with another displacement and the limit of the complete one."""
        norm = self.coefficient_norm
        return dataclasses.replace(self, displacement_px=displacement_px, known_norm=norm)


def spacing_px(pairs: Pairs, anchor: Anchor, recipe: Recipe) -> float:
    """Return the lattice spacing h = R x (landmark spacing or warp distance), px (section 3.3).

    Result: at least `MIN_SPACING_PX` and `LEAST_SPACINGS` of the landmark spacing.
    """
    match recipe.lattice_unit:
        case "spacing":
            unit_px = anchor.spacing_px
        case "warp":
            unit_px = pairs.warp_distance_px
        case unknown:
            assert_never(unknown)
    return max(MIN_SPACING_PX, LEAST_SPACINGS * anchor.spacing_px, recipe.lattice * unit_px)


def fit(
    pairs: Sequence[Pairs],
    anchors: Sequence[Anchor],
    recipes: Sequence[Recipe],
) -> tuple[Lattice, ...]:
    """Fit one lattice to each face.

    Result: the total displacement field is their sum. Raises OutOfBounds.
    """
    return solve(problems_of(pairs, anchors, recipes), recipes)


def problems_of(
    pairs: Sequence[Pairs],
    anchors: Sequence[Anchor],
    recipes: Sequence[Recipe],
    surrounds: Sequence[HeadDisplacement | None] = (),
    photo: Box | None = None,
) -> list[Problem]:
    """Return the fitting problem of each face.

    Result: in the order of the faces. Raises OutOfBounds.
    """
    grids = [
        Grid(anchor.origin_px, spacing_px(pair, anchor, recipe))
        for pair, anchor, recipe in zip(pairs, anchors, recipes, strict=True)
    ]
    requested = [*zip(pairs, anchors, grids, recipes, surrounds or repeat(None), strict=False)]
    _check_control_points(requested)
    # Check before the surrounds of many faces are sampled: that takes long.
    _check_together([_problem(*each[:4], None, photo) for each in requested])
    return [_problem(*each, photo) for each in requested]


def solve(problems: Sequence[Problem], recipes: Sequence[Recipe]) -> tuple[Lattice, ...]:
    """Return the lattice of each problem, by the fit of its recipe.

    Result: in the order of `problems`, their control points on the `QUANTUM_PX` grid.
    """
    if not any(problem.displacement_px.any() or problem.surround for problem in problems):
        return tuple(problem.support.empty for problem in problems)
    total: list[Lattice | None] = [problem.surround for problem in problems]
    made = Field(tuple(lattice for lattice in total if lattice is not None))
    left = [one.requesting(one.displacement_px - made.at(one.target_px)) for one in problems]
    for _ in range(_ROUNDS):
        whole = [
            lattice if done is None else lattice.plus(done)
            for lattice, done in zip(_fitted(left, recipes), total, strict=True)
        ]
        inside = [zero_on_edges(a, one.photo) for a, one in zip(whole, problems, strict=True)]
        total = [*inside]
        if all(kept is lattice for kept, lattice in zip(inside, whole, strict=True)):
            break
        # Request again the part removed at the edges, without the error of an approximation.
        before, after = Field(tuple(whole)), Field(tuple(inside))
        left = [
            one.requesting(before.at(one.target_px) - after.at(one.target_px)) for one in problems
        ]
    return tuple(quantised(lattice) for lattice in total if lattice is not None)


def _fitted(problems: Sequence[Problem], recipes: Sequence[Recipe]) -> list[Lattice]:
    both = list(zip(problems, recipes, strict=True))
    solved = iter(exact([problem for problem, recipe in both if recipe.fit == "exact"]))
    fitted = []
    for problem, recipe in both:
        match recipe.fit:
            case "approximation":
                fitted.append(approximate(problem))
            case "exact":
                fitted.append(next(solved))
            case "multilevel":
                fitted.append(multilevel(problem))
            case unknown:
                assert_never(unknown)
    return fitted


def _check_control_points(requested: Sequence[_Request]) -> None:
    total = 0.0
    for pair, anchor, grid, recipe, surround in requested:
        halvings = MULTILEVEL_STEPS if recipe.fit == "multilevel" else 0
        finest = grid.spacing_px / 2.0**halvings
        finest = min(grid.spacing_px, max(LEAST_SPACINGS * anchor.spacing_px, finest))
        if recipe.threshold_px > LOSSLESS_PX:
            finest /= _FINER_PROOF
        corners = pair.target_px if surround is None else surround.corners_px
        sides = np.ptp(np.vstack([pair.target_px, corners]), axis=0)
        columns, rows = (sides / finest + ORDER).tolist()
        total += columns * rows
    if not total <= MOST_CONTROL_POINTS:
        raise OutOfBounds(
            Text(
                "these faces take {total:.3g} control points at this lattice, and at "
                "most {most_control_points} are worked on; make the lattice coarser "
                "(a larger R), choose fewer faces, or correct landmarks far from "
                "their face",
                total=total,
                most_control_points=MOST_CONTROL_POINTS,
            )
        )


def _check_together(problems: Sequence[Problem]) -> None:
    empty = [problem.support.fitted for problem in problems]
    for group in groups(empty):
        points = sum(problems[k].landmark_count for k in group)
        nodes = sum(
            min(ORDER**2 * problems[k].landmark_count, empty[k].phi[..., 0].size) for k in group
        )
        if points * min(points, nodes) > MOST_TOGETHER**2:
            raise OutOfBounds(
                Text(
                    "faces that touch each other have {points} landmarks together, more than "
                    "can be solved at once (about {most_together}); choose fewer faces",
                    points=points,
                    most_together=MOST_TOGETHER,
                )
            )


def quantised(lattice: Lattice) -> Lattice:
    """Return the lattice with control points rounded to the nearest multiples of `QUANTUM_PX`."""
    phi = np.round(lattice.phi / QUANTUM_PX) * QUANTUM_PX
    return Lattice(lattice.grid, lattice.first, phi)


def _problem(
    pairs: Pairs,
    anchor: Anchor,
    grid: Grid,
    recipe: Recipe,
    surround: HeadDisplacement | None,
    photo: Box | None,
) -> Problem:
    source, target, tolerance = _NO_FEATURES
    # Features only with the exact fit: an approximation would pull landmarks off their targets.
    if surround is not None and recipe.fit == "exact":
        source, target, tolerance = surround.features
    return Problem(
        grid,
        np.vstack([pairs.target_px, target]),
        np.vstack([pairs.displacement_px, source - target]),
        len(pairs.target_px),
        LEAST_SPACINGS * anchor.spacing_px,
        len(target),
        np.concatenate([np.zeros(len(pairs.target_px)), tolerance]),
        None if surround is None else _sampled(surround, grid),
        photo,
        None if surround is None else surround.around_px,
    )


def _sampled(surround: HeadDisplacement, grid: Grid) -> Lattice | None:
    """Sample a surround's displacement at the control points; None if all are zero."""
    corners = surround.corners_px
    columns, rows = (
        np.arange(ends.min() - 1, ends.max() + ORDER - 1)
        for ends in (grid.locate(corners[:, axis], axis)[0] for axis in (0, 1))
    )
    x, y = grid.node_px(columns, 0), grid.node_px(rows, 1)
    phi = surround.at(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))
    moving = phi.any(axis=1).reshape(len(rows), len(columns))
    if not moving.any():
        return None
    i, j = np.flatnonzero(moving.any(axis=0)), np.flatnonzero(moving.any(axis=1))
    phi = phi.reshape(*moving.shape, 2)[j[0] : j[-1] + 1, i[0] : i[-1] + 1]
    return Lattice(grid, (int(columns[i[0]]), int(rows[j[0]])), phi)


class _Support:
    """The 4 x 4 control points of each of a problem's points, eq. (1), and the array they fill."""

    def __init__(self, problem: Problem) -> None:
        self.grid = problem.grid
        column, s = self.grid.locate(problem.target_px[:, 0], 0)
        row, t = self.grid.locate(problem.target_px[:, 1], 1)
        self.first = (int(column.min()) - 1, int(row.min()) - 1)
        self.shape = (int(np.ptp(row)) + ORDER, int(np.ptp(column)) + ORDER)
        # Lattices are grouped by the reach of their points, without the surround.
        self.fitted = Lattice(self.grid, self.first, np.zeros((*self.shape, 2)))
        if problem.surround is not None:
            whole = self.fitted.plus(problem.surround)
            self.first, self.shape = whole.first, whole.shape
        reach = np.arange(ORDER) - 1
        rows = row[:, None, None] + reach[:, None] - self.first[1]
        columns = column[:, None, None] + reach - self.first[0]
        self.weights = basis(t)[:, :, None] * basis(s)[:, None, :]
        self.nodes: npt.NDArray[np.int64] = rows * self.shape[1] + columns

    @property
    def size(self) -> int:
        """Number of control points in the array."""
        return self.shape[0] * self.shape[1]

    @cached_property
    def empty(self) -> Lattice:
        """The lattice without displacement."""
        return self.lattice(np.zeros((self.size, 2)))

    def lattice(self, phi: Array) -> Lattice:
        """Return the lattice with these control points, shape (size, 2)."""
        return Lattice(self.grid, self.first, phi.reshape(*self.shape, 2))


def _design(support: _Support, points_px: Array, nodes: npt.NDArray[np.int64]) -> _Design:
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


def approximate(problem: Problem) -> Lattice:
    """B-spline approximation, eqs. (3) and (4).

    Eq. (3) as printed sums over k and l. The source, Lee, Wolberg and Shin (1997), gives every
    landmark c an own ``phi_c = w_c z_c / sum w_ab^2``. Landmarks that share a control point give
    ``phi = sum w_c^2 phi_c / sum w_c^2``, which minimises eq. (4). Result: close to the
    displacements, but not equal where landmarks share control points.
    """
    support = problem.support
    w2 = support.weights**2
    own = support.weights / w2.sum(axis=(1, 2), keepdims=True)
    total = np.bincount(support.nodes.ravel(), w2.ravel(), support.size)
    phi = np.zeros((support.size, 2))
    for c in (0, 1):
        shares = w2 * own * problem.displacement_px[:, c, None, None]
        phi[:, c] = np.bincount(support.nodes.ravel(), shares.ravel(), support.size)
    return support.lattice(phi / np.where(total > 0.0, total, 1.0)[:, None])


def multilevel(problem: Problem) -> Lattice:
    """Approximate, then approximate the residual on ever finer lattices (refs [8], [12]).

    Result: the sum of all levels, on the finest.
    """
    lattice = approximate(problem)
    for _ in range(MULTILEVEL_STEPS):
        left = problem.displacement_px - lattice.at(problem.target_px)
        if np.abs(left).max() < LOSSLESS_PX or lattice.grid.spacing_px < 2.0 * problem.least_px:
            break
        lattice = lattice.refined()
        detail = approximate(dataclasses.replace(problem, grid=lattice.grid, displacement_px=left))
        lattice = lattice.plus(detail)
    return lattice


def exact(problems: Sequence[Problem]) -> list[Lattice]:
    """Interpolate every landmark of every face with the smallest possible control points.

    Solves ``phi = A' (A A' + r I)^-1 z`` on the control points of `approximate`. Overlapping faces
    are solved together, so landmarks stay exact in the overlap. The ridge r is close to zero. If
    the landmarks request more than the lattice can express, r grows, and all landmarks miss their
    targets by a little. Result: in the order of `problems`.
    """
    lattices = [problem.support.empty for problem in problems]
    for group in groups([problem.support.fitted for problem in problems]):
        solved = _solve_together([problems[k] for k in group])
        for k, lattice in zip(group, solved, strict=True):
            lattices[k] = lattice
    return lattices


def _solve_together(problems: list[Problem]) -> list[Lattice]:
    targets = np.vstack([problem.target_px for problem in problems])
    displacements = np.vstack([problem.displacement_px for problem in problems])
    supports = [problem.support for problem in problems]
    reached_nodes = [problem.reached_nodes for problem in problems]
    designs = [
        _design(support, targets, nodes)
        for support, nodes in zip(supports, reached_nodes, strict=True)
    ]
    known_norm = np.sqrt(sum(problem.coefficient_norm**2 for problem in problems))
    tolerance = np.concatenate(
        [np.broadcast_to(one.tolerance, len(one.target_px)) for one in problems]
    )
    solution = _ridge_solution(designs, displacements, tolerance, MOST_NORM_RATIO * known_norm)
    ends = np.cumsum([len(nodes) for nodes in reached_nodes])
    lattices = []
    for support, nodes, part in zip(
        supports, reached_nodes, np.split(solution, ends[:-1]), strict=True
    ):
        phi = np.zeros((support.size, 2))
        phi[nodes] = part
        lattices.append(support.lattice(phi))
    return lattices


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
