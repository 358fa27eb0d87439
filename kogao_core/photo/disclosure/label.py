"""Draw a text label in the corner of a photo; the other pixels stay unchanged."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
from PIL import Image as Pillow
from PIL import ImageDraw, ImageFont

from kogao_core.base.geometry import Box, Image
from kogao_core.base.language import Text
from kogao_core.base.wording import printable
from kogao_core.photo.errors import CannotDisclose
from kogao_core.photo.model import channels_of

LONGEST: Final = 100
_HEIGHT_SHARE: Final = 0.025  # of the shorter side
_LEAST_PX, _READABLE_PX = 8, 14
_WIDEST_SHARE: Final = 0.96
_PADDING: Final = 0.4  # of the letters' size
_PLATE_OPACITY: Final = 0.6
_Font = ImageFont.FreeTypeFont
# System fonts for letters missing in the built-in font. Pillow searches the font folders of the
# system for these file names.
_OF_SYSTEM: Final = (
    *("NotoSansCJK-Regular.ttc", "DroidSansFallbackFull.ttf"),  # Linux
    *("ipagp.ttf", "TakaoPGothic.ttf", "VL-PGothic-Regular.ttf"),
    *("YuGothM.ttc", "meiryo.ttc", "msgothic.ttc", "malgun.ttf", "msyh.ttc"),  # Windows
    *("Arial Unicode.ttf", "Hiragino Sans GB.ttc"),  # macOS
)


def draw_label(pixels: Image, text: str, font: str | None = None) -> Image:
    """Draw white text on a dark plate in the bottom right corner. Return a copy.

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
    """Check the text and the font of a label. Raises CannotDisclose."""
    if not text.strip() or len(text) > LONGEST or printable(text) != text:
        raise CannotDisclose(
            "a label is one line of 1 to {longest} letters; write another one", longest=LONGEST
        )
    lacking = _lacking(text, _drawing(text, font))
    if lacking:
        raise CannotDisclose(
            "the label's font has no {letter!r}; name a font file that has it", letter=lacking
        )


def _drawing(text: str, font: str | None) -> str | None:
    """Return the font for a text: the given font, or the first system font with all letters.

    None is the built-in font.
    """
    if font is not None or not _lacking(text, None):
        return font
    return next((one for one in _OF_SYSTEM if _is_there(one) and not _lacking(text, one)), None)


def _lacking(text: str, font: str | None) -> str:
    """Return the first letter missing in a font, or ""."""
    face = _font(font, _READABLE_PX)
    # U+FFFF is no character: a font draws the same glyph for every missing letter.
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
    """Return the opacity of the text on the plate, 0 to 1, for a picture of this size."""
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
    raise CannotDisclose("the photo is too small for the label; shorten it or leave it out")


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
        raise CannotDisclose("this Pillow draws no text; install its wheel with FreeType")
    if sum(found.getmetrics()) <= 0:  # a damaged font: letters have no height
        raise CannotDisclose(useless)
    return found


def _blended(patch: Image, mask: Image) -> Image:
    """Blend pixels with a dark plate and white letters; alpha becomes opaque."""
    whole = np.issubdtype(patch.dtype, np.integer)
    white = float(np.iinfo(patch.dtype).max) if whole else 1.0
    channels = channels_of(patch)
    values = patch.reshape(*patch.shape[:2], channels).astype(np.float64)
    colours = values[..., : channels - (channels in (2, 4))]
    colours *= (1.0 - _PLATE_OPACITY) * (1.0 - mask[..., None])
    colours += white * mask[..., None]
    values[..., colours.shape[2] :] = white
    return (np.rint(values) if whole else values).astype(patch.dtype).reshape(patch.shape)
