"""Colours of a photo: an ICC profile, built from a CICP name if necessary; sRGB without either.

Readers convert a CICP name (ITU-T H.273) to an ICC profile with the tag ``cicp`` (ICC.1:2022), so
that all other code needs the profile only. PNG and AVIF store the name again.
"""

from __future__ import annotations

import dataclasses
import io
import math
import struct
from collections.abc import Mapping
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
# Title and chromaticities (x, y) of red, green and blue.
_PRIMARIES: Final = {
    1: ("BT.709", (0.640, 0.330, 0.300, 0.600, 0.150, 0.060)),
    5: ("BT.470 BG", (0.640, 0.330, 0.290, 0.600, 0.150, 0.060)),
    6: ("SMPTE 170M", (0.630, 0.340, 0.310, 0.595, 0.155, 0.070)),
    9: ("BT.2020", (0.708, 0.292, 0.170, 0.797, 0.131, 0.046)),
    12: ("Display P3", (0.680, 0.320, 0.265, 0.690, 0.150, 0.060)),
}
_D65: Final = (0.3127, 0.3290)
# Title and parameters of a curve of ICC: gamma, then a to d: (a x + b) ** gamma, or c x below d.
_SRGB_CURVE, _PQ, _HLG = 13, 16, 18
_VIDEO: Final = ("BT.709 curve", (1 / 0.45, 1 / 1.099, 0.099 / 1.099, 1 / 4.5, 0.081))
_CURVES: Final[dict[int, tuple[str, tuple[float, ...]]]] = {
    **dict.fromkeys((1, 6, 14, 15), _VIDEO),
    4: ("gamma 2.2", (2.2,)),
    5: ("gamma 2.8", (2.8,)),
    8: ("linear", (1.0,)),
    _SRGB_CURVE: ("sRGB curve", (2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)),
}
_HDR: Final = {_PQ: "PQ", _HLG: "HLG"}
# Cameras name these beside sRGB pixels: BT.709, unspecified, and SD video.
_LIKE_SRGB: Final = ((1, 2, 5, 6), (1, 2, 6, _SRGB_CURVE))
_STEPS: Final = 1024  # samples of an HDR curve
_DATE: Final = slice(24, 36)  # of the creation of a profile; zero makes files reproducible
_TABLE_AT: Final = 132
# Tags that show a picture.
_SHOWN: Final = {b"wtpt", b"chad", b"A2B0", b"A2B1", b"desc", b"cprt", b"cicp", b"kTRC"}
_SHOWN.update(b"%c%s" % (one, more) for one in b"rgb" for more in (b"XYZ", b"TRC"))


def of_name(name: Name, pixels: Image) -> bytes | None:
    """Return the ICC profile of a named colour space; None for sRGB. Raises KeyError.

    The curve of an HDR profile is tone-mapped from the brightest value of `pixels`.
    """
    if all(one in known for one, known in zip(name, _LIKE_SRGB, strict=True)):
        return None
    name = name[0] if name[0] != 2 else 1, name[1] if name[1] != 2 else _SRGB_CURVE
    if channels_of(pixels) < 3:  # a built profile has three channels
        raise KeyError(name)
    return _built(name, _peak(name[1], pixels) if name[1] in _HDR else 0)


def name_of(icc: bytes | None) -> Name | None:
    """Return the name in a profile, as built profiles have one; None without a known name."""
    tag = _tags(icc or b"").get(b"cicp", b"")
    name = (tag[8], tag[9]) if tag[10:] == b"\0\1" else (0, 0)
    return name if name[0] in _PRIMARIES and name[1] in {*_CURVES, *_HDR} else None


def is_hdr(icc: bytes | None) -> bool:
    """Return True for a profile with the name of a PQ or HLG curve."""
    name = name_of(icc)
    return name is not None and name[1] in _HDR


def tone_mapped(photo: Photo, pixels: Image) -> tuple[Photo, Image]:
    """Convert pixels of a PQ or HLG photo to the sRGB curve. Return photo and pixels."""
    name = name_of(photo.icc_profile)
    if name is None or name[1] not in _HDR:
        return photo, pixels
    white = np.iinfo(pixels.dtype).max
    linear = _curve(name[1], _peak(name[1], photo.pixels), white + 1)
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    table = np.rint(white * curve).astype(pixels.dtype)
    pixels = pixels.copy()
    pixels[..., :3] = table[pixels[..., :3]]
    icc = of_name((name[0], _SRGB_CURVE), pixels)
    return dataclasses.replace(photo, icc_profile=icc, notes=(*photo.notes, TONE_MAPPED)), pixels


def _peak(transfer: int, pixels: Image) -> int:
    """Return the luminance of the brightest channel, at least that of white, cd/m²."""
    signal = pixels[..., :3].max() / np.iinfo(pixels.dtype).max
    return math.ceil(max(WHITE_NITS, float(_nits(transfer, np.array(signal)))))


def to_srgb(pixels: Image, icc: bytes) -> Rgb8:
    """Convert pixels by an ICC profile to 8-bit sRGB; keep alpha. Raises one of `DAMAGED`."""
    pixels = eight_bits(pixels)
    colours = pixels if channels_of(pixels) in (1, 3) else pixels[..., :-1]
    picture = Pillow.fromarray(np.ascontiguousarray(np.squeeze(colours)))
    done = np.asarray(picture_to_srgb(picture, icc))
    return done if colours is pixels else np.dstack([done, pixels[..., -1]])


def picture_to_srgb(picture: Pillow.Image, icc: bytes) -> Pillow.Image:
    """Convert a picture to sRGB, relative colorimetric with black point. Raises `DAMAGED`."""
    source = ImageCms.ImageCmsProfile(io.BytesIO(icc))
    flags = ImageCms.Flags.BLACKPOINTCOMPENSATION | ImageCms.Flags.HIGHRESPRECALC
    target, intent = ImageCms.createProfile("sRGB"), ImageCms.Intent.RELATIVE_COLORIMETRIC
    done = ImageCms.profileToProfile(picture, source, target, intent, "RGB", flags=flags)
    if done is None:
        raise ImageCms.PyCMSError("no picture came back")
    return done


def for_search(photo: Photo) -> Image:
    """Return pixels for the search for faces: sRGB if channels of the photo mean anything else.

    Such channels have profiles with tables, such as XYB, or HDR profiles.
    """
    icc = photo.icc_profile
    try:
        if icc is not None and (is_hdr(icc) or b"A2B0" in _tags(icc)):
            return to_srgb(photo.pixels, icc)
    except DAMAGED:
        pass
    return photo.pixels


@cache
def srgb() -> bytes:
    """Return an sRGB profile without a date."""
    made = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    return made[: _DATE.start] + bytes(12) + made[_DATE.stop :]


def shown_part(icc: bytes) -> bytes:
    """Return a smaller profile that shows a picture like `icc`."""
    return _assembled(icc, {tag: data for tag, data in _tags(icc).items() if tag in _SHOWN})


@cache
def _built(name: Name, peak_nits: int) -> bytes:
    """Return the profile of a name: that of sRGB with another matrix and curve."""
    (title, places), transfer = _PRIMARIES[name[0]], name[1]
    if transfer in _HDR:
        known, curve = _HDR[transfer], _curve(transfer, peak_nits, _STEPS)
        stored = np.rint(0xFFFF * curve).astype(">u2").tobytes()
        shape = struct.pack(">4s4xI", b"curv", _STEPS) + stored
    else:
        known, parameters = _CURVES[transfer]
        kind = 3 if len(parameters) > 1 else 0
        shape = struct.pack(">4s4xH2x", b"para", kind) + _fixed(parameters)
    text = f"{title}, {known}".encode("utf-16-be")
    tags = _tags(srgb())
    del tags[b"chrm"]
    x, y = np.array([*places, *_D65]).reshape(4, 2).T
    corners = np.array([x / y, np.ones(4), (1.0 - x - y) / y])  # XYZ with Y = 1
    to_d50 = np.frombuffer(tags[b"chad"], ">i4", 9, 8).reshape(3, 3) / 65536
    columns = to_d50 @ (corners[:, :3] * np.linalg.solve(corners[:, :3], corners[:, 3]))
    for letter, column in zip(b"rgb", columns.T, strict=True):
        tags |= {b"%cXYZ" % letter: b"XYZ \0\0\0\0" + _fixed(column), b"%cTRC" % letter: shape}
    tags |= {
        b"desc": struct.pack(">4s4xII4sII", b"mluc", 1, 12, b"enUS", len(text), 28) + text,
        b"cicp": struct.pack(">4s4x4B", b"cicp", *name, 0, 1),
    }
    return _assembled(srgb(), tags)


def _tags(icc: bytes) -> dict[bytes, bytes]:
    """Return the data of a profile's tags; none if the table is damaged."""
    try:
        count = int.from_bytes(icc[_TABLE_AT - 4 : _TABLE_AT], "big")
        table = struct.iter_unpack(">4sII", icc[_TABLE_AT : _TABLE_AT + 12 * count])
        return {tag: icc[at : at + size] for tag, at, size in table}
    except struct.error:
        return {}


def _assembled(icc: bytes, tags: Mapping[bytes, bytes]) -> bytes:
    """Return a profile with the header of `icc` and other tags."""
    table, body, start = b"", b"", _TABLE_AT + 12 * len(tags)
    for tag, data in tags.items():
        table += struct.pack(">4sII", tag, start + len(body), len(data))
        body += data + bytes(-len(data) % 4)
    size, count = start + len(body), len(tags)
    return struct.pack(">I", size) + icc[4:128] + struct.pack(">I", count) + table + body


def _fixed(values: npt.ArrayLike) -> bytes:
    """Return ICC's numbers of 32 bits with 16 bits behind the point."""
    return np.rint(65536.0 * np.asarray(values)).astype(">i4").tobytes()


def _nits(transfer: int, signal: Array) -> Array:
    """Return the luminance of each channel of a PQ or HLG signal of 0 to 1, cd/m² (BT.2100).

    HLG: on a screen of 1000 cd/m², whose system gamma of 1.2 applies to each channel.
    """
    if transfer == _PQ:
        root = signal ** (1 / 78.84375)
        shares = np.maximum(root - 0.8359375, 0.0) / (18.8515625 - 18.6875 * root)
        return np.asarray(10000.0 * shares ** (1 / 0.1593017578125))
    bright = (np.exp((signal - 0.55991073) / 0.17883277) + 0.28466892) / 12.0
    return np.asarray(1000.0 * np.where(signal <= 0.5, signal**2 / 3.0, bright) ** 1.2)


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
    return np.minimum(_nits(_PQ, np.where(signal < knee, signal, spline) * peak) / WHITE_NITS, 1.0)
