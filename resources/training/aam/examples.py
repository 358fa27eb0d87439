"""Training examples: crops with landmarks, turned views and mirror images."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Affine, Array
from kogao_core.faces.landmarks.aam.fitting import Crop, Grey
from kogao_core.faces.landmarks.aam.points import MIRROR
from kogao_core.faces.landmarks.blazeface import Detection

from .faces import STUDIO, Photographed
from .labels import Labeller
from .turned import turned

# Largest added turns, degrees. The photographs show few turns above 15 degrees.
_MOST_YAW, _MOST_PITCH = 35.0, 15.0
# Weights relative to 1: hand labels weigh more, synthetic views less.
_STUDIO_WEIGHT, _TURNED_WEIGHT = 1.5, 0.5
_KEYPOINTS_MIRROR: Final = [1, 0, 2, 3, 5, 4]


@dataclass(frozen=True, eq=False)
class Example:
    """A crop with its landmarks (80, 2) and the detector's box, px of the crop, and a weight."""

    crop: Crop
    shape: Array
    box: Detection
    weight: float

    @property
    def mirrored(self) -> Example:
        """The mirror image of the example."""
        flip = self.crop.mirrored_points
        assert self.box.keypoints_px is not None
        box = replace(
            self.box,
            center_px=flip(self.box.center_px),
            degrees=-self.box.degrees,
            keypoints_px=flip(self.box.keypoints_px)[_KEYPOINTS_MIRROR],
        )
        return Example(self.crop.mirrored, flip(self.shape)[MIRROR], box, self.weight)


def examples(
    faces: Sequence[Photographed], labeller: Labeller, turns: int, seed: int
) -> list[Example]:
    """Return each face as photographed and in `turns` random turned views, with mirror images.

    Each example is followed by its mirror image.
    """
    rng = np.random.default_rng(seed)
    return [
        one
        for face in faces
        for example in _views(face, labeller, turns, rng)
        for one in (example, example.mirrored)
    ]


def _views(
    face: Photographed, labeller: Labeller, turns: int, rng: np.random.Generator
) -> Iterator[Example]:
    shape = labeller.points(face.view.mesh, face.person)
    weight = _STUDIO_WEIGHT if face.folder in STUDIO else 1.0
    yield Example(Crop(face.view.grey), shape, face.box, weight)
    for _ in range(turns):
        yaw = rng.triangular(-_MOST_YAW, 0.0, _MOST_YAW)
        pitch = rng.triangular(-_MOST_PITCH, 0.0, _MOST_PITCH)
        view = turned(face.view, yaw, pitch)
        try:
            shape = labeller.points(view.mesh, face.person)
        except ValueError:  # turned too far: no outline left below the ears
            continue
        box = replace(face.box, keypoints_px=view.keypoints)
        yield Example(Crop(view.grey), shape, box, _TURNED_WEIGHT)


def lit(grey: Grey, rng: np.random.Generator) -> Grey:
    """Return a picture with random light from a side, brightness, blur and noise."""
    picture = grey.astype(np.float32)
    rows, columns = grey.shape
    if rng.random() < 0.6:
        angle, strength = rng.uniform(0.0, 2.0 * np.pi), 0.6 * rng.normal()
        y = np.linspace(-1.0, 1.0, rows)[:, None] * np.sin(angle)
        x = np.linspace(-1.0, 1.0, columns) * np.cos(angle)
        picture *= np.exp(strength * (x + y)).astype(np.float32)
    gamma = float(np.exp(0.3 * rng.normal()))
    picture = 255.0 * np.power(np.clip(picture / 255.0, 0.0, 1.0), gamma)
    if rng.random() < 0.4:
        picture = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.4, 1.4))
    noise = rng.uniform(0.0, 6.0) * rng.standard_normal(grey.shape, dtype=np.float32)
    darker = picture * rng.uniform(0.5, 1.2) + noise
    return np.asarray(np.clip(darker, 0.0, 255.0), np.uint8)


def jittered(shape: Array, rng: np.random.Generator, strength: float) -> Array:
    """Rotate, scale and shift landmarks at random about their centre."""
    middle = shape.mean(axis=0)
    size = float(np.linalg.norm(shape - middle, axis=1).mean())
    place = Affine.similarity(
        float(np.exp(0.07 * strength * rng.normal())),
        6.0 * strength * rng.normal(),
        middle + 0.08 * strength * size * rng.normal(size=2),
    )
    return place(shape - middle)
