"""What the left mouse button does on the photo: drag points, or paint and erase protection."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from .i18n import tr

ToolName = Literal["points", "brush", "line", "eraser"]
SMALLEST_PX: Final = 1.0
LARGEST_PX: Final = 512.0
# Four presses of a bracket key double the brush.
PER_OCTAVE: Final = 4


@dataclass(frozen=True, slots=True)
class Brush:
    """The tool in hand.

    Parameters
    ----------
    tool : {"points", "brush", "line", "eraser"}
        What a drag does.
    radius_px : float
        Half the width of brush, line and eraser, px of the photo.
    hard : bool
        Whether a stroke's own pixels keep every byte, by a feather beside it; a soft one only
        asks the fit to leave the place alone.
    """

    tool: ToolName = "points"
    radius_px: float = 16.0
    hard: bool = False

    @property
    def paints(self) -> bool:
        """True when a drag changes the protection instead of a point."""
        return self.tool != "points"


@dataclass(frozen=True, slots=True)
class Tool:
    """One tool: what it is called, its key and what it does."""

    name: ToolName
    title: str
    key: str
    tip: str


def tools() -> tuple[Tool, ...]:
    """Return the tools, in the order of the panel."""
    return (
        Tool("points", tr("Points"), "A", tr("Drag landmarks and targets")),
        Tool("brush", tr("Brush"), "B", tr("Paint what must not move")),
        Tool(
            "line", tr("Line"), "N", tr("Protect a straight edge; Shift keeps it level or upright")
        ),
        Tool("eraser", tr("Eraser"), "E", tr("Rub protection out")),
    )
