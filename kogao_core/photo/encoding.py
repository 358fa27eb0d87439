"""Pixels and metadata of a photo as the bytes of a file."""

from __future__ import annotations

import numpy as np

from kogao_core.base.atomic import Pieces
from kogao_core.base.geometry import Box, Image
from kogao_core.photo import formats
from kogao_core.photo.formats import Content, FileFormat
from kogao_core.photo.metadata import jpeg_extras, photoshop, stale, upright
from kogao_core.photo.model import Photo


def encode(
    photo: Photo, pixels: Image, form: FileFormat, part: Box | None = None, quality: int = 0
) -> Pieces:
    """Return a file with new pixels and the photo's metadata, whose orientation is upright."""
    if form.encode is None:
        raise ValueError(f"{form.title} is read only")
    carried = photo.carried if form.name == photo.format else ()
    is_extended = any(map(jpeg_extras.is_extension, carried))
    height, width = pixels.shape[:2]
    pixels = pixels[(part or Box.of(pixels)).slices]
    xmp = photo.xmp and upright.upright_xmp(photo.xmp, width, height)
    becomes_colour = form.becomes_colour(pixels)
    content = Content(
        photo,
        _coloured(pixels) if becomes_colour else np.ascontiguousarray(pixels),
        {
            "icc_profile": None if becomes_colour else photo.icc_profile,  # it is one of grey
            "exif": photo.exif and upright.upright_exif(photo.exif, width, height),
            "xmp": xmp and stale.without(xmp, is_extended=is_extended),
            "dpi": photo.dpi,
        },
        photo.photoshop and photoshop.without_stale(photo.photoshop),
        carried,
        is_lossless=photo.lossless_webp or formats.BY_NAME[photo.format].is_lossless,
        quality=quality,
    )
    return form.encode(content)


def _coloured(grey: Image) -> Image:
    """Return grey, with alpha or without, as RGB or RGBA."""
    planes = grey.reshape(*grey.shape[:2], -1)
    return np.ascontiguousarray(planes[..., [0, 0, 0, 1][: 2 + planes.shape[2]]])
