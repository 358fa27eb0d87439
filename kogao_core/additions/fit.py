"""Fit the lattices of all faces of a photo: the paper's fits inside the photo, around heads.

The lattice of a face begins as its head's displacement (`surround`), if any, and moves nothing
across the photo's edges (`frame`); the fit serves what is left at the landmarks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, assert_never

import numpy as np

from kogao_core.additions.edge import zero_on_edges
from kogao_core.additions.exact import exact, norm_px
from kogao_core.additions.head import HeadField
from kogao_core.additions.limits import MOST_CONTROL_POINTS, MOST_TOGETHER, OutOfBounds
from kogao_core.base.geometry import Array, Box
from kogao_core.faces.face import Anchor
from kogao_core.faces.targets import FacePairs
from kogao_core.paper import fit as paper
from kogao_core.paper.basis import ORDER
from kogao_core.paper.fit import MULTILEVEL_STEPS, Problem, approximate, multilevel
from kogao_core.paper.lattice import Grid, Lattice, Spline, groups, quantised
from kogao_core.recipe.recipe import LOSSLESS_PX, Recipe

# Least lattice spacing, in landmark spacings. At this spacing each landmark has control points of
# its own. Without the limit, a warp distance of 0 would need infinitely many control points.
LEAST_SPACINGS: Final = 0.05
# The fade is bounded on lattices with this many times finer spacing.
_FINER_PROOF: Final = 4.0
# Number of rounds, each a fit of the landmarks and a projection onto still photo edges.
_ROUNDS: Final = 2


def spacing_px(pairs: FacePairs, anchor: Anchor, recipe: Recipe) -> float:
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
    return paper.spacing_px(recipe.lattice, unit_px, LEAST_SPACINGS * anchor.spacing_px)


def grids_of(
    pairs: Sequence[FacePairs], anchors: Sequence[Anchor], recipes: Sequence[Recipe]
) -> list[Grid]:
    """Return the grid of each face."""
    return [
        Grid(anchor.origin_px, spacing_px(pair, anchor, recipe))
        for pair, anchor, recipe in zip(pairs, anchors, recipes, strict=True)
    ]


def fit(
    pairs: Sequence[FacePairs],
    anchors: Sequence[Anchor],
    recipes: Sequence[Recipe],
    heads: Sequence[HeadField | None] = (),
    photo: Box | None = None,
) -> tuple[Lattice, ...]:
    """Fit one lattice to each face, by the fit of its recipe.

    `heads`: what each lattice begins with. `photo`: nothing moves across its edges. Result: in the
    order of the faces, on the `QUANTUM_PX` grid; the total displacement field is their sum. Raises
    OutOfBounds.
    """
    heads, grids = heads or (None,) * len(pairs), grids_of(pairs, anchors, recipes)
    _check_control_points(pairs, anchors, grids, recipes, heads)
    problems = [
        Problem(grid, pair.target_px, pair.displacement_px, LEAST_SPACINGS * anchor.spacing_px)
        for grid, pair, anchor in zip(grids, pairs, anchors, strict=True)
    ]
    # Check before the displacements of many heads are sampled: that takes long.
    _check_together(problems)
    both = [_with_features(*each) for each in zip(problems, recipes, heads, strict=True)]
    problems, tolerances = [problem for problem, _ in both], [tolerance for _, tolerance in both]
    starts = [
        None if head is None else _sampled(head, grid)
        for head, grid in zip(heads, grids, strict=True)
    ]
    if not any(a.displacement_px.any() or start for a, start in zip(problems, starts, strict=True)):
        return tuple(problem.support.empty for problem in problems)
    norms = [
        norm_px(problem) if recipe.fit == "exact" else 0.0
        for problem, recipe in zip(problems, recipes, strict=True)
    ]
    return inside(photo, problems, starts, lambda left: _fitted(left, recipes, tolerances, norms))


def inside(
    photo: Box | None,
    problems: Sequence[Problem],
    starts: Sequence[Lattice | None],
    solve: Callable[[Sequence[Problem]], list[Lattice]],
) -> tuple[Lattice, ...]:
    """Return lattices that begin as `starts`, and by `solve` meet the problems, within a photo."""
    total = [*starts]
    made = Spline(tuple(lattice for lattice in total if lattice is not None))
    left = [one.asking(one.displacement_px - made.at(one.target_px)) for one in problems]
    for _ in range(_ROUNDS):
        whole = [
            lattice if done is None else lattice.plus(done)
            for lattice, done in zip(solve(left), total, strict=True)
        ]
        cut = [zero_on_edges(lattice, photo) for lattice in whole]
        total = [*cut]
        if all(kept is lattice for kept, lattice in zip(cut, whole, strict=True)):
            break
        # Request again the part removed at the edges, without the error of an approximation.
        before, after = Spline(tuple(whole)), Spline(tuple(cut))
        left = [one.asking(before.at(one.target_px) - after.at(one.target_px)) for one in problems]
    return tuple(quantised(lattice) for lattice in total if lattice is not None)


def _with_features(
    problem: Problem, recipe: Recipe, head: HeadField | None
) -> tuple[Problem, Array]:
    """Return a problem with the points round eyes and mouth, and the tolerance of each point."""
    tolerance = np.zeros(len(problem.target_px))
    # Features only with the exact fit: an approximation would pull landmarks off their targets.
    if head is None or recipe.fit != "exact":
        return problem, tolerance
    source, target, given = head.features
    return Problem(
        problem.grid,
        np.vstack([problem.target_px, target]),
        np.vstack([problem.displacement_px, source - target]),
        problem.least_px,
    ), np.concatenate([tolerance, given])


def _fitted(
    problems: Sequence[Problem],
    recipes: Sequence[Recipe],
    tolerances: Sequence[Array],
    norms: Sequence[float],
) -> list[Lattice]:
    which = [k for k, recipe in enumerate(recipes) if recipe.fit == "exact"]
    solved = iter(
        exact(
            [problems[k] for k in which], [tolerances[k] for k in which], [norms[k] for k in which]
        )
    )
    fitted = []
    for problem, recipe in zip(problems, recipes, strict=True):
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


def _check_control_points(
    pairs: Sequence[FacePairs],
    anchors: Sequence[Anchor],
    grids: Sequence[Grid],
    recipes: Sequence[Recipe],
    heads: Sequence[HeadField | None],
) -> None:
    total = 0.0
    for pair, anchor, grid, recipe, head in zip(pairs, anchors, grids, recipes, heads, strict=True):
        halvings = MULTILEVEL_STEPS if recipe.fit == "multilevel" else 0
        finest = grid.spacing_px / 2.0**halvings
        finest = min(grid.spacing_px, max(LEAST_SPACINGS * anchor.spacing_px, finest))
        if recipe.threshold_px > LOSSLESS_PX:
            finest /= _FINER_PROOF
        corners = pair.target_px if head is None else head.corners_px
        sides = np.ptp(np.vstack([pair.target_px, corners]), axis=0)
        columns, rows = (sides / finest + ORDER).tolist()
        total += columns * rows
    if not total <= MOST_CONTROL_POINTS:
        raise OutOfBounds(
            "these faces take {total:.3g} control points at this lattice, and at "
            "most {most_control_points} are worked on; make the lattice coarser "
            "(a larger R), choose fewer faces, or correct landmarks far from "
            "their face",
            total=total,
            most_control_points=MOST_CONTROL_POINTS,
        )


def _check_together(problems: Sequence[Problem]) -> None:
    empty = [problem.support.empty for problem in problems]
    for group in groups(empty):
        points = sum(len(problems[k].target_px) for k in group)
        nodes = sum(
            min(ORDER**2 * len(problems[k].target_px), empty[k].phi[..., 0].size) for k in group
        )
        if points * min(points, nodes) > MOST_TOGETHER**2:
            raise OutOfBounds(
                "faces that touch each other have {points} landmarks together, more than "
                "can be solved at once (about {most_together}); choose fewer faces",
                points=points,
                most_together=MOST_TOGETHER,
            )


def _sampled(head: HeadField, grid: Grid) -> Lattice | None:
    """Sample a head's displacement at the control points; None if all are zero."""
    corners = head.corners_px
    columns, rows = (
        np.arange(ends.min() - 1, ends.max() + ORDER - 1)
        for ends in (grid.locate(corners[:, axis], axis)[0] for axis in (0, 1))
    )
    x, y = grid.node_px(columns, 0), grid.node_px(rows, 1)
    phi = head.at(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))
    moving = phi.any(axis=1).reshape(len(rows), len(columns))
    if not moving.any():
        return None
    i, j = np.flatnonzero(moving.any(axis=0)), np.flatnonzero(moving.any(axis=1))
    phi = phi.reshape(*moving.shape, 2)[j[0] : j[-1] + 1, i[0] : i[-1] + 1]
    return Lattice(grid, (int(columns[i[0]]), int(rows[j[0]])), phi)
