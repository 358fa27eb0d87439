"""Every choice of the user as one frozen, versioned value."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
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
# What each face may choose for itself; the rest is the photo's.
FACE_FIELDS: Final = ("percent", "center", "lattice", "lattice_unit", "fit")
# cv2.remap rounds its map to 1/32 px, so a smaller move than half of that changes no byte.
LOSSLESS_PX: Final = 1.0 / 64.0

_RANGES: Final = {
    "percent": (0.0, 15.0),
    "center": (1, len(CENTERS)),
    "lattice": (0.1, 8.0),
    "threshold_px": (0.0, 16.0),
}
_CHOICES: Final = {
    "lattice_unit": get_args(LatticeUnit),
    "fit": get_args(Fit),
    "domain": get_args(DomainName),
    "interpolation": get_args(Interpolation),
}


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
        for name, (low, high) in _RANGES.items():
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise ValueError(f"{name} must be a number, got {shown(value)}")
            if not low <= value <= high:
                raise ValueError(f"{name} must be within {low:g}..{high:g}, got {shown(value)}")
        if self.center != int(self.center):
            raise ValueError(f"center must be a whole number 1..4, got {shown(self.center)}")
        if not isinstance(self.guard, bool):
            raise ValueError(f"guard must be true or false, got {shown(self.guard)}")
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in choices:
                allowed = ", ".join(choices)
                value = shown(getattr(self, name))
                raise ValueError(f"{name} must be one of {allowed}, got {value}")

    def of_face(self, own: Recipe | None) -> Recipe:
        """Return this recipe with a face's `own` choices, where it has some (`FACE_FIELDS`)."""
        if own is None:
            return self
        return dataclasses.replace(self, **{name: getattr(own, name) for name in FACE_FIELDS})

    def at_scale(self, scale: float) -> Recipe:
        """Return the recipe for the same photo resized by `scale`: only the threshold is in px."""
        if self.threshold_px <= LOSSLESS_PX:
            return self
        return dataclasses.replace(self, threshold_px=max(LOSSLESS_PX, self.threshold_px * scale))

    def to_dict(self) -> dict[str, Any]:
        """Return the recipe as plain JSON values, with its version."""
        return {"version": VERSION, **dataclasses.asdict(self)}

    @staticmethod
    def from_dict(values: Mapping[str, Any]) -> Recipe:
        """Read what `to_dict` wrote; missing fields take their defaults, unknown ones are refused.

        Raises
        ------
        ValueError
            If the version is newer, a field is unknown or a value is out of range.
        """
        if not isinstance(values, Mapping):
            raise ValueError("a recipe must be a JSON object")
        version = values.get("version", VERSION)
        if version != VERSION:
            raise ValueError(
                f"this program reads recipes of version {VERSION}, got {shown(version)}"
            )
        fields = {field.name for field in dataclasses.fields(Recipe)}
        unknown = sorted(set(values) - fields - {"version"})
        if unknown:
            raise ValueError(
                f"unknown recipe field {shown(unknown[0])}; known: {', '.join(sorted(fields))}"
            )
        return Recipe(**{name: value for name, value in values.items() if name != "version"})


PAPER: Final = Recipe(fit="approximation", interpolation="bilinear", guard=False)
