"""From the network's opinion at every step across the outline to one smooth line."""

from __future__ import annotations

import struct
import zipfile
import zlib
from pathlib import Path
from typing import Final

import numpy as np

from kogao_core.base.geometry import Array
from kogao_core.base.language import Text
from kogao_core.faces.landmarks.edges import network
from kogao_core.faces.landmarks.edges.network import Floats
from kogao_core.faces.landmarks.edges.strips import ACROSS, ALONG, MOVES, Cut, lines_of, planes
from kogao_core.faces.landmarks.locked import ModelRefused
from kogao_core.faces.landmarks.outline import resampled
from kogao_core.faces.landmarks.pixels import Pyramid

MODEL: Final = "models/edges.npz"
_DAMAGED_ARCHIVE: Final = (zipfile.BadZipFile, zlib.error, struct.error, RuntimeError)

# Steps, each 1 % of the outer inter-ocular distance: how far inside the silhouette an edge that is
# seen lies at the chin, and outside of it, where beards hang over; how far either way on the
# cheeks; how far one that isn't seen; how much the distance changes from line to line; and what
# counts as the same place. Of a chin, what is seen farther out than twice the first is the edge of
# something else.
_INWARDS: Final = 2.5
_OUTWARDS: Final = 20.0
_ON_CHEEKS: Final = 5.0
_GUESSED: Final = 10.0
_CHANGE: Final = 1.5
_SAME: Final = 3.0
# Neighbouring lines are seen together, so each counts as so much of evidence of its own.
_OWN_SHARE: Final = 0.5
_NEIGHBOURS: Final = np.array([0.1, 0.2, 0.4, 0.2, 0.1])
# 0 where lines belong to the chin, 1 where to a cheek.
_CHEEK: Final = np.clip(2.0 * np.abs(np.linspace(-1.0, 1.0, ALONG)) - 0.5, 0.0, 1.0)[:, None]
_AT_CHIN: Final = np.where(MOVES > 0, _OUTWARDS, _INWARDS)
_SEEN: Final = np.exp(-0.5 * (MOVES / (_AT_CHIN + _CHEEK * (_ON_CHEEKS - _AT_CHIN))) ** 2)
_OF_CHIN: Final = np.abs(MOVES) <= 2.0 * _INWARDS
_UNSEEN: Final = np.exp(-0.5 * (MOVES / _GUESSED) ** 2) * (-MOVES[0] >= MOVES)  # either way alike
INSIDE: Final = int(MOVES[0] - ACROSS[0])


class EdgeNetwork:
    """Moves an outline onto the edge that can be seen."""

    def __init__(self, parameters: list[Floats], *, beards: bool = True) -> None:
        self._parameters = parameters
        self._beards = beards

    @staticmethod
    def read(path: Path, *, beards: bool = True) -> EdgeNetwork:
        """Read a model file; `beards` is as above. Raises ModelRefused."""
        try:
            with np.load(path, allow_pickle=False) as file:
                parameters = [np.asarray(file[name], np.float32) for name in sorted(file.files)]
        except (OSError, EOFError, KeyError, ValueError, *_DAMAGED_ARCHIVE) as error:
            raise ModelRefused(
                Text("{path} is damaged ({error}); reinstall Kogao", path=path, error=error)
            ) from error
        if [array.shape for array in parameters] != network.shapes():
            raise ModelRefused(
                Text("{name} isn't a model of the outline's edge; reinstall Kogao", name=path.name)
            )
        return EdgeNetwork(parameters, beards=beards)

    def refined(self, image: Pyramid, eyes: Array, outline: Array) -> tuple[Array, Array]:
        """Return a finer outline and how sure each of its points is.

        `eyes` (4, 2) px. `outline` (N, 2): at equal steps of arc length, px; `confidence` (N,):
        probability, 0 to 1, that the edge is seen and lies within 3 % of the outer inter-ocular
        distance.
        """
        cut = Cut.of(image, eyes, outline)
        lines = lines_of(cut.to_image.inverse(outline))
        outputs = network.forward(self._parameters, planes(cut.strip(lines))[None])
        moves, confidence = settle(*split(outputs[0]), beards=self._beards)
        moved = np.column_stack([lines.moved(moves), confidence])
        even = resampled(moved, len(outline))
        return cut.to_image(even[:, :2]), np.clip(even[:, 2], 0.0, 1.0)


def split(outputs: Floats) -> tuple[Floats, Floats]:
    """Return the log-odds of each move, shape (..., 41, 55), and of unseen edges, (..., 41)."""
    window = outputs[..., INSIDE : INSIDE + len(MOVES)]
    return window[..., 0, :, :], window[..., 1, :, :].mean(axis=-1)


def settle(seen: Floats, unseen: Floats, *, beards: bool = True) -> tuple[Array, Array]:
    """Return the expected move of each line and its confidence.

    Moves of neighbouring lines are alike: a chain, solved forwards and backwards. `seen` (41, 55);
    `unseen` (41,). `moves` (41,): steps outwards; `confidence` (41,): 0 to 1.
    """
    own = np.exp(seen - seen.max(axis=1, keepdims=True)).astype(np.float64)
    own /= own.sum(axis=1, keepdims=True)
    visible = 1.0 / (1.0 + np.exp(np.clip(unseen.astype(np.float64), -30.0, 30.0)))[:, None]
    if not beards:
        own = own * _OF_CHIN + 1e-12
        share = own.sum(axis=1, keepdims=True)
        visible, own = visible * share, own / share
    alone = own**_OWN_SHARE
    alone /= alone.sum(axis=1, keepdims=True)
    likely = visible * alone * _SEEN + (1.0 - visible) * _UNSEEN / _UNSEEN.sum()
    moves = _along_chain(likely) @ MOVES
    # What each line sees for itself says more than the chain, which is sure of everything: areas
    # under the curve for errors above 5 % are 0.86 and 0.72.
    near = np.abs(MOVES - moves[:, None]) <= _SAME
    agreed = visible[:, 0] * (own * near).sum(axis=1)
    return moves, np.convolve(np.pad(agreed, 2, mode="edge"), _NEIGHBOURS, "valid")


def _along_chain(likely: Array) -> Array:
    change = np.exp(-0.5 * ((MOVES[:, None] - MOVES) / _CHANGE) ** 2)
    change /= change.sum(axis=1, keepdims=True)
    before, after = likely.copy(), np.ones_like(likely)
    for line in range(1, len(likely)):
        before[line] *= before[line - 1] @ change
        before[line] /= before[line].sum()
    for line in range(len(likely) - 2, -1, -1):
        after[line] = change @ (after[line + 1] * likely[line + 1])
        after[line] /= after[line].sum()
    share = before * after
    return np.asarray(share / share.sum(axis=1, keepdims=True))
