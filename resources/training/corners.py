"""Learn the confidence of eye and mouth corners: `python -m resources.training.corners DATA`.

Faces of DATA are covered or blurred at random. A corner is correct if it stays within 5 % of its
original position. Prints the weights for `kogao_core/faces/landmarks/mesh.py`, and their accuracy
on people left out of training.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

import click
import cv2
import numpy as np

from kogao_core.base import assets
from kogao_core.base.geometry import Array, Image
from kogao_core.base.threads import one_blas_thread
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import locked
from kogao_core.faces.landmarks.blazeface import Detection
from kogao_core.faces.landmarks.edges import MODEL, EdgeNetwork
from kogao_core.faces.landmarks.mesh import KINDS, MeshNetwork, MeshSource, box_of, corner_signs
from kogao_core.faces.landmarks.pixels import Pyramid

from .aam.detected import read
from .evaluate import area_under_curve

_PHOTOS: Final = {"portraits/*.jpg": 1, "headshots/*.jpg": 2, "frll/*_smiling.jpg": 3}
_LONGEST_PX: Final = 400
_LEAST_SCORE: Final = 0.75
_TIMES: Final = 6  # variants of each face; the first is unchanged
_RIGHT: Final = 0.05  # largest error of a correct corner, in outer inter-ocular distances
_LEFT_OUT: Final = 4  # one in this many people is left out for the test
_PENALTY: Final = 1e-3


class Known(NamedTuple):
    """A photograph of one face."""

    picture: Image
    face: Face


class CornerExample(NamedTuple):
    """Predictors for the six corners of a face, and which corners are correct."""

    person: int
    signs: Array
    right: Array


@click.command()
@click.argument("data", type=click.Path(exists=True, file_okay=False, path_type=Path))
def main(data: Path) -> None:
    """Learn from the photographs in DATA; print the weights."""
    cv2.setNumThreads(1)
    with one_blas_thread():
        known = list(_known(data))
        examples = list(_examples(known, np.random.default_rng(0)))
    click.echo(f"{len(known)} people, {len(examples)} pictures")
    left_out = np.array([one.person % _LEFT_OUT == 0 for one in examples])
    signs = np.stack([one.signs for one in examples])
    right = np.stack([one.right for one in examples])
    for kind, name in enumerate(("outer corners", "inner corners", "mouth")):
        columns = np.flatnonzero(kind == KINDS)
        learnt = _learnt(signs[~left_out][:, columns], right[~left_out][:, columns])
        sure = _log_odds(learnt, signs[left_out][:, columns]).ravel()
        was = right[left_out][:, columns].ravel()
        area = area_under_curve(sure[~was], sure[was])
        weights = ", ".join(f"{one:.2f}" for one in _learnt(signs[:, columns], right[:, columns]))
        click.echo(f"{name}: ({weights}); left out: area {area:.2f}, {(~was).sum()} wrong")


def _known(data: Path) -> Iterator[Known]:
    source = MeshSource()
    for pattern, every in _PHOTOS.items():
        for path in sorted(data.glob(pattern))[::every]:
            picture = read(path)
            scale = min(1.0, _LONGEST_PX / max(picture.shape))
            picture = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
            faces = source.find(picture)
            if len(faces) == 1 and faces[0].score > _LEAST_SCORE:
                yield Known(np.asarray(picture), faces[0])


def _examples(known: list[Known], rng: np.random.Generator) -> Iterator[CornerExample]:
    network = MeshNetwork(locked.network(locked.MESH))
    edges = EdgeNetwork.read(assets.path(MODEL))
    for person, one in enumerate(known):
        for time in range(_TIMES):
            other = known[int(rng.integers(len(known)))].picture
            picture = _covered(one, other, rng) if time else one.picture
            image = Pyramid(picture)
            passes = network.settled(image, _as_detected(box_of(one.face), rng))
            if passes is None:
                continue
            _, mesh, mirrored, _ = passes
            eyes, mouth = (mesh.eyes + mirrored.eyes) / 2.0, (mesh.mouth + mirrored.mouth) / 2.0
            _, seen = edges.refined(image, eyes, (mesh.outline + mirrored.outline) / 2.0)
            corners = np.vstack([one.face.eyes, one.face.mouth])
            moved = np.linalg.norm(np.vstack([eyes, mouth]) - corners, axis=1)
            right = moved < _RIGHT * one.face.interocular_px
            yield CornerExample(person, corner_signs(passes, seen), right)


def _as_detected(box: Detection, rng: np.random.Generator) -> Detection:
    """Return a box with random errors like the detector's."""
    return Detection(
        box.center_px + rng.normal(0.0, 0.04 * box.side_px, 2),
        box.side_px * float(np.exp(rng.normal(0.0, 0.08))),
        box.degrees + float(rng.normal(0.0, 3.0)),
        score=1.0,
    )


def _covered(one: Known, other: Image, rng: np.random.Generator) -> Image:
    """Blur the picture, or cover eyes, mouth or everything below the nose."""
    face, unit = one.face, one.face.interocular_px
    kind = int(rng.integers(5))
    if kind == 4:
        return np.asarray(cv2.GaussianBlur(one.picture, (0, 0), rng.uniform(0.02, 0.1) * unit))
    across = (face.eyes[3] - face.eyes[0]) / unit
    down = np.array([-across[1], across[0]])
    tilt = float(np.degrees(np.arctan2(across[1], across[0])))
    cover = np.zeros(one.picture.shape[:2], np.uint8)

    def blob(middle: Array, axes: Array, degrees: float) -> None:
        box = (tuple(middle.tolist()), tuple((2.0 * unit * axes).tolist()), degrees)
        cv2.ellipse(cover, box, 255, -1)

    if kind == 0:
        middle = np.vstack([face.eyes, face.mouth])[rng.integers(6)]
        spot = middle + rng.normal(0.0, 0.1 * unit, 2)
        blob(spot, rng.uniform(0.1, 0.45, 2), float(rng.uniform(0.0, 180.0)))
    elif kind == 1:
        axes = rng.uniform(0.15, 0.3) * np.array([1.0, rng.uniform(0.6, 1.0)])
        for eye in (face.eyes[:2], face.eyes[2:]):
            blob(eye.mean(axis=0), axes, tilt)
    elif kind == 2:
        top = face.eye_center + rng.uniform(0.25, 0.8) * (face.mouth_center - face.eye_center)
        wide, bend, long = rng.uniform((0.5, -0.12, 0.4), (1.3, 0.05, 1.3))
        places = ((-wide, 0.0), (0.0, bend), (wide, 0.0), (0.8 * wide, long), (-0.8 * wide, long))
        hem = [top + unit * (x * across + y * down) for x, y in places]
        cv2.fillPoly(cover, [np.array(hem).astype(np.int32)], 255)
    else:
        for _ in range(int(rng.integers(1, 5))):
            start = face.points[rng.integers(len(face.points))].astype(int)
            end = (face.mouth_center + rng.normal(0.0, 0.5 * unit, 2)).astype(int)
            width = max(2, int(rng.uniform(0.05, 0.25) * unit))
            cv2.line(cover, start.tolist(), end.tolist(), 255, width)
    soft = cv2.GaussianBlur(cover, (0, 0), float(rng.uniform(0.01, 0.03)) * unit) / 255.0
    share = soft[..., None] * (1.0 if rng.random() < 0.7 else rng.uniform(0.6, 1.0))
    cloth = _cloth(one.picture.shape, other, rng)
    both = one.picture * (1.0 - share) + cloth * share
    return np.asarray(np.clip(both, 0, 255), np.uint8)


def _cloth(shape: tuple[int, ...], other: Image, rng: np.random.Generator) -> Array:
    if rng.random() < 0.5:
        moved = np.roll(other, tuple(rng.integers(0, 300, 2)), (0, 1))
        return np.asarray(cv2.resize(moved, shape[1::-1]), np.float64)
    colour = rng.uniform(0.0, 255.0, 3) if rng.random() < 0.6 else np.full(3, rng.uniform(0, 255))
    shade = 1.0 + rng.uniform(-0.5, 0.5) * np.linspace(-1.0, 1.0, shape[0])[:, None, None]
    return np.asarray(colour * shade + rng.normal(0.0, rng.uniform(1.0, 12.0), shape))


def _learnt(signs: Array, right: Array) -> Array:
    """Fit a logistic regression (Newton's method); return the weights, the constant last."""
    rows = np.c_[signs.reshape(-1, signs.shape[-1]), np.ones(right.size)]
    goal, weights = right.ravel().astype(np.float64), np.zeros(rows.shape[1])
    ridge = _PENALTY * len(rows) * np.diag([1.0] * (len(weights) - 1) + [0.0])
    for _ in range(30):
        sure = 1.0 / (1.0 + np.exp(-rows @ weights))
        slope = rows.T @ (sure - goal) + ridge @ weights
        weights -= np.linalg.solve((rows * (sure * (1.0 - sure))[:, None]).T @ rows + ridge, slope)
    return weights


def _log_odds(weights: Array, signs: Array) -> Array:
    return np.asarray(signs @ weights[:-1] + weights[-1])


if __name__ == "__main__":
    main()
