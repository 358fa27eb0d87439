"""What is on screen: read by the canvas and its overlays, written by the features."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from kogao_core.background.lines import BentLine
from kogao_core.base.display import Rgb8
from kogao_core.base.geometry import Affine, Array, Box
from kogao_core.pipeline import Rendering
from kogao_core.projects.sidecar import Applied
from kogao_core.recipe.settings import DomainName

from .document import Document, State

Kind = Literal["outline", "eye", "mouth", "target", "centre", "corner", "body", "mark"]
ToolName = Literal["points", "push", "restore", "brush", "line", "eraser"]
# How much stronger than it is the difference is shown.
GAIN: Final = 8
# The overlays that mark the points of faces.
MARKS: Final = frozenset({"landmarks", "targets", "centre"})
CompareName = Literal["off", "wipe", "side", "difference"]


@dataclass(frozen=True, slots=True)
class Handle:
    """Something to take hold of: point `index` of a kind, on one face."""

    kind: Kind
    face: int
    index: int

    @property
    def movable(self) -> bool:
        """True when it can be dragged; the centre candidates can only be chosen."""
        return self.kind != "centre"


@dataclass(frozen=True, slots=True)
class VisiblePart:
    """The part of the photo on screen: a box, in px of a pyramid level."""

    level: int
    box: Box


@dataclass(frozen=True, eq=False)
class RenderedFrame:
    """One picture for the screen."""

    revision: int  # which state of the document it shows; larger is newer
    rendering: Rendering  # in px of its own: a level of the photo, or a part of one
    done: Applied  # what it does to the photo, px of the photo
    # The picture and, for a whole photo, its halvings, in the screen's colours.
    levels: Sequence[Rgb8]
    to_photo: Affine  # from px of `rendering` to px of the photo
    took_ms: float  # time from the start of the job to the finished picture
    # What a gesture's preview shows; None for the whole photo by the recipe's own kernel.
    part: VisiblePart | None

    @property
    def whole(self) -> bool:
        """Whether it is the whole photo."""
        return self.part is None

    @property
    def scale(self) -> float:
        """Photo px per px of the rendering."""
        return self.to_photo.scale


@dataclass(frozen=True, slots=True)
class Brush:
    """The tool in hand."""

    tool: ToolName = "points"  # what a drag does
    radius_px: float = 16.0  # half the width of a tool that paints, px of the photo
    # Whether a stroke's own pixels keep every byte, by a feather beside it; a soft one only asks
    # the fit to leave the place alone.
    hard: bool = False
    strength: float = 0.5  # of push and restore, 0 to 1
    falloff: float = 0.8  # the share of the radius over which they get weaker

    @property
    def paints(self) -> bool:
        """True when a drag draws a stroke instead of moving a point."""
        return self.tool != "points"

    @property
    def moves(self) -> bool:
        """True when a stroke changes the displacement."""
        return self.tool in ("push", "restore")

    @property
    def protects(self) -> bool:
        """True when a stroke changes what must not move."""
        return self.paints and not self.moves


@dataclass(frozen=True, slots=True)
class Following:
    """What goes along with a landmark of the outline that is moved by hand."""

    # Whether its neighbours follow, the less the farther they are along the outline.
    soft: bool = False
    reach: float = 4.0  # how far neighbours follow to either side, in landmark spacings
    symmetric: bool = False  # whether the landmark across the midline makes the mirrored move


@dataclass
class ViewState:
    """What to draw and how."""

    document: Document  # whose photo and state these are
    frame: RenderedFrame | None = None  # the newest rendering; it may lag behind `state` by one
    switched: set[str] = field(default_factory=set)  # names of the overlays switched on
    # The faces whose marks are shown; None for those of all faces.
    pointed: frozenset[int] | None = None
    # Overlays that a new user sees beside those switched on, unless all are hidden.
    explained: frozenset[str] = frozenset()
    original: bool = False  # true while the photo is shown as it was
    # The point under the cursor, and the one that the arrow keys move.
    hovered: Handle | None = None
    selected: Handle | None = None
    placing: int | None = None  # the face that is being placed as a whole
    face: int | None = None  # the face whose settings are edited; None for those of the photo
    also: frozenset[int] = frozenset()  # further faces that are set with it
    # How many pixels each domain of the newest whole result holds; empty for not known.
    counts: Mapping[DomainName, int] = field(default_factory=dict)
    marking: bool = False  # true while a press on the photo marks a landmark
    # Straight lines of the background and their bend, the most bent first.
    lines: tuple[BentLine, ...] = ()
    # Uint8 (H, W): where people are in the photo, at a size of its own; 255 is a person.
    people: Rgb8 | None = None
    compare: CompareName = "off"  # how before and after are compared
    wipe: float = 0.5  # where the divider stands, as a share of the canvas's width
    loupe: bool = False  # whether what lies under the cursor is magnified
    brush: Brush = field(default_factory=Brush)  # the tool in hand
    # What goes along with a dragged landmark or target.
    following: Following = field(default_factory=Following)
    other_mode: bool = False  # whether the state is that of the mode that isn't at work
    # (2,): where the mouse is, px of the photo; None when it is elsewhere.
    cursor: Array | None = None
    _turned: tuple[State, State] | None = None

    @property
    def visible(self) -> set[str]:
        """Names of the overlays to draw: those switched on, without marks that step back."""
        shown = self.switched | self.explained if self.switched else set[str]()
        return shown if self.pointed or self.pointed is None else shown - MARKS

    def marks(self, face: int) -> bool:
        """Return whether the marks of a face are shown, if they are switched on."""
        return self.pointed is None or face in self.pointed

    @property
    def state(self) -> State:
        """Faces and recipe, a gesture's preview included."""
        state = self.document.state
        if not self.other_mode:
            return state
        if self._turned is None or self._turned[0] is not state:
            # One and the same until the document changes: it remembers its pairs.
            self._turned = state, state.in_other_mode()
        return self._turned[1]

    @property
    def image(self) -> Box:
        """The photo's rectangle."""
        return self.document.image

    @property
    def busy_hands(self) -> bool:
        """True while the mouse paints, marks or places: a click then selects no face."""
        return self.brush.paints or self.marking or self.placing is not None

    @property
    def face_in_hand(self) -> int | None:
        """The face whose points answer: the one being placed, the selected or the only one."""
        alone = 0 if len(self.state.faces) == 1 else None
        return next((f for f in (self.placing, self.face, alone) if f is not None), None)

    def answers(self, handle: Handle) -> bool:
        """Return whether a handle can be taken: those of one face at a time, but while marking.

        With several faces and none selected, a click means a face and never a point of one.
        """
        return handle.face == self.face_in_hand or (self.marking and handle.movable)
