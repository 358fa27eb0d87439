"""Every choice of the user as one frozen, versioned value."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from kogao_core.base.language import Text
from kogao_core.base.wording import shown
from kogao_core.recipe.settings import (
    FACE_FIELDS,
    SETTINGS,
    SHAPE,
    ZONES,
    DomainName,
    Fit,
    Interpolation,
    LatticeUnit,
    LensName,
)

VERSION: Final = 3
# cv2.remap rounds its map to 1/32 px, so a smaller move than half of that changes no byte.
LOSSLESS_PX: Final = 1.0 / 64.0

# By version: what turns the fields of a recipe of that version into those of the next.
_UPGRADES: Final[dict[int, Callable[[dict[str, Any]], dict[str, Any]]]] = {
    # What was made before lines could be held looks as it did.
    1: lambda fields: {"hold_background": False, **fields},
    # Nor what was made before anything but forehead and hair could follow.
    2: lambda fields: {
        "head_follows": 100.0 if fields.get("whole_head") is True else 0.0,
        "keep_features": False,
        **{name: value for name, value in fields.items() if name != "whole_head"},
    },
}


@dataclass(frozen=True, slots=True)
class Recipe:
    """What to do to a face; the defaults are the retoucher's, `PAPER` is the paper's.

    Parameters
    ----------
    percent : float
        Warp distance in % of D, the landmark-to-centre distance (section 3.2), -15 to 15; below 0
        faces get larger.
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
    hold_background : bool
        Hold straight lines of the background and other people where they are, if it is known
        where those are (`holding.Held`).
    head_follows : float
        How far what surrounds the face goes along, 0 to 100 %: 0 the face alone, as in the paper;
        50 ears, temples and forehead; 100 the whole head with its hair (`surround`).
    keep_features : bool
        Let each eye and the mouth shift without changing their shape, and a line from temple to
        temple stay straight.
    zones : bool
        Let the fields below count.
    cheeks, jaw, chin : float
        How far these go, in % of the warp distance, 0 to 200 (`zones`).
    left, right : float
        The same for the sides of the face, as one sees them in the picture of an upright head.
    even_out : float
        How far the two sides go towards each other's mirror image, 0 to 100 % (`zones`).
    width, length : float
        The face narrower or shorter (below 0), wider or longer, in % of D, -15 to 15; these and
        those below count beside the warp distance, whatever it is (`zones.Shape`).
    jaw_width, chin_length, cheeks_width, left_width, right_width : float
        The same for a zone of the outline, towards the centre or away from it.
    forehead_height : float
        The same for the hairline, down or up.
    lens : {"off", "auto"} or float
        Take out how a lens stretches heads off its axis (`lens`): of which focal length, as
        35-mm film would need it, 8 to 1000 mm; "auto" goes by the photo, see `optics.settled`.
    lens_amount : float
        How much of that stretch is taken out, 0 to 100 %.

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
    hold_background: bool = True
    head_follows: float = 50.0
    keep_features: bool = True
    zones: bool = True
    cheeks: float = 100.0
    jaw: float = 100.0
    chin: float = 100.0
    left: float = 100.0
    right: float = 100.0
    even_out: float = 0.0
    width: float = 0.0
    length: float = 0.0
    jaw_width: float = 0.0
    chin_length: float = 0.0
    cheeks_width: float = 0.0
    forehead_height: float = 0.0
    left_width: float = 0.0
    right_width: float = 0.0
    lens: LensName | float = "off"
    lens_amount: float = 100.0

    def __post_init__(self) -> None:
        """Refuse values outside the documented ranges; numpy's numbers become Python's."""
        for setting in SETTINGS.values():
            value = getattr(self, setting.name)
            setting.check(value)
            object.__setattr__(self, setting.name, setting.plain(value))

    @property
    def amount(self) -> Text:
        """How far faces come towards which centre, and whatever else isn't left as it is.

        Examples
        --------
        >>> import kogao_core as kogao
        >>> kogao.Recipe(percent=6, chin=50, even_out=20).amount
        '6 % towards centre 2, chin 50 %, even out 20 %'
        """
        said = [
            Text("{percent:g} % towards centre {center}", percent=self.percent, center=self.center)
        ]
        told = {"percent", "center"}
        if self.face_alone:
            said.append(Text("the face alone"))
            told |= {"head_follows", "keep_features"}
        for name, setting in SETTINGS.items():
            if name in told or setting.is_method:
                continue
            counts = not setting.needs or getattr(self, setting.needs) not in (False, "off")
            if counts and getattr(self, name) != _DEFAULTS[name]:
                said.append(setting.said(getattr(self, name)))
        return Text.joined(", ", said)

    @property
    def face_alone(self) -> bool:
        """Whether the face alone moves, as in the paper and its survey."""
        return self.head_follows == 0.0 and not self.keep_features

    @property
    def whole_face(self) -> bool:
        """Whether all of a face goes by the same share, as in the paper, and not parts of it."""
        parts = (*SHAPE, *ZONES) if self.zones else SHAPE
        return all(getattr(self, name) == _DEFAULTS[name] for name in parts)

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
            raise ValueError(Text("a recipe must be a JSON object"))
        values = _upgraded(values)
        unknown = sorted(set(values) - set(SETTINGS))
        if unknown:
            raise ValueError(
                Text(
                    "unknown recipe field {unknown}; known: {names}",
                    unknown=shown(unknown[0]),
                    names=", ".join(sorted(SETTINGS)),
                )
            )
        return Recipe(**values)


def _upgraded(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a recipe as this version names them, without the version."""
    version = values.get("version", VERSION)
    if version not in range(1, VERSION + 1):
        raise ValueError(
            Text(
                "this program reads recipes of version {version}, got {found}",
                version=VERSION,
                found=shown(version),
            )
        )
    fields = {name: value for name, value in values.items() if name != "version"}
    for step in range(int(version), VERSION):
        fields = _UPGRADES[step](fields)
    return fields


_DEFAULTS: Final = dataclasses.asdict(Recipe())
PAPER: Final = Recipe(
    fit="approximation",
    interpolation="bilinear",
    guard=False,
    hold_background=False,
    head_follows=0.0,
    keep_features=False,
)
