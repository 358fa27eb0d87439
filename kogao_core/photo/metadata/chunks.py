"""The chunks of a PNG file beside its pixels."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from typing import IO, Final

from kogao_core.base.language import Text
from kogao_core.photo.metadata import kinds
from kogao_core.photo.metadata.kinds import Extra, Kind

SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"
_IHDR_END: Final = 33
_OVERHEAD: Final = 12
_DEPTH_AT: Final = 24
_COLOUR: Final = (b"gAMA", b"cHRM", b"sRGB", b"cICP", b"mDCV", b"cLLI")
_TEXT: Final = (b"tEXt", b"zTXt", b"iTXt")
# Texts that hold blocks with a way of their own.
_ELSEWHERE: Final = (
    b"XML:com.adobe.xmp\0",
    b"Raw profile type exif\0",
    b"Raw profile type iptc\0",
)
# The picture itself, blocks with a way of their own, and Apple's index of the former.
_PLAIN: Final = (
    *(b"IHDR", b"PLTE", b"tRNS", b"IDAT", b"IEND", b"iCCP", b"eXIf", b"pHYs", b"sRGB", b"iDOT"),
)
_FRAMES: Final = (b"acTL", b"fcTL", b"fdAT")
_BACKGROUND, _TRUE = b"bKGD", (b"sBIT", b"sTER", b"sCAL")
_CREDENTIALS: Final = b"caBX"
_COPY_BIT: Final = 0x20
# Bytes that say a significant depth or a background, by the channels they are for.
_SIZES: Final = {b"sBIT": {1: 1, 2: 2, 3: 3, 4: 4}, _BACKGROUND: {1: 2, 2: 2, 3: 6, 4: 6}}
_SRGB_GAMMA: Final = 45455
_SRGB_COLOURS: Final = (31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)
_KEPT: Final = (kinds.TEXTS, kinds.COLOURS, kinds.CHUNKS)
_MOST_BYTES: Final = 1 << 24


def chunks(file: IO[bytes]) -> Iterator[tuple[bytes, bytes]]:
    """Yield name and bytes of each sound chunk but those of pixels; a damaged file ends early."""
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
    """Return chunks that a changed photo of so many channels keeps as they are.

    These are texts, what colours mean, and what stays true or is marked as safe to copy.
    """
    found = list(chunks(file))
    profiled = any(name == b"iCCP" for name, _ in found)
    depth = _file_depth(file)
    return tuple(
        chunk
        for name, chunk in found
        if (name != b"sRGB" or not profiled)
        and (name == b"sRGB" or _kind(name, chunk, channels, depth) in _KEPT)
    )


def found(file: IO[bytes], channels: int) -> Iterator[Extra]:
    """Yield what there is, in the order of the file."""
    depth = _file_depth(file)
    all_of_it = list(chunks(file))
    is_srgb = any(name in (b"sRGB", b"iCCP") for name, _ in all_of_it)
    names: dict[Kind, list[str]] = {}
    for name, chunk in all_of_it:
        kind = _kind(name, chunk, channels, depth)
        if kind is None or (kind is kinds.COLOURS and (is_srgb or _says_srgb(name, chunk))):
            continue
        names.setdefault(kind, []).append(name.decode("latin-1"))
    for kind, members in names.items():
        listed = Text("PNG chunks {names}", names=" ".join(dict.fromkeys(members)))
        yield Extra(kind, listed if kind in (kinds.CHUNKS, kinds.UNSAFE_CHUNKS) else "")


def end(data: bytes) -> int:
    """Return where a PNG file ends by its last chunk."""
    at = len(SIGNATURE)
    while at + _OVERHEAD <= len(data):
        name, at = data[at + 4 : at + 8], at + _OVERHEAD + int.from_bytes(data[at : at + 4], "big")
        if name == b"IEND":
            return min(at, len(data))
    return len(data)


def _file_depth(file: IO[bytes]) -> int:
    """Return the bits per channel, or per index of a palette."""
    file.seek(_DEPTH_AT)
    return int.from_bytes(file.read(1), "big")


def _kind(name: bytes, chunk: bytes, channels: int, depth: int) -> Kind | None:
    """Return what a chunk is; None for the picture itself and what has a way of its own."""
    if name in _TEXT:
        return None if chunk[8:].startswith(_ELSEWHERE) else kinds.TEXTS
    if name in _COLOUR and name != b"sRGB":
        return kinds.COLOURS
    known = {_CREDENTIALS: kinds.CREDENTIALS, **dict.fromkeys(_FRAMES, kinds.FURTHER)}
    if name in known or name in _PLAIN:
        return known.get(name)
    fits = _SIZES.get(name, {}).get(channels) in (None, len(chunk) - _OVERHEAD)
    if name == _BACKGROUND:  # shallower pixels are widened to 8 bits
        return kinds.CHUNKS if fits and depth >= 8 else kinds.UNSAFE_CHUNKS
    is_safe = name in _TRUE or bool(name[3] & _COPY_BIT)
    return kinds.CHUNKS if fits and is_safe else kinds.UNSAFE_CHUNKS


def _says_srgb(name: bytes, chunk: bytes) -> bool:
    """Tell whether gamma or chromaticities are those that every reader takes for granted."""
    body = chunk[8:-4]
    numbers = struct.unpack(f">{len(body) // 4}I", body[: len(body) // 4 * 4])
    return (name == b"gAMA" and numbers == (_SRGB_GAMMA,)) or (
        name == b"cHRM" and numbers == _SRGB_COLOURS
    )


def shape(aspect: tuple[int, int]) -> bytes:
    """Return a `pHYs` chunk with the shape of pixels: so many along x and y in the same length."""
    return made(b"pHYs", struct.pack(">IIB", *aspect, 0))


def made(name: bytes, body: bytes) -> bytes:
    """Return a chunk as a file holds it."""
    checksum = zlib.crc32(body, zlib.crc32(name))
    return b"".join([struct.pack(">I", len(body)), name, body, struct.pack(">I", checksum)])


def before_pixels(png: bytes) -> bytes:
    """Return the chunks between the header and the pixels of a file that an encoder wrote."""
    end = _IHDR_END
    while png[end + 4 : end + 8] != b"IDAT":
        end += _OVERHEAD + int.from_bytes(png[end : end + 4], "big")
    return png[_IHDR_END:end]
