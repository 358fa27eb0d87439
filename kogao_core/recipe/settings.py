"""Declarations of the recipe's settings and their alternatives.

Titles and help texts are visible and translated.
"""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from operator import attrgetter
from typing import Any, Final, Generic, Literal, TypeVar

from kogao_core.base.language import BadValue, Text
from kogao_core.base.wording import shown
from kogao_core.paper.choices import FRACTIONS
from kogao_core.paper.choices import DomainName as DomainName

Fit = Literal["approximation", "exact", "multilevel"]
Interpolation = Literal["bilinear", "cubic", "lanczos4"]
LatticeUnit = Literal["spacing", "warp"]
LensName = Literal["off", "auto"]
ScopeName = Literal["head", "face"]
Name = TypeVar("Name", bound=str, covariant=True)


def cited(words: Text, where: str) -> Text:
    """Append the reference to the paper, if any, to the words."""
    return Text("{words} ({where})", words=words, where=where) if where else words


@dataclass(frozen=True, slots=True)
class Alternative(Generic[Name]):
    """One of the possible values of a field."""

    name: Name  # in files and on the command line
    title: Text  # visible title
    word: Text  # the title within a sentence
    help: Text  # short description
    where: str = ""  # section of the paper; empty if not in the paper
    reference: str = ""  # publication; numbers refer to the paper's list

    @property
    def description(self) -> Text:
        """Title, description and reference to the paper."""
        words = Text("{title}, {help}", title=self.title, help=self.help)
        return cited(words, self.where)


@dataclass(frozen=True, slots=True)
class Center:
    """A centre candidate."""

    fraction: float  # position on the line from the eyes (0) to the mouth (1)
    where: str = ""  # section of the paper; empty if not in the paper


@dataclass(frozen=True, slots=True)
class Setting:
    """Declaration of a field of the recipe, shared by readers, checks and controls."""

    title: Text  # visible title
    help: Text  # effect of the field, in one line
    where: str = ""  # section of the paper; empty if not in the paper
    within: tuple[float, float] | None = None  # smallest and largest value of a number
    is_whole: bool = False  # True if only whole numbers are valid
    # Possible values in addition to the range. Without range and alternatives: True or False.
    alternatives: tuple[Alternative[Any], ...] = ()
    unit: str = ""  # of a number
    per_photo: bool = False  # True if all faces of a photo share the field
    option: str = ""  # on the command line; by default the field's name with hyphens
    default_text: str = ""  # the default in words, if the value alone is unclear
    word: Text | None = None  # the title within a sentence, if different
    needs: str = ""  # name of the field that can disable this field; empty if there is none
    unless: str = ""  # the value of the field `needs` that disables this field
    is_method: bool = False  # True for processing methods, which `Recipe.amount` omits
    letter: str = ""  # mnemonic of the control; empty for none
    name: str = ""  # of the field; set by `SETTINGS`

    def said(self, value: Any) -> Text:
        """Return a value with the field's name, for use within a sentence."""
        name = self.word or self.title
        if value in self.choices:
            return Text("{name}: {word}", name=name, word=self.alternative(value).word)
        if self.within is None:
            return name if value else Text("no {name}", name=name)
        if self.unit == "%":
            return Text("{zone} {value:g} %", zone=name, value=value)
        return Text("{name} {value:g} {unit}", name=name, value=value, unit=self.unit)

    def counts(self, recipe: Any) -> bool:
        """Return True if the field has an effect with a recipe's other fields."""
        return not self.needs or getattr(recipe, self.needs) != self.unless

    @property
    def choices(self) -> tuple[str, ...]:
        """The names of the alternatives."""
        return tuple(map(attrgetter("name"), self.alternatives))

    def alternative(self, name: str) -> Alternative[Any]:
        """Return the alternative with this name."""
        return next(one for one in self.alternatives if one.name == name)

    @property
    def full_help(self) -> Text:
        """Help text and reference to the paper."""
        return cited(self.help, self.where)

    def check(self, value: object) -> None:
        """Raise ValueError for an invalid value; the message names field, range and value."""
        if self.within is not None and not (self.alternatives and isinstance(value, str)):
            self._check_number(value, *self.within)
        elif self.alternatives:
            if value not in self.choices:
                numbers = ("{:g}..{:g}".format(*self.within),) if self.within else ()
                allowed = ", ".join([*self.choices, *numbers])
                raise BadValue(
                    "{name} must be one of {allowed}, got {value}",
                    name=self.name,
                    allowed=allowed,
                    value=shown(value),
                )
        elif not isinstance(value, bool):
            raise BadValue(
                "{name} must be true or false, got {value}", name=self.name, value=shown(value)
            )

    def plain(self, value: Any) -> Any:
        """Convert a value that passed `check`, such as a numpy number, to a plain JSON value."""
        if self.is_whole:
            return int(value)
        return value if self.within is None or type(value) in (int, float, str) else float(value)

    def _check_number(self, value: object, low: float, high: float) -> None:
        if isinstance(value, bool) or not isinstance(value, Real):
            raise BadValue(
                "{name} must be a number, got {value}", name=self.name, value=shown(value)
            )
        number: Any = value  # mypy: Real has no comparison
        if not low <= number <= high:
            raise BadValue(
                "{name} must be within {low:g}..{high:g}, got {value}",
                name=self.name,
                low=low,
                high=high,
                value=shown(value),
            )
        if self.is_whole and number != int(number):
            raise BadValue(
                "{name} must be a whole number {low:g}..{high:g}, got {value}",
                name=self.name,
                low=low,
                high=high,
                value=shown(value),
            )


# `fit` implements the methods.
FITS: Final[tuple[Alternative[Fit], ...]] = (
    Alternative(
        "approximation",
        Text("Approximation"),
        Text("approximation"),
        Text("the paper's"),
        Text("section 2.1"),
        Text("the paper; [7], [9]"),
    ),
    Alternative(
        "exact",
        Text("Exact"),
        Text("exact"),
        Text("meets every target"),
        reference=Text("this program"),
    ),
    Alternative(
        "multilevel",
        Text("Multilevel"),
        Text("multilevel"),
        Text("refined in steps"),
        Text("section 3.3"),
        Text("[8], [10], [12]"),
    ),
)
DOMAINS: Final[tuple[Alternative[DomainName], ...]] = (
    Alternative("image", Text("Whole photo"), Text("image"), Text("all")),
    Alternative(
        "control-points",
        Text("Lattice cells in reach"),
        Text("control points"),
        Text("cells in reach"),
        Text("section 4.1"),
    ),
    Alternative(
        "threshold",
        Text("Reduced warp domain"),
        Text("threshold"),
        Text("moving pixels"),
        Text("section 4.2"),
    ),
)
INTERPOLATIONS: Final[tuple[Alternative[Interpolation], ...]] = (
    Alternative("bilinear", Text("Bilinear"), Text("bilinear"), Text("fastest")),
    Alternative("cubic", Text("Cubic"), Text("cubic"), Text("sharper")),
    Alternative("lanczos4", Text("Lanczos 4"), Text("Lanczos 4"), Text("most detail")),
)
LATTICE_UNITS: Final[tuple[Alternative[LatticeUnit], ...]] = (
    Alternative(
        "spacing",
        Text("Landmark spacings"),
        Text("landmark spacings"),
        Text("fixed"),
        Text("section 3.3"),
    ),
    Alternative(
        "warp",
        Text("Warp distances"),
        Text("warp distances"),
        Text("grows with the amount"),
        Text("section 3.3"),
    ),
)
SCOPES: Final[tuple[Alternative[ScopeName], ...]] = (
    Alternative("head", Text("Head"), Text("head"), Text("with ears and hair")),
    Alternative("face", Text("Face only"), Text("face only"), Text("as in the paper")),
)
LENSES: Final[tuple[Alternative[LensName], ...]] = (
    Alternative("off", Text("Off"), Text("off"), Text("no correction")),
    Alternative(
        "auto",
        Text("From the photo"),
        Text("from the photo"),
        Text("focal length from the metadata"),
    ),
)
# Figure 7a gives distance to the eyes : distance to the mouth as 10:0, 8:2, 6:4 and 4.7:5.3. The
# last one is the tip of the nose.
PAPER_CENTERS: Final = tuple(Center(share, Text("figure 7a")) for share in FRACTIONS)
# The available centres. Experiments use the paper's centres, even if more are added here.
CENTERS: Final = PAPER_CENTERS
