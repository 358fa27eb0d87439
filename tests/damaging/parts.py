"""Damage to the parts of a photo's file: what holds them together stays in order.

JPEG segments get their lengths again, PNG chunks their sums and WebP chunks their sizes, so that a
decoder comes as far as the damage.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from files import chunk, segment

from damaging import bytewise, texts, tiffs

_PNG = b"\x89PNG\r\n\x1a\n"
_PACKED = {b"IDAT": 0, b"zTXt": 2, b"iCCP": 2}  # zeros before what zlib has packed
_SOS, _RESTARTS = 0xDA, (0x00, *range(0xD0, 0xD8))
_MOST_REPEATS = 300


class Part(NamedTuple):
    """A segment or chunk: its name and its bytes."""

    name: bytes
    body: bytes


def change(data: bytes, rng: np.random.Generator, other: bytes) -> bytes:
    """Return a file with one of its parts changed; of unknown formats, some of its bytes."""
    if data[:4] in (b"II*\0", b"MM\0*"):
        return tiffs.change(data, rng)
    for split, join in _FORMATS:
        try:
            parts, others = split(data), split(other)
        except (ValueError, IndexError, struct.error):
            continue
        if parts:
            _change_one(parts, others, rng)
            return join(parts)
    return bytewise.change(data, rng, other)


def _change_one(parts: list[Part], others: list[Part], rng: np.random.Generator) -> None:
    at = int(rng.integers(len(parts)))
    part = parts[at]
    kind = rng.integers(8)
    if kind == 0:
        del parts[at]
    elif kind == 1:
        parts[at:at] = [part] * int(rng.choice([1, 2, _MOST_REPEATS]))
    elif kind == 2:
        parts.insert(int(rng.integers(len(parts) + 1)), parts.pop(at))
    elif kind == 3 and others:
        parts.insert(at, others[rng.integers(len(others))])
    else:
        parts[at] = Part(part.name, _changed_body(part, rng))


def _changed_body(part: Part, rng: np.random.Generator) -> bytes:
    body = part.body
    head = body[:6] if body[:6] == b"Exif\0\0" else b""
    if body[len(head) :][:4] in (b"II*\0", b"MM\0*"):
        return head + tiffs.change(body[len(head) :], rng)
    start = body.find(b"<x:xmpmeta")
    if start >= 0:
        return body[:start] + texts.change(body[start:], rng)
    if part.name in _PACKED and rng.random() < 0.7:
        return _changed_inside(part, rng)
    return bytewise.change(body, rng, body)


def _changed_inside(part: Part, rng: np.random.Generator) -> bytes:
    start = 0
    try:
        for _ in range(_PACKED[part.name]):
            start = part.body.index(b"\0", start) + 1
        plain = zlib.decompress(part.body[start:])
    except (ValueError, zlib.error):
        return bytewise.change(part.body, rng, part.body)
    return part.body[:start] + zlib.compress(bytewise.change(plain, rng, plain))


# ---- JPEG -----------------------------------------------------------------------------------


def _jpeg_parts(data: bytes) -> list[Part]:
    if not data.startswith(b"\xff\xd8\xff"):
        return []
    parts, at = [], 2
    while data[at] == 0xFF and data[at + 1] != 0xD9:
        code, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        body, at = data[at + 4 : at + 2 + length], at + 2 + length
        parts.append(Part(bytes([code]), body))
        if code == _SOS:
            start = at
            while data[at] != 0xFF or data[at + 1] in _RESTARTS:
                at += 1
            parts.append(Part(b"", data[start:at]))
    return parts


def _jpeg(parts: list[Part]) -> bytes:
    pieces = [
        segment(part.name[0], part.body[:65533]) if len(part.name) == 1 else part.body
        for part in parts
    ]
    return b"\xff\xd8" + b"".join(pieces) + b"\xff\xd9"


# ---- PNG ------------------------------------------------------------------------------------


def _png_parts(data: bytes) -> list[Part]:
    if not data.startswith(_PNG):
        return []
    parts, at = [], 8
    while at < len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        parts.append(Part(data[at + 4 : at + 8], data[at + 8 : at + 8 + length]))
        at += 12 + length
    return parts


def _png(parts: list[Part]) -> bytes:
    return _PNG + b"".join(chunk(part.name, part.body) for part in parts)


# ---- WebP -----------------------------------------------------------------------------------


def _webp_parts(data: bytes) -> list[Part]:
    if data[:4] != b"RIFF" or data[8:12] != b"WEBP":
        return []
    parts, at = [], 12
    while at < len(data):
        (length,) = struct.unpack_from("<I", data, at + 4)
        parts.append(Part(data[at : at + 4], data[at + 8 : at + 8 + length]))
        at += 8 + length + length % 2
    return parts


def _webp(parts: list[Part]) -> bytes:
    body = b"".join(
        part.name + struct.pack("<I", len(part.body)) + part.body + b"\0" * (len(part.body) % 2)
        for part in parts
    )
    return b"RIFF" + struct.pack("<I", 4 + len(body)) + b"WEBP" + body


_Split = Callable[[bytes], list[Part]]
_Join = Callable[[list[Part]], bytes]
_FORMATS: tuple[tuple[_Split, _Join], ...] = (
    (_jpeg_parts, _jpeg),
    (_png_parts, _png),
    (_webp_parts, _webp),
)
