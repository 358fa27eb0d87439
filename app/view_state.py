"""State of the display: features set the fields; canvas, overlays and panels watch the fields."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Literal

from kogao_core.background.lines import BackgroundLine
from kogao_core.base.display import Rgb8
from kogao_core.base.geometry import Affine, Array, Box
from kogao_core.pipeline import Measurement, Rendering
from kogao_core.projects.sidecar import Applied
from kogao_core.recipe.settings import DomainName

from .document import Document, State
from .pyramid import PicturePyramid
from .watching import Watched

Kind = Literal["outline", "eye", "mouth", "target", "centre", "corner", "body", "mark"]
ToolName = Literal["points", "push", "restore", "brush", "line", "eraser"]
# Factor by which the displayed difference is amplified.
GAIN: Final = 8
# Overlays with points of faces.
MARKS: Final = frozenset({"landmarks", "targets", "centre", "shape"})
CompareName = Literal["off", "wipe", "side", "difference"]


@dataclass(frozen=True, slots=True)
class Handle:
    """A draggable or selectable point: `index` within a kind, on one face."""

    kind: Kind
    face: int
    index: int

    @property
    def movable(self) -> bool:
        """True for draggable handles; centre candidates are only selectable."""
        return self.kind != "centre"


@dataclass(frozen=True, slots=True)
class VisiblePart:
    """The visible part of the photo: a box, in px of a pyramid level."""

    level: int
    box: Box


@dataclass(frozen=True, eq=False)
class RenderedFrame:
    """One frame for the screen."""

    revision: int  # revision of the document's state; larger is newer
    rendering: Rendering  # in px of a pyramid level, or of part of a level
    figures: Measurement  # of `rendering`
    done: Applied  # applied edits, px of the photo
    # The pixels in the screen's colours; for a full frame also the coarser levels.
    levels: Sequence[Rgb8]
    to_photo: Affine  # from px of `rendering` to px of the photo
    took_ms: float  # time from the start of the job to the finished frame
    # The rendered part of a preview; None for the full photo with the recipe's kernel.
    part: VisiblePart | None

    @property
    def whole(self) -> bool:
        """Whether the frame covers the full photo."""
        return self.part is None

    @property
    def scale(self) -> float:
        """Photo px per px of the rendering."""
        return self.to_photo.scale


@dataclass(frozen=True, eq=False)
class RetouchedCopy:
    """A retouched copy of the open photo; replaces the original in the wipe comparison."""

    picture: PicturePyramid  # in the frame of the photo
    outlines: tuple[Array, ...]  # of the faces in the copy, px of the photo


@dataclass(frozen=True, slots=True)
class Brush:
    """The selected tool."""

    tool: ToolName = "points"  # effect of a drag
    radius_px: float = 16.0  # brush radius, px of the photo
    strength: float = 0.5  # of push and restore, 0 to 1
    falloff: float = 0.8  # fraction of the radius over which the strength fades

    @property
    def paints(self) -> bool:
        """True if a drag paints a stroke instead of moving a point."""
        return self.tool != "points"

    @property
    def moves(self) -> bool:
        """True if a stroke changes the displacement."""
        return self.tool in ("push", "restore")

    @property
    def protects(self) -> bool:
        """True if a stroke changes the protected region."""
        return self.paints and not self.moves


@dataclass(frozen=True, slots=True)
class Following:
    """Points that follow a dragged outline landmark."""

    # Whether neighbours follow; the effect falls with distance along the outline.
    soft: bool = False
    reach: float = 4.0  # follow range to either side, in landmark spacings
    symmetric: bool = False  # whether the landmark across the midline makes the mirrored move


@dataclass(frozen=True, eq=False, kw_only=True)
class ViewState(Watched):
    """Display settings and the newest frame. `set` replaces fields, `watch` tells of a change."""

    document: Document  # the document with photo and state
    frame: RenderedFrame | None = None  # the newest frame; may be one state behind
    full: RenderedFrame | None = None  # the newest frame of the full photo
    # True while no frame follows a change of the document: only marks are drawn.
    marks_only: bool = False
    switched: frozenset[str] = frozenset()  # names of enabled overlays
    # Faces with visible marks; None for all faces.
    pointed: frozenset[int] | None = None
    # Extra overlays for new users, unless all overlays are hidden.
    explained: frozenset[str] = frozenset()
    original: bool = False  # True while the original is shown
    # The handle under the cursor; the handle that the arrow keys move.
    hovered: Handle | None = None
    selected: Handle | None = None
    shaping: str | None = None  # shape field of the curve under the cursor or in hand
    placing: int | None = None  # the face being placed
    unapplied: bool = False  # True while points set by hand wait for *Apply*
    face: int | None = None  # the selected face; None: settings apply to the photo
    also: frozenset[int] = frozenset()  # further selected faces
    marking: bool = False  # True while a press on the photo adds a landmark
    # Straight lines of the background and the turn of each, most turned first.
    lines: tuple[BackgroundLine, ...] = ()
    compare: CompareName = "off"  # comparison mode
    wipe: float = 0.5  # divider position, as a fraction of the canvas width
    retouched: RetouchedCopy | None = None
    loupe: bool = False  # whether a magnifier is shown at the cursor
    brush: Brush = field(default_factory=Brush)  # the selected tool
    # Points that follow a dragged landmark or target.
    following: Following = field(default_factory=Following)
    other_mode: bool = False  # whether this view shows the inactive mode
    # Cursor position (x, y), px of the photo; None outside the canvas.
    cursor: tuple[float, float] | None = None
    _watchers: list[tuple[frozenset[str], Callable[[], object]]] = field(
        default_factory=list, init=False, repr=False
    )

    def set(self, **changes: Any) -> None:
        """Replace fields, then call the watchers of the fields whose values differ."""
        changed = {name for name, value in changes.items() if value != getattr(self, name)}
        for name in changed:
            object.__setattr__(self, name, changes[name])
        if changed:
            self._call_watchers(changed)

    @property
    def visible(self) -> frozenset[str]:
        """Names of the overlays to draw.

        A brush hides the points of faces, and so does the divider in Retouch.
        Otherwise Retouch shows points only for the face at the cursor.
        """
        shown = self.switched | self.explained if self.switched else self.switched
        quiet = self.pointed is not None and (not self.pointed or self.compare == "wipe")
        return shown - MARKS if quiet or self.brush.paints else shown

    def marks(self, face: int) -> bool:
        """Return whether the marks of a face are shown if the overlays are enabled."""
        return self.pointed is None or face in self.pointed

    @property
    def shows_original(self) -> bool:
        """Whether the picture is the original: points are set on the photo as it was."""
        return self.original or self.unapplied or self.placing is not None

    @property
    def state(self) -> State:
        """The document's state, including a gesture's preview, in this view's mode."""
        state = self.document.state
        return state.in_other_mode if self.other_mode else state

    @property
    def counts(self) -> Mapping[DomainName, int]:
        """Number of pixels in each domain of the newest full result; empty if unknown."""
        full = self.full
        return full.figures.pixel_counts if full is not None and full.rendering.pairs else {}

    @property
    def image(self) -> Box:
        """The photo's rectangle."""
        return self.document.image

    @property
    def busy_hands(self) -> bool:
        """True while the mouse paints, marks or places; a click then selects no face."""
        return self.brush.paints or self.marking or self.placing is not None

    @property
    def face_in_hand(self) -> int | None:
        """The face with active handles: being placed, else selected, else the only face."""
        alone = 0 if len(self.state.faces) == 1 else None
        return next((f for f in (self.placing, self.face, alone) if f is not None), None)

    def answers(self, handle: Handle) -> bool:
        """Return whether a handle is active.

        Only handles of one face are active, except while marking. With several faces and no
        selection, a click selects a face and never a point.
        """
        return handle.face == self.face_in_hand or (self.marking and handle.movable)


# Fields that change the picture of every tool; the cursor changes the picture of some tools only.
DRAWN: Final = frozenset(each.name for each in dataclasses.fields(ViewState)) - {"cursor"}
