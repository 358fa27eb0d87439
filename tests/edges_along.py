"""Edges along given lines, as `edges_of` finds them along straight edges of a photo."""

import numpy as np

from kogao_core.background.edges import Edges
from kogao_core.background.holding import Held


def edges_along(lines, spacing_px):
    """Return rows every third of a spacing along lines (N, 2, 2), px."""
    places, normals, weights = [], [], []
    for start, end in np.asarray(lines, np.float64):
        length = np.hypot(*(end - start))
        way = (end - start) / length
        for arm in (1.0, 2.0, 4.0):
            reach = arm * spacing_px
            far = np.arange(reach, length - reach + 1e-9, 0.35 * spacing_px)[:, None]
            middle = start + far * way
            places.append(np.stack([middle - reach * way, middle, middle + reach * way], 1))
            normals.append(np.tile((-way[1], way[0]), (len(far), 1)))
            weights.append(np.full(len(far), 980.0 / arm))
    none = np.zeros((0, 2))
    return Edges(
        np.concatenate(places), np.concatenate(normals), np.concatenate(weights), none, np.zeros(0)
    )


def held_along(lines, faces, neighbours=()):
    """Return what a rendering of faces must hold along lines (N, 2, 2)."""
    edges = tuple(edges_along(lines, face.anchor.spacing_px) for face in faces)
    return Held(edges, neighbours)
