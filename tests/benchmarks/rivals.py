"""Other people's warps on the same points; each needs its own library, absent ones are named."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

import cv2
import numpy as np

from kogao_core.base.geometry import Image
from kogao_core.faces.face import Face
from kogao_core.faces.targets import Pairs
from kogao_core.lab.methods import Method, WarpTask
from kogao_core.recipe.recipe import Recipe
from kogao_core.warp.field import Field
from kogao_core.warp.lattice import ORDER, Lattice, basis, matrices

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
        (((bx, by),),) = matrices([lattice.window_at(*axes)])
        bx, by = bx.astype(np.float32), by.astype(np.float32)
        phi = lattice.phi.astype(np.float32)
        x = (by @ phi[..., 0]) @ bx.T
        x += np.arange(width, dtype=np.float32)
        y = (by @ phi[..., 1]) @ bx.T
        y += np.arange(height, dtype=np.float32)[:, None]
        border = cv2.BORDER_REPLICATE
        return cv2.remap(photo, x, y, cv2.INTER_LINEAR, dst=result, borderMode=border)

    return run


def simpleitk(photo: Image, field: Field) -> Warp:
    """The same control points in SimpleITK's BSplineTransform and resampler."""
    import SimpleITK

    height, width = photo.shape[:2]
    lattice = field.lattices[0]
    h = lattice.grid.spacing_px
    first = np.floor(-np.array(lattice.grid.origin_px) / h).astype(int) - 1
    mesh = [int(np.ceil(size / h)) + 1 for size in (width, height)]
    phi = lattice.window((int(first[0]), int(first[1])), (mesh[1] + 3, mesh[0] + 3))
    transform = SimpleITK.BSplineTransform(2, 3)
    origin = np.array(lattice.grid.origin_px) + h * (first + 1)
    transform.SetTransformDomainOrigin(origin.tolist())
    transform.SetTransformDomainPhysicalDimensions([cells * h for cells in mesh])
    transform.SetTransformDomainMeshSize(mesh)
    transform.SetParameters(phi.transpose(2, 0, 1).ravel().tolist())
    picture = SimpleITK.GetImageFromArray(photo, isVector=True)
    return lambda: SimpleITK.Resample(picture, picture, transform, SimpleITK.sitkLinear)


def fitted_and_warped(method: Method, photo: Image, face: Face) -> Warp:
    """One of the methods of `kogao_core.lab.methods`, from landmarks to pixels."""
    task = WarpTask.of(photo, [face], Recipe())
    if method.needs:
        import_module(method.needs)
    return lambda: method.fit(task).pixels(photo)


def opencv_tps(photo: Image, face: Face) -> Warp:
    """OpenCV's thin-plate spline transformer."""
    target, displacement = WarpTask.of(photo, [face], Recipe()).anchored()
    source = target + displacement
    matches = [cv2.DMatch(k, k, 0) for k in range(len(source))]

    def run() -> object:
        transformer = cv2.createThinPlateSplineShapeTransformer()
        shapes = (np.float32(target)[None], np.float32(source)[None])
        transformer.estimateTransformation(*shapes, matches)
        return transformer.warpImage(photo)

    return run


def facetweak_shift(photo: Image, pairs: Pairs) -> Warp:
    """facetweak's local shift, once for each landmark, cubic."""
    from facetweak.warp import shift

    spacing = float(np.linalg.norm(np.diff(pairs.source_px, axis=0), axis=1).mean())

    def run() -> object:
        result = photo
        for (x, y), (dx, dy) in zip(pairs.source_px, -pairs.displacement_px, strict=True):
            result = shift(result, x, y, 2 * spacing, dx, dy)
        return result

    return run
