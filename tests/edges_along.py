"""Edges along given lines, as `edges_of` finds them along straight edges of a photo."""

import numpy as np

from kogao_core.background.edges import Edges
from kogao_core.background.holding import Held


def edges_along(lines, spacing_px):
    """Return rows every third of a spacing along lines (N, 2, 2), px."""
    places, tied, normals, weights = [], [], [], []
    for start, end in np.asarray(lines, np.float64):
        length = np.hypot(*(end - start))
        way = (end - start) / length
        for arm, shifts in ((1.0, False), (2.0, False), (4.0, False), (4.0, True)):
            reach = arm * spacing_px
            far = np.arange(0.0, length - reach + 1e-9, 0.35 * spacing_px)[:, None]
            near = start + far * way
            places.append(np.stack([near, near if shifts else near + reach * way], 1))
            tied.append(np.full(len(far), 0.0 if shifts else 1.0))
            normals.append(np.tile((-way[1], way[0]), (len(far), 1)))
            weights.append(np.full(len(far), (30.0 if shifts else 980.0) / arm))
    none = np.zeros((0, 2))
    rows = (np.concatenate(part) for part in (places, tied, normals, weights))
    return Edges(*rows, none, np.zeros(0))


def held_along(lines, faces, neighbours=()):
    """Return what a rendering of faces must hold along lines (N, 2, 2)."""
    edges = tuple(edges_along(lines, face.anchor.spacing_px) for face in faces)
    return Held(edges, tuple(np.insert(some, 2, 0.0, axis=1) for some in neighbours))
