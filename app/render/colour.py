"""Photos in the colours of the screen, for showing only: nothing saved comes through here."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np
from PIL import Image as Pillow
from PIL import ImageCms
from PySide6.QtGui import QColorSpace, QImage

from kogao_core.base.display import Rgb8, rgba8
from kogao_core.base.threads import default_threads, share_out
from kogao_core.photo import Photo

from .pyramid import PicturePyramid, Show

# Few rows at a time: Pillow copies them with the interpreter held, and the window must go on.
_STRIP_PX: Final = 2**17
_STEPS: Final = 17
_ONE_LEVEL: Final = 1


@dataclass(frozen=True, eq=False)
class ScreenColours:
    """How the colours of a photo get onto the screen."""

    name: str = ""  # what its profile calls itself; empty without one
    usable: bool = True  # false for a damaged profile, or one for another kind of picture
    # See `PicturePyramid`; None where the colours are the screen's already.
    show: Show | None = None


def screen_colours(photo: Photo) -> ScreenColours:
    """Return how a photo's colours get onto the screen, relative colorimetric.

    No toolkit tells the profile of the screen everywhere, so it is taken to be sRGB. A photo
    without a usable profile is taken to be in it, too.
    """
    if photo.icc_profile is None:
        return ScreenColours()
    return _known_colours(photo.icc_profile, "L" if photo.channels < 3 else "RGB")


def pyramid_of(photo: Photo) -> PicturePyramid:
    """Return what a photo is rendered and painted from."""
    return PicturePyramid(rgba8(photo.pixels), screen_colours(photo).show)


def on_screen(picture: QImage) -> QImage:
    """Return a small picture in the colours of the screen."""
    if picture.colorSpace().isValid():
        picture.convertToColorSpace(QColorSpace(QColorSpace.NamedColorSpace.SRgb))
    return picture


@lru_cache(maxsize=8)
def _known_colours(icc: bytes, mode: str) -> ScreenColours:
    name = ""
    try:
        profile = ImageCms.ImageCmsProfile(io.BytesIO(icc))
        name = ImageCms.getProfileDescription(profile).strip()
        transform = ImageCms.buildTransform(
            profile,
            ImageCms.createProfile("sRGB"),
            mode,
            "RGB",
            ImageCms.Intent.RELATIVE_COLORIMETRIC,
            # Several threads share it.
            ImageCms.Flags.NOCACHE | ImageCms.Flags.HIGHRESPRECALC,
        )
    except (ImageCms.PyCMSError, OSError, TypeError, ValueError):
        return ScreenColours(name, usable=False)
    show = _Transform(transform, mode)
    return ScreenColours(name, show=show if show.changes_colours else None)


class _Transform:
    """Turns 8-bit pictures into sRGB; grey ones come as three equal channels, too."""

    def __init__(self, transform: Any, mode: str) -> None:
        self._transform, self._grey = transform, mode == "L"

    def __call__(self, pictures: Sequence[tuple[Rgb8, Rgb8]]) -> None:
        """Write each first picture into the second one of its pair."""
        strips = [strip for pair in pictures for strip in _strips(*pair)]
        share_out(strips, lambda: self._turn, min(len(strips), default_threads()))

    def _turn(self, pair: tuple[Rgb8, Rgb8]) -> None:
        source, target = pair
        plain = np.ascontiguousarray(source[..., 0] if self._grey else source[..., :3])
        picture = Pillow.fromarray(plain)
        target[..., :3] = np.asarray(ImageCms.applyTransform(picture, self._transform))
        target[..., 3:] = source[..., 3:]

    @property
    def changes_colours(self) -> bool:
        """Whether colours change by more than rounding; those of most photos are sRGB already."""
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
