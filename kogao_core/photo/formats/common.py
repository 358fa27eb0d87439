"""Decode the formats that Pillow recognises."""

from __future__ import annotations

import io
import math
import os
import struct
from contextlib import suppress
from fractions import Fraction
from typing import IO, Any, Final

from PIL import Image as Pillow
from PIL import JpegImagePlugin, UnidentifiedImageError
from PIL.ExifTags import Base as Tag

from kogao_core.base.geometry import Image
from kogao_core.base.language import BadValue, Text
from kogao_core.photo import profiles
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats import colour, png, webp
from kogao_core.photo.formats.base import Source
from kogao_core.photo.jpeg import decoding, segments
from kogao_core.photo.metadata import jpeg_extras, photoshop, upright
from kogao_core.photo.metadata.upright import turn_upright
from kogao_core.photo.model import JpegCoding, Photo, channels_of

_USUAL, _DEEP = 8, 16  # bits of a channel
_HEAD_BYTES = 16  # bytes that Pillow needs to recognise a format
_FINEST, _MOST = 1000, 65535  # largest denominator and numerator (limit of JFIF) of a pixel ratio
_FRAMES: Final = (
    *(*range(0xC0, 0xC4), *range(0xC5, 0xC8), *range(0xC9, 0xCC), *range(0xCD, 0xD0)),
    0xF7,  # JPEG-LS
)
# Baseline, extended, progressive, lossless; then the first and third coded arithmetically.
_KNOWN_FRAMES: Final = (*range(0xC0, 0xC4), 0xC9, 0xCA)
_RARE: Final = Text(
    "is a JPEG of a rare kind (hierarchical, or deeper than 8 bits); "
    "save it as an ordinary JPEG or as PNG first"
)


def decode(source: Source, names: tuple[str, ...]) -> Photo:
    """Decode a file in one of the formats `names`. Raises UnreadablePhoto."""
    file = source.file
    decoding.check_segments(file)
    try:
        opened = Pillow.open(file, formats=names)
    except UnidentifiedImageError:
        if _is_rare_jpeg(file):
            raise UnreadablePhoto(_RARE) from None
        short = segments.short_jfif(file)
        if not short:
            _check_damage(file, names)
            raise
        opened = Pillow.open(io.BytesIO(source.data().replace(short, b"", 1)), formats=names)
    with opened as image:
        bits, is_grey = colour.png_layout(image, file) or (_USUAL, False)
        source.check(*image.size, len(image.getbands()) * max(1, bits // _USUAL))
        jpeg = jpeg_coding(image)
        notes: tuple[str, ...] = ()
        sound = None
        if bits == _DEEP:
            colour.verify_png(file)
        elif jpeg is not None and decoding.check(file):
            sound = decoding.pixels(file, image.size, image.mode)
        decoded, damage = (image, ()) if sound is not None else _decoded(image, source)
        _settle_profile(decoded, file)
        if sound is not None:
            pixels = sound
        elif bits == _DEEP:
            pixels = _deep_png(image, source, is_grey=is_grey)
        else:
            pixels, image.info["icc_profile"], notes = colour.to_array(decoded, bits)
        if image.format == "PNG" and image.mode != "P" and "transparency" in image.info:
            notes = (*notes, Text("the transparent colour became an alpha channel"))
        metadata = _blocks(image, file, pixels)
        if image.format == "AVIF" and metadata["xmp"]:  # only the boxes of the file turn it
            metadata["xmp"] = upright.oriented_xmp(metadata["xmp"])
        turn = upright.orientation(metadata["exif"], metadata["xmp"])
        return Photo(
            turn_upright(pixels, turn),
            source.path,
            # MPO: a JPEG followed by a depth or gain map, as written by phones.
            "JPEG" if jpeg is not None else next(name for name in names if name == image.format),
            **metadata,
            **_density(image),
            orientation=turn,
            jpeg=jpeg if not notes else None,
            lossless_webp=webp.is_lossless(file),
            notes=(*damage, *notes),
        )


def _check_damage(file: IO[bytes], names: tuple[str, ...]) -> None:
    """Raise ValueError if an unidentified file starts like one of the formats."""
    file.seek(0)
    head = file.read(_HEAD_BYTES)
    accepts = (Pillow.OPEN[name][1] for name in names)
    if any(accept is not None and accept(head) is True for accept in accepts):
        raise BadValue("its headers are damaged")


def _deep_png(image: Pillow.Image, source: Source, *, is_grey: bool) -> Image:
    """Return the pixels of a 16-bit PNG file."""
    pixels = colour.decoded_deep(png.without_animation(source.data()))
    if pixels.ndim == 2 and "transparency" in image.info:
        return colour.with_alpha(pixels, image.info["transparency"])
    return pixels[..., [0, 3]] if is_grey and channels_of(pixels) == 4 else pixels


def _decoded(image: Pillow.Image, source: Source) -> tuple[Pillow.Image, tuple[str, ...]]:
    """Decode an open picture. Return the picture, with a note if a JPEG lacks the end marker."""
    if isinstance(image, JpegImagePlugin.JpegImageFile):
        # Decode in one step: after each block of 64 KiB, Pillow would wait for the GIL.
        image.decodermaxblock = os.fstat(source.file.fileno()).st_size
    try:
        image.load()  # PNG metadata may follow the pixels, so even where OpenCV decodes them
    except OSError:
        if not isinstance(image, JpegImagePlugin.JpegImageFile):
            raise
        if _is_rare_jpeg(source.file):
            raise UnreadablePhoto(_RARE) from None
        whole = decoding.without_end(source.data())
        if whole is None:
            raise
        return whole, (Text("the file is slightly damaged: its end marker is missing"),)
    return image, ()


def jpeg_coding(image: Pillow.Image) -> JpegCoding | None:
    """Return the compression settings of a JPEG file; None for other formats."""
    if not isinstance(image, JpegImagePlugin.JpegImageFile):
        return None
    tables = tuple(tuple(image.quantization[key]) for key in sorted(image.quantization))
    # -1 is grey or a subsampling that Pillow can't write: use 4:4:4 to preserve the colours.
    subsampling = max(0, JpegImagePlugin.get_sampling(image))
    return JpegCoding(tables, subsampling, bool(image.info.get("progressive")), _jfif(image))


def _jfif(image: Pillow.Image) -> bytes:
    info = image.info
    if "jfif_unit" not in info:
        return b""
    return struct.pack(">BBBHH", *info["jfif_version"], info["jfif_unit"], *info["jfif_density"])


def _settle_profile(image: Pillow.Image, file: IO[bytes]) -> None:
    """Use the first complete colour profile of a JPEG. Pillow drops both of two profiles."""
    if isinstance(image, JpegImagePlugin.JpegImageFile):
        whole, _ = segments.profiles(file)
        parts = (one[segments.PROFILE_AT :] for one in whole[0]) if whole else ()
        image.info["icc_profile"] = b"".join(parts) or None


def _is_rare_jpeg(file: IO[bytes]) -> bool:
    """Return True if libjpeg can't decode this type of JPEG file."""
    return any(
        code in _FRAMES and (code not in _KNOWN_FRAMES or segment[4:5] != b"\x08")
        for code, segment in segments.segments(file)
    )


def _blocks(image: Pillow.Image, file: IO[bytes], pixels: Image) -> dict[str, Any]:
    """Return the metadata blocks of an open file, by their names in `Photo`."""
    found: dict[str, Any] = {"icc_profile": image.info.get("icc_profile") or None}
    if isinstance(image, JpegImagePlugin.JpegImageFile):
        return found | {
            "exif": jpeg_extras.exif(file),
            "xmp": jpeg_extras.packet(file),
            "photoshop": segments.photoshop(file),
            "carried": jpeg_extras.carried(file, is_grey=image.mode == "L"),
        }
    exif, xmp = image.info.get("exif") or _raw_profile(image, "exif"), image.info.get("xmp")
    found["exif"] = exif and upright.PREFIX + exif.removeprefix(upright.PREFIX)
    found["xmp"] = (xmp.encode() if isinstance(xmp, str) else xmp) or None
    if image.format == "PNG":
        resources = _raw_profile(image, "iptc") or b""
        is_bare = resources.startswith(photoshop.IPTC_START)
        found["photoshop"] = (photoshop.with_iptc(resources) if is_bare else resources) or None
        whole = _raw_profile(image, "icc")
        if whole and len(whole) > png.MOST_PROFILE_BYTES:
            found["icc_profile"] = whole
        if (name := png.colour_name(file)) is not None:  # overrules a profile
            with suppress(KeyError):
                found["icc_profile"] = profiles.of_name(name, pixels)
        found["carried"] = png.carried(file, channels_of(pixels))
    elif image.format == "WEBP":
        found["carried"] = webp.carried(file)
    return found


def _raw_profile(image: Pillow.Image, name: str) -> bytes | None:
    """Return a metadata block stored by ImageMagick as PNG text, or None."""
    text = image.info.get(f"Raw profile type {name}")
    try:
        return bytes.fromhex("".join(text.split("\n")[3:])) if isinstance(text, str) else None
    except ValueError:
        return None  # skip a damaged block


def _density(image: Pillow.Image) -> dict[str, Any]:
    """Return the resolution or the pixel ratio, by their names in `Photo`."""
    ratio = image.info.get("aspect")
    if image.info.get("jfif_unit") == 0:
        ratio = image.info["jfif_density"]
    if (shape := aspect(ratio)) is not None:
        return {"aspect": shape}
    return {} if _is_guessed(image) else {"dpi": dpi(image.info.get("dpi"))}


def _is_guessed(image: Pillow.Image) -> bool:
    """Return True if a JPEG has no resolution and Pillow reports the default of 72 dpi."""
    if not isinstance(image, JpegImagePlugin.JpegImageFile):
        return False
    if image.info.get("jfif_unit") in (1, 2):
        return False
    try:
        return not {Tag.XResolution, Tag.ResolutionUnit} <= image.getexif().keys()
    except (OSError, SyntaxError, ValueError, struct.error):  # a damaged block
        return True


def aspect(value: Any) -> tuple[int, int] | None:
    """Return the pixel density ratio (x, y) as small integers. None for square pixels.

    Extreme ratios are treated as damage: None.
    """
    try:
        x, y = (float(part) for part in value)
        shape = Fraction(x / y).limit_denominator(_FINEST)
    except (TypeError, ValueError, OverflowError, ZeroDivisionError):
        return None
    known = 0 < shape != 1 and shape.numerator <= _MOST
    return (shape.numerator, shape.denominator) if known else None


def dpi(value: Any) -> tuple[float, float] | None:
    """Return a resolution as (x, y) in dots per inch. None unless both numbers are positive."""
    try:
        x, y = (float(part) for part in value)
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    return (x, y) if 0 < x < math.inf and 0 < y < math.inf else None
