"""A landmark model for `cv2.face` that OpenCV reads and runs, and that knows nothing of faces."""

from __future__ import annotations

import numpy as np

_POINTS, _DEPTH = 68, 2


def lbf() -> str:
    """Return an LBF model of one stage with a tree for each point, as YAML."""
    rng = np.random.default_rng(0)
    head = f"%YAML:1.0\n---\nstages_n: 1\ntree_n: 1\ntree_depth: {_DEPTH}\nn_landmarks: {_POINTS}\n"
    parts = [head, _matrix("regressor_meanshape", rng.random((_POINTS, 2)))]
    nodes, leaves = 2**_DEPTH, 2 ** (_DEPTH - 1)
    for point in range(_POINTS):
        parts.append(_matrix(f"tree_0_{point}_0", rng.uniform(-0.1, 0.1, (nodes, 4))))
        values = ", ".join(map(str, rng.integers(0, 9, nodes)))
        parts.append(f"thresholds_0_{point}_0: [ {values} ]\n")
    weights = rng.uniform(-0.01, 0.01, (2 * _POINTS, _POINTS * leaves))
    return "".join([*parts, _matrix("weights_0", weights)])


def _matrix(name: str, values: np.ndarray) -> str:
    rows = (", ".join(f"{value:.1g}" for value in row) for row in values)
    said = ",\n       ".join(rows)
    head = f"{name}: !!opencv-matrix\n   rows: {len(values)}\n   cols: {values.shape[1]}\n"
    return f"{head}   dt: d\n   data: [ {said} ]\n"
