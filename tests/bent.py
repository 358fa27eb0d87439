"""How far a warp bends straight lines."""

import numpy as np

from kogao_core.field.field import shown_at


def bend_px(field, lines):
    """Return the largest distance of a warped line of (N, 2, 2) from a straight line, px."""
    along = lines[:, :1] + np.linspace(0.0, 1.0, 64)[:, None] * np.diff(lines, axis=1)
    offsets = [shown - shown.mean(axis=0) for shown in (shown_at(field, one) for one in along)]
    return max(np.abs(one @ np.linalg.svd(one, full_matrices=False)[2][1]).max() for one in offsets)
