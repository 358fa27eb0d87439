"""The design of a study: pictures, conduct of a session, and rules that exclude answers."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

from kogao_core.base.language import Text
from kogao_core.base.strict import Node
from kogao_core.faces.naturalness import DISTANCES
from kogao_core.recipe.recipe import PAPER, Recipe
from kogao_core.recipe.settings import PAPER_CENTERS, Fit

Kind = Literal["table1", "figure11", "control", "catch", "satisfaction", "practice"]
# The choice the paper comes to in section 3.2; figure 11 varies the lattice at it.
BEST_PERCENT: Final = 4.0
BEST_CENTER: Final = 2
# The paper shows four sizes and prints none. These stand on both sides of 1, from which on nobody
# called a face unnatural; in `Recipe.lattice_unit`.
LATTICES: Final = (0.25, 0.5, 1.0, 2.0)


# Pictures of table 1 that are compared as one: centre and fit.
Group = tuple[int, Fit]


@dataclass(frozen=True, slots=True, order=True)
class Variant:
    """One picture of a subject."""

    # What it is for: the grid of table 1, the lattice sizes of figure 11, the photo as it is among
    # them, one cut in two that nobody who looks calls natural, the picture whose owner says how
    # satisfied they are, or one to practise with.
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
        """Values that decide how the picture looks, to find identical pictures."""
        if self.kind == "catch" or self.percent == 0.0:
            return (self.kind == "catch",)
        return self.percent, self.center, self.lattice, self.fit

    @property
    def is_judged(self) -> bool:
        """Whether the study is about the answers to it."""
        return self.kind not in ("catch", "satisfaction", "practice")

    def recipe(self, base: Recipe) -> Recipe:
        """Return the recipe that makes the picture; the rest is as in `base`."""
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
    """Return one subject's pictures: table 1's, figure 11's by R, and those asked for."""
    made = [
        Variant("table1", percent, center, base.lattice, fit)
        for fit in fits or (base.fit,)
        for center in centers
        for percent in percents
    ]
    best = Variant("figure11", BEST_PERCENT, BEST_CENTER, base.lattice, base.fit)
    made += [dataclasses.replace(best, lattice=size) for size in lattices]
    single: dict[Kind, bool] = {"control": control, "catch": catch}
    made += [
        dataclasses.replace(best, kind=kind, percent=0.0)
        for kind, wanted in single.items()
        if wanted
    ]
    if satisfaction:
        made.append(dataclasses.replace(best, kind="satisfaction"))
    return tuple(made)


def practice(count: int, base: Recipe = PAPER) -> tuple[Variant, ...]:
    """Return pictures to practise with, the strongest and the photo as it is in turn."""
    ends = [(percent, center) for center in (2, 1, 3, 4) for percent in (max(DISTANCES), 0.0)]
    return tuple(Variant("practice", *end, base.lattice, base.fit) for end in ends[:count])


Task = Literal["natural", "slider", "pair", "same"]
Answer = Literal["natural", "unnatural", "left", "right", "same", "different"]
# Answers to a picture; a slider gives grades.
ANSWERS: Final[Mapping[Task, tuple[Answer, ...]]] = {
    "natural": ("natural", "unnatural"),
    "slider": (),
    "pair": ("left", "right"),
    "same": ("same", "different"),
}
# The grey round every picture, in every browser: another one changes how a face's colours look.
SURROUND: Final = "#b8b8b8"
GAP_PX: Final = 40  # between two pictures, in that grey
_LONGEST_TEXT: Final = 20_000
_LONGEST_CODE: Final = 64
_SIZE: Final = re.compile(r"(\d+(?:\.\d+)?)(px|deg)")
_LARGEST: Final = {"px": 4000.0, "deg": 90.0}


@dataclass(frozen=True, slots=True)
class Conduct:
    """Settings of all sessions of a study."""

    # Whether a picture is natural, or how much so; or, beside the photo as it is, which of the two
    # is more so, or whether they are the same.
    task: Task = "natural"
    break_every: int = 0  # answers; 0 for no breaks
    faces_each: int = 0  # how many of the faces a rater judges; 0 for all
    swap_keys: bool = False  # for half of the raters F and J change places
    # The long side of each photo, also of two side by side: "640px" in CSS px, "12deg" in degrees
    # of visual angle, or "fit", the largest of a few scales that fits the window at the beginning.
    size: str = "fit"
    distance_mm: int = 600  # of the eyes from the screen, for degrees
    full_screen: bool = False
    consent: str = ""  # who doesn't agree to it doesn't begin
    instructions: str = ""  # in the place of the page's own
    debriefing: str = ""  # at the end
    completion_code: str = ""  # shown at the end, for payment

    def __post_init__(self) -> None:
        """Refuse a size that is none."""
        found = _SIZE.fullmatch(self.size)
        fits = found is not None and 1.0 <= float(found[1]) <= _LARGEST[found[2]]
        if self.size != "fit" and not fits:
            raise ValueError(
                Text("{size} is no size such as fit, 640px or 12deg", size=repr(self.size))
            )

    @property
    def pairs(self) -> bool:
        """Whether pictures are shown beside the photo as it is."""
        return self.task in ("pair", "same")

    @staticmethod
    def parse(node: Node) -> Conduct:
        """Read the settings of a study file. Raises BadFile."""
        node.only([one.name for one in dataclasses.fields(Conduct)])
        try:
            return Conduct(
                one_of(node.field("task"), Task),
                node.field("break_every").whole(0, 10**6),
                node.field("faces_each").whole(0, 10**6),
                node.field("swap_keys").flag(),
                node.field("size").text(20),
                node.field("distance_mm").whole(100, 10**5),
                node.field("full_screen").flag(),
                _text(node.field("consent")),
                _text(node.field("instructions")),
                _text(node.field("debriefing")),
                node.field("completion_code").text(_LONGEST_CODE),
            )
        except ValueError as problem:
            node.refuse(str(problem))


CONDUCT: Final = Conduct()


def one_of(node: Node, names: Any, longest: int = 20) -> Any:
    """Read one of the names of a `Literal`."""
    return node.text(longest, get_args(names))


def _text(node: Node) -> str:
    """Return a text of several lines, which `Node.text` has not."""
    if not isinstance(node.value, str) or len(node.value) > _LONGEST_TEXT:
        node.refuse(Text("must be a text"))
    return node.value


# A judgement and a key press take longer; the page accepts no earlier answer.
LEAST_MS: Final = 200


@dataclass(frozen=True, slots=True)
class Rules:
    """Rules that exclude answers, fixed in the key when a study is made."""

    least_ms: int = LEAST_MS  # an earlier answer doesn't count
    # A rater doesn't count who has a larger share of earlier answers,
    most_quick: float = 0.1
    # who gave one answer to this many pictures or more, from 2 to 10 % of D,
    straight: int = 20
    # who called a smaller share of the catch pictures unnatural,
    least_caught: float = 0.75
    # or whose answers follow the warp distance no better than chance: the AUC is less than this
    # many standard errors above 0.5 (2.33: 1 % of attentive guesses).
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
