"""Colours of a photo: an ICC profile, built from a CICP name if necessary; sRGB without either.

Readers convert a CICP name (ITU-T H.273) to an ICC profile with the tag ``cicp`` (ICC.1:2022), so
that all other code needs the profile only. PNG and AVIF store the name again.
"""

from __future__ import annotations

import dataclasses
import io
import math
import struct
from collections.abc import Sequence
from functools import cache
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow
from PIL import ImageCms

from kogao_core.base.display import Rgb8, eight_bits
from kogao_core.base.geometry import Array, Image
from kogao_core.base.language import Text
from kogao_core.photo.model import Photo, channels_of

Name = tuple[int, int]
"""Primaries and transfer curve of a picture, numbers of ITU-T H.273."""
DAMAGED: Final = (ImageCms.PyCMSError, OSError, TypeError, ValueError)
"""Exceptions of littleCMS for a damaged profile, or one for another colour mode."""
WHITE_NITS: Final = 203.0
"""Luminance of the white of sRGB in HDR pictures, cd/m² (ITU-R BT.2408)."""
TONE_MAPPED: Final = Text("the HDR brightness was tone-mapped to the range of sRGB")
# Title and chromaticities (x, y) of red, green and blue; white is D65.
_PRIMARIES: Final[dict[int, tuple[str, tuple[tuple[float, float], ...]]]] = {
    1: ("BT.709", ((0.640, 0.330), (0.300, 0.600), (0.150, 0.060))),
    5: ("BT.470 BG", ((0.640, 0.330), (0.290, 0.600), (0.150, 0.060))),
    6: ("SMPTE 170M", ((0.630, 0.340), (0.310, 0.595), (0.155, 0.070))),
    9: ("BT.2020", ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046))),
    12: ("Display P3", ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060))),
}
# Title and parameters of a curve of ICC: gamma, then a to d: ((a x + b) ** gamma, or c x below d).
_VIDEO: Final = ("BT.709 curve", (1 / 0.45, 1 / 1.099, 0.099 / 1.099, 1 / 4.5, 0.081))
_CURVES: Final[dict[int, tuple[str, tuple[float, ...]]]] = {
    **dict.fromkeys((1, 6, 14, 15), _VIDEO),
    4: ("gamma 2.2", (2.2,)),
    5: ("gamma 2.8", (2.8,)),
    8: ("linear", (1.0,)),
    13: ("sRGB curve", (2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)),
}
_PQ, _HLG, _SRGB_CURVE = 16, 18, 13
_HDR: Final = {_PQ: "PQ", _HLG: "HLG"}
# Cameras name these beside sRGB pixels: unspecified, BT.709 and primaries and curve of SD video.
_LIKE_SRGB: Final = ((1, 2, 5, 6), (1, 2, 6, 13))
_HLG_NITS, _HLG_GAMMA = 1000.0, 1.2  # nominal peak and system gamma of BT.2100
_STEPS: Final = 4096  # samples of an HDR curve
_D65: Final = (0.3127, 0.3290)
_D50: Final = np.array([0.9642, 1.0, 0.8249])
_BRADFORD: Final = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
# Bytes of the creation date in an ICC profile, set to zero for reproducible files.
_DATE: Final = slice(24, 36)
_TAGS: Final = 12
_NAME_AT: Final = 132 + 12 * _TAGS  # offset of the tag with the name in a built profile
_PEAK_AT: Final = _NAME_AT + 24  # offset of the brightest value, cd/m²


def of_name(name: Name, pixels: Image) -> bytes | None:
    """Return the ICC profile of a named colour space; None for sRGB. Raises KeyError.

    The curve of an HDR profile is tone-mapped from the brightest value of `pixels`.
    """
    if all(one in known for one, known in zip(name, _LIKE_SRGB, strict=True)):
        return None
    name = name[0] if name[0] != 2 else 1, name[1] if name[1] != 2 else _SRGB_CURVE
    if channels_of(pixels) < 3:  # a built profile has three channels
        raise KeyError(name)
    nits = WHITE_NITS
    if name[1] in _HDR:
        brightest = pixels[..., :3].max() / np.iinfo(pixels.dtype).max
        nits = max(nits, float(_nits(name[1], np.array(brightest))))
    return _built(name, math.ceil(nits))


def name_of(icc: bytes | None) -> Name | None:
    """Return the name of a profile that was built from a name; None for other profiles."""
    if not icc or icc[_NAME_AT : _NAME_AT + 4] != b"cicp":
        return None
    name = icc[_NAME_AT + 8], icc[_NAME_AT + 9]
    known = name[0] in _PRIMARIES and name[1] in {*_CURVES, *_HDR}
    return name if known and icc == _built(name, _peak(icc)) else None


def _peak(icc: bytes) -> int:
    return int.from_bytes(icc[_PEAK_AT : _PEAK_AT + 2], "big")


def is_hdr(icc: bytes | None) -> bool:
    """Return True for a profile that was built for a PQ or HLG curve."""
    name = name_of(icc)
    return name is not None and name[1] in _HDR


def tone_mapped(photo: Photo, pixels: Image) -> tuple[Photo, Image]:
    """Convert pixels of a PQ or HLG photo to the sRGB curve. Return photo and pixels."""
    icc = photo.icc_profile
    name = name_of(icc)
    if icc is None or name is None or name[1] not in _HDR:
        return photo, pixels
    white = np.iinfo(pixels.dtype).max
    linear = _curve(name[1], _peak(icc), white + 1)
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    table = np.rint(white * curve).astype(pixels.dtype)
    pixels = pixels.copy()
    pixels[..., :3] = table[pixels[..., :3]]
    icc = of_name((name[0], _SRGB_CURVE), pixels)
    return dataclasses.replace(photo, icc_profile=icc, notes=(*photo.notes, TONE_MAPPED)), pixels


def to_srgb(pixels: Image, icc: bytes) -> Rgb8:
    """Convert pixels by an ICC profile to 8-bit sRGB; keep alpha. Raises one of `DAMAGED`."""
    pixels = eight_bits(pixels)
    colours = pixels if channels_of(pixels) in (1, 3) else pixels[..., :-1]
    picture = Pillow.fromarray(np.ascontiguousarray(np.squeeze(colours)))
    done = np.asarray(picture_to_srgb(picture, icc))
    return done if colours is pixels else np.dstack([done, pixels[..., -1]])


def picture_to_srgb(picture: Pillow.Image, icc: bytes) -> Pillow.Image:
    """Convert a picture by an ICC profile to sRGB, relative colorimetric with black point."""
    source = ImageCms.ImageCmsProfile(io.BytesIO(icc))
    flags = ImageCms.Flags.BLACKPOINTCOMPENSATION | ImageCms.Flags.HIGHRESPRECALC
    target, intent = ImageCms.createProfile("sRGB"), ImageCms.Intent.RELATIVE_COLORIMETRIC
    done = ImageCms.profileToProfile(picture, source, target, intent, "RGB", flags=flags)
    if done is None:
        raise ImageCms.PyCMSError("no picture came back")
    return done


@cache
def srgb() -> bytes:
    """Return an sRGB profile without a date."""
    made = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    return made[: _DATE.start] + bytes(12) + made[_DATE.stop :]


def for_search(photo: Photo) -> Image:
    """Return the pixels for the search for faces: sRGB if the channels may mean anything else.

    That are profiles with tables, such as XYB, and HDR profiles.
    """
    icc = photo.icc_profile
    if icc is None or not (is_hdr(icc) or b"A2B0" in icc[:1024]):
        return photo.pixels
    try:
        return to_srgb(photo.pixels, icc)
    except DAMAGED:
        return photo.pixels


@cache
def _built(name: Name, peak_nits: int) -> bytes:
    """Return an ICC profile (version 4.4) with a matrix and a curve."""
    (title, places), transfer = _PRIMARIES[name[0]], name[1]
    if transfer in _HDR:
        known, curve = _HDR[transfer], _curve(transfer, peak_nits, _STEPS)
        stored = np.rint(0xFFFF * curve).astype(">u2").tobytes()
        shape = struct.pack(">4s4xI", b"curv", _STEPS) + stored
    else:
        known, parameters = _CURVES[transfer]
        kind = 3 if len(parameters) > 1 else 0
        shape = struct.pack(">4s4xH2x", b"para", kind) + _fixed(parameters)
    corners = _xyz([*places, _D65])
    adapted = np.diag(_BRADFORD @ _D50 / (_BRADFORD @ corners[:, 3]))
    adaptation = np.linalg.inv(_BRADFORD) @ adapted @ _BRADFORD
    columns = adaptation @ (corners[:, :3] * np.linalg.solve(corners[:, :3], corners[:, 3]))
    texts = (one.encode("utf-16-be") for one in (f"{title}, {known}", "Public domain"))
    text = struct.pack(">4s4xII4s", b"mluc", 1, 12, b"enUS")
    parts = {
        b"cicp": struct.pack(">4s4xBBBB", b"cicp", *name, 0, 1),
        b"lumi": _place((0, peak_nits, 0)),
        **{tag: text + struct.pack(">II", len(one), 28) + one
           for tag, one in zip((b"desc", b"cprt"), texts, strict=True)},
        b"wtpt": _place(_D50),
        b"chad": struct.pack(">4s4x", b"sf32") + _fixed(adaptation),
        **{b"%cXYZ" % one: _place(at) for one, at in zip(b"rgb", columns.T, strict=True)},
        b"rTRC": shape,
    }  # fmt: skip
    directory, body = b"", b""
    for tag, data in parts.items():
        directory += struct.pack(">4sII", tag, _NAME_AT + len(body), len(data))
        body += data + bytes(-len(data) % 4)
    directory += b"gTRC" + directory[-8:] + b"bTRC" + directory[-8:]
    head = struct.pack(">I4xI4s4s4s12x4s28x12s", _NAME_AT + len(body), 0x04400000, b"mntr",
                       b"RGB ", b"XYZ ", b"acsp", _fixed(_D50))  # fmt: skip
    return head.ljust(128, b"\0") + struct.pack(">I", _TAGS) + directory + body


def _xyz(places: Sequence[tuple[float, float]]) -> Array:
    """Return the XYZ of chromaticities with Y = 1, shape (3, N)."""
    return np.array([(x / y, 1.0, (1.0 - x - y) / y) for x, y in places]).T


def _place(xyz: npt.ArrayLike) -> bytes:
    return b"XYZ \0\0\0\0" + _fixed(xyz)


def _fixed(values: npt.ArrayLike) -> bytes:
    """Return ICC's numbers of 32 bits with 16 bits behind the point."""
    return np.rint(65536.0 * np.asarray(values)).astype(">i4").tobytes()


def _nits(transfer: int, signal: Array) -> Array:
    """Return the luminance of each channel of a PQ or HLG signal of 0 to 1, cd/m² (BT.2100)."""
    if transfer == _PQ:
        root = signal ** (1 / 78.84375)
        shares = np.maximum(root - 0.8359375, 0.0) / (18.8515625 - 18.6875 * root)
        return np.asarray(10000.0 * shares ** (1 / 0.1593017578125))
    bright = (np.exp((signal - 0.55991073) / 0.17883277) + 0.28466892) / 12.0
    scene = np.where(signal <= 0.5, signal**2 / 3.0, bright)
    return np.asarray(_HLG_NITS * scene**_HLG_GAMMA)


def _pq(nits: npt.ArrayLike) -> Array:
    """Return the PQ signal of a luminance in cd/m²."""
    powered = (np.asarray(nits) / 10000.0) ** 0.1593017578125
    return np.asarray(((0.8359375 + 18.8515625 * powered) / (1 + 18.6875 * powered)) ** 78.84375)


def _curve(transfer: int, peak_nits: int, steps: int) -> Array:
    """Return linear sRGB values of 0 to 1 for an HDR signal, `steps` values of 0 to 1.

    Each channel is tone-mapped from `peak_nits` to `WHITE_NITS` (ITU-R BT.2390, 5.4.1).
    """
    peak = _pq(peak_nits)
    signal = np.minimum(_pq(_nits(transfer, np.linspace(0.0, 1.0, steps))) / peak, 1.0)
    white = float(_pq(WHITE_NITS) / peak)
    knee = 1.5 * white - 0.5
    t = np.maximum(signal - knee, 0.0) / max(1.0 - knee, 1e-9)
    spline = (2 * t**3 - 3 * t**2 + 1) * knee + (t**3 - 2 * t**2 + t) * (1.0 - knee)
    spline += (3 * t**2 - 2 * t**3) * white
    mapped = np.where(signal < knee, signal, spline)
    return np.clip(_nits(_PQ, mapped * peak) / WHITE_NITS, 0.0, 1.0)
