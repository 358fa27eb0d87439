"""Colour profiles made from their definitions, exact conversions, and colour difference."""

from __future__ import annotations

import struct

import numpy as np
from skimage.color import deltaE_ciede2000

_D50 = np.array([0.9642, 1.0, 0.8249])
_D65_XY, D50_XY = (0.3127, 0.3290), (0.3457, 0.3585)
_BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
_SRGB = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))
# Name: primaries, white, gamma.
SPACES = {
    "Display P3": (((0.680, 0.320), (0.265, 0.690), (0.150, 0.060)), _D65_XY, 2.2),
    "Adobe RGB": (((0.64, 0.33), (0.21, 0.71), (0.15, 0.06)), _D65_XY, 563 / 256),
    "wide": (((0.7347, 0.2653), (0.1596, 0.8404), (0.0366, 0.0001)), D50_XY, 1.8),
}


def _xyz(xy) -> np.ndarray:
    x, y = xy
    return np.array([x / y, 1.0, (1 - x - y) / y])


def to_d50(primaries, white) -> np.ndarray:
    """Return the matrix from linear RGB to XYZ under D50, Bradford-adapted, shape (3, 3)."""
    columns = np.column_stack([_xyz(xy) for xy in primaries])
    columns = columns * np.linalg.solve(columns, _xyz(white))
    gain = (_BRADFORD @ _D50) / (_BRADFORD @ _xyz(white))
    return np.linalg.inv(_BRADFORD) @ (gain[:, None] * _BRADFORD) @ columns


def profile(name: str) -> bytes:
    """Return an ICC profile (v2, matrix and gamma) of a space in `SPACES`, or a grey one."""
    curve = _curve(2.2 if name == "grey" else SPACES[name][2])
    tags = {b"desc": _text(name), b"cprt": b"text\0\0\0\0none\0", b"wtpt": _xyz_tag(_D50)}
    if name == "grey":
        tags[b"kTRC"] = curve
    else:
        for letter, column in zip("rgb", to_d50(*SPACES[name][:2]).T, strict=True):
            tags[f"{letter}XYZ".encode()] = _xyz_tag(column)
            tags[f"{letter}TRC".encode()] = curve
    at, table, body = 132 + 12 * len(tags), struct.pack(">I", len(tags)), b""
    for tag, data in tags.items():
        table += struct.pack(">4sII", tag, at + len(body), len(data))
        body += data + bytes(-len(data) % 4)
    head = bytearray(128)
    struct.pack_into(">I4sI4s4s4s", head, 0, at + len(body), b"lcms", 0x02100000, b"mntr", b"", b"")
    head[16:24] = (b"GRAY" if name == "grey" else b"RGB ") + b"XYZ "
    head[24:36] = struct.pack(">6H", 2020, 1, 1, 0, 0, 0)
    head[36:40] = b"acsp"
    head[68:80] = _numbers(_D50)
    return bytes(head) + table + body


def _numbers(values) -> bytes:
    return b"".join(struct.pack(">i", round(float(value) * 65536)) for value in values)


def _xyz_tag(values) -> bytes:
    return b"XYZ \0\0\0\0" + _numbers(values)


def _curve(gamma: float) -> bytes:
    return b"curv\0\0\0\0" + struct.pack(">IH", 1, round(gamma * 256)) + b"\0\0"


def _text(text: str) -> bytes:
    plain = text.encode() + b"\0"
    return b"desc\0\0\0\0" + struct.pack(">I", len(plain)) + plain + bytes(78)


def expected_srgb(values: np.ndarray, name: str) -> np.ndarray:
    """Return colours of a space (0 to 1, last axis RGB, or grey) as sRGB, unrounded and clipped."""
    if name == "grey":
        linear = np.repeat(values[..., None] ** 2.2, 3, axis=-1)
    else:
        primaries, white, gamma = SPACES[name]
        # The profile's own gamma is rounded to 1/256.
        xyz = (values ** (round(gamma * 256) / 256)) @ to_d50(primaries, white).T
        linear = xyz @ np.linalg.inv(to_d50(_SRGB, _D65_XY)).T
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def lab_of_srgb(values: np.ndarray) -> np.ndarray:
    """Return sRGB colours (0 to 1) as CIE L*a*b* under D50."""
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    shares = linear @ to_d50(_SRGB, _D65_XY).T / _D50
    f = np.where(shares > (6 / 29) ** 3, np.cbrt(shares), shares / (3 * (6 / 29) ** 2) + 4 / 29)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def delta_e_2000(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the CIEDE2000 difference of L*a*b* colours, last axis L*, a*, b*."""
    return deltaE_ciede2000(first, second)
