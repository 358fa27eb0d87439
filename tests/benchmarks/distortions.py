"""What is done to a portrait whose face is known: covered, blurred, shrunk, cut."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

import cv2
import numpy as np

from kogao_core.base.geometry import Affine, Array, Image
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks.edges import smooth


class Distorted(NamedTuple):
    """A picture, and how its points follow from the portrait's."""

    picture: Image
    change: Affine


Distortion = Callable[[Image, Face, np.random.Generator], Distorted]
SAME: Final = Affine(np.eye(2), np.zeros(2))
MASKS: Final = {"light blue": (150, 195, 215), "white": (236, 236, 232), "black": (32, 32, 36)}


def mask(colour: tuple[int, int, int]) -> Distortion:
    """Return what draws a face mask: folds, shade to the sides, noise, loops to the ears."""

    def worn(picture: Image, face: Face, rng: np.random.Generator) -> Distorted:
        unit, down = face.interocular_px, _down(face)
        line = smooth(face.outline)
        top = face.eye_center + (0.38 + 0.08 * rng.random()) * (face.mouth_center - face.eye_center)
        reach = 0.18 + 0.06 * rng.random()  # of the outline, from either end down
        first = round(reach * len(line))
        hem = line[first : len(line) - first]
        hem = face.middle + 1.04 * (hem - face.middle)
        wings = [(top + end) / 2.0 - 0.06 * unit * down for end in (hem[-1], hem[0])]
        edge = np.vstack([hem, wings[0], top, wings[1]])
        y, x = np.mgrid[: picture.shape[0], : picture.shape[1]].astype(np.float32)
        across, along = (face.eyes[3] - face.eyes[0]) / unit, down
        u = ((x - top[0]) * across[0] + (y - top[1]) * across[1]) / unit
        v = ((x - top[0]) * along[0] + (y - top[1]) * along[1]) / unit
        light = 1.0 - 0.35 * (u / 0.75) ** 2 + 0.06 * np.sin(2.0 * np.pi * v / 0.16) - 0.08 * v
        cloth = np.clip(light, 0.2, 1.1)[..., None] * np.array(colour, np.float32)
        cloth += rng.normal(0.0, 5.0, (*picture.shape[:2], 1)).astype(np.float32)
        loops = (hem[0], line[max(0, first - 6)]), (hem[-1], line[-first + 5])
        result = picture
        for loop in loops:
            result = _laid(
                result, cloth, _stroke(picture, np.array(loop), 0.02 * unit), 0.01 * unit
            )
        return Distorted(_laid(result, cloth, _filled(picture, edge), 0.012 * unit), SAME)

    return worn


def scarf(picture: Image, face: Face, rng: np.random.Generator) -> Distorted:
    """Wind a scarf round the face up to the tip of the nose, and far beyond it on both sides."""
    unit, down = face.interocular_px, _down(face)
    across = (face.eyes[3] - face.eyes[0]) / unit
    top = face.eye_center + 0.55 * (face.mouth_center - face.eye_center)
    corners = [top + s * across * unit + t * down * unit for s, t in _SCARF]
    wool = _noise(picture, rng, 0.03 * unit, 18.0) + np.array((130, 45, 40), np.float32)
    return Distorted(_laid(picture, wool, _filled(picture, np.array(corners)), 0.02 * unit), SAME)


_SCARF: Final = ((-1.1, 0.05), (0.0, -0.04), (1.1, 0.05), (1.3, 1.5), (-1.3, 1.5))


def veil(picture: Image, face: Face, rng: np.random.Generator) -> Distorted:
    """Let a thin cloth hang before all but the eyes."""
    unit, down = face.interocular_px, _down(face)
    across = (face.eyes[3] - face.eyes[0]) / unit
    top = face.eye_center + 0.3 * (face.mouth_center - face.eye_center)
    corners = np.array([top + (s * across + t * down) * unit for s, t in _SCARF])
    cloth = _noise(picture, rng, 0.05 * unit, 10.0) + np.array((60, 60, 75), np.float32)
    share = 0.75 * _soft(_filled(picture, corners), 0.02 * unit)
    return Distorted(_mixed(picture, cloth, share), SAME)


def hand(picture: Image, face: Face, rng: np.random.Generator) -> Distorted:
    """Hold four fingers of the cheek's colour before one side of the jaw."""
    unit, down = face.interocular_px, _down(face)
    across = (face.eyes[3] - face.eyes[0]) / unit * (1.0 if rng.random() < 0.5 else -1.0)
    cheek = (face.eyes.mean(axis=0) + face.mouth_center) / 2.0
    x, y = np.clip(cheek, 0, np.array(picture.shape[1::-1]) - 1).astype(int)
    skin = picture[max(0, y - 4) : y + 5, max(0, x - 4) : x + 5].reshape(-1, 3).mean(axis=0)
    result = picture
    for finger in range(4):
        base = face.mouth_center + (0.85 * across + (0.55 - 0.16 * finger) * down) * unit
        tip = base + (-0.75 * across - 0.2 * down) * unit
        tone = skin * (0.82 + 0.06 * finger) + _noise(picture, rng, 0.02 * unit, 4.0)
        cover = _stroke(picture, np.array([base, tip]), 0.15 * unit)
        result = _laid(result, tone.astype(np.float32), cover, 0.01 * unit)
    return Distorted(result, SAME)


def sunglasses(picture: Image, face: Face, _: np.random.Generator) -> Distorted:
    """Put dark glasses before the eyes."""
    unit, cover = face.interocular_px, np.zeros(picture.shape[:2], np.uint8)
    tilt = float(np.degrees(np.arctan2(*(face.eyes[3] - face.eyes[0])[::-1])))
    for corners in (face.eyes[:2], face.eyes[2:]):
        middle = corners.mean(axis=0) + 0.03 * unit * _down(face)
        axes = (round(0.24 * unit), round(0.17 * unit))
        cv2.ellipse(cover, tuple(map(round, middle.tolist())), axes, tilt, 0, 360, 255, -1)
    bridge = _stroke(picture, face.eyes[1:3], 0.03 * unit)
    glass = np.full(picture.shape, 22.0, np.float32)
    return Distorted(_laid(picture, glass, np.maximum(cover, bridge), 0.01 * unit), SAME)


def blur(percent: float) -> Distortion:
    """Return what blurs by a Gaussian, its sigma in % of the outer inter-ocular distance."""

    def blurred(picture: Image, face: Face, _: np.random.Generator) -> Distorted:
        soft = cv2.GaussianBlur(picture, (0, 0), percent / 100.0 * face.interocular_px)
        return Distorted(np.asarray(soft), SAME)

    return blurred


def small(width_px: float) -> Distortion:
    """Return what shrinks the face to a width, px."""

    def shrunk(picture: Image, face: Face, _: np.random.Generator) -> Distorted:
        scale = width_px / face.box[2]
        tiny = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        rows, columns = tiny.shape[:2]
        change = Affine.resize(columns / picture.shape[1], rows / picture.shape[0])
        return Distorted(np.asarray(tiny), change)

    return shrunk


def cut_at_nose(picture: Image, face: Face, _: np.random.Generator) -> Distorted:
    """Leave the right half of the face."""
    left = int(face.middle[0])
    return Distorted(np.ascontiguousarray(picture[:, left:]), Affine(np.eye(2), (-left, 0.0)))


def cut_at_chin(picture: Image, face: Face, _: np.random.Generator) -> Distorted:
    """Leave what is above the lower lip."""
    below = int(face.mouth_center[1] + 0.08 * face.interocular_px)
    return Distorted(np.ascontiguousarray(picture[:below]), SAME)


def dark(factor: float) -> Distortion:
    """Return what lets so much of the light through."""
    return lambda picture, _, __: Distorted((picture * factor).astype(np.uint8), SAME)


def noise(sigma: float) -> Distortion:
    """Return what adds noise of so many levels."""

    def noisy(picture: Image, _: Face, rng: np.random.Generator) -> Distorted:
        levels = picture + rng.normal(0.0, sigma, picture.shape)
        return Distorted(np.clip(levels, 0, 255).astype(np.uint8), SAME)

    return noisy


def touching(picture: Image, face: Face, rng: np.random.Generator) -> Distorted:
    """Lean the same head, mirrored, against one cheek from behind."""
    line = np.vstack([face.outline, _rim(face)[::-1]])
    side = 1.0 if rng.random() < 0.5 else -1.0
    across = (face.eyes[3] - face.eyes[0]) / face.interocular_px
    reach = (line - face.middle) @ across
    apart = 0.92 * (reach.max() - reach.min()) * side * across
    return Distorted(_behind(picture, face, line, _mirrored(face, apart), 1.0), SAME)


def double_chin(picture: Image, face: Face, rng: np.random.Generator) -> Distorted:
    """Let the chin show once more below itself."""
    line = np.vstack([face.outline, _rim(face)[::-1]])
    below = (0.10 + 0.08 * rng.random()) * face.interocular_px * _down(face)
    return Distorted(_behind(picture, face, line, Affine(np.eye(2), below), 0.9), SAME)


def _rim(face: Face) -> Array:
    assert face.forehead is not None
    return np.asarray(face.forehead)


def _mirrored(face: Face, shift: Array) -> Affine:
    """Mirror at the line down the middle of a face, and shift."""
    across = (face.eyes[3] - face.eyes[0]) / face.interocular_px
    mirror = np.eye(2) - 2.0 * np.outer(across, across)
    return Affine(mirror, face.middle - mirror @ face.middle + shift)


def _behind(picture: Image, face: Face, line: Array, change: Affine, light: float) -> Image:
    """Draw a face once more, changed and less lit, behind itself."""
    soft = 0.01 * face.interocular_px
    matrix = np.column_stack([change.matrix, change.shift])
    again = cv2.warpAffine(picture, matrix, picture.shape[1::-1], borderMode=cv2.BORDER_REFLECT)
    beside = _laid(picture, light * again, _filled(picture, change(line)), soft)
    return _laid(beside, picture.astype(np.float32), _filled(picture, line), soft)


DISTORTIONS: Final[dict[str, Distortion]] = {
    **{f"{name} mask": mask(colour) for name, colour in MASKS.items()},
    "scarf": scarf,
    "veil": veil,
    "hand": hand,
    "sunglasses": sunglasses,
    "touching": touching,
    "double chin": double_chin,
    "blur 5 %": blur(5.0),
    "blur 12 %": blur(12.0),
    "24 px": small(24.0),
    "half": cut_at_nose,
    "no chin": cut_at_chin,
    "dark x0.1": dark(0.1),
    "noise 60": noise(60.0),
}


def _down(face: Face) -> Array:
    across = face.eyes[3] - face.eyes[0]
    return np.array([-across[1], across[0]]) / np.linalg.norm(across)


def _filled(picture: Image, corners: Array) -> Image:
    cover = np.zeros(picture.shape[:2], np.uint8)
    cv2.fillPoly(cover, [np.round(corners).astype(np.int32)], 255)
    return cover


def _stroke(picture: Image, line: Array, width_px: float) -> Image:
    cover = np.zeros(picture.shape[:2], np.uint8)
    corners = [np.round(line).astype(np.int32)]
    cv2.polylines(cover, corners, isClosed=False, color=255, thickness=max(1, round(width_px)))
    return cover


def _soft(cover: Image, sigma_px: float) -> Array:
    return np.asarray(cv2.GaussianBlur(cover, (0, 0), max(0.5, sigma_px)) / 255.0)


def _laid(picture: Image, over: Array, cover: Image, sigma_px: float) -> Image:
    return _mixed(picture, over, _soft(cover, sigma_px))


def _mixed(picture: Image, over: Array, share: Array) -> Image:
    both = (1.0 - share[..., None]) * picture + share[..., None] * over
    return np.clip(both, 0, 255).astype(np.uint8)


def _noise(picture: Image, rng: np.random.Generator, grain_px: float, sigma: float) -> Array:
    """Return grey noise of so coarse a grain, shape (H, W, 3)."""
    rows, columns = (int(side / max(1.0, grain_px)) + 2 for side in picture.shape[:2])
    coarse = rng.normal(0.0, sigma, (rows, columns, 1)).astype(np.float32)
    fine = cv2.resize(coarse, picture.shape[1::-1], interpolation=cv2.INTER_CUBIC)
    return np.repeat(fine.reshape(*picture.shape[:2], 1), 3, axis=2)
