"""From faces and a recipe to a displacement field: three steps of the paper, seven additions.

Each step takes a `WarpDraft` and returns one that knows more. Without its setting, an addition
returns the draft as it is: with `PAPER`, what is left is `targets`, `lattice` and `domain`. To add
a step, write its mathematics in a module of its own, a function here, and a line in `STEPS`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import repeat
from typing import Final

from kogao_core.background.holding import NOTHING_HELD, Held, Site, hold
from kogao_core.base.geometry import Box
from kogao_core.faces.face import Anchor, Face
from kogao_core.faces.targets import FacePairs, aim
from kogao_core.paper.domain import Domain
from kogao_core.recipe.recipe import Recipe
from kogao_core.warp.brush import UNTOUCHED, Brushwork, brushed
from kogao_core.warp.contact import near_heads
from kogao_core.warp.fade import domain_of, fade_of
from kogao_core.warp.field import Field
from kogao_core.warp.fit import fit, grids_of
from kogao_core.warp.frame import attenuated_near_edge
from kogao_core.warp.guard import Limit, limited
from kogao_core.warp.lens import NO_LENS, LensCorrection
from kogao_core.warp.protection import NOTHING, Protection
from kogao_core.warp.surround import HeadDisplacement, giving_way, near_protected, surrounds_of

_STILL: Final = Field(())
_NOWHERE: Final = Domain("image", Box(0, 0, 0, 0), ())


@dataclass(frozen=True, eq=False, kw_only=True)
class WarpDraft:
    """A warp before its pixels are drawn: the request, and the results of the steps."""

    faces: Sequence[Face]
    recipe: Recipe
    photo: Box  # the complete photo
    image: Box  # the part of the photo that is drawn
    protection: Protection = NOTHING
    held: Held = NOTHING_HELD
    brushwork: Brushwork = UNTOUCHED

    corrected_faces: Sequence[Face] = ()  # `lens`: the faces after lens correction
    correction: LensCorrection = NO_LENS  # `lens`
    requested_pairs: tuple[FacePairs, ...] = ()  # `targets`, changed by `pivots`
    pairs_in_photo: tuple[FacePairs, ...] = ()  # `edge`: moves that the photo's edge allows
    pairs: tuple[FacePairs, ...] = ()  # `heads`: moves that heads in front allow
    heads: tuple[HeadDisplacement | None, ...] = ()  # `heads`
    field: Field = _STILL  # `lattice`, changed by all later steps
    limits: tuple[Limit, ...] = ()  # `guard`
    field_before_holding: Field = _STILL  # `guard`
    brush_shares: tuple[float, ...] = ()  # `brush`
    domain: Domain = _NOWHERE  # `domain`

    @cached_property
    def recipes(self) -> list[Recipe]:
        """The recipe of each face; `Face.recipe` takes precedence."""
        return [self.recipe.of_face(face.recipe) for face in self.faces]

    @property
    def anchors(self) -> list[Anchor]:
        """Anchor of each face's lattice, without lens correction."""
        return [face.anchor for face in self.faces]

    @property
    def still_edges(self) -> Box | None:
        """The photo across whose edges nothing moves; None without guard."""
        return self.photo if self.recipe.guard else None

    @property
    def neighbours(self) -> Held:
        """The people to leave in place; none without `Recipe.hold_background`."""
        return self.held if self.recipe.hold_background else NOTHING_HELD

    def updated(self, **results: object) -> WarpDraft:
        """Return the draft with the results of a step."""
        return dataclasses.replace(self, **results)  # type: ignore[arg-type]


def lens(draft: WarpDraft) -> WarpDraft:
    """Correct the perspective stretch of heads away from the photo's centre (`warp.lens`)."""
    correction = LensCorrection.of(draft.faces, draft.recipe, draft.photo)
    return draft.updated(correction=correction, corrected_faces=correction.faces or draft.faces)


def targets(draft: WarpDraft) -> WarpDraft:
    """Section 3.2: place targets on the lines to the centre; then shapes and targets by hand."""
    pairs = map(aim, draft.faces, repeat(draft.recipe), draft.corrected_faces, repeat(draft.photo))
    return draft.updated(requested_pairs=tuple(pairs))


def pivots(draft: WarpDraft) -> WarpDraft:
    """Move pivots towards heads in front and protected places nearby, and targets with them."""
    faces, others = draft.corrected_faces, draft.neighbours.others
    pairs = near_heads(draft.requested_pairs, faces, others)
    return draft.updated(requested_pairs=near_protected(pairs, faces, draft.protection.strokes))


def edge(draft: WarpDraft) -> WarpDraft:
    """Reduce moves across the photo's edge (`warp.frame`)."""
    pairs = draft.requested_pairs
    if draft.recipe.guard:
        pairs = tuple(attenuated_near_edge(pair, draft.photo) for pair in pairs)
    return draft.updated(pairs_in_photo=pairs, pairs=pairs)


def heads(draft: WarpDraft) -> WarpDraft:
    """Move the whole head along, or room beside the outline; give way to heads in front."""
    fields = surrounds_of(
        draft.corrected_faces,
        [pair.started for pair in draft.pairs],
        draft.recipes,
        draft.photo,
        draft.neighbours.neighbours,
        draft.correction,
        draft.neighbours.others,
    )
    pairs = giving_way(draft.pairs, fields) if draft.recipe.guard else draft.pairs
    return draft.updated(heads=fields, pairs=pairs)


def lattice(draft: WarpDraft) -> WarpDraft:
    """Sections 2 and 3.3: fit the control points of each face to its pairs."""
    lattices = fit(draft.pairs, draft.anchors, draft.recipes, draft.heads, draft.still_edges)
    return draft.updated(field=Field(lattices, fade_of(draft.recipe), draft.protection))


def guard(draft: WarpDraft) -> WarpDraft:
    """Reduce displacements where they would fold or squeeze the picture (`warp.guard`)."""
    field, limits = draft.field, (Limit(),) * len(draft.faces)
    if draft.recipe.guard:
        field, limits = limited(field, draft.photo)
    return draft.updated(field=field, field_before_holding=field, limits=limits)


def background(draft: WarpDraft) -> WarpDraft:
    """Keep straight edges straight and neighbours in place (`background.holding`)."""
    if not draft.recipe.hold_background:
        return draft
    grids = grids_of(draft.pairs, draft.anchors, draft.recipes)
    boxes = [None if head is None else head.around_px for head in draft.heads]
    targets_px = [pair.target_px for pair in draft.pairs]
    sites = list(map(Site, grids, targets_px, boxes, repeat(draft.still_edges)))
    return draft.updated(field=hold(draft.field, sites, draft.corrected_faces, draft.held))


def brush(draft: WarpDraft) -> WarpDraft:
    """Add the lattices of push and restore strokes (`warp.brush`)."""
    if not draft.brushwork.strokes:
        return draft
    guarded = draft.recipe.guard
    field, shares = brushed(draft.field, draft.brushwork, draft.photo, guarded=guarded)
    return draft.updated(field=field, brush_shares=shares)


def domain(draft: WarpDraft) -> WarpDraft:
    """Section 4: select the lattice cells that can move a pixel by more than the threshold."""
    return draft.updated(domain=domain_of(draft.field, draft.image, draft.recipe.domain))


# In order, each with the stage (`pipeline.STAGES`) that its time is added to.
STEPS: Final[tuple[tuple[str, Callable[[WarpDraft], WarpDraft]], ...]] = (
    ("targets", lens),
    ("targets", targets),
    ("targets", pivots),
    ("targets", edge),
    ("targets", heads),
    ("lattice", lattice),
    ("guard", guard),
    ("background", background),
    ("brush", brush),
    ("domain", domain),
)
