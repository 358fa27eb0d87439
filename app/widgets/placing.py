"""Where something lies over a picture and hides as little as possible of what matters."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from PySide6.QtCore import QRectF, QSizeF


def clear_place(
    size: QSizeF, area: QRectF, kept: Sequence[QRectF], now: QRectF | None = None
) -> QRectF:
    """Return the place of `size` in `area` that covers least of what is to be `kept` in sight.

    Parameters
    ----------
    size : QSizeF
        Of what is laid over the picture.
    area : QRectF
        Where it may lie.
    kept : sequence of QRectF
        What it should not cover.
    now : QRectF, optional
        Where it lies; it moves only for a place that covers less. Without one the upper places
        come before the lower ones, and the middle before the sides.
    """
    places = list(_places(size, area))
    if now is not None and now in places:
        places.insert(0, now)
    return min(places, key=lambda place: sum(_common(place, one) for one in kept))


def _places(size: QSizeF, area: QRectF) -> Iterable[QRectF]:
    right, below = area.width() - size.width(), area.height() - size.height()
    for y in (0.0, below):
        for x in (right / 2, 0.0, right):
            yield QRectF(area.left() + x, area.top() + y, size.width(), size.height())


def _common(one: QRectF, other: QRectF) -> float:
    both = one.intersected(other)
    return both.width() * both.height()
