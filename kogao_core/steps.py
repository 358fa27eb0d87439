"""From faces and a recipe to a displacement field: three steps of the paper, seven additions.

Each step takes a `WarpDraft` and returns a draft with more results. `STEPS` lists the steps in
their order. The paper's are `targets`, `lattice` and `domain`. With the recipe `PAPER` the other
seven have no effect on the picture; brush strokes, which are no part of a recipe, do. To add a
step, write its mathematics in a module of `additions`, a function here, and a line in `STEPS`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import repeat
from typing import Final, NamedTuple

from kogao_core.additions.brush import UNTOUCHED, Brushwork, brushed
from kogao_core.additions.edge import attenuated_near_edge, cut_note
from kogao_core.additions.fit import fit, grids_of
from kogao_core.additions.guard import Limit, limited
from kogao_core.additions.head import HeadField, give_way, head_fields
from kogao_core.additions.lens import NO_LENS, LensCorrection
from kogao_core.additions.pivot import attract_pivots
from kogao_core.background.holding import NOTHING_HELD, Held, Site, hold
from kogao_core.base.geometry import Box
from kogao_core.faces.face import Anchor, Face
from kogao_core.faces.targets import FacePairs, aim
from kogao_core.field.fade import domain_of, fade_of
from kogao_core.field.field import Field
from kogao_core.field.protection import NOTHING, Protection
from kogao_core.paper.domain import Domain
from kogao_core.recipe.recipe import Recipe

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

    correction: LensCorrection = NO_LENS  # `lens`
    requested_pairs: tuple[FacePairs, ...] = ()  # `targets`, `pivots`
    pairs_in_photo: tuple[FacePairs, ...] = ()  # `edge`: moves that the photo's edge allows
    pairs: tuple[FacePairs, ...] = ()  # `heads`: moves that heads in front allow
    heads: tuple[HeadField | None, ...] = ()  # `heads`
    field: Field = _STILL  # `lattice`, `guard`, `background`, `brush`
    field_before_holding: Field = _STILL  # `lattice`, `guard`
    limits: tuple[Limit, ...] = ()  # `guard`
    brush_shares: tuple[float, ...] = ()  # `brush`
    domain: Domain = _NOWHERE  # `domain`

    @property
    def corrected_faces(self) -> Sequence[Face]:
        """The faces after lens correction."""
        return self.correction.faces or self.faces

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
    def people(self) -> Held:
        """The people to leave in place; none without `Recipe.hold_background`."""
        return self.held if self.recipe.hold_background else NOTHING_HELD

    @property
    def note(self) -> str:
        """A sentence on faces with too little space in the photo; empty if there are none."""
        percents = [recipe.percent for recipe in self.recipes]
        return cut_note(self.pairs_in_photo, self.requested_pairs, percents, self.pairs)

    def updated(self, **results: object) -> WarpDraft:
        """Return the draft with the results of a step."""
        return dataclasses.replace(self, **results)  # type: ignore[arg-type]


def lens(draft: WarpDraft) -> WarpDraft:
    """Correct the perspective stretch of heads away from the photo's centre."""
    return draft.updated(correction=LensCorrection.of(draft.faces, draft.recipe, draft.photo))


def targets(draft: WarpDraft) -> WarpDraft:
    """Section 3.2: place targets on the lines to the centre; then shapes and targets by hand."""
    seen, photos = draft.corrected_faces, repeat(draft.photo)
    pairs = tuple(map(aim, draft.faces, repeat(draft.recipe), seen, photos))
    return draft.updated(requested_pairs=pairs, pairs_in_photo=pairs, pairs=pairs)


def pivots(draft: WarpDraft) -> WarpDraft:
    """Move pivots towards heads in front and protected places nearby, and targets with them."""
    faces, strokes = draft.corrected_faces, draft.protection.strokes
    pairs = attract_pivots(draft.requested_pairs, faces, strokes, draft.people.others)
    return draft.updated(requested_pairs=pairs, pairs_in_photo=pairs, pairs=pairs)


def edge(draft: WarpDraft) -> WarpDraft:
    """Reduce moves across the photo's edge."""
    if not draft.recipe.guard:
        return draft
    pairs = tuple(attenuated_near_edge(pair, draft.photo) for pair in draft.requested_pairs)
    return draft.updated(pairs_in_photo=pairs, pairs=pairs)


def heads(draft: WarpDraft) -> WarpDraft:
    """Move the whole head, or make room beside the outline; give way to heads in front."""
    fields = head_fields(
        draft.corrected_faces,
        [pair.started for pair in draft.pairs],
        draft.recipes,
        draft.photo,
        draft.people.neighbours,
        draft.correction,
        draft.people.others,
    )
    pairs = give_way(draft.pairs, fields) if draft.recipe.guard else draft.pairs
    return draft.updated(heads=fields, pairs=pairs)


def lattice(draft: WarpDraft) -> WarpDraft:
    """Sections 2 and 3.3: fit the control points of each face to its pairs."""
    lattices = fit(draft.pairs, draft.anchors, draft.recipes, draft.heads, draft.still_edges)
    field = Field(lattices, fade_of(draft.recipe), draft.protection)
    limits = (Limit(),) * len(lattices)
    return draft.updated(field=field, field_before_holding=field, limits=limits)


def guard(draft: WarpDraft) -> WarpDraft:
    """Reduce displacements where they would fold or squeeze the picture."""
    if not draft.recipe.guard:
        return draft
    field, limits = limited(draft.field, draft.photo)
    return draft.updated(field=field, field_before_holding=field, limits=limits)


def background(draft: WarpDraft) -> WarpDraft:
    """Keep straight edges straight and neighbours in place."""
    if not draft.recipe.hold_background:
        return draft
    grids = grids_of(draft.pairs, draft.anchors, draft.recipes)
    boxes = [None if head is None else head.around_px for head in draft.heads]
    targets_px = [pair.target_px for pair in draft.pairs]
    sites = list(map(Site, grids, targets_px, boxes, repeat(draft.still_edges)))
    return draft.updated(field=hold(draft.field, sites, draft.corrected_faces, draft.held))


def brush(draft: WarpDraft) -> WarpDraft:
    """Add the lattices of push and restore strokes."""
    if not draft.brushwork.strokes:
        return draft
    guarded = draft.recipe.guard
    field, shares = brushed(draft.field, draft.brushwork, draft.photo, guarded=guarded)
    return draft.updated(field=field, brush_shares=shares)


def domain(draft: WarpDraft) -> WarpDraft:
    """Section 4: select the lattice cells that can move a pixel by more than the threshold."""
    return draft.updated(domain=domain_of(draft.field, draft.image, draft.recipe.domain))


class Step(NamedTuple):
    """A step of `render`."""

    stage: str  # key of `pipeline.STAGES` to which the step's time is added
    apply: Callable[[WarpDraft], WarpDraft]
    section: str = ""  # of the paper; empty for an addition, without effect for `PAPER`


STEPS: Final = (
    Step("targets", lens),
    Step("targets", targets, "3.2"),
    Step("targets", pivots),
    Step("targets", edge),
    Step("targets", heads),
    Step("lattice", lattice, "2, 3.3"),
    Step("guard", guard),
    Step("background", background),
    Step("brush", brush),
    Step("domain", domain, "4"),
)
