"""Determine a photo's focal length from EXIF data, unless crop or projection is doubtful."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Final

from PIL.ExifTags import Base as Tag

from kogao_core.base.language import Text
from kogao_core.photo.metadata.tiff import told_by
from kogao_core.photo.model import Photo
from kogao_core.recipe.recipe import SETTINGS, Recipe

FILM_MM: Final = math.hypot(36.0, 24.0)  # diagonal of 35-mm film, the basis of equivalents
_SENSORS: Final = (3 / 2, 4 / 3)  # aspect ratios of uncropped photos, longer side / shorter side
_SAME_SHAPE: Final = 0.01  # relative tolerance for the aspect ratio
_SAME_LENGTH: Final = 0.1  # relative tolerance between the two estimates of the equivalent
_UNITS_MM: Final = {2: 25.4, 3: 10.0, 4: 1.0, 5: 0.001}  # by FocalPlaneResolutionUnit
_PANORAMA: Final = 6  # value of CustomRendered in panoramas of phones
_CURVED: Final = ("fish", "gopro", "insta360", "osmo action", "theta")
_LEAST_MM, _MOST_MM = SETTINGS["lens"].within or (0.0, math.inf)


@dataclass(frozen=True, slots=True)
class Optics:
    """Focal length as 35-mm equivalent in mm, or the reason that the length is unknown."""

    focal_mm: float | None = None
    why: str = ""

    def settled(self, recipe: Recipe) -> Recipe:
        """Replace "auto" in a recipe by the focal length, or by "off" if unknown."""
        if recipe.lens != "auto":
            return recipe
        return dataclasses.replace(recipe, lens=self.focal_mm or "off")

    def note(self, recipe: Recipe) -> str:
        """Return the reason that "auto" applies no lens correction; "" otherwise."""
        if recipe.lens != "auto" or not self.why:
            return ""
        return Text("the lens' stretch stays: {why}", why=self.why)


UNKNOWN: Final = Optics(
    why=Text("the photo doesn't tell its focal length; give it, in mm on 35-mm film")
)


def optics_of(photo: Photo) -> Optics:
    """Return the optics of a photo from EXIF data, XMP data and size."""
    told = dict(told_by(photo.exif) or ())  # empty for a damaged block
    told |= told.get(Tag.ExifOffset, {})
    panorama = b"GPano:" in (photo.xmp or b"") or told.get(Tag.CustomRendered) == _PANORAMA
    words = " ".join(str(told.get(tag, "")) for tag in (Tag.Make, Tag.Model, Tag.LensModel))
    if panorama or any(word in words.lower() for word in _CURVED):
        return Optics(
            why=Text("a panorama, or a fisheye's or an action camera's picture, isn't stretched so")
        )
    focal, sensor_mm = _equivalent(told)
    if focal is None:
        return UNKNOWN
    if (why := _cropped(photo, told, focal, sensor_mm)) is not None:
        return Optics(why=why)
    return Optics(round(focal, 1))


def _equivalent(told: dict[int, Any]) -> tuple[float | None, float | None]:
    """Return the 35-mm equivalent, and the equivalent computed from the sensor diagonal, mm."""
    equivalent = _number(told.get(Tag.FocalLengthIn35mmFilm))
    focal, sides = _number(told.get(Tag.FocalLength)), _sides(told)
    by_sensor = None
    per = _UNITS_MM.get(told.get(Tag.FocalPlaneResolutionUnit, 2))
    x, y = (
        _number(told.get(tag)) for tag in (Tag.FocalPlaneXResolution, Tag.FocalPlaneYResolution)
    )
    if focal and sides and per and x and y:
        by_sensor = focal * FILM_MM / math.hypot(sides[0] / x * per, sides[1] / y * per)
    found = equivalent or by_sensor
    return found if found and _LEAST_MM <= found <= _MOST_MM else None, by_sensor


def _cropped(
    photo: Photo, told: dict[int, Any], focal: float, by_sensor: float | None
) -> Text | None:
    """Return the reason that a photo may be cropped, or None."""
    sides, longer, shorter = _sides(told), max(photo.pixels.shape[:2]), min(photo.pixels.shape[:2])
    say = Text("if it is whole, give the focal length, {focal:.0f} mm", focal=focal)
    if sides is not None and (max(sides), min(sides)) != (longer, shorter):
        return Text(
            "the photo is {longer} x {shorter} px and tells of {x:.0f} x {y:.0f} px; {say}",
            longer=longer,
            shorter=shorter,
            x=max(sides),
            y=min(sides),
            say=say,
        )
    is_whole = any(abs(longer / shorter / shape - 1.0) < _SAME_SHAPE for shape in _SENSORS)
    zoomed = (_number(told.get(Tag.DigitalZoomRatio)) or 1.0) > 1.0
    if not is_whole or zoomed or (by_sensor and abs(by_sensor / focal - 1.0) > _SAME_LENGTH):
        return Text("the photo looks as if it had been cropped; {say}", say=say)
    return None


def _sides(told: dict[int, Any]) -> tuple[float, float] | None:
    x, y = (_number(told.get(tag)) for tag in (Tag.ExifImageWidth, Tag.ExifImageHeight))
    return (x, y) if x and y else None


def _number(value: Any) -> float | None:
    """Return `value` as a finite number above 0, or None."""
    try:
        number = float(value)
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    return number if 0.0 < number < math.inf else None
