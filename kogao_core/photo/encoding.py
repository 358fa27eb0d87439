"""Pixels and metadata of a photo as the bytes of a file."""

from __future__ import annotations

import dataclasses
import io
from functools import partial

import cv2
import numpy as np
from PIL import Image as Pillow

from kogao_core.base.atomic import Pieces
from kogao_core.base.display import eight_bits
from kogao_core.base.geometry import Box, Image
from kogao_core.photo import formats
from kogao_core.photo.formats import Content, FileFormat
from kogao_core.photo.formats.turning import as_stored
from kogao_core.photo.jpeg.segments import SOI
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

_SMALL_PX, _SMALL_QUALITY = (512, 320, 160, 120), 80  # of thumbnails: the longer side


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
    carried: tuple[bytes, ...] = ()
    if form.name == photo.format:
        late = (one.data for one in photo.extras if one.kind is kinds.LATE_SEGMENTS)
        carried = (*photo.carried, *late)
    if photo.jpeg is None:  # its colours were converted
        carried = tuple(one for one in carried if not jpeg_extras.is_profile(one))
    along = {one.kind: len(one.data) for one in photo.companions}
    if kinds.GAIN_MAP not in along:
        carried = tuple(one for one in carried if not jpeg_extras.tells_gain_map(one))
    is_extended = any(map(jpeg_extras.is_extension, carried))
    turns = form.turns(photo, is_export=quality is not None)
    small = partial(_small, pixels, 1 if turns else photo.orientation)
    if photo.orientation != 1 and not turns:
        pixels = as_stored(pixels, photo.orientation)
    height, width = pixels.shape[:2]
    turn = upright.Turn(photo.orientation if turns else 1, width, height)
    if turn.swaps_sides:
        photo = dataclasses.replace(
            photo, dpi=photo.dpi and photo.dpi[::-1], aspect=photo.aspect and photo.aspect[::-1]
        )

    def tidied(packet: bytes) -> bytes:
        packet = places.turned_xmp(packet, turn)
        packet = stale.without(packet, is_extended=is_extended, is_turned=turns, along=along)
        return container.adjusted(packet, along) if along else packet

    pixels = pixels[(part or Box.of(pixels)).slices]
    becomes_colour = form.becomes_colour(pixels)
    content = Content(
        photo,
        _coloured(pixels) if becomes_colour else np.ascontiguousarray(pixels),
        {
            "icc_profile": None if becomes_colour else photo.icc_profile,  # it is one of grey
            "exif": photo.exif and upright.turned_exif(photo.exif, turn, small),
            "xmp": photo.xmp and tidied(photo.xmp),
            "dpi": photo.dpi,
        },
        photo.photoshop and photoshop.without_stale(photo.photoshop, is_turned=turns),
        tuple(jpeg_extras.with_packet(one, tidied) for one in carried),
        is_lossless=photo.lossless_webp or formats.BY_NAME[photo.format].is_lossless,
        quality=quality or 0,
    )
    return form.encode(content)


def _small(pixels: Image, orientation: int, old: bytes) -> bytes:
    """Return upright pixels as a small JPEG file that lies so, as long as an old one, or b""."""
    if not old.startswith(SOI):
        return b""
    for longest in _SMALL_PX:
        scale = min(1.0, longest / max(pixels.shape[:2]))
        size = [max(1, round(scale * side)) for side in pixels.shape[1::-1]]
        reduced = eight_bits(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))
        picture = Pillow.fromarray(np.ascontiguousarray(as_stored(reduced, orientation)))
        with io.BytesIO() as out:
            picture.convert("RGB").save(out, "JPEG", quality=_SMALL_QUALITY, optimize=True)
            if out.tell() <= len(old):
                return out.getvalue()
    return b""


def _coloured(grey: Image) -> Image:
    """Return grey, with alpha or without, as RGB or RGBA."""
    planes = grey.reshape(*grey.shape[:2], -1)
    return np.ascontiguousarray(planes[..., [0, 0, 0, 1][: 2 + planes.shape[2]]])
