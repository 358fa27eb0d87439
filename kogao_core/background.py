"""Straight lines of the background near faces, and how far the warp bends each: the bend meter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from kogao_core.assets import AssetMissing
from kogao_core.bend import BentLine, bends, beside, shortest_px, straight_lines
from kogao_core.face import Face
from kogao_core.geometry import Array, Box, Image
from kogao_core.landmarks import ModelRefused
from kogao_core.person import PersonFinder, PersonMask
from kogao_core.pipeline import Rendering

# Hair stands off further than the mask's edge: lines keep so far from people, in sides of a face.
_APART: Final = 0.03
_CUTS: Final = 256  # steps along a line at which it can be cut
_HALF: Final = 0.5
_HAIR_COUNTS: Final = "lines of hair and clothes count as lines of the background"


@dataclass(frozen=True, slots=True, eq=False)
class Background:
    """The straight lines of a photo that the meter goes by.

    Parameters
    ----------
    lines : array of shape (N, 2, 2)
        Ends (x, y) of each, px.
    note : str
        Why they may not all be lines of the background; empty where they are.
    """

    lines: Array
    note: str = ""


@dataclass(frozen=True, slots=True)
class Bends:
    """What the meter says.

    Parameters
    ----------
    lines : tuple of BentLine
        The most bent first.
    note : str
        See `Background`.
    """

    lines: tuple[BentLine, ...]
    note: str = ""


def background(photo: Image, near: Box, faces: Sequence[Face], finder: PersonFinder) -> Background:
    """Find straight lines near faces, of the background only.

    Lines that touch a person are cut there. Where people can't be told from the background, only
    lines on the faces are left out.

    Parameters
    ----------
    photo : array of shape (H, W) or (H, W, C)
        The photo before the warp.
    near : Box
        The warp domain, or any other box; px.
    faces : sequence of Face
        Those that the warp makes smaller, px of `photo`.
    finder : PersonFinder
        Keep it for the next rendering of the same photo.

    Returns
    -------
    Background
    """
    lines = beside(straight_lines(photo, near), [face.outline for face in faces])
    try:
        people = finder.find(photo, faces)
    except (AssetMissing, ModelRefused):
        why = "the network that tells people apart is missing or damaged (see kogao-cli doctor)"
        return Background(lines, f"{why}, so {_HAIR_COUNTS}")
    if not people.looks:
        return Background(lines, f"people couldn't be told from the background, so {_HAIR_COUNTS}")
    found = _cut(lines, people.grown(_APART), shortest_px(photo))
    return Background(found, _missed(people.missed))


def measure(
    photo: Image, rendering: Rendering, faces: Sequence[Face], finder: PersonFinder
) -> Bends:
    """Measure how far a rendering bends the straight lines of its background.

    Parameters
    ----------
    photo : array of shape (H, W) or (H, W, C)
        The photo before the warp.
    rendering : Rendering
        What became of it.
    faces : sequence of Face
        Those that were made smaller, px of `photo`.
    finder : PersonFinder
        Keep it for the next rendering of the same photo.

    Returns
    -------
    Bends
    """
    found = background(photo, rendering.domain.bounds, faces, finder)
    return Bends(tuple(bends(rendering.field, found.lines, photo)), found.note)


def _missed(count: int) -> str:
    if count == 0:
        return ""
    who = "one face" if count == 1 else f"{count} faces"
    return f"{who} couldn't be told from the background, so lines there don't count"


def _cut(lines: Array, people: PersonMask, shortest: float) -> Array:
    """Return the parts of lines that are long enough and lie on the background."""
    if len(lines) == 0:
        return lines
    t = np.linspace(0.0, 1.0, _CUTS)
    along = lines[:, :1] + t[:, None] * (lines[:, 1:] - lines[:, :1])
    free = people.at(along) < _HALF  # unknown is not free
    kept = []
    for (start, end), row in zip(lines, free, strict=True):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(np.int8)))
        for first, behind in edges.reshape(-1, 2):
            ends = start + t[[first, behind - 1], None] * (end - start)
            if np.linalg.norm(ends[1] - ends[0]) >= shortest:
                kept.append(ends)
    return np.array(kept).reshape(-1, 2, 2)
