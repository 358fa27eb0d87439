"""All settings of the user as one frozen, versioned value."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Final, TypeVar

from kogao_core.base.language import BadValue, Text
from kogao_core.base.wording import shown
from kogao_core.paper.choices import LOSSLESS_PX as LOSSLESS_PX
from kogao_core.recipe.settings import (
    CENTERS,
    DOMAINS,
    FITS,
    INTERPOLATIONS,
    LATTICE_UNITS,
    LENSES,
    SCOPES,
    DomainName,
    Fit,
    Interpolation,
    LatticeUnit,
    LensName,
    ScopeName,
    Setting,
)

Value = TypeVar("Value")
VERSION: Final = 4

_SIGNED: Final = (-15.0, 15.0)  # below 0 smaller, above it larger


def setting(default: Value, title: Text, what: Text, where: str = "", **others: Any) -> Value:
    """Declare a field of the recipe with its `Setting`."""
    declared = Setting(title, what, where, **others)
    field: Any = dataclasses.field(default=default, metadata={Setting: declared})
    return field  # type: ignore[no-any-return]  # like `dataclasses.field`


def _signed(default: float, title: Text, word: Text, what: Text, **others: str) -> float:
    """Declare a field for the size of a part of the face, -15 to 15 %."""
    return setting(default, title, what, within=_SIGNED, unit=Text("%"), word=word, **others)


@dataclass(frozen=True, slots=True)
class Recipe:
    """Settings for the warp of a face; the defaults suit retouchers, `PAPER` has the paper's.

    Parameters
    ----------
    percent : float
        Warp distance in % of D, the landmark-to-centre distance (section 3.2), -15 to 15; below 0
        faces get larger.
    center : int
        Centre candidate 1 to 4 on the line from the eyes to the mouth (figure 7a), with scope
        "face".
    lattice : float
        Lattice spacing R in `lattice_unit`, 0.1 to 8 (section 3.3).
    lattice_unit : {"spacing", "warp"}
        Unit of R: mean landmark spacing, or mean warp distance.
    fit : {"approximation", "exact", "multilevel"}
        Method to compute control points from landmarks (section 2).
    domain : {"image", "control-points", "threshold"}
        The processed pixels (section 4).
    threshold_px : float
        Smaller displacements leave a pixel unchanged, px of the rendered image (section 4.2).
        Values up to 1/64 change no byte; larger values fade the displacement in over [T, 2T].
    interpolation : {"bilinear", "cubic", "lanczos4"}
        Resampling kernel.
    guard : bool
        Limit displacements that would fold the picture.
    hold_background : bool
        Keep straight lines of the background straight and other people still, where their
        positions are known (`holding.Held`).
    scope : {"head", "face"}
        What shrinks: the whole head as one body about a fixed point on the head's axis (`head`),
        or the face alone towards its centre, as in the paper.
    even_out : float
        Move both sides towards each other's mirror image, 0 to 100 % (`zones`).
    width, length : float
        Make the face narrower or shorter (below 0), wider or longer, in % of D, -15 to 15. These
        settings and the zones below are independent of the warp distance (`zones.Shape`).
    jaw_width, chin_length, cheeks_width, left_width, right_width : float
        The same for a zone of the outline, towards the centre or away from it.
    forehead_height : float
        The same for the hairline, down or up, with scope "head".
    lens : {"off", "auto"} or float
        Correct the stretch of heads away from the lens' axis (`lens`), for this 35-mm equivalent
        focal length, 8 to 1000 mm; "auto" reads the photo's metadata, see `optics.settled`.
    lens_amount : float
        Strength of the lens correction, 0 to 100 %.

    Raises
    ------
    ValueError
        If a value is out of range; the message names the field, its range and the value.

    Notes
    -----
    The paper leaves three choices open. Every recipe, `PAPER` too, fixes them as follows. Effects
    at 4 % towards centre 2 on 91 portraits of 400 to 1400 px:

    - Lattice origin: between eyes and mouth, not the image's corner. Another origin changes
      displacements by up to 23 % of the largest one, and the achieved percentage of one face by up
      to 0.38.
    - Unit of R: landmark spacings, not warp distances (``lattice_unit="warp"``). R = 1 is about 5.5
      warp distances. With R = 1 in warp distances, 34 of the 91 faces fold.
    - Direction of the fit: backward, at the targets. A forward fit at the landmarks changes
      displacements by up to 0.8 % of the eye distance, and the achieved percentage by up to 0.06.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> recipe = kogao.Recipe(percent=6, center=3)
    >>> recipe.fit, recipe.guard
    ('exact', True)
    >>> kogao.Recipe.from_dict({"percent": 6, "center": 3}) == recipe
    True
    """

    percent: float = setting(
        6.0,
        Text("Warp distance"),
        Text("Move landmarks by this % of the distance to the centre; negative enlarges"),
        Text("section 3.2"),
        within=(-15.0, 15.0),
        option="amount",
        unit=Text("% of D"),
        letter="W",
    )
    center: int = setting(
        2,
        Text("Centre"),
        Text("Centre candidate between eyes and mouth"),
        Text("section 3.2"),
        within=(1, len(CENTERS)),
        is_whole=True,
        needs="scope",
        unless="head",
        letter="C",
    )
    lattice: float = setting(
        1.0,
        Text("Lattice"),
        Text("Lattice spacing R: small is local, large is smooth"),
        Text("section 3.3"),
        within=(0.1, 8.0),
        is_method=True,
        letter="L",
    )
    lattice_unit: LatticeUnit = setting(
        "spacing",
        Text("Lattice unit"),
        Text("Unit of R"),
        Text("section 3.3"),
        alternatives=LATTICE_UNITS,
        is_method=True,
        letter="u",
    )
    fit: Fit = setting(
        "exact",
        Text("Fit"),
        Text("Fit of the lattice to the landmarks"),
        Text("sections 2.1, 2.2"),
        alternatives=FITS,
        is_method=True,
        letter="i",
    )
    domain: DomainName = setting(
        "threshold",
        Text("Domain"),
        Text("Pixels to compute; smaller is faster, the result is the same"),
        Text("sections 4.1, 4.2"),
        alternatives=DOMAINS,
        per_photo=True,
        is_method=True,
        letter="D",
    )
    threshold_px: float = setting(
        LOSSLESS_PX,
        Text("Threshold"),
        Text("Leave pixels unchanged below this displacement"),
        Text("section 4.2"),
        within=(0.0, 16.0),
        unit=Text("px"),
        option="threshold",
        default_text=Text("1/64: lossless"),
        per_photo=True,
        is_method=True,
        letter="r",
    )
    interpolation: Interpolation = setting(
        "cubic",
        Text("Interpolation"),
        Text("Interpolation between pixels"),
        alternatives=INTERPOLATIONS,
        per_photo=True,
        is_method=True,
    )
    guard: bool = setting(
        True,
        Text("Guard"),
        Text("Limit displacements that would fold the picture or read outside the photo"),
        per_photo=True,
        is_method=True,
        letter="Q",
    )
    hold_background: bool = setting(
        True,
        Text("Hold background"),
        Text("Keep background lines straight and other people in place"),
        per_photo=True,
        is_method=True,
        letter="b",
    )
    scope: ScopeName = setting(
        "head", Text("Change"), Text("What gets smaller"), alternatives=SCOPES, letter="g"
    )
    even_out: float = setting(
        0.0,
        Text("Even out"),
        Text("Make both sides more alike, % towards the mirror image; less for turned heads"),
        within=(0.0, 100.0),
        unit=Text("%"),
        word=Text("even out"),
    )
    width: float = _signed(
        0.0,
        Text("Width"),
        Text("face width"),
        Text("Width of the face; negative is narrower"),
        option="face-width",
    )
    length: float = _signed(
        0.0,
        Text("Length"),
        Text("face length"),
        Text("Length of the face; negative is shorter"),
        option="face-length",
    )
    jaw_width: float = _signed(
        0.0,
        Text("Jaw"),
        Text("jaw width"),
        Text("Width of the jaw; negative is slimmer"),
        letter="J",
    )
    chin_length: float = _signed(
        0.0, Text("Chin"), Text("chin length"), Text("Length of the chin; negative is shorter")
    )
    cheeks_width: float = _signed(
        0.0,
        Text("Cheeks"),
        Text("cheeks' width"),
        Text("Width of the cheeks; negative is slimmer"),
        letter="k",
    )
    forehead_height: float = _signed(
        0.0,
        Text("Forehead"),
        Text("forehead height"),
        Text("Height of the hairline; negative is lower"),
        needs="scope",
        unless="face",
    )
    left_width: float = _signed(
        0.0,
        Text("Picture's left"),
        Text("width on the left"),
        Text("Side of the face at the picture's left; negative is slimmer"),
    )
    right_width: float = _signed(
        0.0,
        Text("Picture's right"),
        Text("width on the right"),
        Text("Side of the face at the picture's right; negative is slimmer"),
    )
    lens: LensName | float = setting(
        "off",
        Text("Correct lens stretch"),
        Text("Correct wide-angle stretch of heads, with the 35-mm equivalent focal length"),
        within=(8.0, 1000.0),
        alternatives=LENSES,
        unit=Text("mm"),
        word=Text("lens"),
        per_photo=True,
        letter="n",
    )
    lens_amount: float = setting(
        100.0,
        Text("Lens amount"),
        Text("Strength of the lens correction"),
        within=(0.0, 100.0),
        unit=Text("%"),
        word=Text("lens amount"),
        needs="lens",
        unless="off",
    )

    def __post_init__(self) -> None:
        """Reject values outside the documented ranges; convert numpy numbers to Python numbers."""
        for setting in SETTINGS.values():
            value = getattr(self, setting.name)
            setting.check(value)
            if setting.is_whole or type(value) not in (bool, float, str):
                object.__setattr__(self, setting.name, setting.plain(value))

    @property
    def amount(self) -> Text:
        """The Amount and all settings that differ from the defaults, as one sentence."""
        if self.scope == "head":
            said = [Text("{percent:g} %", percent=self.percent)]
        else:
            values = {"percent": self.percent, "center": self.center}
            said = [Text("{percent:g} % towards centre {center}", **values), Text("face only")]
        for name, setting in SETTINGS.items():
            if name in ("percent", "center", "scope") or setting.is_method:
                continue
            if setting.counts(self) and getattr(self, name) != _DEFAULTS[name]:
                said.append(setting.said(getattr(self, name)))
        return Text.joined(", ", said)

    @property
    def whole_face(self) -> bool:
        """True if all of a face moves by the same share, as in the paper."""
        return not any(_shape_of(self))

    def of_face(self, own: Recipe | None) -> Recipe:
        """Return this recipe with a face's `own` settings (`FACE_FIELDS`), if any.

        Parameters
        ----------
        own : Recipe, optional
            The face's recipe; only `FACE_FIELDS` are used.
        """
        if own is None:
            return self
        return dataclasses.replace(self, **{name: getattr(own, name) for name in FACE_FIELDS})

    def at_scale(self, scale: float) -> Recipe:
        """Return the recipe for the same photo resized by `scale`.

        Only the threshold changes; it stays at least the lossless 1/64 px.

        Parameters
        ----------
        scale : float
            Above 0.
        """
        if self.threshold_px <= LOSSLESS_PX:
            return self
        return dataclasses.replace(self, threshold_px=max(LOSSLESS_PX, self.threshold_px * scale))

    def to_dict(self) -> dict[str, Any]:
        """Return the recipe as plain JSON values, with its version."""
        return {"version": VERSION, **dataclasses.asdict(self)}

    @staticmethod
    def from_dict(values: Mapping[str, Any]) -> Recipe:
        """Read the output of `to_dict`; missing fields get defaults, unknown fields are refused.

        Parameters
        ----------
        values : mapping
            Plain JSON values by field, with the version of the writer.

        Raises
        ------
        ValueError
            If the version is another one, a field is unknown or a value is out of range.
        """
        if not isinstance(values, Mapping):
            raise BadValue("a recipe must be a JSON object")
        fields = dict(values)
        if (version := fields.pop("version", VERSION)) != VERSION:
            raise BadValue(
                "this program reads recipes of version {version}, got {found}; use the Kogao "
                "that wrote it, or set its values again",
                version=VERSION,
                found=shown(version),
            )
        unknown = sorted(set(fields) - set(SETTINGS))
        if unknown:
            raise BadValue(
                "unknown recipe field {unknown}; known: {names}",
                unknown=shown(unknown[0]),
                names=", ".join(sorted(SETTINGS)),
            )
        return Recipe(**fields)


# In declaration order.
SETTINGS: Final = {
    field.name: dataclasses.replace(field.metadata[Setting], name=field.name)
    for field in dataclasses.fields(Recipe)
}
# Settings for the shape of the face, independent of the warp distance; all are 0 by default.
SHAPE: Final = (
    *("width", "length", "jaw_width", "chin_length", "cheeks_width", "forehead_height"),
    *("left_width", "right_width", "even_out"),
)
_shape_of: Final = attrgetter(*SHAPE)
# Settings that each face may override.
FACE_FIELDS: Final = tuple(name for name, setting in SETTINGS.items() if not setting.per_photo)

_DEFAULTS: Final = dataclasses.asdict(Recipe())
# The notes of `Recipe` list the choices that the paper leaves open.
PAPER: Final = Recipe(
    percent=4.0,
    fit="approximation",
    interpolation="bilinear",
    guard=False,
    hold_background=False,
    scope="face",
)
