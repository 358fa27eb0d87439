"""Pixels and metadata of a photo as the bytes of a file."""

from __future__ import annotations

import dataclasses

import numpy as np

from kogao_core.base.atomic import Pieces
from kogao_core.base.geometry import Box, Image
from kogao_core.photo import formats
from kogao_core.photo.formats import Content, FileFormat
from kogao_core.photo.formats.turning import as_stored
from kogao_core.photo.metadata import (
    container,
    jpeg_extras,
    kinds,
    photoshop,
    places,
    stale,
    upright,
)
from kogao_core.photo.model import Photo


def encode(
    photo: Photo,
    pixels: Image,
    form: FileFormat,
    part: Box | None = None,
    quality: int | None = None,
) -> Pieces:
    """Return a file with new pixels and the photo's metadata.

    It is upright, unless the format keeps a photo as it lies and no quality is asked for; `part` is
    then of the stored pixels.
    """
    if form.encode is None:
        raise ValueError(f"{form.title} is read only")
    carried = photo.carried if form.name == photo.format else ()
    along = {one.kind: len(one.data) for one in photo.companions}
    if kinds.GAIN_MAP not in along:
        carried = tuple(one for one in carried if not jpeg_extras.tells_gain_map(one))
    is_extended = any(map(jpeg_extras.is_extension, carried))
    turns = form.turns(photo, is_export=quality is not None)
    if photo.orientation != 1 and not turns:
        pixels = as_stored(pixels, photo.orientation)
    height, width = pixels.shape[:2]
    turn = upright.Turn(photo.orientation if turns else 1, width, height)
    if turn.swaps_sides:
        photo = dataclasses.replace(
            photo, dpi=photo.dpi and photo.dpi[::-1], aspect=photo.aspect and photo.aspect[::-1]
        )
    pixels = pixels[(part or Box.of(pixels)).slices]
    xmp = photo.xmp and places.turned_xmp(photo.xmp, turn)
    if xmp:
        xmp = stale.without(xmp, is_extended=is_extended, is_turned=turns, along=along)
        xmp = container.adjusted(xmp, along) if along else xmp
    becomes_colour = form.becomes_colour(pixels)
    content = Content(
        photo,
        _coloured(pixels) if becomes_colour else np.ascontiguousarray(pixels),
        {
            "icc_profile": None if becomes_colour else photo.icc_profile,  # it is one of grey
            "exif": photo.exif and upright.turned_exif(photo.exif, turn),
            "xmp": xmp,
            "dpi": photo.dpi,
        },
        photo.photoshop and photoshop.without_stale(photo.photoshop, is_turned=turns),
        carried,
        is_lossless=photo.lossless_webp or formats.BY_NAME[photo.format].is_lossless,
        quality=quality or 0,
    )
    return form.encode(content)


def _coloured(grey: Image) -> Image:
    """Return grey, with alpha or without, as RGB or RGBA."""
    planes = grey.reshape(*grey.shape[:2], -1)
    return np.ascontiguousarray(planes[..., [0, 0, 0, 1][: 2 + planes.shape[2]]])
