"""Search for faces: in the whole image, in ever smaller tiles, in rotated and in distant views."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from kogao_core.base.threads import default_threads, parallel_in_order
from kogao_core.faces.face import Face, OnFace, ignored
from kogao_core.faces.landmarks.blazeface import BlazeFace, Detection, Look, Square
from kogao_core.faces.landmarks.pixels import Pyramid

# Least detector score for a closer look, in the whole image. Lower values cost time; a closer look
# rejects false faces.
WHOLE_SCORE: Final = 0.5
TILE_SCORE: Final = 0.6  # the same in tiles and distant views
SURE_SCORE: Final = 0.8  # score of a face that is certain
# Faces smaller than this share of the long side suggest more faces too small for larger views.
TILES_BELOW: Final = {2: 0.25, 4: 0.1}
# Overlap of neighbouring tiles, as a share of their side. The finest show faces of a tenth or less.
_LEAST_OVERLAP: Final = 0.3
OVERLAP: Final[dict[float, float]] = {2: 0.5, 4: _LEAST_OVERLAP}
LEAST_TILE_PX: Final = 96  # smallest useful side of a tile
# Faces smaller than this share of the long side, and found with certainty, start a search nearby:
# small faces often have neighbours.
COMPANY_BELOW: Final = 0.1
COMPANY_SIDES: Final = 5.0  # side of the searched square, in sides of the face
COMPANY_SCORE: Final = 0.4  # least detector score in that square
# Around an upright face, search only if another box in its closer look scores more than this.
COMPANY_HINT: Final = 0.3
# Degrees of roll. Tiles miss neighbours of faces with a larger roll, so always search there.
COMPANY_UPRIGHT: Final = 30.0
# A lying head raises the detector's score in an upright view, too. A view is also searched rotated
# if the score exceeds this share of the requested score.
STIRRED: Final = 0.2


class Fitted(NamedTuple):
    """A detected face."""

    face: Face  # the face
    box: Detection  # the square of the mesh
    # Other boxes seen in the closer look; None without a closer look.
    beside: Sequence[Detection] | None = None


Fit = Callable[[Detection], Fitted | None]


def faces(
    image: Pyramid,
    detector: BlazeFace,
    fit: Fit,
    fit_in_company: Fit | None = None,
    on_face: OnFace = ignored,
) -> list[Face]:
    """Return every face that `fit` confirms, without duplicates.

    Threads run ahead, but duplicates are removed in the order of the proposals.
    """
    found: list[Fitted] = []
    most: dict[Square, float] = {}

    def take(proposal: Detection, fitted: Fitted | None) -> None:
        if fitted is not None and not _known(proposal, found) and not _known(fitted.box, found):
            found.append(fitted)
            on_face(fitted.face)

    def look(views: Sequence[Square], least_score: float, fit: Fit = fit) -> None:
        def unknown(proposal: Detection) -> Fitted | None:
            return None if _known(proposal, found) else fit(proposal)

        seen: list[Detection] = []

        def note(view: Square, look: Look) -> None:
            most[view] = look.most
            seen.extend(box for box in look.boxes if _whole_in_view(box, view, image))

        parallel_in_order(
            views, lambda view: detector.look(image, view, least_score), note, default_threads()
        )
        parallel_in_order(_distinct(seen), unknown, take, default_threads())

    def stirred(views: Sequence[Square], least_score: float) -> list[Square]:
        return [view for view in views if most[view] > STIRRED * least_score]

    whole, long_side = _whole(image), max(image.width, image.height)
    tiles = {parts: _tiles(image, parts) for parts in TILES_BELOW}
    look([whole], WHOLE_SCORE)
    if max((one.face.score for one in found), default=0.0) < SURE_SCORE:
        look(_turned(stirred([whole], WHOLE_SCORE)), WHOLE_SCORE)
    for parts, share in TILES_BELOW.items():
        if min((one.box.side_px for one in found), default=0.0) < share * long_side:
            look(tiles[parts], TILE_SCORE)
    if (parts_across := long_side / min(image.width, image.height)) > max(TILES_BELOW):
        look(_tiles(image, parts_across), TILE_SCORE)  # squares as wide as a long, narrow photo
    if fit_in_company is not None:
        around = list(_around(found, COMPANY_BELOW * long_side))
        look(around, COMPANY_SCORE, fit_in_company)
    if not found:
        look(_turned(stirred(tiles[2], TILE_SCORE)), TILE_SCORE)
    if not found:
        # Small rotated faces are rare, and false ones (coins) are likelier: accept only sure faces.
        look(_turned(stirred(tiles[4], SURE_SCORE)), SURE_SCORE, _sure(fit))
    if not found:
        # A face larger than the frame is visible in a distant view.
        far = _far(image)
        look([far, *_turned([far])], TILE_SCORE)
    return [one.face for one in found]


def _sure(fit: Fit) -> Fit:
    """Return a fit that confirms sure faces only."""

    def sure(proposal: Detection) -> Fitted | None:
        fitted = fit(proposal)
        return fitted if fitted is not None and fitted.face.score > SURE_SCORE else None

    return sure


def cut_faces(
    image: Pyramid, detector: BlazeFace, fit: Fit, on_face: OnFace = ignored
) -> list[Face]:
    """Return the faces that the image's edge cuts, found in an image `mirrored` at the edges."""
    found: list[Fitted] = []
    for proposal in detector.look(image, _far(image), SURE_SCORE).boxes:
        fitted = fit(proposal) if _at_edge(proposal, image) else None
        if fitted is not None and _at_edge(fitted.box, image) and not _known(fitted.box, found):
            found.append(fitted)
            on_face(fitted.face)
    return [one.face for one in found]


def _at_edge(box: Detection, image: Pyramid) -> bool:
    low, high = _sides(box.center_px, box.side_px)
    last = np.array([image.width, image.height]) - 1.0
    inside = bool(((high > 0.0) & (low < last)).all())
    return inside and bool(((low < 0.0) | (high > last)).any())


def _around(found: Sequence[Fitted], below_px: float) -> Iterator[Square]:
    for face, box, beside in found:
        if face.score > SURE_SCORE and box.side_px < below_px:
            hints = [one for one in beside or () if one.score > COMPANY_HINT]
            alone = beside is not None and all(_known(one, found) for one in hints)
            if not alone or abs(box.degrees) > COMPANY_UPRIGHT:
                yield Square(box.center_px, COMPANY_SIDES * box.side_px, box.degrees)


def _known(box: Detection, found: Sequence[Fitted]) -> bool:
    return any(box.overlaps(known.box) for known in found)


def _distinct(boxes: Sequence[Detection]) -> list[Detection]:
    """Return the boxes of all views, best first, without overlapping boxes."""
    kept: list[Detection] = []
    for box in sorted(boxes, key=lambda one: -one.score):
        if not any(box.overlaps(other) for other in kept):
            kept.append(box)
    return kept


def _whole_in_view(box: Detection, view: Square, image: Pyramid) -> bool:
    # Drop a face cut by a tile's border, which the next tile shows. Keep a face cut by the image.
    low, high = _sides(box.center_px, box.side_px)
    view_low, view_high = _sides(view.center_px, view.side_px)
    size = np.array([image.width, image.height])
    cut_low = (low < view_low) & (view_low > 0.0)
    cut_high = (high > view_high) & (view_high < size - 1.0)
    return not bool((cut_low | cut_high).any())


def _sides(center_px: np.ndarray, side_px: float) -> tuple[np.ndarray, np.ndarray]:
    return center_px - side_px / 2.0, center_px + side_px / 2.0


def _whole(image: Pyramid) -> Square:
    center = np.array([image.width - 1.0, image.height - 1.0]) / 2.0
    return Square(center, float(max(image.width, image.height)))


def _far(image: Pyramid) -> Square:
    whole = _whole(image)
    return Square(whole.center_px, 2.0 * whole.side_px)


def _turned(views: Sequence[Square]) -> list[Square]:
    turns = (180.0, 90.0, 270.0)
    return [Square(view.center_px, view.side_px, turn) for view in views for turn in turns]


def _tiles(image: Pyramid, parts: float) -> list[Square]:
    """Cover the image by squares of 1 / `parts` of its long side that overlap."""
    side = max(image.width, image.height) / parts
    if side < LEAST_TILE_PX:
        return []
    step = side * (1.0 - OVERLAP.get(parts, _LEAST_OVERLAP))
    rows, columns = _middles(image.height, side, step), _middles(image.width, side, step)
    return [Square(np.array([x, y]), side) for y in rows for x in columns]


def _middles(length_px: int, side_px: float, step_px: float) -> list[float]:
    if length_px <= side_px:
        return [(length_px - 1.0) / 2.0]
    steps = int(np.ceil((length_px - side_px) / step_px))
    ends = side_px / 2.0 - 0.5, length_px - side_px / 2.0 - 0.5
    return [float(middle) for middle in np.linspace(*ends, steps + 1)]
