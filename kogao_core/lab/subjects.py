"""Photos with faces, the input of experiments, and the difference of two pictures."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Affine, Image
from kogao_core.faces.face import Face
from kogao_core.faces.targets import aim
from kogao_core.recipe.recipe import Recipe

# Called with the number of finished steps and of all steps; an exception ends the experiment.
Progress = Callable[[int, int], None]
PAPER_SIZE: Final = (960, 720)  # px, long and short side (section 5)


def no_progress(_: int, __: int) -> None:
    """Ignore the progress."""


@dataclass(frozen=True, eq=False)
class Subject:
    """A photo and the faces to work on."""

    name: str  # name in reports: the file's name
    # (H, W) or (H, W, C): the upright photo, in the form of `kogao_core.pipeline.render`.
    pixels: Image
    faces: tuple[Face, ...]  # at least one, px of the photo
    sha256: str = ""  # digest of the file; empty without a file
    by_hand: tuple[Face, ...] = ()  # the same faces with landmarks and targets set by a person
    file: Path | None = None  # the photo's file

    @property
    def stem(self) -> str:
        """The name for files: characters other than letters, digits and _ become one -."""
        return re.sub(r"[^\w-]+", "-", self.name).strip("-")

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        return int(self.pixels.shape[1]), int(self.pixels.shape[0])

    @property
    def interocular_px(self) -> float:
        """Mean distance between the outer eye corners, px."""
        return float(np.mean([face.interocular_px for face in self.faces]))


def at_paper_size(subject: Subject) -> Subject:
    """Return the subject at 960 x 720 px, upright photos at 720 x 960.

    Crop the largest area of this shape around the faces and resize the crop.
    """
    width, height = subject.size
    goal = np.array(PAPER_SIZE if width >= height else PAPER_SIZE[::-1])
    cut = np.floor(goal * min(width / goal[0], height / goal[1])).astype(int)
    points = np.vstack([face.points for face in subject.faces])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    corner = np.clip(np.round(middle - cut / 2.0), 0, [width, height] - cut).astype(int)
    (left, top), (right, bottom) = corner.tolist(), (corner + cut).tolist()
    part = subject.pixels[top:bottom, left:right]
    smaller = cut[0] > goal[0]
    kernel = cv2.INTER_AREA if smaller else cv2.INTER_CUBIC
    pixels = np.asarray(cv2.resize(part, goal.tolist(), interpolation=kernel))
    resize = Affine.resize(*(goal / cut).tolist())
    onto = resize.after(Affine(np.eye(2), -corner.astype(np.float64)))
    faces, by_hand = (
        tuple(face.mapped(onto) for face in mode) for mode in (subject.faces, subject.by_hand)
    )
    return dataclasses.replace(subject, pixels=pixels, faces=faces, by_hand=by_hand)


def set_by_hand(faces: Sequence[Face], recipe: Recipe) -> tuple[Face, ...]:
    """Return the faces with the targets of `aim`, marked as set by hand."""
    return tuple(dataclasses.replace(f, targets=aim(f, recipe).target_px) for f in faces)
