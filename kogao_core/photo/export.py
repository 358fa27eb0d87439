"""Export options: size, format, colours and file name.

`render` produces pictures of reduced size directly, so the pixels are resampled only once.
"""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.base.display import eight_bits
from kogao_core.base.geometry import Image
from kogao_core.base.language import BadValue, Text
from kogao_core.base.wording import shown
from kogao_core.photo import profiles
from kogao_core.photo.errors import RefusedOutput
from kogao_core.photo.formats import FORMATS, READ_ONLY, png
from kogao_core.photo.formats.jpeg import JPEG
from kogao_core.photo.metadata import jpeg_extras, kinds
from kogao_core.photo.model import Photo, channels_of
from kogao_core.recipe.export import ExportSettings

# Sigma of the sharpening blur, in pixels of the result.
_SHARPEN_PX: Final = 0.6
_NO_BLOCK: Final = Text("without its metadata, every block of the JPEG was compressed again")
_FIELD: Final = re.compile(r"\{(\w*)\}")
_PARTS: Final = re.compile(r"(\{\w*\})")
_FIELDS: Final = ("name", "n", "amount")
_SEPARATORS: Final = re.compile(r'[<>:"/\\|?*\x00-\x1f]')


@dataclass(frozen=True, slots=True)
class Export(ExportSettings):
    """Options for saving a copy. The defaults preserve as much of the source as possible."""

    def __post_init__(self) -> None:
        """Validate all fields. Raises ValueError."""
        self.check_ranges()
        if self.ending and self.ending not in FORMATS:
            raise BadValue("no photo is written as {ending}", ending=shown(self.ending))
        unknown = [field for field in _FIELD.findall(self.name) if field not in _FIELDS]
        if unknown or not self.name.strip() or _SEPARATORS.search(self.name):
            raise BadValue(
                "a name is made of letters and {{name}}, {{n}} and {{amount}}, got {value}",
                value=shown(self.name),
            )

    @property
    def coding(self) -> int | None:
        """Quality for `write`. None: preserve as much of the source's encoding as possible."""
        names = {one: getattr(AS_IT_IS, one) for one in ("ending", "name", "first")}
        same_coding = dataclasses.replace(self, **names)
        return None if same_coding == AS_IT_IS else self.quality

    def reduces(self, photo: Photo) -> bool:
        return 0 < self.longest_px < max(photo.width, photo.height)

    def place(self, photo: Path, number: int, percent: float, ending: str = ".jpg") -> Path:
        """Return the output path. `photo` is the path in the output folder with the source's name.

        `ending` is the fallback extension for photos in a read-only format.
        """
        photo = photo.with_name(photo.name.rstrip())
        if not self.ending and self.name == "{name}":
            unwritten = photo.suffix.lower() in READ_ONLY
            # Append the extension: a raw photo and its JPEG are often in the same folder.
            return photo.with_name(photo.name + ending) if unwritten else photo
        fields = {"name": photo.stem, "n": f"{number:03}", "amount": f"{percent:g}"}
        own = photo.suffix if photo.suffix.lower() in FORMATS else ending
        name = _FIELD.sub(lambda field: fields[field[1]], self.name)
        return photo.with_name(name + (self.ending or own))

    def numbers(self, photos: Sequence[Path], earlier: Mapping[str, str]) -> list[int]:
        """Return a number for each photo.

        `earlier`: outputs of earlier exports by source; their photos keep their numbers.
        """
        if self.first:
            return [self.first + index for index in range(len(photos))]
        parts = {"{n}": r"(\d+)", "{name}": ".*", "{amount}": ".*"}
        pattern = "".join(parts.get(one) or re.escape(one) for one in _PARTS.split(self.name))
        found = {
            source: int(match[1])
            for source, output in earlier.items()
            if "{n}" in self.name and (match := re.fullmatch(pattern, Path(output).stem))
        }
        free = itertools.count(max(found.values(), default=0) + 1)
        return [found.get(str(photo)) or next(free) for photo in photos]

    def applied(self, photo: Photo, pixels: Image) -> tuple[Photo, Image]:
        """Apply sharpening, metadata removal and colour conversion. Return photo and pixels.

        Raises RefusedOutput for --srgb if the colours are unknown.
        """
        rare = {one.kind for one in photo.extras} & {kinds.COLOURS, kinds.RARE_COLOURS}
        if self.srgb and rare and photo.icc_profile is None:
            raise RefusedOutput(
                "{path} names its colours in a rare way, which can't be converted to sRGB; "
                "leave the colours as they are",
                path=photo.path,
            )
        if self.sharpen and pixels.shape[:2] != photo.pixels.shape[:2]:
            pixels = _sharpened(pixels, self.sharpen / 100.0)
        if not self.metadata:
            lost = {one.name: 0 for one in photo.extras if one.kind in JPEG.companions}
            notes = [Text("not kept: {lost}", lost=Text.joined(", ", lost))] if lost else []
            if photo.format == JPEG.name:
                notes.append(_NO_BLOCK)
            photo = dataclasses.replace(
                photo, exif=None, xmp=None, photoshop=None, carried=(), extras=(),
                notes=(*photo.notes, *notes),
            )  # fmt: skip
        return _in_srgb(photo, pixels) if self.srgb else (photo, pixels)


AS_IT_IS: Final = Export()


def _sharpened(pixels: Image, share: float) -> Image:
    """Sharpen fine detail with an unsharp mask. Preserve the alpha channel."""
    colours = pixels if channels_of(pixels) in (1, 3) else pixels[..., :-1]
    blurred = cv2.GaussianBlur(colours, (0, 0), _SHARPEN_PX).reshape(colours.shape)
    sharp = cv2.addWeighted(colours, 1.0 + share, blurred, -share, 0.0).reshape(colours.shape)
    if colours is pixels:
        return np.asarray(sharp)
    return np.concatenate([sharp, pixels[..., -1:]], axis=2)


def _in_srgb(photo: Photo, pixels: Image) -> tuple[Photo, Image]:
    """Convert pixels to 8-bit sRGB and replace the photo's profile. Keep a damaged profile."""
    photo, pixels = profiles.tone_mapped(photo, pixels)
    pixels = eight_bits(pixels)
    if photo.icc_profile is not None:
        try:
            pixels = profiles.to_srgb(pixels, photo.icc_profile)
        except profiles.DAMAGED:
            note = Text("its colour profile can't be followed, so it was kept")
            return dataclasses.replace(photo, notes=(*photo.notes, note)), pixels
    elif channels_of(pixels) < 3:
        return photo, pixels  # grey without a profile is the same in sRGB
    of_colours = png.is_colour if photo.format == "PNG" else jpeg_extras.is_colour
    carried = tuple(one for one in photo.carried if not of_colours(one))
    return dataclasses.replace(photo, icc_profile=profiles.srgb(), carried=carried), pixels
