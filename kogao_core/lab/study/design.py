"""The design of a study: pictures, conduct of a session, and rules that exclude answers."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

from kogao_core.base.json_reader import Node
from kogao_core.base.language import BadValue, Text
from kogao_core.paper.table1 import DISTANCES
from kogao_core.recipe.recipe import PAPER, Recipe
from kogao_core.recipe.settings import PAPER_CENTERS, Fit

Kind = Literal["table1", "figure11", "control", "catch", "satisfaction", "practice"]
# The paper's choice in section 3.2; the lattice sizes of figure 11 use this choice.
BEST_PERCENT: Final = 4.0
BEST_CENTER: Final = 2
# Lattice sizes for figure 11, in `Recipe.lattice_unit`. The paper shows four sizes without values.
# According to the paper, all faces look natural above 1.
LATTICES: Final = (0.25, 0.5, 1.0, 2.0)


# Pictures of table 1 that are compared as one: centre and fit.
Group = tuple[int, Fit]


@dataclass(frozen=True, slots=True, order=True)
class Variant:
    """One picture of a subject."""

    # Purpose: the grid of table 1, the lattice sizes of figure 11, the original photo (control), a
    # face cut in two (catch), the rater's own face (satisfaction), or practice.
    kind: Kind
    percent: float  # warp distance, % of D; below 0 the face becomes larger
    center: int  # centre candidate 1 to 4
    lattice: float  # lattice spacing R
    fit: Fit = PAPER.fit

    @property
    def group(self) -> Group:
        """Group of pictures that are compared as one: centre and fit."""
        return self.center, self.fit

    @property
    def what(self) -> tuple[object, ...]:
        """Values that determine the pixels: identical pictures have equal values."""
        if self.kind == "catch" or self.percent == 0.0:
            return (self.kind == "catch",)
        return self.percent, self.center, self.lattice, self.fit

    @property
    def is_judged(self) -> bool:
        """Whether the answers to this picture are results of the study."""
        return self.kind not in ("catch", "satisfaction", "practice")

    def recipe(self, base: Recipe) -> Recipe:
        """Return `base` with the settings of this picture."""
        return dataclasses.replace(
            base, percent=self.percent, center=self.center, lattice=self.lattice, fit=self.fit
        )


def variants(
    base: Recipe = PAPER,
    lattices: tuple[float, ...] = LATTICES,
    *,
    percents: tuple[float, ...] = DISTANCES,
    centers: tuple[int, ...] = tuple(range(1, len(PAPER_CENTERS) + 1)),
    fits: tuple[Fit, ...] | None = None,
    control: bool = False,
    catch: bool = False,
    satisfaction: bool = False,
) -> tuple[Variant, ...]:
    """Return the pictures of one subject: table 1, figure 11 (R = `lattices`) and the options."""
    made = [
        Variant("table1", percent, center, base.lattice, fit)
        for fit in fits or (base.fit,)
        for center in centers
        for percent in percents
    ]
    best = Variant("figure11", BEST_PERCENT, BEST_CENTER, base.lattice, base.fit)
    made += [dataclasses.replace(best, lattice=size) for size in lattices]
    if control:
        made.append(dataclasses.replace(best, kind="control", percent=0.0))
    if catch:
        made.append(dataclasses.replace(best, kind="catch", percent=0.0))
    if satisfaction:
        made.append(dataclasses.replace(best, kind="satisfaction"))
    return tuple(made)


def practice(count: int, base: Recipe = PAPER) -> tuple[Variant, ...]:
    """Return practice pictures: alternately the strongest warp and the original photo."""
    ends = [(percent, center) for center in (2, 1, 3, 4) for percent in (max(DISTANCES), 0.0)]
    return tuple(Variant("practice", *end, base.lattice, base.fit) for end in ends[:count])


Answer = Literal["natural", "unnatural"]
_LONGEST_TEXT: Final = 20_000
_LONGEST_CODE: Final = 64
_SIZE: Final = re.compile(r"(\d+(?:\.\d+)?)px")
_LARGEST_PX: Final = 4000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Conduct:
    """Settings of all sessions of a study."""

    break_every: int = 0  # answers; 0 for no breaks
    faces_each: int = 0  # number of faces per rater; 0 for all
    swap_keys: bool = False  # swap F and J for half of the raters
    # Long side of each photo: "640px" in CSS px, or "fit", the largest of a few scales that fits
    # the window at the start.
    size: str = "fit"
    full_screen: bool = False
    consent: str = ""  # raters must agree to this text
    instructions: str = ""  # replaces the instructions of the page
    debriefing: str = ""  # at the end
    completion_code: str = ""  # shown at the end, for payment

    def __post_init__(self) -> None:
        """Raise ValueError for an invalid size."""
        found = _SIZE.fullmatch(self.size)
        fits = found is not None and 1.0 <= float(found[1]) <= _LARGEST_PX
        if self.size != "fit" and not fits:
            raise BadValue("{size} is not a size such as fit or 640px", size=repr(self.size))

    @staticmethod
    def parse(node: Node) -> Conduct:
        """Read the settings of a study file. Raises BadFile."""
        # Studies of 1.0.0 name their task, of which one is left, and a viewing distance.
        former = ("task", "distance_mm")
        node.only([*former, *(one.name for one in dataclasses.fields(Conduct))])
        if node.field("task").value is not None:
            node.field("task").text(20, ("natural",))
        try:
            return Conduct(
                break_every=node.field("break_every").whole(0, 10**6),
                faces_each=node.field("faces_each").whole(0, 10**6),
                swap_keys=node.field("swap_keys").flag(),
                size=node.field("size").text(20),
                full_screen=node.field("full_screen").flag(),
                consent=_text(node.field("consent")),
                instructions=_text(node.field("instructions")),
                debriefing=_text(node.field("debriefing")),
                completion_code=node.field("completion_code").text(_LONGEST_CODE),
            )
        except ValueError as problem:
            node.refuse(str(problem))


CONDUCT: Final = Conduct()


def one_of(node: Node, names: Any, longest: int = 20) -> Any:
    """Read one of the names of a `Literal`."""
    return node.text(longest, get_args(names))


def _text(node: Node) -> str:
    """Read a text of several lines; `Node.text` reads single lines only."""
    if not isinstance(node.value, str) or len(node.value) > _LONGEST_TEXT:
        node.refuse(Text("must be a text"))
    return node.value


# Minimum time of an answer: a judgement takes longer. The page ignores earlier keys.
LEAST_MS: Final = 200


@dataclass(frozen=True, slots=True)
class Rules:
    """Rules that exclude answers, fixed in the key when a study is made."""

    least_ms: int = LEAST_MS  # earlier answers don't count
    # Maximum share of earlier answers of a rater.
    most_quick: float = 0.1
    # Minimum number of equal answers, from 2 to 10 % of D, that exclude a rater.
    straight: int = 20
    # Minimum share of catch pictures that a rater calls unnatural.
    least_caught: float = 0.75
    # Minimum AUC of the answers over the warp distance, in standard errors above 0.5: 2.33 is the
    # chance level of 1 %.
    least_follows: float = 2.33
    unfinished: bool = False  # True: answers of sessions that were not finished count

    @staticmethod
    def parse(node: Node) -> Rules:
        """Read the rules of a key. Raises BadFile."""
        node.only([one.name for one in dataclasses.fields(Rules)])
        return Rules(
            node.field("least_ms").whole(0, 10**6),
            node.field("most_quick").number(0.0, 1.0),
            node.field("straight").whole(1, 10**6),
            node.field("least_caught").number(0.0, 1.0),
            node.field("least_follows").number(-100.0, 100.0),
            node.field("unfinished").flag(),
        )


RULES: Final = Rules()
