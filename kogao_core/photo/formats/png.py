"""PNG, of 8 and 16 bits."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from typing import IO, Final

import numpy as np
from PIL import PngImagePlugin

from kogao_core.base.atomic import Chunks
from kogao_core.base.geometry import Image
from kogao_core.base.threads import default_threads, parallel_in_order
from kogao_core.photo import profiles
from kogao_core.photo.formats.base import BLOCKS, OF_PRINTS, Content, FileFormat
from kogao_core.photo.metadata import kinds, trailers
from kogao_core.photo.metadata.kinds import Extra, Kind
from kogao_core.photo.model import Photo, channels_of

SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"
_IHDR_END: Final = 33
_OVERHEAD: Final = 12
_WHOLE_PROFILE: Final = b"Raw profile type icc\0"
_TEXT: Final = (b"tEXt", b"zTXt", b"iTXt")
# Texts with metadata blocks that are written separately.
_ELSEWHERE: Final = (b"XML:com.adobe.xmp\0", b"Raw profile type exif\0", b"Raw profile type iptc\0")
# Pillow refuses a PNG with a larger profile. A text holds the whole profile.
MOST_PROFILE_BYTES: Final = 1 << 20
# The picture, metadata blocks that are written separately, and Apple's index of the picture.
_PLAIN: Final = (
    *(b"IHDR", b"PLTE", b"tRNS", b"IDAT", b"IEND", b"iCCP", b"eXIf", b"pHYs", b"sRGB", b"iDOT"),
)
_COLOUR_NAMES: Final = (b"gAMA", b"cHRM", b"cICP", b"mDCV", b"cLLI")
_BACKGROUND, _TRUE = b"bKGD", (b"sBIT", b"sTER", b"sCAL")
# Chunk sizes in bytes, by number of channels.
_SIZES: Final = {b"sBIT": {1: 1, 2: 2, 3: 3, 4: 4}, _BACKGROUND: {1: 2, 2: 2, 3: 6, 4: 6}}
_SRGB_COLOURS: Final = (31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)
_KEPT: Final = (kinds.TEXTS, kinds.COLOURS, kinds.CHUNKS)
_MOST_BYTES: Final = 1 << 24
# Compression level. Pillow's default takes eight times as long and saves 10 %.
_LEVEL: Final = 1
_UP: Final = 2  # each line as its difference from the one above
_STRIP_BYTES: Final = 1 << 20
_COLOUR_TYPES: Final = {1: 0, 2: 4, 3: 2, 4: 6}
_RAW: Final = -zlib.MAX_WBITS  # no header and no checksum: strips have one of both together
_ZLIB_HEADER: Final = b"\x78\x01"  # a window of 32 KiB, the fastest level


def _encode(content: Content) -> Chunks:
    aspect = content.photo.aspect
    shape = () if aspect is None else (made(b"pHYs", struct.pack(">IIB", *aspect, 0)),)
    name = profiles.name_of(content.blocks["icc_profile"])
    named = () if name is None else (made(b"cICP", bytes([*name, 0, 1])),)
    own = [b"iCCP", *((b"pHYs",) if aspect or content.blocks["dpi"] else ())]
    own += [b"cICP"] if name else []
    kept = [one for one in content.carried if one[4:8] not in own]
    return [
        header(content.pixels),
        *shape,
        *named,
        *_profile(content, is_named=name is not None),
        *kept,
        _metadata(content),
        *packed(content.pixels),
    ]


def _profile(content: Content, *, is_named: bool) -> list[bytes]:
    """Return the chunk of the colour profile, with the profile name of the source."""
    profile = content.blocks.pop("icc_profile")
    stored = [one for one in content.carried if one[4:8] == b"iCCP"]
    if not profile or (stored and is_named):  # readers without cICP use the source's profile
        return stored if profile else []
    name = stored[0][8:].partition(b"\0")[0] if stored else b"ICC Profile"
    whole = []
    if len(profile) > MOST_PROFILE_BYTES:
        whole = [made(b"tEXt", _WHOLE_PROFILE + _as_text("icc", profile))]
        profile = profiles.shown_part(profile)
    is_small = len(profile) <= MOST_PROFILE_BYTES
    return whole + is_small * [made(b"iCCP", name + b"\0\0" + zlib.compress(profile))]


def _metadata(content: Content) -> bytes:
    """Encode the metadata blocks with Pillow. Return the chunks."""
    xmp, resources = content.blocks.pop("xmp"), content.resources
    text = PngImagePlugin.PngInfo()
    if resources:
        # PNG has no standard for IPTC. ImageMagick and ExifTool use this text.
        text.add_text("Raw profile type iptc", _as_text("iptc", resources).decode(), zip=True)
    if xmp is not None:
        text.add_itxt("XML:com.adobe.xmp", xmp.decode("utf-8", "replace"))
    empty = Content(content.photo, np.zeros((1, 1), np.uint8), content.blocks)
    return _before_pixels(empty.saved("PNG", pnginfo=text))


def _as_text(name: str, block: bytes) -> bytes:
    """Return a metadata block as ImageMagick's text."""
    lines = "\n".join(block[at : at + 36].hex() for at in range(0, len(block), 36))
    return f"\n{name}\n{len(block):8}\n{lines}\n".encode()


def _behind(file: IO[bytes]) -> Iterator[Extra]:
    data = file.read()
    return trailers.found(data, _end(data))


def chunks(file: IO[bytes]) -> Iterator[tuple[bytes, bytes]]:
    """Yield name and bytes of each valid chunk except pixel data. A damaged file ends early."""
    file.seek(len(SIGNATURE))
    while len(head := file.read(8)) == 8:
        size, name = int.from_bytes(head[:4], "big"), head[4:]
        if name == b"IDAT" or size > _MOST_BYTES:
            file.seek(size + 4, os.SEEK_CUR)
            continue
        body = file.read(size + 4)
        if len(body) < size + 4:
            return
        if zlib.crc32(name + body[:-4]) == int.from_bytes(body[-4:], "big"):
            yield name, head + body


def carried(file: IO[bytes], channels: int) -> tuple[bytes, ...]:
    """Return the chunks that a changed photo with `channels` channels preserves unchanged.

    These are texts, colour definitions and chunks that are still valid or marked as safe to copy.
    """
    found = list(chunks(file))
    profiled = any(name == b"iCCP" for name, _ in found)
    depth = _file_depth(file)
    return tuple(
        chunk
        for name, chunk in found
        if (name != b"sRGB" or not profiled)
        and (name in (b"sRGB", b"iCCP", b"pHYs") or _kind(name, chunk, channels, depth) in _KEPT)
    )


def without_animation(data: bytes) -> bytes:
    """Return a PNG file without the chunk that starts an animation: decoders show the still."""
    at = data.find(b"acTL", 0, max(0, data.find(b"IDAT"))) - 4
    return data if at < 0 else data[:at] + data[at + _OVERHEAD + 8 :]


def colour_name(file: IO[bytes]) -> profiles.Name | None:
    """Return the CICP name of the colours; None if missing, or not of RGB in full range."""
    body = next((chunk[8:-4] for name, chunk in chunks(file) if name == b"cICP"), b"")
    return (body[0], body[1]) if body[2:] == b"\0\1" else None


def is_colour(chunk: bytes) -> bool:
    """Return True if a chunk defines the colours or contains a profile."""
    return chunk[4:8] in (*_COLOUR_NAMES, b"sRGB", b"iCCP")


def _inside(photo: Photo, file: IO[bytes]) -> Iterator[Extra]:
    depth = _file_depth(file)
    all_of_it = list(chunks(file))
    is_known = photo.icc_profile is not None or any(name == b"sRGB" for name, _ in all_of_it)
    found = []
    for name, chunk in all_of_it:
        kind = _kind(name, chunk, photo.channels, depth)
        is_overruled = is_known and name not in (b"mDCV", b"cLLI")
        if kind is not kinds.COLOURS or not (is_overruled or _says_srgb(name, chunk)):
            found.append((kind, name.decode("latin-1")))
    return kinds.grouped("PNG", found)


def _end(data: bytes) -> int:
    """Return the end offset of the last PNG chunk."""
    at = len(SIGNATURE)
    while at + _OVERHEAD <= len(data):
        name, at = data[at + 4 : at + 8], at + _OVERHEAD + int.from_bytes(data[at : at + 4], "big")
        if name == b"IEND":
            return min(at, len(data))
    return len(data)


def _file_depth(file: IO[bytes]) -> int:
    """Return the bits per channel, or per index of a palette."""
    file.seek(24)
    return int.from_bytes(file.read(1), "big")


def _kind(name: bytes, chunk: bytes, channels: int, depth: int) -> Kind | None:
    """Return the kind of a chunk. None: the picture, or metadata that is written separately."""
    if name in _TEXT:
        if chunk[8:].startswith(_WHOLE_PROFILE) and len(chunk) > 2 * MOST_PROFILE_BYTES:
            return None
        return None if chunk[8:].startswith(_ELSEWHERE) else kinds.TEXTS
    if name in _COLOUR_NAMES:
        return kinds.COLOURS
    known = {b"caBX": kinds.CREDENTIALS}
    known |= dict.fromkeys((b"acTL", b"fcTL", b"fdAT"), kinds.FURTHER)
    if name in known or name in _PLAIN:
        return known.get(name)
    fits = _SIZES.get(name, {}).get(channels) in (None, len(chunk) - _OVERHEAD)
    if name == _BACKGROUND:  # shallower pixels are widened to 8 bits
        return kinds.CHUNKS if fits and depth >= 8 else kinds.UNSAFE_CHUNKS
    is_safe = name in _TRUE or name[3:].islower()
    return kinds.CHUNKS if fits and is_safe else kinds.UNSAFE_CHUNKS


def _says_srgb(name: bytes, chunk: bytes) -> bool:
    """Return True if gamma or chromaticities are sRGB's, the default of all readers."""
    body = chunk[8:-4]
    numbers = struct.unpack(f">{len(body) // 4}I", body[: len(body) // 4 * 4])
    known = ((b"gAMA", (45455,)), (b"cHRM", _SRGB_COLOURS), (b"cICP", (0x010D0001,)))
    return (name, numbers) in known


def made(name: bytes, body: bytes) -> bytes:
    """Return a chunk: length, name, body and checksum."""
    checksum = zlib.crc32(body, zlib.crc32(name))
    return b"".join([struct.pack(">I", len(body)), name, body, struct.pack(">I", checksum)])


def _before_pixels(png: bytes) -> bytes:
    """Return the chunks between the header and the pixels of a PNG file."""
    end = _IHDR_END
    while png[end + 4 : end + 8] != b"IDAT":
        end += _OVERHEAD + int.from_bytes(png[end : end + 4], "big")
    return png[_IHDR_END:end]


def header(pixels: Image) -> bytes:
    """Return the signature and the header chunk for an array of pixels."""
    height, width = pixels.shape[:2]
    colours = _COLOUR_TYPES[channels_of(pixels)]
    return SIGNATURE + made(
        b"IHDR", struct.pack(">IIBBBBB", width, height, 8 * pixels.itemsize, colours, 0, 0, 0)
    )


def packed(pixels: Image) -> list[bytes]:
    """Compress pixels in parallel. Return the pixel chunks and the end chunk.

    The result doesn't depend on the number of threads.
    """
    lines = pixels.reshape(len(pixels), -1)
    rows = max(1, _STRIP_BYTES // (lines.shape[1] * lines.itemsize))
    tops = range(0, len(lines), rows)
    checksum, pieces = 1, list[bytes]()

    def take(_: int, strip: tuple[bytes, Image]) -> None:
        nonlocal checksum
        piece, filtered = strip
        checksum = zlib.adler32(filtered.data, checksum)
        pieces.append(piece)

    parallel_in_order(tops, lambda top: _packed(lines, top, rows), take, default_threads())
    return [*pieces, _idat(struct.pack(">I", checksum)), made(b"IEND", b"")]


def _packed(lines: Image, top: int, rows: int) -> tuple[bytes, Image]:
    """Return the chunk of a strip, and the bytes that were compressed."""
    filtered = _filtered(lines, top, min(len(lines), top + rows))
    packer = zlib.compressobj(_LEVEL, zlib.DEFLATED, _RAW)
    start = b"" if top else _ZLIB_HEADER
    end = zlib.Z_FINISH if top + rows >= len(lines) else zlib.Z_SYNC_FLUSH
    piece = _idat(start + packer.compress(filtered.data) + packer.flush(end))
    return piece, filtered


def _idat(body: bytes) -> bytes:
    return made(b"IDAT", body)


def _filtered(lines: Image, top: int, bottom: int) -> Image:
    """Return PNG lines: filter type, then big-endian bytes minus the bytes of the line above."""
    stored = lines[max(0, top - 1) : bottom]
    data = np.ascontiguousarray(stored, stored.dtype.newbyteorder(">")).view(np.uint8)
    filtered = np.empty((bottom - top, 1 + data.shape[1]), np.uint8)
    filtered[:, 0] = _UP
    if top == 0:
        filtered[0, 1:] = data[0]
    np.subtract(data[1:], data[:-1], out=filtered[len(filtered) - len(data) + 1 :, 1:])
    return filtered


PNG: Final = FileFormat(
    name="PNG",
    title="PNG",
    suffixes=(".png",),
    is_lossless=True,
    encode=_encode,
    layouts={"uint8": (1, 2, 3, 4), "uint16": (1, 2, 3, 4)},
    holds_hdr=True,
    kept=BLOCKS | OF_PRINTS | {kinds.TEXTS, kinds.COLOURS, kinds.CHUNKS},
    inside=_inside,
    behind=_behind,
)
