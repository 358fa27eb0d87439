"""TIFF, of 8 and 16 bits and of 32-bit floating-point numbers."""

from __future__ import annotations

import io
import itertools
import os
from collections.abc import Iterator, Sequence
from math import prod
from typing import IO, Any, Final

import cv2
import numpy as np
from PIL import Image as Pillow
from PIL import TiffImagePlugin, TiffTags, UnidentifiedImageError
from PIL.ExifTags import Base as Tag

from kogao_core.base.atomic import Chunks
from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.base.threads import parallel_map
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats import colour, common
from kogao_core.photo.formats.base import OF_PRINTS, Content, FileFormat, Source
from kogao_core.photo.metadata import kinds, photoshop, tiff, tiff_extras, trailers
from kogao_core.photo.metadata.kinds import Extra
from kogao_core.photo.metadata.upright import turn_upright
from kogao_core.photo.model import Photo, channels_of

_UNCOMPRESSED, _LZW = 1, 5
# Readers differ: darktable and libvips assume linear values, Java assumes sRGB. Values from a
# division by 255 are sRGB.
_SEEN: Final = Text(
    "32-bit numbers without a colour profile are seen as sRGB: linear ones look dark, and are "
    "written right all the same"
)
_DEPTHS: Final[dict[tuple[int, int], np.dtype[Any]]] = {
    (16, 1): np.dtype(np.uint16),
    (32, 3): np.dtype(np.float32),
}
_FORMATS: Final = {"u": 1, "f": 3}
_HEADER_BYTES: Final = 8
_GREY_ALPHA, _RGB_ALPHA, _STRAIGHT = 2, 4, 2
_NO_UNIT, _PER_INCH = 1, 2
_BLACK_IS_ZERO, _RGB, _INTERLEAVED = 1, 2, 1
_USUAL_STRIP: Final = 8192  # bytes, as TIFF advises
_BAND_BYTES: Final = 1 << 22  # of pixels that are compressed in one call


def _decode(source: Source) -> Photo:
    file, path = source.file, source.path
    tags = tiff.TiffTags.read(file)
    source.check(tags[Tag.ImageWidth], tags[Tag.ImageLength], tags.pixel_bytes)
    tags.check_whole(os.fstat(file.fileno()).st_size)
    notes: tuple[str, ...] = ()
    profile = tags.icc_profile
    # Both decoders return upright pixels. OpenCV accepts damaged 8-bit strips, so Pillow decodes
    # 8 bits.
    tags.check()
    if tags.is_deep:
        plain = read_plain(file, tags)
        if plain is None and tags[Tag.SamplesPerPixel] == _GREY_ALPHA:  # OpenCV can't decode it
            raise UnreadablePhoto(tiff.RARE)
        pixels = tags.meant(_unpacked(source, tags) if plain is None else plain)
        if pixels.dtype == np.float32 and profile is None:
            notes = (*notes, _SEEN)
    else:
        file.seek(0)
        try:
            with Pillow.open(file, formats=["TIFF"]) as image:
                image.load()
                pixels, profile, notes = colour.to_array(image, tags[Tag.BitsPerSample])
        except UnidentifiedImageError:
            raise UnreadablePhoto(tiff.RARE) from None
        notes = notes or tags.converted
    is_converted = any(note.startswith(colour.CONVERTED) for note in notes)
    if tags.is_inverted:
        notes = (*notes, Text("grey values are stored with 0 as black instead of white"))
    if tags.has_reversed_bits:
        more = Text("the bits of each byte are stored in the usual order (FillOrder 1)")
        notes = (*notes, more)
    dpi, shape = tags.density()
    return Photo(
        np.ascontiguousarray(pixels),
        path,
        "TIFF",
        icc_profile=profile,
        exif=tags.exif,
        xmp=tags.xmp,
        dpi=common.dpi(dpi),
        aspect=common.aspect(shape),
        orientation=tags.orientation,
        tiff_compression=tags[Tag.Compression],
        photoshop=tags.photoshop,
        notes=notes,
        carried=tuple(filter(None, [tags.kept(is_converted=is_converted)])),
    )


def _encode(content: Content) -> Chunks:
    photo, blocks = content.photo, content.blocks
    number = photo.tiff_compression
    if number == _UNCOMPRESSED or channels_of(content.pixels) == _GREY_ALPHA:
        directory, *stored = laid_out(content.pixels)
    else:
        how = (cv2.IMWRITE_TIFF_COMPRESSION, number if number in tiff.LOSSLESS else _LZW)
        directory, stored = _packed(content.pixels, how)
    if channels_of(content.pixels) in (_GREY_ALPHA, _RGB_ALPHA):
        directory[Tag.ExtraSamples] = _STRAIGHT
    density = blocks["dpi"] or photo.aspect
    if density is not None:
        directory[Tag.XResolution], directory[Tag.YResolution] = density
        directory[Tag.ResolutionUnit] = _PER_INCH if blocks["dpi"] else _NO_UNIT
    iptc = photoshop.iptc_of(content.resources or b"")
    is_iptc_only = iptc is not None and content.resources == photoshop.with_iptc(iptc)
    found = {
        Tag.InterColorProfile: blocks["icc_profile"],
        Tag.XMLPacket: blocks["xmp"],
        Tag.ImageResources: None if is_iptc_only else content.resources,
        Tag.IPTCNAA: iptc,
    }
    for tag, block in found.items():
        if block:
            directory[tag] = block
    for rare in map(tiff.directory_of, content.carried):
        for name, value in rare.items():
            directory.tagtype[name], directory[name] = rare.tagtype[name], tiff.as_read(value)
    for name, value in tiff.entries_of(blocks["exif"]) or ():
        if density is None or name not in tiff.DENSITY:
            directory[name] = value
    with io.BytesIO() as out:
        directory.save(out)  # adds its length to the strip offsets
        return [out.getvalue(), *stored]


def _inside(photo: Photo, file: IO[bytes]) -> Iterator[Extra]:
    file.seek(0)
    kept = tiff.directory_of(photo.carried[0]) if photo.carried else ()
    tags, small = tiff.TiffTags.read(file), tiff_extras.has_only_thumbnails(file)
    return tiff_extras.found(tags, photo.channels, kept, only_thumbnails=small)


def _behind(file: IO[bytes]) -> Iterator[Extra]:
    end = tiff_extras.end(file)
    if end == file.seek(0, os.SEEK_END):
        return iter(())  # as nearly always, and pixels may be large
    file.seek(0)
    return trailers.found(file.read(), end)


TIFF: Final = FileFormat(
    name="TIFF",
    title="TIFF",
    suffixes=(".tif", ".tiff"),
    is_lossless=True,
    encode=_encode,
    layouts=dict.fromkeys(("uint8", "uint16", "float32"), (1, 2, 3, 4)),
    kept=OF_PRINTS | {kinds.EXIF, kinds.XMP, kinds.ICC, kinds.TIFF_TAGS},
    moved=frozenset({kinds.MAKER_NOTE, kinds.MOVED_NOTE}),
    recognises=tiff.is_tiff,
    decode=_decode,
    inside=_inside,
    behind=_behind,
    note=kinds.MOVED_NOTE,
    holds_exif=lambda block: tiff.entries_of(block) is not None,
)


def _unpacked(source: Source, tags: tiff.TiffTags) -> Image:
    """Decode deep pixels, upright."""
    pixels = np.empty(_shape(tags), _DEPTHS[tags.depth])
    is_filled = tags.orientation == 1 and colour.filled_deep(pixels, source.file)
    return pixels if is_filled else colour.decoded_deep(source.data())


def _shape(tags: tiff.TiffTags) -> tuple[int, ...]:
    samples = tags[Tag.SamplesPerPixel]
    return (tags[Tag.ImageLength], tags[Tag.ImageWidth], samples)[: 2 if samples == 1 else 3]


def read_plain(file: IO[bytes], tags: tiff.TiffTags) -> Image | None:
    """Read deep pixels, upright, if the file stores them uncompressed and contiguous.

    Result: uint16 or float32, (H, W) or (H, W, 2..4); None if a decoder is necessary.
    """
    bits, formats = (tiff.numbers(tags.tags, tag) for tag in (Tag.BitsPerSample, Tag.SampleFormat))
    depth, samples = _DEPTHS.get(tags.depth), tags[Tag.SamplesPerPixel]
    is_array = (
        tags[Tag.Compression] == _UNCOMPRESSED
        and not tags.has_reversed_bits
        and Tag.TileWidth not in tags.tags
        and bits == bits[:1] * samples
        and formats in ((), formats[:1] * samples)
    )
    if depth is None or not is_array:
        return None
    shape = _shape(tags)
    start = _start(tags, shape[0], prod(shape[1:]) * depth.itemsize)
    if start is None:
        return None
    file.seek(0)
    stored = depth.newbyteorder(">" if file.read(2) == b"MM" else "<")
    file.seek(start)
    pixels = np.fromfile(file, stored, prod(shape)).astype(depth, copy=False)
    return turn_upright(pixels.reshape(shape), tags.orientation)


def _start(tags: tiff.TiffTags, height: int, row_bytes: int) -> int | None:
    """Return where the pixels start, if one strip follows the other."""
    starts, lengths = (
        np.array(tiff.numbers(tags.tags, tag), np.int64)
        for tag in (Tag.StripOffsets, Tag.StripByteCounts)
    )
    rows = min(tags[Tag.RowsPerStrip] or height, height)
    wanted = np.diff([*range(0, height, rows), height]) * row_bytes
    is_whole = np.array_equal(lengths, wanted) and np.array_equal(np.diff(starts), lengths[:-1])
    return int(starts[0]) if is_whole and len(starts) == len(lengths) else None


def _packed(
    pixels: Image, how: Sequence[int]
) -> tuple[TiffImagePlugin.ImageFileDirectory_v2, list[memoryview]]:
    """Compress pixels in parallel. Return the directory, as of one call of OpenCV, and the data."""
    rows = max(1, _USUAL_STRIP // pixels[0].nbytes)
    band = rows * max(1, _BAND_BYTES // (rows * pixels[0].nbytes))

    def packed(top: int) -> tuple[TiffImagePlugin.ImageFileDirectory_v2, memoryview]:
        return _taken_apart(colour.encoded_deep(pixels[top : top + band], how))

    bands = parallel_map(packed, range(0, len(pixels), band))
    directory, lengths = bands[0][0], [n for one, _ in bands for n in one[Tag.StripByteCounts]]
    filling = bytes(sum(lengths) % 2)  # as before a directory
    starts = tuple(itertools.accumulate(lengths[:-1], initial=0))
    directory[Tag.ImageLength] = len(pixels)
    directory[Tag.StripOffsets], directory[Tag.StripByteCounts] = starts, tuple(lengths)
    return directory, [*(data for _, data in bands), memoryview(filling)]


def _taken_apart(written: bytes) -> tuple[TiffImagePlugin.ImageFileDirectory_v2, memoryview]:
    """Split a file by OpenCV into the directory and the pixels.

    The pixels lie between header and directory. Strip offsets then start at the first pixel.
    """
    directory = tiff.directory_of(written)
    dict(directory)  # load all entries: `save` skips entries that were not loaded
    starts, lengths = directory[Tag.StripOffsets], directory[Tag.StripByteCounts]
    directory[Tag.StripOffsets] = tuple(offset - _HEADER_BYTES for offset in starts)
    return directory, memoryview(written)[_HEADER_BYTES : starts[-1] + lengths[-1]]


def laid_out(pixels: Image) -> tuple[TiffImagePlugin.ImageFileDirectory_v2, memoryview]:
    """Return the directory and the pixel bytes of an uncompressed file.

    The directory is like that of libtiff, with strip offsets from the first pixel. The bytes are a
    view of `pixels` on little-endian machines.
    """
    height, width = pixels.shape[:2]
    samples = channels_of(pixels)
    row_bytes = width * samples * pixels.itemsize
    rows = min(height, max(1, _USUAL_STRIP // row_bytes))
    starts = tuple(range(0, height * row_bytes, rows * row_bytes))
    lengths = tuple(min(rows * row_bytes, height * row_bytes - start) for start in starts)
    directory = TiffImagePlugin.ImageFileDirectory_v2()
    sizes = {
        Tag.ImageWidth: (width,),
        Tag.ImageLength: (height,),
        Tag.RowsPerStrip: (rows,),
        Tag.StripByteCounts: lengths,
    }
    for tag, values in sizes.items():
        directory.tagtype[tag] = TiffTags.SHORT if max(values) <= 0xFFFF else TiffTags.LONG
        directory[tag] = values
    directory[Tag.BitsPerSample] = (8 * pixels.itemsize,) * samples
    directory[Tag.SampleFormat] = (_FORMATS[pixels.dtype.kind],) * samples
    directory[Tag.Compression], directory[Tag.PlanarConfiguration] = _UNCOMPRESSED, _INTERLEAVED
    directory[Tag.PhotometricInterpretation] = _RGB if samples > _GREY_ALPHA else _BLACK_IS_ZERO
    directory[Tag.SamplesPerPixel] = samples
    directory[Tag.StripOffsets] = starts
    stored = np.ascontiguousarray(pixels, pixels.dtype.newbyteorder("<"))
    return directory, stored.reshape(-1).view(np.uint8).data
