"""What follows a JPEG's picture in its file and can go along: a gain map, a film, records.

The gain map is a small JPEG file of how much brighter each place is on an HDR screen. Behind the
picture come such pictures, which the index of CIPA DC-007 (MPF) counts, and the film last.
"""

from __future__ import annotations

import dataclasses
import io
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image as Pillow

from kogao_core.base.geometry import Box, Image, check_type
from kogao_core.base.stderr import hushed
from kogao_core.photo.formats import common
from kogao_core.photo.jpeg import decoding, segments
from kogao_core.photo.jpeg.blocks import keep_blocks
from kogao_core.photo.jpeg.coefficients import CannotKeepBlocks
from kogao_core.photo.metadata import kinds, stale
from kogao_core.photo.metadata.upright import as_stored, turn_upright
from kogao_core.photo.model import Companion, Photo, is_same

Move = Callable[[Image], Image]
_TURNED: Final = 5  # from this orientation on rows become columns
_MOST_OFF: Final = 0.02  # of a gain map's width, beside a pixel: sizes are rounded
_MPF: Final = 0xE2
_PRIMARY: Final = 0x030000  # MPF's type of the picture itself; 0 is that of a gain map
_ENTRY: Final = ">IIIHH"
_MPF_NAME: Final = b"MPF\0"  # behind which offsets count


def accompanied(photo: Photo, move: Move, *, film: bool = False) -> Photo:
    """Return the photo with an HDR gain map that matches the warped pixels, for `write`.

    Parameters
    ----------
    photo : Photo
        The JPEG file, from `read`.
    move : callable
        Function that warps an upright picture of the whole photo of any size, uint8 (H, W) or
        (H, W, 3), as the photo was warped; such as `Rendering.warped`.
    film : bool
        Keep the video of a motion photo; the video shows the original face.

    Returns
    -------
    Photo
        For `write`. Photos without a gain map or video are returned unchanged.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> photo = kogao.read(kogao.sample())
    >>> face = kogao.template_face((450, 480), 400)
    >>> rendering = kogao.render(photo.pixels, [face], kogao.Recipe(percent=5))
    >>> along = kogao.accompanied(photo, rendering.warped)
    >>> note = kogao.write(along, rendering.pixels, "with-hdr.jpg")
    >>> along.companions  # the sample is no HDR photo
    ()
    """
    check_type(photo, Photo, "from kogao.read")
    found: list[Companion] = []
    for extra in photo.extras:
        if extra.kind is kinds.VIDEO and film and extra.data and stale.tells_film(photo.xmp or b""):
            found.append(Companion(kinds.VIDEO, extra.data))
        elif extra.kind is kinds.GAIN_MAP and _fits(extra.data, photo):
            before = _decoded(extra.data)
            if before is not None:
                after = move(turn_upright(before, photo.orientation))
                found.append(Companion(kinds.GAIN_MAP, extra.data, after, before))
    one_each = {one.kind: one for one in reversed(found)}
    return dataclasses.replace(photo, companions=tuple(reversed(one_each.values())))


def has_gain_map(photo: Photo) -> bool:
    """Tell whether a photo is one for HDR screens, by a gain map that can go along."""
    return any(one.kind is kinds.GAIN_MAP and _fits(one.data, photo) for one in photo.extras)


def _fits(data: bytes, photo: Photo) -> bool:
    """Tell whether a picture is grey or RGB, of the photo's shape as it lies, and no larger."""
    try:
        with Pillow.open(io.BytesIO(data), formats=["JPEG"]) as image:
            (width, height), mode = image.size, image.mode
    except Exception:  # decoders raise almost anything on damaged files
        return False
    if photo.orientation >= _TURNED:
        width, height = height, width
    off = abs(width - height * photo.width / photo.height)
    return mode in ("L", "RGB") and width <= photo.width and off <= 1.0 + _MOST_OFF * width


def _decoded(data: bytes) -> Image | None:
    """Return a gain map's pixels as stored: uint8 (H, W) or (H, W, 3); None where it is damaged."""
    try:
        with hushed(), Pillow.open(io.BytesIO(data), formats=["JPEG"]) as image:
            quick = decoding.pixels(data, image.size, image.mode)
            return np.array(image) if quick is None else quick
    except Exception:  # as above
        return None


def settled(photo: Photo, folder: Path) -> Photo:
    """Return a photo whose companions are the files to write."""
    done = (
        Companion(one.kind, _encoded(one, photo.orientation, folder)) for one in photo.companions
    )
    return dataclasses.replace(photo, companions=tuple(done))


def _encoded(one: Companion, orientation: int, folder: Path) -> bytes:
    """Return a gain map with other pixels: headers and unchanged blocks are its own."""
    data, before = one.data, one.before
    if before is None or one.pixels is None:
        return data
    after = np.ascontiguousarray(as_stored(one.pixels, orientation))
    if is_same(before, after):
        return data
    with Pillow.open(io.BytesIO(data), formats=["JPEG"]) as image:
        coding = common.jpeg_coding(image)

    def encode(box: Box) -> bytes:
        with io.BytesIO() as out:
            tables = [list(table) for table in coding.tables] if coding is not None else None
            subsampling = coding.subsampling if coding is not None else 0
            part = Pillow.fromarray(np.ascontiguousarray(after[box.slices]))
            part.save(out, "JPEG", qtables=tables, subsampling=subsampling)
            return out.getvalue()

    try:
        fresh = keep_blocks(data, before, after, encode, folder).data
    except CannotKeepBlocks:
        fresh = encode(Box.of(after))
    return segments.with_headers(fresh, data)


def joined(photo: Photo, picture: bytes) -> bytes:
    """Return a JPEG file with what follows it, and an index of the pictures among that."""
    pictures = [one.data for one in photo.companions if one.kind is kinds.GAIN_MAP]
    if pictures:
        index = _index(0, [len(one) for one in pictures])
        at = segments.end_of_headers(picture)
        size = len(picture) + len(index)
        base = at + 4 + len(_MPF_NAME)
        picture = picture[:at] + _index(size, [len(one) for one in pictures], base) + picture[at:]
    films = [one.data for one in photo.companions if one.kind is kinds.VIDEO]
    # A film is looked for at the end.
    records = [one.data for one in photo.extras if one.kind in kinds.RECORDS and not films]
    return b"".join([picture, *pictures, *films, *records])


def _index(size: int, lengths: list[int], base: int = 0) -> bytes:
    """Return the segment that counts pictures: the first of a size, and what follows it at once.

    `base` is where its offsets count from in the file.
    """
    entries, at = [struct.pack(_ENTRY, _PRIMARY, size, 0, 0, 0)], size
    for length in lengths:
        entries.append(struct.pack(_ENTRY, 0, length, at - base, 0, 0))
        at += length
    listed = b"".join(entries)
    head = struct.pack(">2sHIH", b"MM", 42, 8, 3)
    place = len(head) + 3 * 12 + 4
    tags = struct.pack(
        ">HHI4sHHIIHHIII", 0xB000, 7, 4, b"0100", 0xB001, 4, 1, len(entries),
        0xB002, 7, len(listed), place, 0,
    )  # fmt: skip
    return segments.segment(_MPF, _MPF_NAME + head + tags + listed)
