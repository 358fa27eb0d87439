"""What becomes of a result on its way into a file: size, format, colours, name; one value.

A reduced picture comes from `render` itself, which resamples once.
"""

from __future__ import annotations

import dataclasses
import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from PIL import Image as Pillow
from PIL import ImageCms

from kogao_core.base.display import eight_bits
from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.base.wording import shown
from kogao_core.photo.formats import FORMATS, READ_ONLY
from kogao_core.photo.metadata import jpeg_extras
from kogao_core.photo.model import Photo, channels_of

LONGEST_PX: Final = 65500
_SHARPEN_PX: Final = 0.6  # of the result: what reducing has blurred
_DATE: Final = slice(24, 36)  # in an ICC profile: the same result has the same bytes
_FIELD: Final = re.compile(r"\{(\w*)\}")
_FIELDS: Final = ("name", "n", "amount")
_SEPARATORS: Final = re.compile(r'[<>:"/\\|?*\x00-\x1f]')


@dataclass(frozen=True, slots=True)
class Export:
    """How results are written; as it is, a copy that keeps all that a file can."""

    longest_px: int = 0  # of the longer side; 0 is the photo's own, and none is enlarged
    ending: str = ""  # the format, such as .jpg; empty: the photo's own
    quality: int = 0  # of JPEG and WebP, 1 to 100; 0 is the source's, or 95
    srgb: bool = False  # converted to sRGB, 8 bits; else the photo's profile is kept
    sharpen: float = 0.0  # of reduced pictures, 0 to 200 %
    name: str = "{name}"  # of the file, with {name}, {n} and {amount}
    metadata: bool = True  # EXIF, XMP, IPTC and the like are kept

    def __post_init__(self) -> None:
        """Refuse what can't be written."""
        ranges = {"longest_px": LONGEST_PX, "quality": 100, "sharpen": 200}
        for field, most in ranges.items():
            value: Any = getattr(self, field)
            if not 0 <= value <= most:
                raise ValueError(
                    Text(
                        "{name} must be within {low:g}..{high:g}, got {value}",
                        name=field, low=0, high=most, value=shown(value),
                    )
                )  # fmt: skip
        if self.ending and self.ending not in FORMATS:
            raise ValueError(Text("no photo is written as {ending}", ending=shown(self.ending)))
        unknown = [field for field in _FIELD.findall(self.name) if field not in _FIELDS]
        if unknown or not self.name.strip() or _SEPARATORS.search(self.name):
            raise ValueError(
                Text(
                    "a name is made of letters and {{name}}, {{n}} and {{amount}}, got {value}",
                    value=shown(self.name),
                )
            )

    @property
    def coding(self) -> int | None:
        """Return the quality for `write`; None where a file keeps all it can of the source's."""
        changes = self.longest_px or self.quality or self.srgb or self.sharpen
        return None if not changes and self.metadata else self.quality

    def reduces(self, photo: Photo) -> bool:
        """Tell whether a photo's result is smaller than the photo."""
        return 0 < self.longest_px < max(photo.width, photo.height)

    def place(self, photo: Path, number: int, percent: float, ending: str = ".jpg") -> Path:
        """Return the file of a result, `photo` being its place by the source's own name.

        `ending` is for photos whose own format isn't written.
        """
        if not self.ending and self.name == "{name}":
            unwritten = photo.suffix.lower() in READ_ONLY
            # The whole name stays: a raw photo often lies beside its JPEG.
            return photo.with_name(photo.name + ending) if unwritten else photo
        fields = {"name": photo.stem, "n": f"{number:03}", "amount": f"{percent:g}"}
        own = photo.suffix if photo.suffix.lower() in FORMATS else ending
        name = _FIELD.sub(lambda field: fields[field[1]], self.name)
        return photo.with_name(name + (self.ending or own))

    def applied(self, photo: Photo, pixels: Image) -> tuple[Photo, Image]:
        """Return a photo and its result as they are to be disclosed and written."""
        if self.sharpen and pixels.shape[:2] != photo.pixels.shape[:2]:
            pixels = _sharpened(pixels, self.sharpen / 100.0)
        if not self.metadata:
            photo = dataclasses.replace(
                photo, exif=None, xmp=None, photoshop=None, carried=(), extras=()
            )
        return _in_srgb(photo, eight_bits(pixels)) if self.srgb else (photo, pixels)


AS_IT_IS: Final = Export()


def _sharpened(pixels: Image, share: float) -> Image:
    """Return a picture with its finest detail stronger; transparency stays."""
    colours = pixels if channels_of(pixels) in (1, 3) else pixels[..., :-1]
    blurred = cv2.GaussianBlur(colours, (0, 0), _SHARPEN_PX).reshape(colours.shape)
    sharp = cv2.addWeighted(colours, 1.0 + share, blurred, -share, 0.0).reshape(colours.shape)
    if colours is pixels:
        return np.asarray(sharp)
    return np.concatenate([sharp, pixels[..., -1:]], axis=2)


def _in_srgb(photo: Photo, pixels: Image) -> tuple[Photo, Image]:
    """Return 8-bit pixels in sRGB, and the photo with that profile; damaged ones are kept."""
    srgb = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB"))
    if photo.icc_profile is not None:
        colours = pixels if channels_of(pixels) in (1, 3) else pixels[..., :-1]
        picture = Pillow.fromarray(np.ascontiguousarray(np.squeeze(colours)))
        try:
            source = ImageCms.ImageCmsProfile(io.BytesIO(photo.icc_profile))
            turned = ImageCms.profileToProfile(
                picture, source, srgb, ImageCms.Intent.RELATIVE_COLORIMETRIC, "RGB",
                flags=ImageCms.Flags.BLACKPOINTCOMPENSATION | ImageCms.Flags.HIGHRESPRECALC,
            )  # fmt: skip
        except (ImageCms.PyCMSError, OSError):
            note = Text("its colour profile can't be followed, so it was kept")
            return dataclasses.replace(photo, notes=(*photo.notes, note)), pixels
        done = np.asarray(turned)
        pixels = done if colours is pixels else np.dstack([done, pixels[..., -1]])
    elif channels_of(pixels) < 3:
        return photo, pixels  # grey without a profile is grey everywhere
    made = srgb.tobytes()
    undated = made[: _DATE.start] + bytes(12) + made[_DATE.stop :]
    carried = tuple(one for one in photo.carried if not jpeg_extras.is_profile(one))
    return dataclasses.replace(photo, icc_profile=undated, carried=carried), pixels
