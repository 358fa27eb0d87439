"""What a setting of the recipe is, and what there is to choose from.

The words are for people, who read them translated.
"""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import Any, Final, Generic, Literal, TypeVar

from kogao_core.base.language import Text
from kogao_core.base.wording import shown

Fit = Literal["approximation", "exact", "multilevel"]
DomainName = Literal["image", "control-points", "threshold"]
Interpolation = Literal["bilinear", "cubic", "lanczos4"]
LatticeUnit = Literal["spacing", "warp"]
LensName = Literal["off", "auto"]
Corner = Literal["top-left", "top-right", "bottom-left", "bottom-right"]
Name = TypeVar("Name", bound=str, covariant=True)


def cited(words: Text, where: str) -> Text:
    """Return words with the place in the paper behind them, if there is one."""
    return Text("{words} ({where})", words=words, where=where) if where else words


@dataclass(frozen=True, slots=True)
class Alternative(Generic[Name]):
    """One of the things that a field of the recipe may be."""

    name: Name  # in files and on the command line
    title: Text  # what people call it
    word: Text  # the same within a sentence
    help: Text  # what it is, in a few words
    where: str = ""  # where the paper has it; empty, where it hasn't
    reference: str = ""  # who described it; numbers are those of the paper's list

    @property
    def description(self) -> Text:
        """What it is called, what it is, and where the paper has it."""
        words = Text("{title}, {help}", title=self.title, help=self.help)
        return cited(words, self.where)


@dataclass(frozen=True, slots=True)
class Center:
    """A centre candidate."""

    fraction: float  # how far along the way from the eyes to the mouth it lies
    where: str = ""  # where the paper has it; empty, where it hasn't


@dataclass(frozen=True, slots=True)
class Setting:
    """A field of the recipe, declared once for all that read, check or show it.

    Parameters
    ----------
    title : Text
        What people call it.
    help : Text
        What it does, in one line.
    where : str
        Where the paper has it; empty, where it hasn't.
    within : tuple of float, optional
        Smallest and largest value of a number.
    is_whole : bool
        Whether only whole numbers will do.
    alternatives : tuple of Alternative
        What there is to choose from, beside the numbers of a range; a field without range and
        alternatives is true or false.
    unit : str
        Of a number.
    per_photo : bool
        Whether all faces of a photo share it; of the rest each face may choose for itself.
    option : str
        What it is called on the command line; the name with hyphens, if not given.
    default_text : str
        The default in words, where it says little as it is.
    word : Text, optional
        The title within a sentence, where that differs.
    needs : str
        The field that must be on for this one to count.
    is_method : bool
        Whether it says how the work is done: `Recipe.amount` tells of all others.
    letter : str
        What leads to its control, with Alt; empty behind another's. All letters are taken.
    name : str
        The field; it is filled in by `SETTINGS`.
    """

    title: Text
    help: Text
    where: str = ""
    within: tuple[float, float] | None = None
    is_whole: bool = False
    alternatives: tuple[Alternative[Any], ...] = ()
    unit: str = ""
    per_photo: bool = False
    option: str = ""
    default_text: str = ""
    word: Text | None = None
    needs: str = ""
    is_method: bool = False
    letter: str = ""
    name: str = ""

    def said(self, value: Any) -> Text:
        """Return a value within a sentence, by the name of the field."""
        name = self.word or self.title
        if value in self.choices:
            return Text("{name}: {word}", name=name, word=self.alternative(value).word)
        if self.within is None:
            return name if value else Text("no {name}", name=name)
        if self.unit == "%":
            return Text("{zone} {value:g} %", zone=name, value=value)
        return Text("{name} {value:g} {unit}", name=name, value=value, unit=self.unit)

    @property
    def choices(self) -> tuple[str, ...]:
        """The names of what there is to choose from."""
        return tuple(one.name for one in self.alternatives)

    def alternative(self, name: str) -> Alternative[Any]:
        """Return one of the things to choose from by its name."""
        return next(one for one in self.alternatives if one.name == name)

    @property
    def full_help(self) -> Text:
        """What it does, and where the paper has it."""
        return cited(self.help, self.where)

    def check(self, value: object) -> None:
        """Check a value.

        Parameters
        ----------
        value : object
            Of any kind.

        Raises
        ------
        ValueError
            If it is none for this field; the message names the field, its range and the value.
        """
        if self.within is not None and not (self.alternatives and isinstance(value, str)):
            self._check_number(value, *self.within)
        elif self.alternatives:
            if value not in self.choices:
                numbers = ("{:g}..{:g}".format(*self.within),) if self.within else ()
                allowed = ", ".join([*self.choices, *numbers])
                raise ValueError(
                    Text(
                        "{name} must be one of {allowed}, got {value}",
                        name=self.name,
                        allowed=allowed,
                        value=shown(value),
                    )
                )
        elif not isinstance(value, bool):
            raise ValueError(
                Text(
                    "{name} must be true or false, got {value}", name=self.name, value=shown(value)
                )
            )

    def plain(self, value: Any) -> Any:
        """Return a value that passed `check` as files hold it.

        Parameters
        ----------
        value : object
            Numbers may be numpy's.

        Returns
        -------
        object
            Python's own number; what is none, as it is.
        """
        if self.is_whole:
            return int(value)
        return value if self.within is None or type(value) in (int, float, str) else float(value)

    def _check_number(self, value: object, low: float, high: float) -> None:
        if isinstance(value, bool) or not isinstance(value, Real):
            raise ValueError(
                Text("{name} must be a number, got {value}", name=self.name, value=shown(value))
            )
        number: Any = value  # comparing isn't among what Real has for mypy
        if not low <= number <= high:
            raise ValueError(
                Text(
                    "{name} must be within {low:g}..{high:g}, got {value}",
                    name=self.name,
                    low=low,
                    high=high,
                    value=shown(value),
                )
            )
        if self.is_whole and number != int(number):
            raise ValueError(
                Text(
                    "{name} must be a whole number {low:g}..{high:g}, got {value}",
                    name=self.name,
                    low=low,
                    high=high,
                    value=shown(value),
                )
            )


# What solves each is in `fit`.
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
        Text("on every target"),
        reference=Text("this program"),
    ),
    Alternative(
        "multilevel",
        Text("Multilevel"),
        Text("multilevel"),
        Text("refined steps"),
        Text("section 3.3"),
        Text("[8], [10], [12]"),
    ),
)
DOMAINS: Final[tuple[Alternative[DomainName], ...]] = (
    Alternative("image", Text("Whole image"), Text("image"), Text("every pixel")),
    Alternative(
        "control-points",
        Text("Control points"),
        Text("control points"),
        Text("cells in their reach"),
        Text("section 4.1"),
    ),
    Alternative(
        "threshold",
        Text("Threshold"),
        Text("threshold"),
        Text("pixels that move"),
        Text("section 4.2"),
    ),
)
INTERPOLATIONS: Final[tuple[Alternative[Interpolation], ...]] = (
    Alternative("bilinear", Text("Bilinear"), Text("bilinear"), Text("quickest")),
    Alternative("cubic", Text("Cubic"), Text("cubic"), Text("sharper")),
    Alternative("lanczos4", Text("Lanczos 4"), Text("Lanczos 4"), Text("keeps most detail")),
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
        Text("grow with %"),
        Text("section 3.3"),
    ),
)
LENSES: Final[tuple[Alternative[LensName], ...]] = (
    Alternative("off", Text("Off"), Text("off"), Text("heads stay as the lens drew them")),
    Alternative(
        "auto", Text("From the photo"), Text("from the photo"), Text("what it tells of itself")
    ),
)
# Figure 7a gives distance to the eyes : distance to the mouth as 10:0, 8:2, 6:4 and 4.7:5.3. The
# last one is the tip of the nose.
PAPER_CENTERS: Final = tuple(Center(share, Text("figure 7a")) for share in (1.0, 0.8, 0.6, 0.47))
# What there is to choose from; experiments ask for the paper's, which stay when this grows.
CENTERS: Final = PAPER_CENTERS

# Of the picture that labels a result (`photo.disclosure`), which no recipe holds.
CORNERS: Final[dict[Corner, Text]] = {
    "top-left": Text("Top left"),
    "top-right": Text("Top right"),
    "bottom-left": Text("Bottom left"),
    "bottom-right": Text("Bottom right"),
}
LABEL_SHARE: Final = (0.1, 50.0)  # of a photo's area, %
# As Norway prescribes.
LABEL_CORNER: Final[Corner] = "top-left"
LABEL_PERCENT: Final = 7.0
