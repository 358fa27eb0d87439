"""Every choice of the user as one frozen, versioned value."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

from kogao_core.wording import shown

Fit = Literal["approximation", "exact", "multilevel"]
DomainName = Literal["image", "control-points", "threshold"]
Interpolation = Literal["bilinear", "cubic", "lanczos4"]
LatticeUnit = Literal["spacing", "warp"]

VERSION: Final = 1
# Figure 7a gives distance to the eyes : distance to the mouth as 10:0, 8:2, 6:4 and 4.7:5.3; these
# are the fractions of the way from the eyes to the mouth. The last one is the tip of the nose.
PAPER_CENTERS: Final = (1.0, 0.8, 0.6, 0.47)
# What there is to choose from; experiments ask for the paper's, which stay when this grows.
CENTERS: Final = PAPER_CENTERS
# cv2.remap rounds its map to 1/32 px, so a smaller move than half of that changes no byte.
LOSSLESS_PX: Final = 1.0 / 64.0

# By version: what turns the fields of a recipe of that version into those of the next.
_UPGRADES: Final[dict[int, Callable[[dict[str, Any]], dict[str, Any]]]] = {}


@dataclass(frozen=True, slots=True)
class Setting:
    """What there is to say of a field of the recipe, once for all who read, check or show it.

    Parameters
    ----------
    name : str
        The field.
    help : str
        What it is, in a few words.
    within : tuple of float, optional
        Smallest and largest value of a number.
    is_whole : bool
        Whether only whole numbers will do.
    choices : tuple of str
        What there is to choose from; a field without range and choices is true or false.
    unit : str
        Of a number.
    per_face : bool
        Whether each face may choose for itself; the rest is the photo's.
    option : str
        What it is called on the command line; the name with hyphens, if not given.
    default_text : str
        The default in words, where it says little as it is.
    """

    name: str
    help: str
    within: tuple[float, float] | None = None
    is_whole: bool = False
    choices: tuple[str, ...] = ()
    unit: str = ""
    per_face: bool = False
    option: str = ""
    default_text: str = ""

    def check(self, value: object) -> None:
        """Check a value.

        Raises
        ------
        ValueError
            If it is none for this field; the message names the field, its range and the value.
        """
        if self.within is not None:
            self._check_number(value, *self.within)
        elif self.choices:
            if value not in self.choices:
                allowed = ", ".join(self.choices)
                raise ValueError(f"{self.name} must be one of {allowed}, got {shown(value)}")
        elif not isinstance(value, bool):
            raise ValueError(f"{self.name} must be true or false, got {shown(value)}")

    def _check_number(self, value: object, low: float, high: float) -> None:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"{self.name} must be a number, got {shown(value)}")
        if not low <= value <= high:
            raise ValueError(f"{self.name} must be within {low:g}..{high:g}, got {shown(value)}")
        if self.is_whole and value != int(value):
            raise ValueError(
                f"{self.name} must be a whole number {low:g}..{high:g}, got {shown(value)}"
            )


# In the order of the recipe's fields.
_ALL: Final = (
    Setting("percent", "Warp distance in % of D", within=(0.0, 15.0), unit="% of D", per_face=True),
    Setting(
        "center",
        f"Centre candidate 1..{len(CENTERS)}",
        within=(1, len(CENTERS)),
        is_whole=True,
        per_face=True,
    ),
    Setting("lattice", "Lattice spacing R", within=(0.1, 8.0), per_face=True),
    Setting(
        "lattice_unit",
        "What R counts: landmark spacings or warp distances",
        choices=get_args(LatticeUnit),
        per_face=True,
    ),
    Setting("fit", "How the lattice follows the landmarks", choices=get_args(Fit), per_face=True),
    Setting("domain", "Which pixels are worked on", choices=get_args(DomainName)),
    Setting(
        "threshold_px",
        "Position change below which a pixel stays",
        within=(0.0, 16.0),
        unit="px",
        option="threshold",
        default_text="1/64: no byte is lost",
    ),
    Setting("interpolation", "Resampling kernel", choices=get_args(Interpolation)),
    Setting("guard", "Hold faces that would fold back to the largest move that doesn't"),
)
SETTINGS: Final = {setting.name: setting for setting in _ALL}
# What each face may choose for itself.
FACE_FIELDS: Final = tuple(setting.name for setting in _ALL if setting.per_face)


@dataclass(frozen=True, slots=True)
class Recipe:
    """What to do to a face; the defaults are the retoucher's, `PAPER` is the paper's.

    Parameters
    ----------
    percent : float
        Warp distance in % of D, the landmark-to-centre distance (section 3.2), 0 to 15.
    center : int
        Centre candidate 1 to 4 on the line from the eyes to the mouth (figure 7a).
    lattice : float
        Lattice spacing R in `lattice_unit`, 0.1 to 8 (section 3.3).
    lattice_unit : {"spacing", "warp"}
        What R is measured in: mean landmark spacing, or mean warp distance.
    fit : {"approximation", "exact", "multilevel"}
        How control points follow from landmarks (section 2).
    domain : {"image", "control-points", "threshold"}
        Which pixels are worked on (section 4).
    threshold_px : float
        Position change below which a pixel stays, px of the image rendered (section 4.2); values
        up to 1/64 change no byte, larger ones fade the displacement in over [T, 2T].
    interpolation : {"bilinear", "cubic", "lanczos4"}
        Resampling kernel.
    guard : bool
        Hold a face that would fold back to the largest move that doesn't.

    Raises
    ------
    ValueError
        If a value is out of range; the message names the field, its range and the value.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> recipe = kogao.Recipe(percent=6, center=3)
    >>> recipe.fit, recipe.guard
    ('exact', True)
    >>> kogao.Recipe.from_dict({"percent": 6, "center": 3}) == recipe
    True
    """

    percent: float = 4.0
    center: int = 2
    lattice: float = 1.0
    lattice_unit: LatticeUnit = "spacing"
    fit: Fit = "exact"
    domain: DomainName = "threshold"
    threshold_px: float = LOSSLESS_PX
    interpolation: Interpolation = "cubic"
    guard: bool = True

    def __post_init__(self) -> None:
        """Refuse values outside the documented ranges."""
        for setting in _ALL:
            setting.check(getattr(self, setting.name))

    def of_face(self, own: Recipe | None) -> Recipe:
        """Return this recipe with a face's `own` choices, where it has some (`FACE_FIELDS`).

        Parameters
        ----------
        own : Recipe, optional
            The face's recipe; of it, `FACE_FIELDS` count.

        Returns
        -------
        Recipe

        Examples
        --------
        >>> import kogao_core as kogao
        >>> photo, own = kogao.Recipe(interpolation="lanczos4"), kogao.Recipe(percent=8)
        >>> both = photo.of_face(own)
        >>> both.percent, both.interpolation
        (8, 'lanczos4')
        """
        if own is None:
            return self
        return dataclasses.replace(self, **{name: getattr(own, name) for name in FACE_FIELDS})

    def at_scale(self, scale: float) -> Recipe:
        """Return the recipe for the same photo resized by `scale`: only the threshold is in px.

        Parameters
        ----------
        scale : float
            Above 0.

        Returns
        -------
        Recipe
            Its threshold never falls below the lossless 1/64 px.

        Examples
        --------
        >>> import kogao_core as kogao
        >>> kogao.Recipe(threshold_px=2.0).at_scale(0.5).threshold_px
        1.0
        """
        if self.threshold_px <= LOSSLESS_PX:
            return self
        return dataclasses.replace(self, threshold_px=max(LOSSLESS_PX, self.threshold_px * scale))

    def to_dict(self) -> dict[str, Any]:
        """Return the recipe as plain JSON values, with its version."""
        return {"version": VERSION, **dataclasses.asdict(self)}

    @staticmethod
    def from_dict(values: Mapping[str, Any]) -> Recipe:
        """Read what `to_dict` wrote; missing fields take their defaults, unknown ones are refused.

        Parameters
        ----------
        values : mapping
            Plain JSON values by field, with the version that wrote them.

        Returns
        -------
        Recipe
            Brought up from an older version if need be.

        Raises
        ------
        ValueError
            If the version is newer, a field is unknown or a value is out of range.
        """
        if not isinstance(values, Mapping):
            raise ValueError("a recipe must be a JSON object")
        values = _upgraded(values)
        unknown = sorted(set(values) - set(SETTINGS))
        if unknown:
            raise ValueError(
                f"unknown recipe field {shown(unknown[0])}; known: {', '.join(sorted(SETTINGS))}"
            )
        return Recipe(**values)


def _upgraded(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a recipe as this version names them, without the version."""
    version = values.get("version", VERSION)
    if version not in range(1, VERSION + 1):
        raise ValueError(f"this program reads recipes of version {VERSION}, got {shown(version)}")
    fields = {name: value for name, value in values.items() if name != "version"}
    for step in range(int(version), VERSION):
        fields = _UPGRADES[step](fields)
    return fields


PAPER: Final = Recipe(fit="approximation", interpolation="bilinear", guard=False)
