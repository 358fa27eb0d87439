"""Recreate the template of 189 points: the mean of hand-labelled frontal faces.

``python -m resources.training.mean_face DATA FILE`` reads the labels of ``frll/`` and ``canada/``:
Face Research Lab London Set (DeBruine & Jones 2017, figshare 5047666) and Young Adult White Faces
(the same, figshare 4220517), both CC BY 4.0. The mean reveals no individual face.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Final

import numpy as np

from kogao_core.base.atomic import put
from kogao_core.base.geometry import Array
from kogao_core.faces.landmarks.aam.points import similarity

_SETS: Final = ("frll", "canada")
_ROUNDS: Final = 5
_LEFT_EYE, _RIGHT_EYE = 18, 27


def mean_face(shapes: list[Array]) -> Array:
    """Return the mean of aligned shapes (N, 2); the origin is the middle of its points.

    Its unit is the outer inter-ocular distance.
    """
    mean = shapes[0]
    for _ in range(_ROUNDS):
        mean = np.mean([similarity(shape, mean)(shape) for shape in shapes], axis=0)
    mean = mean - mean.mean(axis=0)
    return np.asarray(mean / np.linalg.norm(mean[_RIGHT_EYE] - mean[_LEFT_EYE]))


def main(arguments: list[str]) -> None:
    """Write the file (2nd argument) from the folder with the sets of labelled faces (1st)."""
    data, target = map(Path, arguments)
    files = [path for name in _SETS for path in sorted((data / name).glob("[0-9]*.csv"))]
    shapes = [np.loadtxt(path, delimiter=",", skiprows=1) for path in files]
    rows = [f"{x:.4f},{y:.4f}" for x, y in mean_face(shapes).tolist()]
    put(("\n".join(["x,y", *rows]) + "\n").encode("ascii"), target)
    print(f"{target}: mean of {len(shapes)} faces")


if __name__ == "__main__":
    main(sys.argv[1:])
