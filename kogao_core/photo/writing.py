"""Save a photo safely: check the output, write a temporary file, rename the file."""

from __future__ import annotations

import dataclasses
import errno
import io
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
from PIL import Image as Pillow

from kogao_core.base.atomic import Chunks, NotAFile, atomic_write, check_target
from kogao_core.base.display import eight_bits
from kogao_core.base.geometry import Box, Image, check_image, check_type
from kogao_core.base.language import Text
from kogao_core.base.wording import system_reason
from kogao_core.photo import formats, profiles
from kogao_core.photo.errors import CannotWrite, RefusedOutput
from kogao_core.photo.formats import FORMATS
from kogao_core.photo.formats.base import Content, FileFormat
from kogao_core.photo.jpeg.segments import SOI
from kogao_core.photo.metadata import jpeg_extras, kinds, photoshop, rating, references, upright
from kogao_core.photo.metadata.kinds import Extra
from kogao_core.photo.metadata.upright import as_stored
from kogao_core.photo.model import Photo, channels_of, is_same

# Lengths of a thumbnail's longer side, tried in this order, and JPEG quality.
_SMALL_PX, _SMALL_QUALITY = (512, 320, 160, 120), 80


def write(
    photo: Photo,
    pixels: Image,
    path: str | os.PathLike[str],
    *,
    force: bool = False,
    before: Callable[[Chunks], object] | None = None,
    quality: int | None = None,
) -> str:
    """Write new pixels with the photo's metadata. The file extension selects the format.

    - The file is written completely or not at all.
    - ICC profile, EXIF (with a new thumbnail), XMP, IPTC and resolution are preserved.
    - JPEG to JPEG preserves the orientation, the quantisation tables, the subsampling and, bit for
      bit, every block without changed pixels.
    - All other files are upright. A JPEG from another format has quality 95 and 4:4:4 subsampling.
    - Unchanged pixels in the source's format: the source file is copied byte for byte.

    Parameters
    ----------
    photo : Photo
        Source of the metadata.
    pixels : array of shape (H, W) or (H, W, C)
        uint8; uint16 for PNG and TIFF; float32 for TIFF.
    path : path
        ``.jpg``, ``.jpeg``, ``.png``, ``.tif``, ``.tiff``, ``.webp`` or ``.avif``.
    force : bool
        Overwrite an existing file, but never the photo itself.
    before : callable, optional
        Called with the new file content just before the file is replaced. The file may then be the
        photo itself; the callback must back it up.
    quality : int, optional
        Re-encode the whole picture. JPEG and WebP use this quality, 1 to 100; 0 uses the source's
        quality. 16-bit pixels are reduced to 8 bits if the format needs 8 bits.

    Returns
    -------
    str
        Notes in one line: conversions during reading, lost data, and the share of unchanged JPEG
        blocks. Empty without notes, for example after a byte copy.

    Raises
    ------
    RefusedOutput
        If the file exists and `force` isn't set, the file is the photo itself, or the format can't
        store these pixels.
    CannotWrite
        If the folder is missing or not writable, or the disk is full.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> photo = kogao.read(kogao.sample())
    >>> pixels = photo.pixels.copy()
    >>> pixels[:8, :8] = 0
    >>> kogao.write(photo, pixels, "marked.jpg")
    '100.0 % of the JPEG unchanged'
    >>> kogao.write(photo, pixels, "marked.png")
    ''
    >>> try:
    ...     kogao.write(photo, pixels, "marked.png")
    ... except kogao.CannotWrite as problem:
    ...     print(problem)
    marked.png exists; choose another name, or force=True to replace it
    """
    check_type(photo, Photo, "from kogao.read")
    check_image(pixels)
    path = Path(path)
    name = check_output(path, force=force)
    is_itself = os.path.exists(path) and photo.path.exists() and path.samefile(photo.path)
    if is_itself and before is None:
        raise RefusedOutput(
            "{path} is the photo itself; choose another name, or save in place", path=path
        )
    if not formats.BY_NAME[name].holds_hdr and name != photo.format:
        photo, pixels = profiles.tone_mapped(photo, pixels)
    if quality is not None and pixels.dtype == np.uint16 and bits_of(path) == 8:
        pixels = eight_bits(pixels)
    check_holds(path, pixels)
    form, is_same_format = formats.BY_NAME[name], name == photo.format and quality is None
    if not is_same_format:
        photo = dataclasses.replace(photo, companions=())
    if kinds.XMP not in form.kept and rating.has_record(photo.xmp or b""):
        raise RefusedOutput(
            "{format} can't hold the edit record; choose another format", format=form.title
        )

    def encoded(photo: Photo, part: Box | None) -> Chunks:
        try:
            return encode(photo, pixels, form, part, quality)
        except ValueError as error:
            raise CannotWrite(
                "{path} can't be encoded as {format} ({error}); write it as {other}",
                path=path,
                format=form.title,
                error=error,
                other=formats.exact_endings(pixels, form),
            ) from error

    try:
        if is_same_format and is_same(photo.pixels, pixels) and photo.is_as_read:
            pieces: Chunks = [photo.path.read_bytes()]
            note = ""
        else:
            keep = form.keep if is_same_format else None
            pieces, kept = (
                keep(photo, pixels, encoded, path) if keep else (encoded(photo, None), "")
            )
            note = _worth_knowing(photo, pixels, form, kept, is_export=quality is not None)
        if before is not None:
            before(pieces)
        # Check again just before the rename: another program may have created the file.
        atomic_write(pieces, path, lambda: check_output(path, force=force))
        return note
    except OSError as error:
        is_full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        raise CannotWrite(
            "{path} can't be written ({reason}); {remedy}",
            path=path,
            reason=system_reason(error),
            remedy=Text("choose another name")
            if isinstance(error, NotAFile)
            else Text("make room, or choose another drive")
            if is_full
            else Text("choose another folder or drive, or a shorter name"),
        ) from error


def check_output(path: str | os.PathLike[str], *, force: bool = False) -> str:
    """Check an output path. Return the name of the format, from the file extension.

    Raises RefusedOutput, CannotWrite.
    """
    path = Path(path)
    if os.path.isdir(path):
        raise RefusedOutput("{path} is a folder; name a file inside it", path=path)
    form = FORMATS.get(path.suffix.lower())
    if form is None:
        raise RefusedOutput(
            "{path} must end in one of {names}", path=path, names=", ".join(FORMATS)
        )
    if not path.parent.is_dir():
        raise CannotWrite("the folder {folder} doesn't exist; make it first", folder=path.parent)
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise CannotWrite(
            "the folder {folder} isn't writable; choose another one", folder=path.parent
        )
    try:
        check_target(path)
    except NotAFile as error:
        raise RefusedOutput(
            "{path} can't be replaced: {reason}; name another file",
            path=path,
            reason=system_reason(error),
        ) from None
    if os.path.exists(path) and not force:
        raise RefusedOutput(
            "{path} exists; choose another name, or force=True to replace it", path=path
        )
    return form


def bits_of(path: str | os.PathLike[str]) -> Literal[8, 16]:
    """Return the best bit depth for reading a raw photo that is saved to `path`."""
    form = FORMATS.get(Path(path).suffix.lower())
    return 16 if form is None or "uint16" in formats.BY_NAME[form].layouts else 8


def check_holds(path: str | os.PathLike[str], pixels: Image) -> None:
    """Check that the format of an output path can store these pixels. Raises RefusedOutput."""
    path = Path(path)
    form = formats.of(path)
    depth, longest = pixels.dtype.name, form.longest_side_px
    reason = ""
    if depth not in form.layouts:
        deep = (
            Text("32-bit float")
            if pixels.dtype == np.float32
            else Text("{bits}-bit", bits=8 * pixels.dtype.itemsize)
        )
        reason = Text("this {deep} photo", deep=deep)
    elif not form.holds_alpha(depth) and _shows_through(pixels):
        reason = Text("transparency")
    elif longest is not None and max(pixels.shape[:2]) > longest:
        reason = Text("more than {longest} px a side", longest=longest)
    if reason:
        other = formats.exact_endings(pixels, form)
        raise RefusedOutput(
            "{path}: {format} can't hold {reason}; write it as {other}",
            path=path,
            format=form.title,
            reason=reason,
            other=other,
        )


def _shows_through(pixels: Image) -> bool:
    return channels_of(pixels) in (2, 4) and bool((pixels[..., -1] != np.iinfo(np.uint8).max).any())


def _worth_knowing(
    photo: Photo, pixels: Image, form: FileFormat, kept: str, *, is_export: bool
) -> str:
    """Return notes about a changed photo: lost metadata, conversions and unchanged blocks."""
    blocks = {
        kinds.EXIF: photo.exif,
        kinds.XMP: photo.xmp,
        kinds.ICC: photo.icc_profile,
        kinds.IPTC: photo.photoshop,
        kinds.RESOLUTION: photo.dpi,
        kinds.ASPECT: photo.aspect,
    }
    extras = [*photo.extras, *(Extra(kind) for kind, block in blocks.items() if block)]
    along = {one.kind for one in photo.companions}
    notes = [*photo.notes, form.not_kept(photo, extras, along, is_export=is_export)]
    if kinds.VIDEO in along:
        notes.append(Text("the motion photo's video still shows the original face"))
    if photo.exif and not form.holds_exif(photo.exif):
        notes.append(
            Text(
                "the EXIF block is damaged, and {format} can't hold it as it is: it is left out",
                format=form.title,
            )
        )
    if photo.icc_profile and form.becomes_colour(pixels):
        notes.append(Text("grey became RGB, without its colour profile"))
    if pixels.dtype == np.uint16 and form.deep_bits < 16:
        notes.append(Text("stored with {bits} bits", bits=form.deep_bits))
    return Text.joined("; ", [*notes, _spread(photo, pixels), kept])


def _spread(photo: Photo, pixels: Image) -> str:
    """Return a note if resampling increased the number of NaN or infinite pixels."""
    if pixels.dtype != np.float32:
        return ""
    before, after = (
        np.count_nonzero(~np.isfinite(p).reshape(*p.shape[:2], -1).all(axis=2))
        for p in (photo.pixels, pixels)
    )
    if after <= before:
        return ""
    return Text(
        "pixels without a number (NaN or infinity) have spread from {before:,} to {after:,}",
        before=before,
        after=after,
    )


def encode(
    photo: Photo,
    pixels: Image,
    form: FileFormat,
    part: Box | None = None,
    quality: int | None = None,
) -> Chunks:
    """Encode new pixels with the photo's metadata. Return the file content.

    Only a format that stores the orientation, without `quality`, keeps the photo's orientation. All
    other files are upright. `part` selects a region of the pixels as stored.
    """
    if form.encode is None:
        raise ValueError(f"{form.title} is read only")
    carried = photo.carried if form.name == photo.format else ()
    if photo.jpeg is None:  # the colours were converted
        carried = tuple(one for one in carried if not jpeg_extras.is_colour(one))
    along = {one.kind: len(one.data) for one in photo.companions}
    if kinds.GAIN_MAP not in along:
        carried = tuple(one for one in carried if jpeg_extras.kind_of(one) is not kinds.GAIN_MAP)
    is_extended = any(jpeg_extras.kind_of(one) is kinds.XMP_EXTENSION for one in carried)
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
        packet = upright.turned_xmp(packet, turn)
        packet = references.without(packet, is_extended=is_extended, is_turned=turns, along=along)
        return references.adjusted(packet, along) if along else packet

    pixels = pixels[(part or Box.of(pixels)).slices]
    becomes_colour = form.becomes_colour(pixels)
    content = Content(
        photo,
        _coloured(pixels) if becomes_colour else np.ascontiguousarray(pixels),
        {
            "icc_profile": None if becomes_colour else photo.icc_profile,  # the profile is for grey
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
    """Return a JPEG thumbnail in the given orientation, no larger than `old` in bytes.

    Return b"" if no size fits or if `old` is no JPEG.
    """
    if not old.startswith(SOI):
        return b""
    for longest in _SMALL_PX:
        scale = min(1.0, longest / max(pixels.shape[:2]))
        size = [max(1, round(scale * side)) for side in pixels.shape[1::-1]]
        pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
        lying = as_stored(eight_bits(pixels), orientation)
        picture = Pillow.fromarray(np.ascontiguousarray(lying))
        with io.BytesIO() as out:
            picture.convert("RGB").save(out, "JPEG", quality=_SMALL_QUALITY, optimize=True)
            if out.tell() <= len(old):
                return out.getvalue()
    return b""


def _coloured(grey: Image) -> Image:
    """Convert grey to RGB, or grey with alpha to RGBA."""
    planes = grey.reshape(*grey.shape[:2], -1)
    return np.ascontiguousarray(planes[..., [0, 0, 0, 1][: 2 + planes.shape[2]]])
