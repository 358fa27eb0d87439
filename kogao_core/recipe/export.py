"""Options of an export, declared once for the command line, the editor's dialog and presets.

A module of its own, so that help is printed without loading numpy.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Final

from kogao_core.base.language import BadValue, Text
from kogao_core.base.wording import shown
from kogao_core.recipe.recipe import Value


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportSetting:
    """Declaration of a field of `ExportSettings`."""

    title: Text  # in the dialog, with & before the letter for Alt
    tip: Text  # in the dialog
    most: int = 0  # largest value of a number; 0 keeps what the photo has
    unit: str = ""  # of a number, in the dialog
    lowest: str = ""  # words for 0 in the dialog
    option: str = ""  # on the command line; empty for none; ``--no-...`` means False
    help: str = ""  # of the option
    metavar: str | None = None
    needs: str | None = None  # option that must be given, too
    name: str = ""  # of the field; set by `EXPORT_SETTINGS`


def _option(default: Value, **declared: Any) -> Value:
    """Declare a field with its `ExportSetting`."""
    metadata = {ExportSetting: ExportSetting(**declared)}
    field: Any = dataclasses.field(default=default, metadata=metadata)
    return field  # type: ignore[no-any-return]  # like `dataclasses.field`


@dataclass(frozen=True, slots=True)
class ExportSettings:
    """The fields of `Export`."""

    # Maximum length of the longer side; 0 keeps the size; never enlarges.
    longest_px: int = _option(
        0,
        title=Text("&Longer side"),
        tip=Text("Photos are never enlarged"),
        most=65500,
        unit=Text(" px"),
        lowest=Text("same as photo"),
        option="--longest-side",
        metavar="PX",
        help=Text("Downscale to this longer side in the same resampling as the warp, 1..65500"),
    )
    # File name extension such as .jpg; empty keeps the photo's format.
    ending: str = _option("", title=Text("&Format"), tip=Text("File format"))
    # JPEG and WebP quality, 1 to 100; 0 uses the source's quality, or 95.
    quality: int = _option(
        0,
        title=Text("&Quality"),
        tip=Text("Quality of JPEG and WebP"),
        most=100,
        lowest=Text("same as photo"),
        option="--quality",
        help=Text("JPEG and WebP quality, 1..100 [source quality]; re-encodes the whole picture"),
    )
    # Convert to 8-bit sRGB; False preserves the photo's profile.
    srgb: bool = _option(
        False,
        title=Text("Con&vert to sRGB (8 bits)"),
        tip=Text("Off: keep the colour profile"),
        option="--srgb",
        help=Text("Convert to 8-bit sRGB [keep the profile]"),
    )
    # Sharpening of pictures with reduced size, 0 to 200 %.
    sharpen: float = _option(
        0.0,
        title=Text("Output &sharpening"),
        tip=Text("Only if the photo is reduced"),
        most=200,
        unit=Text(" %"),
        option="--sharpen",
        metavar="PERCENT",
        needs="--longest-side",
        help=Text("Sharpen downscaled pictures, 0..200 [0]"),
    )
    # File name template with {name}, {n} and {amount}.
    name: str = _option(
        "{name}", title=Text("&Name"), tip=Text("May contain {name}, {n} and {amount}")
    )
    # Number of the first photo, for {n}; 0 continues the last export into the folder.
    first: int = _option(
        0,
        title=Text("First n&umber"),
        tip=Text("For {n}; photos exported before keep their number"),
        most=999_999,
        lowest=Text("continue"),
    )
    # Preserve EXIF, XMP, IPTC and other metadata.
    metadata: bool = _option(
        True,
        title=Text("Keep &metadata"),
        tip=Text("EXIF, XMP and IPTC; off: keep the profile"),
        option="--no-metadata",
        help=Text("Omit EXIF, XMP, IPTC and similar; keep the profile"),
    )

    def check_ranges(self) -> None:
        """Raise ValueError for a number outside its range."""
        for field, setting in EXPORT_SETTINGS.items():
            value: Any = getattr(self, field)
            if setting.most and not 0 <= value <= setting.most:
                raise BadValue(
                    "{name} must be within {low:g}..{high:g}, got {value}",
                    name=field,
                    low=0,
                    high=setting.most,
                    value=shown(value),
                )


# In declaration order.
EXPORT_SETTINGS: Final = {
    field.name: dataclasses.replace(field.metadata[ExportSetting], name=field.name)
    for field in dataclasses.fields(ExportSettings)
}
