"""Return a landmark source by name, and find faces.

The module also contains a mean face to place by hand on photos where no source finds a face.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base import assets
from kogao_core.base.geometry import Affine, Image
from kogao_core.base.language import BadValue
from kogao_core.faces.choices import CHOICES
from kogao_core.faces.face import OUTLINE_POINTS, Face, LandmarkSource
from kogao_core.faces.landmarks import locked

_NETWORKS: Final = (locked.DETECTOR, locked.MESH)


def source(name: str | None = None) -> LandmarkSource:
    """Return a landmark source by name.

    Parameters
    ----------
    name : {"mesh", "aam", "chin"}, optional
        Default: "mesh", or "aam" if the networks are not installed.

    Returns
    -------
    LandmarkSource
        The first call of `find` loads the models. Reuse the source for many photos.

    Raises
    ------
    ValueError
        If there is no source of this name.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> photo = kogao.read(kogao.sample())
    >>> (face,) = kogao.source("aam").find(photo.pixels)
    >>> face.source
    'aam'
    """
    if name is None:
        name = next(c.name for c in CHOICES if not c.needs_networks or networks_are_here())
    make = {choice.name: choice.make for choice in CHOICES}
    if name not in make:
        names = ", ".join(make)
        raise BadValue(
            "{name} is not a landmark source; use one of {names}", name=name, names=names
        )
    return make[name]()


def find(image: Image, landmarks: str | None = None) -> list[Face]:
    """Find the faces of an image and their landmarks (section 3.1).

    Parameters
    ----------
    image : array of shape (H, W) or (H, W, C)
        Grey, RGB or RGBA, upright, such as `Photo.pixels`; float32 is 0 to 1.
    landmarks : {"mesh", "aam", "chin"}, optional
        Name of the landmark source, see `source`.

    Returns
    -------
    list of Face
        Faces in reading order, px of `image`. Empty if no face is found.

    Raises
    ------
    ModelRefused
        If a model file is damaged.
    AssetMissing
        If the source needs a file that is not installed.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> photo = kogao.read(kogao.sample())
    >>> (face,) = kogao.find(photo.pixels)
    >>> face.outline.shape, face.eyes.shape, face.mouth.shape
    ((21, 2), (4, 2), (2, 2))
    """
    return source(landmarks).find(image)


def networks_are_here() -> bool:
    """Return True if the network files are installed."""
    try:
        return all(assets.path(name).exists() for name in _NETWORKS)
    except assets.AssetMissing:
        return False


def check_networks() -> None:
    """Verify the hashes of the installed networks.

    Raises ModelRefused.
    """
    for name in _NETWORKS:
        with suppress(assets.AssetMissing):
            locked.network(name)


# Mean of 118 hand-labelled frontal faces, made symmetric, with the ends of the outline at the
# standard height (`outline.ended`); origin in the middle of the points' box, unit from end to end.
# Averaged
# from the labels of two sets under CC BY 4.0: Face Research Lab London Set (DeBruine & Jones 2017,
# figshare 5047666), Young Adult White Faces (the same, figshare 4220517).
_LEFT_OUTLINE: Final = (
    *((-0.500, -0.412), (-0.503, -0.303), (-0.494, -0.195), (-0.477, -0.088), (-0.457, 0.018)),
    *((-0.425, 0.122), (-0.369, 0.214), (-0.295, 0.293), (-0.207, 0.356), (-0.107, 0.397)),
)
_CHIN: Final = (0.0, 0.412)
_LEFT_EYE: Final = ((-0.314, -0.412), (-0.120, -0.399))
_LEFT_MOUTH: Final = ((-0.178, 0.076),)


def template_face(center_px: npt.ArrayLike, width_px: float, angle_degrees: float = 0.0) -> Face:
    """Return the mean face at a given position, size and angle.

    Parameters
    ----------
    center_px : array of shape (2,)
        Middle of the bounding box of the upright face's 27 points, (x, y).
    width_px : float
        Distance between the two ends of the outline, above 0.
    angle_degrees : float
        Roll from +x towards +y.

    Returns
    -------
    Face
        21 outline points, score 1, source "manual".

    Raises
    ------
    ValueError
        If the width isn't above 0.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> face = kogao.template_face((240, 180), 200)
    >>> face.outline[0], face.outline[20]
    (array([140. ,  97.6]), array([340. ,  97.6]))
    """
    if np.shape(center_px) != (2,):
        raise ValueError(f"center_px must be a point (x, y), got shape {np.shape(center_px)}")
    if not width_px > 0.0:
        raise BadValue("width_px must be above 0, got {width_px!r}", width_px=width_px)
    place = Affine.similarity(width_px, angle_degrees, center_px)
    points = place(_mean_points())
    eyes = OUTLINE_POINTS + 4
    return Face(points[:OUTLINE_POINTS], points[OUTLINE_POINTS:eyes], points[eyes:])


def _mean_points() -> npt.NDArray[np.float64]:
    left = np.array(_LEFT_OUTLINE)
    eye, mouth = np.array(_LEFT_EYE), np.array(_LEFT_MOUTH)
    mirror = np.array([-1.0, 1.0])
    groups = [left, [_CHIN], left[::-1] * mirror, eye, eye[::-1] * mirror, mouth, mouth * mirror]
    return np.vstack(groups)
