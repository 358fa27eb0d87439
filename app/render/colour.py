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
from ..pyramid import PicturePyramid, Show

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


def _on_x(number: int) -> bytes | None:
    """Return the ICC profile that colord or a similar daemon stored on X's root window."""
    x = ctypes.CDLL("libX11.so.6")  # Qt's plugin for X needs this library, too
    x.XOpenDisplay.restype = ctypes.c_void_p
    x.XInternAtom.restype = x.XDefaultRootWindow.restype = ctypes.c_ulong
    display = ctypes.c_void_p(x.XOpenDisplay(None))
    if not display:
        return None
    try:
        name = f"_ICC_PROFILE_{number}".removesuffix("_0").encode()
        atom, root = x.XInternAtom(display, name, True), x.XDefaultRootWindow(display)
        if not atom:
            return None
        data, length = ctypes.c_void_p(), ctypes.c_ulong()
        kind, bits, more = ctypes.c_ulong(), ctypes.c_int(), ctypes.c_ulong()
        answers = map(ctypes.byref, (kind, bits, length, more, data))
        where = ctypes.c_ulong(root), ctypes.c_ulong(atom)
        part = ctypes.c_long(0), ctypes.c_long(_MOST_BYTES // 4)
        x.XGetWindowProperty(display, *where, *part, False, ctypes.c_ulong(_ANY), *answers)
        profile = ctypes.string_at(data, length.value) if data else b""
        x.XFree(data)
        return profile or None
    finally:
        x.XCloseDisplay(display)
