"""Pixels and metadata of a photo as the bytes of a file."""

from __future__ import annotations

import dataclasses
import io
import struct
import textwrap
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from PIL import Image as Pillow
from PIL import PngImagePlugin

from kogao_core.geometry import Image
from kogao_core.photo import chunks, deep, jpeg_extras, metadata, photoshop, segments, stale, tiff
from kogao_core.photo.model import Format, Photo

_QUALITY: Final = 95
_EFFORT: Final = 50  # of lossless WebP: a quarter of the time of 95, and 0.1 % longer
_LOSSY: Final = ("JPEG", "WEBP", "HEIF")
_NO_DENSITY: Final = (1, 1, 0)  # JFIF 1.01, and no unit
_FULL_COLOUR: Final = 0  # Pillow's code for 4:4:4


def encode(photo: Photo, pixels: Image, form: Format) -> bytes:
    """Return a file with new pixels and the photo's metadata, telling that it is upright.

    Parameters
    ----------
    photo : Photo
        Where the metadata and the compression come from.
    pixels : array of shape (H, W) or (H, W, C)
        Upright, of a depth and layout that `form` holds.
    form : {"JPEG", "PNG", "TIFF", "WEBP"}
        What to write.
    """
    carried = photo.carried if form == photo.format else ()
    content = _holdable(_upright(photo, pixels, carried), form)
    resources = photo.photoshop and photoshop.without_stale(photo.photoshop)
    if form == "JPEG":
        more = (*carried, *segments.photoshop_segments(resources or b""))
        return segments.inserted(_jpeg(content, photo), more)
    if form == "PNG":
        shape = () if photo.aspect is None else (chunks.shape(photo.aspect),)
        return chunks.inserted(_png(content, resources), b"".join((*shape, *carried)))
    if form == "TIFF":
        written = deep.encode(content.pixels, ".tiff")
        return tiff.with_metadata(
            written, photoshop_resources=resources, aspect=photo.aspect, **content.blocks
        )
    del content.blocks["dpi"]  # WebP has no place for it, nor for Photoshop's resources
    lossless = _is_lossless(photo)
    quality = _EFFORT if lossless else _QUALITY
    return content.saved("WEBP", quality=quality, lossless=lossless, exact=True, method=4)


def _is_lossless(photo: Photo) -> bool:
    """Tell whether nothing was lost in the source, so that nothing may be lost now."""
    return photo.lossless_webp or photo.format not in _LOSSY


@dataclass(frozen=True)
class _Content:
    """Pixels to write and the metadata there is, by Pillow's names."""

    pixels: Image
    blocks: dict[str, Any]

    def saved(self, form: Format, **options: Any) -> bytes:
        known = {name: block for name, block in self.blocks.items() if block is not None}
        with io.BytesIO() as out:
            Pillow.fromarray(self.pixels).save(out, form, **known, **options)
            return out.getvalue()


def _upright(photo: Photo, pixels: Image, carried: tuple[bytes, ...]) -> _Content:
    height, width = pixels.shape[:2]
    xmp = photo.xmp and metadata.upright_xmp(photo.xmp, width, height)
    is_extended = any(map(jpeg_extras.is_extension, carried))
    return _Content(
        np.ascontiguousarray(pixels),
        {
            "icc_profile": photo.icc_profile,
            "exif": photo.exif and metadata.upright_exif(photo.exif, width, height),
            "xmp": xmp and stale.without(xmp, is_extended=is_extended),
            "dpi": photo.dpi,
        },
    )


def becomes_colour(pixels: Image, form: Format) -> bool:
    """Tell whether pixels are grey and the encoder knows no such grey."""
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    grey_alpha_is_known = form == "JPEG" or (form == "PNG" and pixels.dtype == np.uint8)
    return channels < 3 and not (grey_alpha_is_known if channels == 2 else form != "WEBP")


def _holdable(content: _Content, form: Format) -> _Content:
    """Turn grey into colour where the encoder knows no grey, and leave grey's profile behind."""
    pixels = content.pixels
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    if not becomes_colour(pixels, form):
        return content
    grey = pixels.reshape(*pixels.shape[:2], channels)
    coloured = grey[..., [0, 0, 0, 1][: 2 + channels]]
    return _Content(np.ascontiguousarray(coloured), {**content.blocks, "icc_profile": None})


def _jpeg(content: _Content, photo: Photo) -> bytes:
    content = dataclasses.replace(content, pixels=_without_alpha(content.pixels))
    coding = photo.jpeg
    if coding is None or not coding.tables:
        saved = content.saved("JPEG", quality=_QUALITY, subsampling=_FULL_COLOUR)
    else:
        saved = content.saved(
            "JPEG",
            qtables=[list(table) for table in coding.tables],
            subsampling=coding.subsampling,
            progressive=coding.progressive,
        )
    if coding is not None and coding.jfif:
        return segments.with_jfif(saved, coding.jfif)
    if photo.aspect is None:
        return saved
    return segments.with_jfif(saved, struct.pack(">BBBHH", *_NO_DENSITY, *photo.aspect))


def _without_alpha(pixels: Image) -> Image:
    if pixels.ndim == 2 or pixels.shape[2] == 3:
        return pixels
    return np.ascontiguousarray(pixels[..., :3] if pixels.shape[2] == 4 else pixels[..., 0])


def _png(content: _Content, resources: bytes | None) -> bytes:
    xmp = content.blocks.pop("xmp")
    text = PngImagePlugin.PngInfo()
    if resources:
        # PNG itself knows no IPTC: this is where ImageMagick and ExifTool look for it.
        lines = "\n".join(textwrap.wrap(resources.hex(), 72))
        text.add_text("Raw profile type iptc", f"\niptc\n{len(resources):8}\n{lines}\n", zip=True)
    if xmp is not None:
        text.add_itxt("XML:com.adobe.xmp", xmp.decode("utf-8", "replace"))
    if content.pixels.dtype == np.uint8:
        return content.saved("PNG", pnginfo=text)
    # Pillow can't write 16-bit colour: OpenCV writes the pixels, Pillow the chunks around them.
    carrier = _Content(np.zeros((1, 1), np.uint8), content.blocks).saved("PNG", pnginfo=text)
    written = deep.encode(content.pixels, ".png")
    return chunks.inserted(written, chunks.before_pixels(carrier))
