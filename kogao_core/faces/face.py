"""Section 3.1: the landmarks of a face: 21 outline points, 4 eye corners and 2 mouth corners."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite
from typing import Any, Final, Protocol

import numpy as np
import numpy.typing as npt

from kogao_core.base.geometry import Affine, Array, Image, frozen
from kogao_core.base.language import BadValue
from kogao_core.base.wording import shown
from kogao_core.recipe.recipe import Recipe

OUTLINE_POINTS: Final = 21  # landmarks from ear to ear round the chin (section 3.1)
FOREHEAD_POINTS: Final = 13  # points over the forehead, without the ends of the outline


@dataclass(frozen=True, slots=True)
class Anchor:
    """Origin and unit of the lattice of a face.

    Stored separately from the landmarks, so that dragging one landmark doesn't shift the lattice
    of the others.
    """

    # Position (x, y) of lattice node (0, 0): halfway between eyes and mouth.
    origin_px: tuple[float, float]
    # Mean distance between neighbouring outline landmarks, the unit of R (section 3.3).
    spacing_px: float

    def __post_init__(self) -> None:
        """Raise ValueError unless the origin is finite and the spacing is finite and positive."""
        if not all(map(isfinite, self.origin_px)) or not 0.0 < self.spacing_px < inf:
            raise BadValue("a face's anchor needs a finite origin and a spacing above 0")


@dataclass(frozen=True, eq=False)
class Face:
    """Landmarks of one face, px of the upright image. "Left" is the viewer's left.

    Parameters
    ----------
    outline : array of shape (N, 2)
        Silhouette from the left end of the eye line around the chin to the right end. Automatic
        outlines have N = 21.
    eyes : array of shape (4, 2)
        Left eye outer and inner corner, right eye inner and outer corner.
    mouth : array of shape (2, 2)
        Left and right mouth corner.
    score : float
        Confidence 0 to 1 of the source; 1 for a face placed by hand.
    targets : array of shape (N, 2), optional
        Targets set by hand for the outline points; rows of NaN are automatic (section 3.2).
    pinned_anchor : Anchor, optional
        Lattice anchor to use instead of the anchor derived from the landmarks.
    source : str
        Name of the landmark source: "mesh", "manual", ...
    recipe : Recipe, optional
        Warp distance, centre, lattice and fit of this face; None for those of the photo.
    confidence : array of shape (N + 6,), optional
        Confidence of each of `points`, 0 to 1: low if hair or a hand covers the point, 1 for a
        point placed by hand. None if the source has no confidence.
    forehead : array of shape (13, 2), optional
        Edge of the forehead, evenly spaced from above the first to above the last outline point.
        None if the source doesn't find the forehead.

    Raises
    ------
    ValueError
        If landmarks are missing or not finite, or a confidence is outside 0 to 1.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> face = kogao.template_face((240, 180), 200)
    >>> face.points.shape
    (27, 2)
    >>> moved = face.with_outline_point(10, (240, 265))
    >>> moved.outline[10], moved.anchor == face.anchor
    (array([240., 265.]), True)
    """

    outline: Array
    eyes: Array
    mouth: Array
    score: float = 1.0
    targets: Array | None = None
    pinned_anchor: Anchor | None = None
    source: str = "manual"
    recipe: Recipe | None = None
    confidence: Array | None = None
    forehead: Array | None = None

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for name, count in (("outline", None), ("eyes", 4), ("mouth", 2)):
            object.__setattr__(self, name, _landmarks(getattr(self, name), name, count))
        outline = self.outline
        if len(outline) < 3:
            raise BadValue(
                "a face needs at least 3 outline points, got {count}", count=len(outline)
            )
        if self.targets is not None:
            targets = frozen(self.targets, outline.shape, gaps=True)
            if (np.isnan(targets[:, 0]) != np.isnan(targets[:, 1])).any():
                raise BadValue("a face's target has only one coordinate")
            object.__setattr__(self, "targets", targets)
        if self.confidence is not None:
            confidence = frozen(self.confidence, (len(outline) + 6,), gaps=True)
            if not ((confidence >= 0.0) & (confidence <= 1.0)).all():
                raise BadValue("confidence must lie between 0 and 1")
            object.__setattr__(self, "confidence", confidence)
        if self.forehead is not None:
            forehead = _landmarks(self.forehead, "forehead", FOREHEAD_POINTS)
            object.__setattr__(self, "forehead", forehead)

    @cached_property
    def anchor(self) -> Anchor:
        """Anchor and unit of this face's lattice."""
        if self.pinned_anchor is not None:
            return self.pinned_anchor
        steps = np.linalg.norm(np.diff(self.outline, axis=0), axis=1)
        x, y = self.middle.tolist()
        return Anchor((x, y), max(1e-3, float(steps.mean())))

    @cached_property
    def eye_center(self) -> Array:
        """Mean of the four eye corners, (x, y)."""
        return np.asarray(self.eyes.mean(axis=0))

    @cached_property
    def mouth_center(self) -> Array:
        """Mean of the two mouth corners, (x, y)."""
        return np.asarray(self.mouth.mean(axis=0))

    @cached_property
    def middle(self) -> Array:
        """Point halfway between `eye_center` and `mouth_center`, (x, y)."""
        return np.asarray((self.eye_center + self.mouth_center) / 2.0)

    @cached_property
    def interocular_px(self) -> float:
        """Distance between the outer eye corners, px."""
        return float(np.linalg.norm(self.eyes[3] - self.eyes[0]))

    @cached_property
    def box(self) -> tuple[float, float, float, float]:
        """Bounding rectangle (x, y, width, height) of all landmarks, px."""
        points = self.points
        low, high = points.min(axis=0), points.max(axis=0)
        return float(low[0]), float(low[1]), float(high[0] - low[0]), float(high[1] - low[1])

    @property
    def points(self) -> Array:
        """All landmarks, shape (N + 6, 2): outline, eyes, mouth (the paper's 27 when N = 21)."""
        return np.vstack([self.outline, self.eyes, self.mouth])

    def with_outline_point(self, index: int, position: npt.ArrayLike) -> Face:
        """Return the face with one outline landmark moved, with confidence 1; the anchor stays.

        Parameters
        ----------
        index : int
            Index of the landmark, 0 to 20; negative indices count from the end.
        position : array of shape (2,)
            New position (x, y), px.
        """
        return self._placed("outline", index, position, 0)

    def with_target(self, index: int, position: npt.ArrayLike | None) -> Face:
        """Return the face with one target set by hand, or reset to automatic.

        Parameters
        ----------
        index : int
            Index of the outline landmark.
        position : array of shape (2,), optional
            Target (x, y), px; None for the automatic target.
        """
        targets = np.full_like(self.outline, np.nan) if self.targets is None else self.targets
        row = (np.nan, np.nan) if position is None else position
        targets = _with_row(targets, index, row)
        return self._edited(targets=None if np.isnan(targets).all() else targets)

    def with_eye_point(self, index: int, position: npt.ArrayLike) -> Face:
        """Return the face with one eye corner moved, with confidence 1.

        Parameters
        ----------
        index : int
            0 to 3, from the viewer's left.
        position : array of shape (2,)
            New position (x, y), px.
        """
        return self._placed("eyes", index, position, len(self.outline))

    def with_mouth_point(self, index: int, position: npt.ArrayLike) -> Face:
        """Return the face with one mouth corner moved, with confidence 1.

        Parameters
        ----------
        index : int
            0 or 1, from the viewer's left.
        position : array of shape (2,)
            New position (x, y), px.
        """
        return self._placed("mouth", index, position, len(self.outline) + 4)

    def _placed(self, part: str, index: int, position: npt.ArrayLike, first_row: int) -> Face:
        """Return the face with one point of a part moved, with confidence 1."""
        points, confidence = getattr(self, part), self.confidence
        if confidence is not None:
            confidence = _with_row(confidence, first_row + index % len(points), 1.0)
        moved = {part: _with_row(points, index, position)}
        return self._edited(confidence=confidence, **moved)

    def _edited(self, **changes: Any) -> Face:
        return dataclasses.replace(self, pinned_anchor=self.anchor, **changes)

    def mapped(self, transform: Affine) -> Face:
        """Return the face with all points and the anchor transformed, like its image.

        Parameters
        ----------
        transform : Affine
            A similarity: rotation, scale, reflection and translation.
        """
        origin = transform(self.anchor.origin_px)
        return dataclasses.replace(
            self,
            outline=transform(self.outline),
            eyes=transform(self.eyes),
            mouth=transform(self.mouth),
            targets=None if self.targets is None else transform(self.targets),
            pinned_anchor=Anchor(
                (float(origin[0]), float(origin[1])), self.anchor.spacing_px * transform.scale
            ),
            forehead=None if self.forehead is None else transform(self.forehead),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the face as written by `kogao-cli detect --json`."""
        return {
            "box": list(self.box),
            "score": self.score,
            "outline": self.outline.tolist(),
            "eyes": self.eyes.tolist(),
            "mouth": self.mouth.tolist(),
            "confidence": None if self.confidence is None else self.confidence.tolist(),
        }


def _landmarks(points: npt.ArrayLike, name: str, count: int | None) -> Array:
    try:
        return frozen(points, (count, 2))
    except ValueError as error:
        raise BadValue("a face's {name} can't be used: {error}", name=name, error=error) from None


def _with_row(points: Array, index: int, position: npt.ArrayLike) -> Array:
    changed, place = points.copy(), np.asarray(position, np.float64)
    if place.shape != points.shape[1:]:
        raise ValueError(f"a position must be a point (x, y), got shape {place.shape}")
    changed[index] = place
    return changed


# Callback for each detected face; called from any thread.
OnFace = Callable[[Face], object]


def ignored(face: Face) -> None:
    """Ignore a face during detection; the returned list contains it."""


class LandmarkSource(Protocol):
    """A face detector with landmarks: the mesh network or the paper's AAM."""

    name: str

    def find(self, rgb: Image, on_face: OnFace = ignored) -> list[Face]:
        """Return the faces of an upright image in reading order, px; empty if there is none.

        `rgb` (H, W) or (H, W, C): uint8, uint16 or float32 (0 to 1). `on_face` is called with each
        face when it is found, one at a time, from any thread; the returned face may have refined
        landmarks.
        """
        ...


def in_reading_order(faces: Iterable[Face]) -> list[Face]:
    """Sort faces in reading order: row by row from the top, each row from the left.

    A new row starts if a horizontal line separates at least two faces above from two faces below
    and crosses no landmarks. The result doesn't depend on the input order.
    """
    rows: list[list[Face]] = [[]]
    bottom = -inf
    for face in sorted(faces, key=lambda face: (face.box[1], face.anchor.origin_px)):
        _, top, _, height = face.box
        if top > bottom and len(rows[-1]) > 1:
            rows.append([])
        rows[-1].append(face)
        bottom = max(bottom, top + height)
    if len(rows) > 1 and len(rows[-1]) == 1:
        alone = rows.pop()
        rows[-1] += alone
    return [face for row in rows for face in sorted(row, key=lambda face: face.anchor.origin_px)]


def select(faces: Sequence[Face], which: str) -> list[Face]:
    """Select faces by ``"all"``, ``"largest"`` or 1-based numbers such as ``"1,3"``.

    Numbered faces are returned in the order of `faces`.
    """
    if which == "all":
        return list(faces)
    if which == "largest":
        return sorted(faces, key=lambda face: face.interocular_px)[-1:]
    try:
        numbers = [int(part) for part in which.split(",")]
    except ValueError:
        raise BadValue(
            "face must be all, largest or numbers like 1,3, got {which}", which=shown(which)
        ) from None
    for number in numbers:
        if not 1 <= number <= len(faces):
            raise BadValue(
                "there is no face {number}; the photo has {count}, from 1 up",
                number=number,
                count=len(faces),
            )
    return [faces[number - 1] for number in sorted(set(numbers))]
