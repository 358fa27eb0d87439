"""Room beside the outline of a face that moves alone, for the steep part of its moves.

Where a landmark moves by more than a lattice spacing can take, pixels beside the outline move, too.
With rho and the rim's displacement m(a) of `additions.rim`::

    d(p) = m(a) * smoothstep((rho - depth) / (1 - depth))    inside the face, rho < 1
    d(p) = m(a) * (1 - ramp((rho - 1) / fade(a)))            outside

fade(a) is `_ROOM` times the length of m(a). `docs/figures/outline.svg` draws both shares over rho.
Reference: the smoothstep is that of Perlin (1985), "An image synthesizer".
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.additions.rim import Rim
from kogao_core.base.geometry import Array, ramp, smoothstep
from kogao_core.faces.targets import FacePairs

# A face that moves alone needs room beside its outline where a landmark moves more than this, in
# landmark spacings: none up to the first value, all from the second.
_STEEP: Final = (0.6, 0.9)
_ROOM: Final = 5.0  # width of that room, in moves; larger: less squeezed, more background moves
_DEPTH: Final = 0.4  # the rho from which it moves the face; larger: a steeper cheek


@dataclass(frozen=True, slots=True, eq=False)
class OutlineMotion:
    """The displacement beside an outline."""

    rim: Rim

    @property
    def strength(self) -> float:
        """How far the outline moves, as a share of its distance to the middle."""
        moves = np.hypot(*self.rim.moves_px.T)
        return float(moves.max() / self.rim.radii_px.mean())

    def end(self, angles: Array) -> Array:
        """Return in directions of shape (N,) the rho beyond which nothing moves."""
        return 1.0 + self._fade(angles)

    def at(self, points: Array) -> Array:
        """Return the backward displacement at points of shape (N, 2), px, same shape."""
        rho, angles = self.rim.at(points)
        within, beyond = (rho - _DEPTH) / (1.0 - _DEPTH), (rho - 1.0) / self._fade(angles)
        share = np.where(rho < 1.0, smoothstep(within), 1.0 - ramp(beyond))
        return np.asarray(self.rim.moved_px(angles, self.rim.moves_px) * share[:, None])

    def _fade(self, angles: Array) -> Array:
        width_px = _ROOM * np.hypot(*self.rim.moved_px(angles, self.rim.moves_px).T)
        return np.asarray(np.maximum(width_px, 1e-6) / self.rim.radius_px(angles))


def steep_part(pairs: FacePairs, spacing_px: float) -> FacePairs:
    """Return pairs with the part of each move that needs room."""
    length = np.hypot(*pairs.displacement_px.T) / spacing_px
    share = smoothstep((length - _STEEP[0]) / (_STEEP[1] - _STEEP[0]))
    moves = share[:, None] * pairs.displacement_px
    return dataclasses.replace(pairs, source_px=pairs.target_px + moves)
