"""Conversion of photos to the screen's colours, for display only, and the screen's profile."""

from __future__ import annotations

import ctypes
import dataclasses
import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np
from PIL import Image as Pillow
from PIL import ImageCms
from PySide6.QtGui import QColorSpace, QGuiApplication, QImage, QScreen

from kogao_core.base.display import Rgb8, rgba8
from kogao_core.base.threads import default_threads, parallel_for
from kogao_core.photo import Photo

from ..i18n import tr
from .pictures import PicturePyramid, Show

# Few rows at a time: Pillow copies rows while holding the GIL, and the window must respond.
_STRIP_PX: Final = 2**17
_STEPS: Final = 17
_ONE_LEVEL: Final = 1
_SRGB: Final = QColorSpace(QColorSpace.NamedColorSpace.SRgb)
_MOST_BYTES: Final = 1 << 24
_ANY: Final = 0  # type of a property


@dataclass(frozen=True, eq=False)
class ScreenColours:
    """Conversion of a photo's colours to the screen."""

    name: str = ""  # description in the profile; empty without a profile
    usable: bool = True  # False for a damaged profile, or one for another colour mode
    # See `PicturePyramid`; None if the photo already has the screen's colours.
    show: Show | None = None


def screen_colours(photo: Photo) -> ScreenColours:
    """Return the conversion of a photo's colours to the screen, relative colorimetric.

    A screen without a known profile counts as sRGB, and so does a photo without a usable profile.
    """
    grey = photo.channels < 3 and photo.icc_profile is not None
    return _known_colours(photo.icc_profile, _screen.icc, "L" if grey else "RGB")


def use_screen(icc: bytes | None) -> bool:
    """Set the screen's ICC profile; return True if the profile has changed.

    None and unusable profiles mean sRGB.
    """
    if icc is not None and not _known_colours(None, icc, "RGB").usable:
        icc = None
    before, _screen.icc = _screen.icc, icc
    return icc != before


def told_screen() -> str:
    """Return a line about the screen's colours."""
    if _screen.icc is None:
        return tr("The screen is taken to be sRGB: the system reports no profile")
    return tr("The screen's colours: {profile}", profile=_name(_profile(_screen.icc)))


def in_srgb(picture: QImage) -> QImage:
    """Convert a screenshot to sRGB, in place."""
    if _screen.icc is not None:
        picture.setColorSpace(QColorSpace.fromIccProfile(_screen.icc))
        picture.convertToColorSpace(_SRGB)
    return picture


def pyramid_of(photo: Photo) -> PicturePyramid:
    """Return the pyramid for rendering and painting a photo."""
    return PicturePyramid(rgba8(photo.pixels), screen_colours(photo).show)


def on_screen(picture: QImage) -> QImage:
    """Convert a small picture to the screen's colours, in place."""
    space = _SRGB if _screen.icc is None else QColorSpace.fromIccProfile(_screen.icc)
    if not picture.colorSpace().isValid():
        picture.setColorSpace(_SRGB)
    picture.convertToColorSpace(space if space.isValidTarget() else _SRGB)
    return picture


class _Screen:
    """The screen that shows the window."""

    icc: bytes | None = None  # ICC profile; None for sRGB


_screen: Final = _Screen()


@lru_cache(maxsize=8)
def _known_colours(icc: bytes | None, screen: bytes | None, mode: str) -> ScreenColours:
    if icc is None and screen is None:
        return ScreenColours()
    name, compensates = "", ImageCms.Flags.BLACKPOINTCOMPENSATION
    try:
        profile = _profile(icc)
        name = "" if icc is None else _name(profile)
        transform = ImageCms.buildTransform(
            profile,
            _profile(screen),
            mode,
            "RGB",
            ImageCms.Intent.RELATIVE_COLORIMETRIC,
            # Several threads share the transform.
            ImageCms.Flags.NOCACHE
            | ImageCms.Flags.HIGHRESPRECALC
            | (compensates if screen else ImageCms.Flags.NONE),
        )
    except (ImageCms.PyCMSError, OSError, TypeError, ValueError):
        plain = ScreenColours() if icc is None else _known_colours(None, screen, "RGB")
        return dataclasses.replace(plain, name=name, usable=False)
    show = _Transform(transform, mode)
    return ScreenColours(name, show=show if show.changes_colours else None)


def _profile(icc: bytes | None) -> Any:
    """Return a parsed profile; sRGB for None. Raises OSError, PyCMSError."""
    return (
        ImageCms.createProfile("sRGB") if icc is None else ImageCms.ImageCmsProfile(io.BytesIO(icc))
    )


def _name(profile: Any) -> str:
    return ImageCms.getProfileDescription(profile).strip()


class _Transform:
    """Converts 8-bit pictures to the screen's colours; grey pictures get three channels."""

    def __init__(self, transform: Any, mode: str) -> None:
        self._transform, self._grey = transform, mode == "L"

    def __call__(self, pictures: Sequence[tuple[Rgb8, Rgb8]]) -> None:
        """Convert the first picture of each pair into the second."""
        strips = [strip for pair in pictures for strip in _strips(*pair)]
        parallel_for(strips, lambda: self._turn, min(len(strips), default_threads()))

    def _turn(self, pair: tuple[Rgb8, Rgb8]) -> None:
        source, target = pair
        plain = np.ascontiguousarray(source[..., 0] if self._grey else source[..., :3])
        picture = Pillow.fromarray(plain)
        target[..., :3] = np.asarray(ImageCms.applyTransform(picture, self._transform))
        target[..., 3:] = source[..., 3:]

    @property
    def changes_colours(self) -> bool:
        """Whether colours change by more than rounding; False for most photos, which are sRGB."""
        levels = np.linspace(0, 255, _STEPS).round().astype(np.uint8)
        if self._grey:
            before = np.repeat(levels[None, :, None], 3, axis=-1)
        else:
            before = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(1, -1, 3)
        after = np.empty_like(before)
        self._turn((before, after))
        return int(np.abs(after.astype(int) - before).max()) > _ONE_LEVEL


def _strips(source: Rgb8, target: Rgb8) -> list[tuple[Rgb8, Rgb8]]:
    rows = max(1, _STRIP_PX // max(1, source.shape[1]))
    tops = range(0, len(source), rows)
    return [(source[top : top + rows], target[top : top + rows]) for top in tops]


def profile_of(screen: QScreen, window: int) -> bytes | None:
    """Return the ICC profile of the screen with a window. Qt has no such function.

    None if the system reports no profile: under Wayland, where the desktop converts the colours,
    on macOS, where this is untested, and if no profile is installed.
    """
    platform = QGuiApplication.platformName()
    if platform == "xcb":
        return _on_x(QGuiApplication.screens().index(screen))
    if platform == "windows":  # Pillow calls GetICMProfile; untested
        profile = ImageCms.get_display_profile(window)
        return None if profile is None else profile.tobytes()
    return None


class _Reply(ctypes.Structure):
    # The property's reply after the common header. The reply with the atom starts alike.
    _fields_ = (
        *(("kind", ctypes.c_uint8), ("format", ctypes.c_uint8), ("sequence", ctypes.c_uint16)),
        *(("length", ctypes.c_uint32), ("atom", ctypes.c_uint32)),
    )


class _Screens(ctypes.Structure):
    _fields_ = (
        *(("root", ctypes.POINTER(ctypes.c_uint32)),),
        *(("left", ctypes.c_int), ("index", ctypes.c_int)),
    )


def _on_x(number: int) -> bytes | None:
    """Return the ICC profile that colord or a similar daemon stored on X's root window."""
    x, libc = ctypes.CDLL("libxcb.so.1"), ctypes.CDLL(None)
    handle, reply = ctypes.c_void_p, ctypes.POINTER(_Reply)
    for name, result in (
        *(("xcb_connect", handle), ("xcb_get_setup", handle), ("xcb_get_property_value", handle)),
        *(("xcb_intern_atom_reply", reply), ("xcb_get_property_reply", reply)),
        ("xcb_setup_roots_iterator", _Screens),
    ):
        getattr(x, name).restype = result
    connection = handle(x.xcb_connect(None, None))
    try:
        if x.xcb_connection_has_error(connection):
            return None
        root = x.xcb_setup_roots_iterator(handle(x.xcb_get_setup(connection))).root[0]
        wanted = f"_ICC_PROFILE_{number}".removesuffix("_0").encode()
        asked = x.xcb_intern_atom(connection, 1, len(wanted), wanted)
        named = x.xcb_intern_atom_reply(connection, asked, None)
        atom = named.contents.atom if named else 0
        libc.free(named)
        if not atom:
            return None
        asked = x.xcb_get_property(connection, 0, root, atom, _ANY, 0, _MOST_BYTES // 4)
        found = x.xcb_get_property_reply(connection, asked, None)
        if not found:
            return None
        size = x.xcb_get_property_value_length(found)
        profile = ctypes.string_at(x.xcb_get_property_value(found), size)
        libc.free(found)
        return profile or None
    finally:
        x.xcb_disconnect(connection)
