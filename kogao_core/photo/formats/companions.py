"""Companions of a JPEG: data after the picture that a changed photo keeps.

A gain map is a small JPEG with the brightness of each place on an HDR screen. Gain maps follow the
picture and are listed in the MPF index (CIPA DC-007). A video comes last.
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

from kogao_core.base.geometry import Image, check_type
from kogao_core.base.stderr import hushed
from kogao_core.photo.formats import common
from kogao_core.photo.jpeg import decoding, segments
from kogao_core.photo.jpeg.blocks import keep_blocks
from kogao_core.photo.jpeg.coefficients import CannotKeepBlocks
from kogao_core.photo.metadata import kinds, references
from kogao_core.photo.metadata.upright import as_stored, turn_upright
from kogao_core.photo.model import Companion, Photo, is_same

Move = Callable[[Image], Image]
_TURNED: Final = 5  # from this orientation on rows become columns
_MOST_OFF: Final = 0.02  # of a gain map's width, beside a pixel: sizes are rounded
_MPF: Final = 0xE2
_PRIMARY: Final = 0x030000  # MPF type of the main picture; the type of a gain map is 0
_ENTRY: Final = ">IIIHH"
_MPF_NAME: Final = b"MPF\0"  # behind which offsets count


def accompanied(photo: Photo, move: Move, *, film: bool = False) -> Photo:
    """Return a photo with a warped HDR gain map, for writing a changed JPEG.

    Parameters
    ----------
    photo : Photo
        A JPEG photo from `read`.
    move : callable
        Warps an upright picture of the whole photo in another size, uint8 (H, W) or (H, W, 3),
        such as `Rendering.warped`.
    film : bool
        Also keep the video of a motion photo. The video shows the original face.

    Returns
    -------
    Photo
        For `write`; unchanged if the photo has no companions.

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
        if (
            extra.kind is kinds.VIDEO
            and film
            and extra.data
            and references.locates_video(photo.xmp or b"")
        ):
            found.append(Companion(kinds.VIDEO, extra.data))
        elif extra.kind is kinds.GAIN_MAP and (before := _decoded(extra.data, photo)) is not None:
            after = move(turn_upright(before, photo.orientation))
            found.append(Companion(kinds.GAIN_MAP, extra.data, after, before))
    one_each = {one.kind: one for one in reversed(found)}
    return dataclasses.replace(photo, companions=tuple(reversed(one_each.values())))


def has_gain_map(photo: Photo) -> bool:
    """Return True if a photo has a gain map that a changed photo can keep."""
    return any(
        one.kind is kinds.GAIN_MAP and _decoded(one.data, photo) is not None for one in photo.extras
    )


def _decoded(data: bytes, photo: Photo) -> Image | None:
    """Decode a gain map: uint8 (H, W) or (H, W, 3), as stored.

    None if damaged, of another shape than the photo, or larger.
    """
    try:
        with hushed(), Pillow.open(io.BytesIO(data), formats=["JPEG"]) as image:
            width, height = image.size[:: -1 if photo.orientation >= _TURNED else 1]
            off = abs(width - height * photo.width / photo.height)
            if width > photo.width or off > 1.0 + _MOST_OFF * width:
                return None
            quick = decoding.pixels(io.BytesIO(data), image.size, image.mode)
            pixels = np.array(image) if quick is None else quick
            return pixels if image.mode in ("L", "RGB") else None
    except Exception:  # decoders raise almost anything on damaged files
        return None


def settled(photo: Photo, folder: Path) -> Photo:
    """Encode the companions of a photo. Return the photo with their files."""
    done = (
        Companion(one.kind, _encoded(one, photo.orientation, folder)) for one in photo.companions
    )
    return dataclasses.replace(photo, companions=tuple(done))


def _encoded(one: Companion, orientation: int, folder: Path) -> bytes:
    """Encode a gain map with new pixels. Headers and unchanged blocks stay."""
    data, before = one.data, one.before
    if before is None or one.pixels is None:
        return data
    after = np.ascontiguousarray(as_stored(one.pixels, orientation))
    if is_same(before, after):
        return data
    try:
        return keep_blocks(data, before, after, data, folder).data
    except CannotKeepBlocks:
        with Pillow.open(io.BytesIO(data), formats=["JPEG"]) as image, io.BytesIO() as out:
            coding = common.jpeg_coding(image)
            tables = [list(table) for table in coding.tables] if coding is not None else None
            subsampling = coding.subsampling if coding is not None else 0
            Pillow.fromarray(after).save(out, "JPEG", qtables=tables, subsampling=subsampling)
            return segments.with_headers(out.getvalue(), data)


def joined(photo: Photo, picture: bytes) -> bytes:
    """Return a JPEG file with the companions and an index of the pictures."""
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
    """Return the MPF segment: the main picture of `size` bytes, then pictures of these lengths.

    `base`: file position from which the segment counts offsets.
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
