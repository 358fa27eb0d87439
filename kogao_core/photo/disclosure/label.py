"""A visible label in the corner of a photo, text or a picture; other pixels stay as they are."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass
from functools import cache
from typing import Final

import cv2
import numpy as np
from PIL import Image as Pillow
from PIL import ImageCms, ImageDraw, ImageFont

from kogao_core.base.display import Rgb8, rgba8
from kogao_core.base.geometry import Box, Image
from kogao_core.base.language import Text
from kogao_core.base.wording import printable
from kogao_core.photo.errors import CannotDisclose, UnreadablePhoto
from kogao_core.photo.model import Photo, channels_of
from kogao_core.photo.reading import read
from kogao_core.recipe.settings import LABEL_CORNER, LABEL_PERCENT, Corner

LONGEST: Final = 100
_HEIGHT_SHARE: Final = 0.025  # of the shorter side
_LEAST_PX, _READABLE_PX = 8, 14
_WIDEST_SHARE: Final = 0.96
_PADDING: Final = 0.4  # of the letters' size
_PLATE_OPACITY: Final = 0.6
_Font = ImageFont.FreeTypeFont
# What systems bring along for letters that the built-in font lacks, by the names of its files;
# Pillow looks for them where each system has its fonts.
_OF_SYSTEM: Final = (
    *("NotoSansCJK-Regular.ttc", "DroidSansFallbackFull.ttf"),  # Linux
    *("ipagp.ttf", "TakaoPGothic.ttf", "VL-PGothic-Regular.ttf"),
    *("YuGothM.ttc", "meiryo.ttc", "msgothic.ttc", "malgun.ttf", "msyh.ttc"),  # Windows
    *("Arial Unicode.ttf", "Hiragino Sans GB.ttc"),  # macOS
)
_MOST_MEGAPIXELS: Final = 50.0
_OPAQUE: Final = 255


def draw_label(pixels: Image, text: str, font: str | None = None) -> Image:
    """Return a copy of a picture with white text on a dark plate in its bottom right corner.

    Raises CannotDisclose.
    """
    height, width = pixels.shape[:2]
    check_label(text, font)
    mask = _mask(text, _drawing(text, font), width, height)
    rows, columns = mask.shape
    box = Box(width - columns, height - rows, width, height)
    result = pixels.copy()
    patch = result[box.slices]
    patch[...] = _blended(patch, mask)
    return result


def check_label(text: str, font: str | None = None) -> None:
    """Check that a label can be drawn on a picture that is large enough. Raises CannotDisclose."""
    if not text.strip() or len(text) > LONGEST or printable(text) != text:
        raise CannotDisclose(
            Text(
                "a label is one line of 1 to {longest} letters; write another one", longest=LONGEST
            )
        )
    lacking = _lacking(text, _drawing(text, font))
    if lacking:
        raise CannotDisclose(
            Text(
                "the label's font has no {letter!r}; name a font file that has it",
                letter=lacking,
            )
        )


def _drawing(text: str, font: str | None) -> str | None:
    """Return the font that draws a text: the one named, or the built-in one where none is better.

    None is the built-in one.
    """
    if font is not None or not _lacking(text, None):
        return font
    return next((one for one in _OF_SYSTEM if _is_there(one) and not _lacking(text, one)), None)


def _lacking(text: str, font: str | None) -> str:
    """Return the first letter that a font lacks, if any."""
    face = _font(font, _READABLE_PX)
    # U+FFFF is no character: what a font shows for it is what it shows for those it lacks.
    blank = bytes(face.getmask("\uffff"))
    letters = (one for one in sorted(set(text)) if one != " ")
    return next((one for one in letters if bytes(face.getmask(one)) == blank), "")


@cache
def _is_there(font: str) -> bool:
    try:
        return bool(_font(font, _READABLE_PX))
    except CannotDisclose:
        return False


def _mask(text: str, font: str | None, width: int, height: int) -> Image:
    """Return the text's opacity on its plate, 0 to 1, as large as suits the picture."""
    size = max(_READABLE_PX, round(_HEIGHT_SHARE * min(width, height)))
    while size >= _LEAST_PX:
        face = _font(font, size)
        columns, rows = _plate(text, face, size)
        if columns <= _WIDEST_SHARE * width and rows <= height:
            mask = Pillow.new("L", (columns, rows))
            middle = columns / 2, rows / 2
            ImageDraw.Draw(mask).text(middle, text, fill=255, font=face, anchor="mm")
            return np.asarray(mask) / 255.0
        size = int(0.9 * size)
    raise CannotDisclose(Text("the photo is too small for the label; shorten it or leave it out"))


def _plate(text: str, face: _Font, size: int) -> tuple[int, int]:
    ascent, descent = face.getmetrics()
    pad = 2 * _PADDING * size
    return round(face.getlength(text) + pad), round(ascent + descent + pad)


@cache
def _font(font: str | None, size: int) -> _Font:
    useless = Text("{font} can't be used as a font; name a .ttf or .otf file", font=font)
    try:
        found = ImageFont.load_default(size) if font is None else ImageFont.truetype(font, size)
    except (OSError, ValueError):
        raise CannotDisclose(useless) from None
    if not isinstance(found, _Font):  # Pillow without FreeType
        raise CannotDisclose(Text("this Pillow draws no text; install its wheel with FreeType"))
    if sum(found.getmetrics()) <= 0:  # it is damaged: letters have no height
        raise CannotDisclose(useless)
    return found


def _blended(patch: Image, mask: Image) -> Image:
    """Return pixels under a dark plate and white letters; alpha, if any, becomes opaque there."""
    whole = np.issubdtype(patch.dtype, np.integer)
    white = float(np.iinfo(patch.dtype).max) if whole else 1.0
    channels = channels_of(patch)
    values = patch.reshape(*patch.shape[:2], channels).astype(np.float64)
    colours = values[..., : channels - (channels in (2, 4))]
    colours *= (1.0 - _PLATE_OPACITY) * (1.0 - mask[..., None])
    colours += white * mask[..., None]
    values[..., colours.shape[2] :] = white
    return (np.rint(values) if whole else values).astype(patch.dtype).reshape(patch.shape)


@dataclass(frozen=True, slots=True)
class LabelPicture:
    """A picture that says that a photo was retouched, such as the mark that Norway prescribes."""

    file: str  # any photo that can be read; where it is transparent, the photo shows through
    corner: Corner = LABEL_CORNER  # where it lies, a key of `settings.CORNERS`
    # How much of the photo's area lies within its convex outline, within `settings.LABEL_SHARE`.
    percent: float = LABEL_PERCENT


def check_picture(label: LabelPicture) -> None:
    """Check that a label's picture can be laid over a photo that is large enough.

    Raises CannotDisclose.
    """
    _read(label)


def lay_over(photo: Photo, pixels: Image, label: LabelPicture) -> Image:
    """Return a copy of a photo's new pixels with a picture over one of their corners.

    The picture keeps its shape, less what is transparent all round it. Its 8-bit colours are
    converted from its colour profile, or sRGB, to the photo's. Raises CannotDisclose.
    """
    mark, profile = _read(label)
    box = _place(label, pixels, mark)
    result = pixels.copy()
    patch = result[box.slices]
    is_grey = channels_of(pixels) < 3
    colours = _in_colours_of(photo, mark[..., :3], profile, is_grey=is_grey)
    layers = np.dstack([colours, mark[..., 3]])
    fitted = _resized(layers, box.width, box.height)
    patch[...] = _over(patch, fitted)
    return result


def _read(label: LabelPicture) -> tuple[Rgb8, bytes | None]:
    """Return what can be seen of a picture as RGBA, and its colour profile."""
    try:
        picture = read(label.file, max_megapixels=_MOST_MEGAPIXELS, bits=8)
    except UnreadablePhoto as error:
        raise CannotDisclose(
            Text("the label's picture can't be used: {error}", error=error)
        ) from error
    mark = rgba8(picture.pixels)
    if mark.shape[2] == 3:
        mark = np.dstack([mark, np.full(mark.shape[:2], _OPAQUE, np.uint8)])
    rows, columns = (np.flatnonzero(mark[..., 3].any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        raise CannotDisclose(
            Text("{file} is transparent all over; choose another label", file=label.file)
        )
    seen = mark[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    return seen, picture.icc_profile if picture.channels > 2 else None


def _place(label: LabelPicture, pixels: Image, mark: Rgb8) -> Box:
    height, width = pixels.shape[:2]
    scale = math.sqrt(label.percent / 100.0 * width * height / _area(mark))
    rows, columns = (round(scale * side) for side in mark.shape[:2])
    if not (0 < columns <= width and 0 < rows <= height):
        raise CannotDisclose(
            Text(
                "the label's picture doesn't fit into the photo at {percent:g} % of "
                "its area; choose another share, or leave it out",
                percent=label.percent,
            )
        )
    left = width - columns if label.corner.endswith("right") else 0
    top = height - rows if label.corner.startswith("bottom") else 0
    return Box(left, top, left + columns, top + rows)


def _area(mark: Rgb8) -> float:
    """Return the area within a picture's convex outline, px: a disc counts without its corners."""
    seen = mark[..., 3] > 0
    rows = np.flatnonzero(seen.any(axis=1))
    first, last = seen.argmax(axis=1), seen.shape[1] - 1 - seen[:, ::-1].argmax(axis=1)
    ends = np.concatenate([np.stack([side[rows], rows], axis=1) for side in (first, last)])
    outline = cv2.convexHull(ends.astype(np.int32))
    # From the pixels' centres to their edges.
    return cv2.contourArea(outline) + cv2.arcLength(outline, closed=True) / 2.0 + 1.0


def _in_colours_of(photo: Photo, rgb: Rgb8, profile: bytes | None, *, is_grey: bool) -> Rgb8:
    """Return sRGB colours, or those of a profile, as the photo's; 3 channels, or 1 in 2 axes."""
    picture = Pillow.fromarray(np.ascontiguousarray(rgb))
    mode = "L" if is_grey else "RGB"
    if photo.icc_profile is not None or profile is not None:
        try:
            ends = [_profile(profile), _profile(photo.icc_profile, is_grey=is_grey)]
            done = ImageCms.profileToProfile(picture, ends[0], ends[1], outputMode=mode)
        except (ImageCms.PyCMSError, OSError):
            done = None  # a profile that nobody can follow
        if done is not None:
            return np.asarray(done)
    return np.asarray(picture.convert(mode))


def _profile(data: bytes | None, *, is_grey: bool = False) -> ImageCms.ImageCmsProfile:
    if data is not None:
        return ImageCms.ImageCmsProfile(io.BytesIO(data))
    if is_grey:
        raise ImageCms.PyCMSError("there is no standard profile for grey")
    return ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB"))


def _resized(layers: Rgb8, width: int, height: int) -> Rgb8:
    """Return colours with alpha in another size; transparent colours don't show at edges."""
    picture = Pillow.fromarray(np.ascontiguousarray(layers))  # LA or RGBA
    return np.asarray(picture.resize((width, height), Pillow.Resampling.LANCZOS))


def _over(patch: Image, layers: Rgb8) -> Image:
    """Return pixels under others with straight alpha; where these are transparent, as they were."""
    whole = np.issubdtype(patch.dtype, np.integer)
    white = float(np.iinfo(patch.dtype).max) if whole else 1.0
    channels = channels_of(patch)
    values = patch.reshape(*patch.shape[:2], channels).astype(np.float64)
    count = channels - (channels in (2, 4))
    alpha = layers[..., -1:] / float(_OPAQUE)
    ground = (1.0 - alpha) * (values[..., count:] / white if count < channels else 1.0)
    seen = alpha[..., 0] > 0.0
    share = (alpha / np.where(alpha > 0.0, alpha + ground, 1.0))[seen]
    colours = layers[..., :-1][seen] * (white / _OPAQUE)
    values[..., :count][seen] += share * (colours - values[..., :count][seen])
    values[..., count:][seen] = white * (alpha + ground)[seen][:, : channels - count]
    return (np.rint(values) if whole else values).astype(patch.dtype).reshape(patch.shape)
