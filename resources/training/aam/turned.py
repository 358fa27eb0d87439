"""Make turned views of a face from the mesh's depth: few photographs show strong turns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.faces.landmarks.aam.fitting import Grey
from kogao_core.faces.landmarks.aam.model import Floats, carried
from kogao_core.faces.landmarks.mesh import EYES

from .detected import SURFACE

_EARS: Final = (234, 454)  # points of the mesh
_GRID: Final = 40
_RING: Final = 24
_RING_UNITS: Final = 2.15
_STEPS: Final = 24


@dataclass(frozen=True, eq=False)
class FaceCrop:
    """A face on its crop."""

    grey: Grey  # uint8 (H, H): the crop
    mesh: Array  # (478, 3): points of the mesh, px of the crop
    keypoints: Array  # (6, 2): the detector's keypoints, px of the crop


def turned(view: FaceCrop, yaw_degrees: float, pitch_degrees: float) -> FaceCrop:
    """Return the face turned sideways and up or down, rendered from the single picture."""
    center = view.mesh[:SURFACE].mean(axis=0)
    depth = _depth(view, center)
    turn = _rotation(yaw_degrees, pitch_degrees)
    picture = _rendered(view.grey, depth, center, turn)
    at = view.keypoints.astype(np.float32)
    keypoint_depth = cv2.remap(depth, at[:, :1], at[:, 1:], cv2.INTER_LINEAR)
    keypoints = np.column_stack([view.keypoints - center[:2], keypoint_depth]) @ turn.T
    return FaceCrop(
        picture,
        (view.mesh - center) @ turn.T + center,
        keypoints[:, :2] + center[:2],
    )


def _rotation(yaw_degrees: float, pitch_degrees: float) -> Array:
    yaw, pitch = np.radians(yaw_degrees), np.radians(pitch_degrees)
    cos, sin = np.cos(yaw), np.sin(yaw)
    aside = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    cos, sin = np.cos(pitch), np.sin(pitch)
    return np.asarray(np.array([[1.0, 0.0, 0.0], [0.0, cos, sin], [0.0, -sin, cos]]) @ aside)


def _depth(view: FaceCrop, center: Array) -> Floats:
    """Return a depth for each pixel: from the mesh, or from a plane behind the head."""
    side = view.grey.shape[0]
    unit = float(np.linalg.norm(view.mesh[EYES[3], :2] - view.mesh[EYES[0], :2]))
    angles = np.linspace(0.0, 2.0 * np.pi, _RING, endpoint=False)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    ring = center[:2] + _RING_UNITS * unit * circle
    behind = view.mesh[list(_EARS), 2].max()
    known = view.mesh[:SURFACE:4]
    at = np.linspace(0.0, side - 1.0, _GRID)
    grid = np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)
    weights = carried(np.vstack([known[:, :2], ring]), grid)
    coarse = weights @ np.concatenate([known[:, 2], np.full(_RING, behind)])
    coarse = np.clip(coarse, view.mesh[:SURFACE, 2].min(), behind).reshape(_GRID, _GRID)
    coarse = cv2.GaussianBlur(coarse.astype(np.float32), (0, 0), 0.7)
    rows, columns = np.mgrid[:side, :side].astype(np.float32) * ((_GRID - 1) / (side - 1))
    return np.asarray(cv2.remap(coarse, columns, rows, cv2.INTER_LINEAR) - center[2], np.float32)


def _rendered(grey: Grey, depth: Floats, center: Array, turn: Array) -> Grey:
    # The source positions are smooth, so half the resolution suffices.
    side = grey.shape[0]
    at = np.arange(0, side + 1, 2).astype(np.float32)
    x, y = np.meshgrid(at, at)
    back = np.linalg.inv(turn[:2, :2]).astype(np.float32)
    (middle_x, middle_y, _), (lean_x, lean_y) = (
        center.astype(np.float32),
        turn[:2, 2].astype(np.float32),
    )
    from_x, from_y = x, y
    # Fixed-point iteration for each pixel's source; half steps converge where the depth is steep.
    for _ in range(_STEPS):
        z = cv2.remap(depth, from_x, from_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        flat_x, flat_y = x - middle_x - lean_x * z, y - middle_y - lean_y * z
        from_x = (from_x + back[0, 0] * flat_x + back[0, 1] * flat_y + middle_x) / 2
        from_y = (from_y + back[1, 0] * flat_x + back[1, 1] * flat_y + middle_y) / 2
    rows, columns = np.mgrid[:side, :side].astype(np.float32) / 2
    full_x = cv2.remap(from_x, columns, rows, cv2.INTER_LINEAR)
    full_y = cv2.remap(from_y, columns, rows, cv2.INTER_LINEAR)
    return np.asarray(
        cv2.remap(grey, full_x, full_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.uint8
    )
