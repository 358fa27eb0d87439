"""Made-up faces and photos, so that most tests need neither networks nor real pictures.

And what is done to pictures whose face is known: turning, mirroring, comparing what was found.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from kogao_core.additions.edge import edges_px
from kogao_core.additions.fit import fit
from kogao_core.base.geometry import Affine, Box
from kogao_core.faces.face import FOREHEAD_POINTS, Face, OnFace, ignored
from kogao_core.faces.targets import aim
from kogao_core.field.field import Field
from kogao_core.recipe.recipe import Recipe

# The face alone moves, as in the paper, by the retoucher's fit.
ALONE = Recipe(scope="face")


def oval_face(
    width: int = 480,
    height: int = 360,
    *,
    center: tuple[float, float] | None = None,
    size: float = 0.6,
    forehead: bool = False,
) -> Face:
    """Return an oval face whose height is `size` of the picture's, if asked to with a forehead."""
    face_height = size * height
    face_width = 0.78 * face_height
    cx, cy = center or (width / 2 - 0.5, height * 0.48)
    angle = np.deg2rad(np.linspace(205, -25, 2001))
    fine = np.column_stack(
        [cx + face_width / 2 * np.cos(angle), cy + face_height / 2 * np.sin(angle)]
    )
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1)))
    even = np.linspace(0.0, length[-1], 21)
    outline = np.column_stack([np.interp(even, length, fine[:, axis]) for axis in (0, 1)])
    eye_y, mouth_y = cy - 0.06 * face_height, cy + 0.28 * face_height
    eyes = [(cx + f * face_width, eye_y) for f in (-0.30, -0.12, 0.12, 0.30)]
    mouth = [(cx + f * face_width, mouth_y) for f in (-0.15, 0.15)]
    rim = None
    if forehead:
        above = np.deg2rad(np.linspace(205, 335, FOREHEAD_POINTS + 2)[1:-1])
        rim = np.column_stack(
            [cx + face_width / 2 * np.cos(above), cy + face_height / 2 * np.sin(above)]
        )
    return Face(outline, eyes, mouth, forehead=rim)


def textured_photo(
    width: int = 480, height: int = 360, channels: int = 3, dtype: type = np.uint8, seed: int = 7
) -> np.ndarray:
    """Return smooth noise at several scales, shape (H, W, C), or (H, W) for one channel."""
    unit = _noise(width, height, channels, seed)
    if channels == 1:
        unit = unit[..., 0]
    if dtype is np.float32:
        return unit.copy()
    return (unit * np.iinfo(dtype).max).round().astype(dtype)


# Most tests ask for the same one; two, for some are large.
@lru_cache(maxsize=2)
def _noise(width: int, height: int, channels: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    total = np.zeros((height, width, channels), np.float32)
    for step in (64, 16, 4, 2):
        coarse = rng.standard_normal((height // step + 2, width // step + 2, channels))
        fine = cv2.resize(coarse.astype(np.float32), (width, height), interpolation=cv2.INTER_CUBIC)
        total += fine.reshape(total.shape)
    return np.clip(0.5 + 0.12 * total, 0.0, 1.0)


class KnownFaces:
    """A landmark source that finds the same faces in every photo."""

    name = "known"

    def __init__(self, *faces: Face) -> None:
        self.faces = list(faces)

    def find(self, rgb: np.ndarray, on_face: OnFace = ignored) -> list[Face]:  # noqa: ARG002
        for face in self.faces:
            on_face(face)
        return list(self.faces)


def field_of(recipe: Recipe = Recipe(), *faces: Face, fade_px: float = 0.0) -> Field:  # noqa: B008
    """Return the field of faces that are aimed by a recipe; of an oval one if none is given."""
    faces = faces or (oval_face(),)
    pairs = [aim(face, recipe) for face in faces]
    return Field(fit(pairs, [face.anchor for face in faces], [recipe] * len(faces)), fade_px)


def apart_percent(one: Face, other: Face) -> float:
    """Return the mean distance of the 27 points in % of the outer inter-ocular distance."""
    apart = np.linalg.norm(one.points - other.points, axis=1).mean()
    return float(apart / other.interocular_px * 100.0)


def turned(
    picture: np.ndarray, degrees: float, border: int = cv2.BORDER_CONSTANT
) -> tuple[np.ndarray, Affine]:
    """Return a picture turned about its middle, none of it lost, and the turn of its points."""
    rows, columns = picture.shape[:2]
    side = int(np.hypot(rows, columns)) + 1
    turn = Affine.similarity(1.0, degrees, (0.0, 0.0))
    middle = turn(((columns - 1) / 2.0, (rows - 1) / 2.0))
    turn = Affine(turn.matrix, (side - 1) / 2.0 - middle)
    ways = {"flags": cv2.INTER_CUBIC, "borderMode": border}
    return cv2.warpAffine(picture, turn.opencv, (side, side), **ways), turn


def mirrored(picture: np.ndarray, face: Face) -> tuple[np.ndarray, Face]:
    """Return a picture and its face as a mirror shows them."""
    flip = Affine(np.diag([-1.0, 1.0]), np.array([picture.shape[1] - 1.0, 0.0]))
    parts = (flip(part)[::-1] for part in (face.outline, face.eyes, face.mouth))
    rim = None if face.forehead is None else flip(face.forehead)[::-1]
    return np.ascontiguousarray(picture[:, ::-1]), Face(*parts, forehead=rim)


def resized(picture: np.ndarray, scale: float) -> tuple[np.ndarray, Affine]:
    """Return a picture of another size, and the change of its points."""
    interpolation = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_CUBIC
    other = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=interpolation)
    return other, Affine.resize(
        other.shape[1] / picture.shape[1], other.shape[0] / picture.shape[0]
    )


def read_outside_px(field: Field, photo: Box, step_px: float = 1.0) -> float:
    """Return how far outside the photo a one-to-one field reads at most, px: at its edges."""
    low, high = edges_px(photo)
    farthest = 0.0
    for axis in (0, 1):
        along = np.arange(low[1 - axis], high[1 - axis] + step_px, step_px)
        for edge, sign in ((low, -1.0), (high, 1.0)):
            places = np.empty((len(along), 2))
            places[:, axis], places[:, 1 - axis] = edge[axis], along
            farthest = max(farthest, float((sign * field.at(places)[:, axis]).max(initial=0.0)))
    return farthest
