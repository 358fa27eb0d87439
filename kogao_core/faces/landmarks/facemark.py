"""A user's own model for `cv2.face`: the 68 points that LBF and Kazemi files are trained on."""

from __future__ import annotations

import io
import itertools
import re
import threading
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np

from kogao_core.base.geometry import Array, Image
from kogao_core.base.language import Text
from kogao_core.base.wording import system_reason
from kogao_core.faces.face import OUTLINE_POINTS, Face, OnFace, ignored, in_reading_order
from kogao_core.faces.landmarks import locked, search
from kogao_core.faces.landmarks.blazeface import INPUT_PX, BlazeFace, Detection, Square
from kogao_core.faces.landmarks.locked import ModelRefused
from kogao_core.faces.landmarks.mesh import LEAST_SCORE
from kogao_core.faces.landmarks.outline import resampled
from kogao_core.faces.landmarks.pixels import Pyramid

POINTS: Final = 68
_JAW: Final = slice(0, 17)
_EYES: Final = (36, 39, 42, 45)
_MOUTH: Final = (48, 54)
_YAML: Final = b"%YAML"
# A Kazemi file starts with the length of its first word, and the word. Anything else makes OpenCV
# ask for whatever memory the bytes happen to spell.
_KAZEMI: Final = (13).to_bytes(8, "little") + b"cascade_depth"
# OpenCV's parser calls itself for every level and ends the program where there are too many. A
# model is flat: names with numbers, lists and matrices.
_DEEPEST_BRACKETS: Final = 16
_DEEPEST_INDENT: Final = 64
_MOST_COLONS: Final = 8  # in a line, the one of a path included
_BRACKETS: Final = re.compile(rb"[\[\]{}]")
_OF_A_MODEL: Final = (b"n_landmarks:", b"stages_n:")
_DEPTH: Final = "tree_depth"
_DEPTHS: Final = range(1, 17)
_COUNTS: Final = range(1, 101)  # of stages, and of each point's trees; commonly 5 and 6
# The published LBF and Kazemi models have 54 and 69 MB.
_MOST_BYTES: Final = 256 * 2**20
# The detector's box as the models' own trainers saw it, in sides of the face: OpenCV's Haar boxes.
_SIDE: Final = 1.12
_UP: Final = 0.12
_SIDES_IN_CROP: Final = 2.0


class FacemarkSource:
    """Landmarks by a model file that the user brings, faces by BlazeFace."""

    name = "facemark"

    def __init__(self, model: Path) -> None:
        self._facemark = _loaded(model)
        self._lock = threading.Lock()  # OpenCV's models keep state between their calls

    @cached_property
    def _detector(self) -> BlazeFace:
        return BlazeFace(locked.network(locked.DETECTOR))

    def find(self, rgb: Image, on_face: OnFace = ignored) -> list[Face]:
        """Return the faces of an upright image, `in_reading_order`; see `MeshSource.find`."""
        image = Pyramid(rgb)
        faces = search.faces(
            image, self._detector, lambda box: self._fit(image, box), on_face=on_face
        )
        return in_reading_order(faces)

    def _fit(self, image: Pyramid, proposal: Detection) -> search.Fitted | None:
        boxes, _ = self._detector.look_closer(image, proposal)
        if not boxes or boxes[0].score < LEAST_SCORE:
            return None
        box = boxes[0]
        view = Square(box.center_px, _SIDES_IN_CROP * box.side_px, box.degrees)
        grey = cv2.cvtColor(image.sample(view.to_image, INPUT_PX), cv2.COLOR_RGB2GRAY)
        side = _SIDE * INPUT_PX / _SIDES_IN_CROP
        left = (INPUT_PX - side) / 2.0
        top = left - _UP * side
        frame = np.array([[left, top, side, side]]).round().astype(np.int32)
        with self._lock:
            done, found = self._facemark.fit(grey, frame)
        if not done or np.shape(found[0]) != (1, POINTS, 2) or not np.isfinite(found[0]).all():
            return None
        return search.Fitted(face_of(view.to_image(found[0][0]), box.score), box)


def face_of(points: Array, score: float) -> Face:
    """Return a face from the 68 points of iBUG's mark-up, shape (68, 2), px."""
    return Face(
        resampled(points[_JAW], OUTLINE_POINTS),
        points[list(_EYES)],
        points[list(_MOUTH)],
        score,
        source=FacemarkSource.name,
    )


def _loaded(model: Path) -> Any:
    try:
        with model.open("rb") as file:
            start = file.read(len(_KAZEMI))
            is_yaml = start.startswith(_YAML)
            text = start + file.read(_MOST_BYTES) if is_yaml else b""
    except OSError as error:
        raise ModelRefused(
            Text(
                "the model {model} can't be read ({reason})",
                model=model,
                reason=system_reason(error),
            )
        ) from error
    if len(text) > _MOST_BYTES:
        raise ModelRefused(
            Text("{model} is too large for a landmark model; give another file", model=model)
        )
    if is_yaml:
        facemark = _silent_lbf()
    elif start == _KAZEMI:
        facemark = cv2.face.createFacemarkKazemi()
    else:
        raise ModelRefused(
            Text(
                "{model} is no landmark model that cv2.face reads; give an LBF "
                "(.yaml) or Kazemi (.dat) file of 68 points",
                model=model,
            )
        )
    try:
        whole = not is_yaml or (_is_flat(text) and _is_whole(model))
        if whole:
            facemark.loadModel(str(model))
    except (cv2.error, SystemError):
        whole = False
    if not whole:
        raise ModelRefused(
            Text("the landmark model {model} is damaged, or not one of 68 points", model=model)
        )
    return facemark


def _silent_lbf() -> Any:
    # By itself it prints to standard output, which belongs to the command.
    settings = cv2.FileStorage(
        "%YAML:1.0\n---\nverbose: 0\n", cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY
    )
    facemark = cv2.face.createFacemarkLBF()
    facemark.read(settings.root())
    return facemark


def _is_flat(text: bytes) -> bool:
    """Return whether YAML text looks like a model, and OpenCV can read it without a crash."""
    if not all(name in text for name in _OF_A_MODEL):
        return False
    if text.count(b"\r") != text.count(b"\r\n"):  # a line's end to one reader, not to another
        return False
    for line in io.BytesIO(text):
        indent = len(line) - len(line.lstrip(b" \t-"))
        if indent > _DEEPEST_INDENT or line.count(b":") > _MOST_COLONS:
            return False
    depth = 0
    for bracket in _BRACKETS.finditer(text):
        depth += 1 if bracket[0] in b"[{" else -1
        if not 0 <= depth <= _DEEPEST_BRACKETS:
            return False
    return True


def _is_whole(lbf: Path) -> bool:
    """Return whether a YAML file holds all of an LBF model: OpenCV itself doesn't look.

    It takes every tree and weight for there and as large as the numbers at the head say, and reads
    past the end of what isn't.
    """
    stored = cv2.FileStorage(str(lbf), cv2.FILE_STORAGE_READ)
    try:
        landmarks, stages, trees, depth = (
            stored.getNode(name).real() for name in ("n_landmarks", "stages_n", "tree_n", _DEPTH)
        )
        if landmarks != POINTS or stages not in _COUNTS or trees not in _COUNTS:
            return False
        if depth not in _DEPTHS or not _has_matrix(stored, "regressor_meanshape", POINTS, 2):
            return False
        nodes, leaves = 2 ** int(depth), 2 ** (int(depth) - 1)
        width = POINTS * int(trees) * leaves
        return all(
            _has_matrix(stored, f"weights_{stage}", 2 * POINTS, width)
            for stage in range(int(stages))
        ) and all(
            _has_matrix(stored, f"tree_{name}", nodes, 4) and _has_list(stored, name, nodes)
            for name in _trees(int(stages), int(trees))
        )
    finally:
        stored.release()


def _trees(stages: int, trees: int) -> Iterator[str]:
    for place in itertools.product(range(stages), range(POINTS), range(trees)):
        yield "_".join(map(str, place))


def _has_matrix(stored: cv2.FileStorage, name: str, rows: int, columns: int) -> bool:
    node = stored.getNode(name)
    found = node.mat() if node.isMap() else None
    return found is not None and found.shape == (rows, columns) and found.dtype == np.float64


def _has_list(stored: cv2.FileStorage, name: str, length: int) -> bool:
    node = stored.getNode(f"thresholds_{name}")
    return bool(node.isSeq()) and node.size() == length
