"""A mean face to place by hand, for photos in which no source finds one."""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine
from kogao_core.base.language import Text
from kogao_core.faces.face import OUTLINE_POINTS, Face

# Mean of 118 hand-labelled frontal faces, made symmetric, its outline ended where every outline is
# (`outline.ended`); origin in the middle of the points' box, unit from end to end. Averaged
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
    """Return the mean face at a place, a size and an angle.

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
    if not width_px > 0.0:
        raise ValueError(Text("width_px must be above 0, got {width_px!r}", width_px=width_px))
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
