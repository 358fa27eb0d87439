"""The ways to see the photo before and after."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from .i18n import tr

CompareName = Literal["off", "wipe", "side", "difference"]
# How much stronger than it is the difference is shown.
GAIN: Final = 8


@dataclass(frozen=True, slots=True)
class Comparison:
    """One way to compare: what it is called, its key and what it shows."""

    name: CompareName
    title: str
    key: str
    tip: str


def comparisons() -> tuple[Comparison, ...]:
    """Return the ways to compare, in the order of the toolbar."""
    return (
        Comparison(
            "wipe", tr("Wipe"), "W", tr("Before and after, with a divider to drag; , and . move it")
        ),
        Comparison("side", tr("Side by side"), "Y", tr("Before and after beside each other")),
        Comparison(
            "difference",
            tr("Difference"),
            "X",
            tr("What has changed, {n} times as strong", n=GAIN),
        ),
    )
