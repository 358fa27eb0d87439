"""Where to look for faces: the whole image, ever smaller tiles, turned and from afar."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final

import numpy as np

from kogao_core.face import Face, OnFace, ignored
from kogao_core.landmarks.blazeface import BlazeFace, Detection, Square
from kogao_core.landmarks.pixels import Pyramid
from kogao_core.threads import default_threads, share_in_order

# Least probability worth a closer look: a wrong one costs time, not a false face.
WHOLE_SCORE: Final = 0.5
TILE_SCORE: Final = 0.6
SURE_SCORE: Final = 0.8
# Faces below this part of the long side make others likely that the last views couldn't show.
TILES_BELOW: Final = {2: 0.25, 4: 0.1}
# Neighbouring tiles share this part of their side. The finest show faces of a tenth and less.
OVERLAP: Final = {2: 0.5, 4: 0.3}
LEAST_TILE_PX: Final = 96
# People stand beside people: around a small sure face others are looked for at the size the
# detector sees best, and believed sooner.
COMPANY_BELOW: Final = 0.1
COMPANY_SIDES: Final = 5.0
COMPANY_SCORE: Final = 0.4

Fitted = tuple[Face, Detection]
"""A face and the box that its mesh fills."""
Fit = Callable[[Detection], Fitted | None]


def faces(
    image: Pyramid,
    detector: BlazeFace,
    fit: Fit,
    fit_in_company: Fit | None = None,
    on_face: OnFace = ignored,
) -> list[Face]:
    """Return every face that `fit` bears out, each once.

    The result doesn't depend on the number of threads: they look and fit ahead, but what counts as
    found already is decided in the order of the proposals.

    Parameters
    ----------
    image : Pyramid
        The image.
    detector : BlazeFace
        Proposes boxes.
    fit : callable
        Turns a box into a face and its own box, or None; called in several threads at once.
    fit_in_company : callable, optional
        The same for boxes beside a sure small face, where another is likely.
    on_face : callable
        Gets each face as it is found, one at a time.
    """
    found: list[Fitted] = []

    def take(proposal: Detection, fitted: Fitted | None) -> None:
        if fitted is not None and not _known(proposal, found) and not _known(fitted[1], found):
            found.append(fitted)
            on_face(fitted[0])

    def look(views: Sequence[Square], least_score: float, fit: Fit = fit) -> None:
        def unknown(proposal: Detection) -> Fitted | None:
            return None if _known(proposal, found) else fit(proposal)

        proposals = _proposals(image, detector, views, least_score)
        share_in_order(proposals, unknown, take, default_threads())

    def sure(proposal: Detection) -> Fitted | None:
        fitted = fit(proposal)
        return fitted if fitted is not None and fitted[0].score > SURE_SCORE else None

    whole, long_side = _whole(image), max(image.width, image.height)
    look([whole], WHOLE_SCORE)
    if max((face.score for face, _ in found), default=0.0) < SURE_SCORE:
        look(_turned(whole), WHOLE_SCORE)
    for parts, share in TILES_BELOW.items():
        if min((box.side_px for _, box in found), default=0.0) < share * long_side:
            look(_tiles(image, parts), TILE_SCORE)
    if fit_in_company is not None:
        around = list(_around(found, COMPANY_BELOW * long_side))
        look(around, COMPANY_SCORE, fit_in_company)
    if not found:
        look([turned for tile in _tiles(image, 2) for turned in _turned(tile)], TILE_SCORE)
    if not found:
        # Small and not upright is rare: coins and such are likelier unless all are sure.
        look([turned for tile in _tiles(image, 4) for turned in _turned(tile)], SURE_SCORE, sure)
    if not found:
        # A face larger than the frame is one again from afar.
        far = Square(whole.center_px, 2.0 * whole.side_px)
        look([far, *_turned(far)], TILE_SCORE)
    return [face for face, _ in found]


def _around(found: Sequence[Fitted], below_px: float) -> Iterator[Square]:
    for face, box in found:
        if face.score > SURE_SCORE and box.side_px < below_px:
            yield Square(box.center_px, COMPANY_SIDES * box.side_px, box.degrees)


def _known(box: Detection, found: Sequence[Fitted]) -> bool:
    return any(box.overlaps(known) for _, known in found)


def _proposals(
    image: Pyramid, detector: BlazeFace, views: Sequence[Square], least_score: float
) -> list[Detection]:
    """Return the boxes seen in any of the views, best first, overlapping ones dropped."""
    kept: list[Detection] = []
    seen: list[Detection] = []

    def look(view: Square) -> list[Detection]:
        boxes = detector.look(image, view, least_score)
        return [box for box in boxes if _whole_in_view(box, view, image)]

    share_in_order(views, look, lambda _, boxes: seen.extend(boxes), default_threads())
    for box in sorted(seen, key=lambda one: -one.score):
        if not any(box.overlaps(other) for other in kept):
            kept.append(box)
    return kept


def _whole_in_view(box: Detection, view: Square, image: Pyramid) -> bool:
    # A face cut by a tile's border lies whole in the next tile; one cut by the image's is kept.
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


def _turned(view: Square) -> list[Square]:
    return [Square(view.center_px, view.side_px, turn) for turn in (180.0, 90.0, 270.0)]


def _tiles(image: Pyramid, parts: int) -> list[Square]:
    """Cover the image by squares of 1 / `parts` of its long side that overlap."""
    side = max(image.width, image.height) / parts
    if side < LEAST_TILE_PX:
        return []
    step = side * (1.0 - OVERLAP[parts])
    rows, columns = _middles(image.height, side, step), _middles(image.width, side, step)
    return [Square(np.array([x, y]), side) for y in rows for x in columns]


def _middles(length_px: int, side_px: float, step_px: float) -> list[float]:
    if length_px <= side_px:
        return [(length_px - 1.0) / 2.0]
    steps = int(np.ceil((length_px - side_px) / step_px))
    ends = side_px / 2.0 - 0.5, length_px - side_px / 2.0 - 0.5
    return [float(middle) for middle in np.linspace(*ends, steps + 1)]
