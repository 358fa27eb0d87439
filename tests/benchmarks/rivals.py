"""The same warp without the reduced domain: eq. (1) at every pixel, and two matrix products."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from kogao_core.base.geometry import Image
from kogao_core.warp.field import Field
from kogao_core.warp.lattice import ORDER, Lattice, basis

Warp = Callable[[], object]


def literal(photo: Image, lattice: Lattice) -> Warp:
    """Eq. (1) at every pixel of the image, sixteen gathers each, and one full remap."""

    def run() -> object:
        height, width = photo.shape[:2]
        ys, xs = np.mgrid[0:height, 0:width]
        i, s = lattice.grid.locate(xs, 0)
        j, t = lattice.grid.locate(ys, 1)
        bx, by = basis(s), basis(t)
        first = (int(i.min()) - 1, int(j.min()) - 1)
        phi = lattice.window(first, (int(np.ptp(j)) + ORDER, int(np.ptp(i)) + ORDER))
        displacement = np.zeros((height, width, 2))
        for row in range(ORDER):
            for column in range(ORDER):
                weight = by[..., row] * bx[..., column]
                at = phi[j - 1 + row - first[1], i - 1 + column - first[0]]
                displacement += weight[..., None] * at
        x, y = (
            (xs + displacement[..., 0]).astype(np.float32),
            (ys + displacement[..., 1]).astype(np.float32),
        )
        return cv2.remap(photo, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)

    return run


def conventional(photo: Image, field: Field) -> Warp:
    """The whole image's map by two matrix products, and one full remap."""
    height, width = photo.shape[:2]
    result = np.empty_like(photo)
    lattice = field.lattices[0]

    def run() -> object:
        axes = np.arange(float(width)), np.arange(float(height))
        bx, by = (weights.astype(np.float32) for weights in lattice.weights_at(*axes))
        phi = lattice.phi.astype(np.float32)
        x = (by @ phi[..., 0]) @ bx.T
        x += np.arange(width, dtype=np.float32)
        y = (by @ phi[..., 1]) @ bx.T
        y += np.arange(height, dtype=np.float32)[:, None]
        border = cv2.BORDER_REPLICATE
        return cv2.remap(photo, x, y, cv2.INTER_LINEAR, dst=result, borderMode=border)

    return run
