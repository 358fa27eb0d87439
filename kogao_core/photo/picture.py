"""Identity of a picture: a hash of its coded pixels and of the orientation as shown."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from kogao_core.photo.jpeg import segments

if TYPE_CHECKING:
    from kogao_core.photo.model import Photo

_ADOBE: Final = (0xEE, b"Adobe")  # defines the colour coding
_PNG: Final = (b"IHDR", b"PLTE", b"tRNS", b"IDAT")
_WEBP: Final = (b"VP8 ", b"VP8L", b"ALPH", b"ANMF")


def hashes_of(file: BufferedReader, photo: Photo) -> tuple[str, str]:
    """Return the SHA-256 of the picture and of the whole open file.

    Metadata, colour profile, thumbnails and data after the picture are no part of the picture. For
    JPEG, PNG and WebP its hash covers the compressed data and the orientation; for a raw photo the
    file, because developing depends on the version of LibRaw; for other formats the pixels.
    """
    file.seek(0)
    whole = hashlib.file_digest(file, "sha256").hexdigest()
    digest = hashlib.sha256(b"%s %d " % (photo.format.encode(), photo.orientation))
    if photo.format == "RAW":
        digest.update(whole.encode())
    elif (coded := _CODED.get(photo.format)) is None:
        digest = hashlib.sha256(f"{photo.pixels.shape} {photo.pixels.dtype}".encode())
        digest.update(np.ascontiguousarray(photo.pixels).data)
    else:
        file.seek(0)
        for piece in coded(file.read()):
            digest.update(piece)
    return digest.hexdigest(), whole


def sha256_of(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file as 64 hexadecimal digits."""
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _jpeg(data: bytes) -> Iterator[memoryview]:
    view, start, last = memoryview(data), 2, 2
    for code, at, end in segments.markers(data, 2):
        last = end
        is_coding = code == _ADOBE[0] and data[at + 4 :].startswith(_ADOBE[1])
        if code in segments.APP_OR_COMMENT and not is_coding:
            yield view[start:at]
            start = end
    yield view[start:last]


def _png(data: bytes) -> Iterator[memoryview]:
    at = 8
    while at + 12 <= len(data):
        end = at + 8 + int.from_bytes(data[at : at + 4], "big")
        if data[at + 4 : at + 8] in _PNG:
            yield memoryview(data)[at + 8 : end]  # any division into chunks is equal
        at = end + 4


def _webp(data: bytes) -> Iterator[memoryview]:
    at = 12
    while at + 8 <= len(data):
        end = at + 8 + int.from_bytes(data[at + 4 : at + 8], "little")
        if data[at : at + 4] in _WEBP:
            yield memoryview(data)[at:end]
        at = end + end % 2


_CODED: Final = {"JPEG": _jpeg, "PNG": _png, "WEBP": _webp}
