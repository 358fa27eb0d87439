"""Every choice of the user as one frozen, versioned value."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, TypeVar

from kogao_core.base.language import Text
from kogao_core.base.wording import shown
from kogao_core.recipe.settings import (
    CENTERS,
    DOMAINS,
    FITS,
    INTERPOLATIONS,
    LATTICE_UNITS,
    LENSES,
    DomainName,
    Fit,
    Interpolation,
    LatticeUnit,
    LensName,
    Setting,
)

Value = TypeVar("Value")
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

_SIGNED: Final = (-15.0, 15.0)  # below 0 smaller, above it larger


def setting(default: Value, title: Text, what: Text, where: str = "", **others: Any) -> Value:
    """Return a field of the recipe with all that is said of it, a `Setting`."""
    declared = Setting(title, what, where, **others)
    field: Any = dataclasses.field(default=default, metadata={Setting: declared})
    return field  # type: ignore[no-any-return]  # as `dataclasses.field` has it


def _zone(default: float, title: Text, word: Text, what: Text) -> float:
    """Return how far a part of the face goes beside the rest."""
    return setting(
        default, title, what, within=(0.0, 200.0), unit=Text("%"), word=word, needs="zones"
    )


def _signed(default: float, title: Text, word: Text, what: Text, **others: str) -> float:
    """Return how much larger or smaller a part of the face gets."""
    return setting(default, title, what, within=_SIGNED, unit=Text("%"), word=word, **others)


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

    percent: float = setting(
        4.0,
        Text("Warp distance"),
        Text(
            "How far landmarks move, in % of D, their distance to the centre; below 0, away from it"
        ),
        Text("section 3.2"),
        within=(-15.0, 15.0),
        unit=Text("% of D"),
        letter="W",
    )
    center: int = setting(
        2,
        Text("Centre"),
        Text("Which candidate between the eyes and the mouth landmarks move to"),
        Text("section 3.2"),
        within=(1, len(CENTERS)),
        is_whole=True,
        letter="C",
    )
    lattice: float = setting(
        1.0,
        Text("Lattice"),
        Text("Spacing R of the control lattice: small is local, large is smooth"),
        Text("section 3.3"),
        within=(0.1, 8.0),
        is_method=True,
        letter="L",
    )
    lattice_unit: LatticeUnit = setting(
        "spacing",
        Text("Lattice unit"),
        Text("What R counts"),
        Text("section 3.3"),
        alternatives=LATTICE_UNITS,
        is_method=True,
        letter="u",
    )
    fit: Fit = setting(
        "exact",
        Text("Fit"),
        Text("How the lattice takes up the landmarks' moves"),
        Text("sections 2.1, 2.2"),
        alternatives=FITS,
        is_method=True,
        letter="i",
    )
    domain: DomainName = setting(
        "threshold",
        Text("Domain"),
        Text("Which pixels are worked on; the picture is the same, the smaller is quicker"),
        Text("sections 4.1, 4.2"),
        alternatives=DOMAINS,
        per_photo=True,
        is_method=True,
        letter="D",
    )
    threshold_px: float = setting(
        LOSSLESS_PX,
        Text("Threshold"),
        Text("Pixels that would move less stay as they are"),
        Text("section 4.2"),
        within=(0.0, 16.0),
        unit=Text("px"),
        option="threshold",
        default_text=Text("1/64: no byte is lost"),
        per_photo=True,
        is_method=True,
        letter="r",
    )
    interpolation: Interpolation = setting(
        "cubic",
        Text("Interpolation"),
        Text("How a pixel is read between pixels"),
        alternatives=INTERPOLATIONS,
        per_photo=True,
        is_method=True,
    )
    guard: bool = setting(
        True,
        Text("Guard"),
        Text("Hold back what would fold, or read from outside the photo"),
        per_photo=True,
        is_method=True,
        letter="Q",
    )
    hold_background: bool = setting(
        True,
        Text("Hold background"),
        Text("Keep straight lines of the background straight, and other people where they are"),
        per_photo=True,
        is_method=True,
        letter="b",
    )
    head_follows: float = setting(
        50.0,
        Text("Head follows"),
        Text(
            "How far what surrounds the face goes along: 0 % the face alone, 50 % ears and "
            "temples, 100 % the whole head with its hair"
        ),
        within=(0.0, 100.0),
        unit=Text("%"),
        word=Text("head follows"),
        letter="o",
    )
    keep_features: bool = setting(
        True,
        Text("Keep features"),
        Text("Let eyes and mouth keep their shape, and a line from temple to temple stay straight"),
        word=Text("features kept"),
        letter="K",
    )
    zones: bool = setting(
        True,
        Text("Zones"),
        Text("Let parts of the face go their own shares, and even out its sides"),
        is_method=True,
    )
    cheeks: float = _zone(
        100.0,
        Text("Share of the cheeks"),
        Text("cheeks"),
        Text("How far the cheeks move, in % of the warp distance"),
    )
    jaw: float = _zone(
        100.0,
        Text("Share of the jaw"),
        Text("jaw"),
        Text("How far the jaw moves, between cheeks and chin, in % of the warp distance"),
    )
    chin: float = _zone(
        100.0,
        Text("Share of the chin"),
        Text("chin"),
        Text("How far the chin moves, in % of the warp distance"),
    )
    left: float = _zone(
        100.0,
        Text("Share of the left"),
        Text("picture's left"),
        Text(
            "How far the side moves that is on the left in the picture, in % of the warp distance"
        ),
    )
    right: float = _zone(
        100.0,
        Text("Share of the right"),
        Text("picture's right"),
        Text(
            "How far the side moves that is on the right in the picture, in % of the warp distance"
        ),
    )
    even_out: float = setting(
        0.0,
        Text("Even out"),
        Text(
            "How far left and right move to each other's mirror image; less, the more a head turns"
        ),
        within=(0.0, 100.0),
        unit=Text("%"),
        word=Text("even out"),
        needs="zones",
    )
    width: float = _signed(
        0.0,
        Text("Width"),
        Text("face width"),
        Text("The face narrower (below 0) or wider, in % of its distance to the centre"),
        option="face-width",
    )
    length: float = _signed(
        0.0,
        Text("Length"),
        Text("face length"),
        Text("The face shorter (below 0) or longer, in % of its distance to the centre"),
        option="face-length",
    )
    jaw_width: float = _signed(
        0.0,
        Text("Jaw"),
        Text("jaw width"),
        Text("The jaw slimmer (below 0) or wider, in % of its distance to the centre"),
        letter="J",
    )
    chin_length: float = _signed(
        0.0,
        Text("Chin"),
        Text("chin length"),
        Text("The chin shorter (below 0) or longer, in % of its distance to the centre"),
    )
    cheeks_width: float = _signed(
        0.0,
        Text("Cheeks"),
        Text("cheeks' width"),
        Text("The cheeks slimmer (below 0) or wider, in % of their distance to the centre"),
    )
    forehead_height: float = _signed(
        0.0,
        Text("Forehead"),
        Text("forehead height"),
        Text("The hairline lower (below 0) or higher, in % of its distance to the centre"),
    )
    left_width: float = _signed(
        0.0,
        Text("Picture's left"),
        Text("width on the left"),
        Text(
            "The side on the left in the picture slimmer (below 0) or wider, in % of its "
            "distance to the centre"
        ),
    )
    right_width: float = _signed(
        0.0,
        Text("Picture's right"),
        Text("width on the right"),
        Text(
            "The side on the right in the picture slimmer (below 0) or wider, in % of its "
            "distance to the centre"
        ),
    )
    lens: LensName | float = setting(
        "off",
        Text("Take out lens stretch"),
        Text(
            "How a wide lens stretched heads towards the edge, by its focal length as 35-mm film "
            "would need it"
        ),
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
        Text("How much of the lens' stretch is taken out"),
        within=(0.0, 100.0),
        unit=Text("%"),
        word=Text("lens amount"),
        needs="lens",
    )

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


# In the order of the fields.
SETTINGS: Final = {
    field.name: dataclasses.replace(field.metadata[Setting], name=field.name)
    for field in dataclasses.fields(Recipe)
}
# What is said of parts of the face, and its name within a sentence; it counts while `zones` is on.
ZONES: Final = {
    name: setting.word or setting.title
    for name, setting in SETTINGS.items()
    if setting.needs == "zones"
}
# What reshapes the face directly, whatever the warp distance.
SHAPE: Final = tuple(
    name for name, setting in SETTINGS.items() if setting.within == _SIGNED and name != "percent"
)
# What each face may choose for itself.
FACE_FIELDS: Final = tuple(name for name, setting in SETTINGS.items() if not setting.per_photo)

_DEFAULTS: Final = dataclasses.asdict(Recipe())
PAPER: Final = Recipe(
    fit="approximation",
    interpolation="bilinear",
    guard=False,
    hold_background=False,
    head_follows=0.0,
    keep_features=False,
)
