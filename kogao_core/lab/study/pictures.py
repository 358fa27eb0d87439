"""Pictures that say nothing of how they were made, but to the eye."""

from __future__ import annotations

import dataclasses
import hashlib
import io
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image as Pillow
from PIL import ImageCms

from kogao_core.base.atomic import put
from kogao_core.base.display import rgb8
from kogao_core.base.geometry import Image
from kogao_core.faces.face import Face
from kogao_core.lab.study.conduct import SURROUND
from kogao_core.lab.study.origin import PictureFigures
from kogao_core.lab.study.plan import Side
from kogao_core.lab.study.variants import Variant
from kogao_core.lab.subjects import Subject, at_paper_size
from kogao_core.photo import Photo
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe

_QUALITY: Final = 95
_FULL_COLOUR: Final = 0
_LEAST_PADDING: Final = 16
_STEPS: Final = 3
# Between two pictures, px, in the page's grey.
_GAP: Final = 40
_GREY: Final = int(SURROUND[1:3], 16)
_MOST: Final = 15.0  # % of D
# The day on which the MS-DOS calendar begins: every file system can hold it.
_CHANGED_S: Final = 315_619_200.0


def subject(photo: Photo, face: Face) -> Subject:
    """Return one face of a photo at the paper's 960 x 720 px, in sRGB, upright."""
    named = Subject(photo.path.name, _srgb(photo), (face,))
    return at_paper_size(named)


def _srgb(photo: Photo) -> Image:
    pixels = rgb8(photo.pixels)
    if photo.icc_profile is None:
        return pixels
    try:
        source = ImageCms.ImageCmsProfile(io.BytesIO(photo.icc_profile))
        srgb = ImageCms.createProfile("sRGB")
        shown = ImageCms.profileToProfile(Pillow.fromarray(pixels), source, srgb)
    except (ImageCms.PyCMSError, OSError):
        return pixels  # a profile that fits no RGB picture changes nothing, as in any viewer
    return pixels if shown is None else np.array(shown)


def drawn(
    shown: Subject, variant: Variant, base: Recipe, *, match: bool = False, side: Side | None = None
) -> tuple[bytes, PictureFigures]:
    """Return a picture of the subject, as JPEG without any metadata, and how far it came.

    With `match` its percentage is what is achieved, and what is asked for follows. With a side it
    lies there beside the photo as it is.
    """
    rendering, asked = render(shown.pixels, shown.faces, variant.recipe(base)), None
    if match and variant.percent:
        # What is achieved is all but proportional to what is asked for.
        asked = variant
        for _ in range(_STEPS):
            wanted = asked.percent * variant.percent / rendering.achieved[0]
            asked = dataclasses.replace(asked, percent=max(-_MOST, min(_MOST, wanted)))
            rendering = render(shown.pixels, shown.faces, asked.recipe(base))
    pixels = rendering.pixels
    if variant.kind == "catch":
        pixels = _cut(pixels, shown.faces[0])
    if side is not None:
        between = np.full_like(pixels[:, :_GAP], _GREY)
        both = (pixels, between, shown.pixels)
        pixels = np.hstack(both if side == "left" else both[::-1])
    figures = PictureFigures.of(rendering)
    if asked is not None:
        figures = dataclasses.replace(figures, asked=round(asked.percent, 4))
    return jpeg(pixels), figures


def _cut(pixels: Image, face: Face) -> Image:
    """Return a picture whose part below the middle of a face is moved aside by half the face."""
    left, top = face.outline.min(axis=0)
    right, bottom = face.outline.max(axis=0)
    cut, moved = round((top + bottom) / 2.0), round((right - left) / 2.0)
    return np.concatenate([pixels[:cut], np.roll(pixels[cut:], moved, axis=1)])


def jpeg(pixels: Image) -> bytes:
    """Return RGB pixels as JPEG without any metadata."""
    with io.BytesIO() as out:
        image = Pillow.fromarray(pixels)
        image.save(out, "JPEG", quality=_QUALITY, subsampling=_FULL_COLOUR)
        return out.getvalue()


def padded(data: bytes, size: int, secret: str) -> bytes:
    """Return a JPEG file of exactly `size` bytes: chance bytes follow its end, which nobody reads.

    Without them a folder sorted by size would mostly be sorted by warp distance (decision 33).
    They follow from a secret, so that the same study can be made again to the byte.
    """
    return data + hashlib.shake_256(secret.encode()).digest(size - len(data))


def write_all(pictures: Mapping[str, Path], folder: Path, seed: str) -> None:
    """Put pictures in their folder, all of one size and time, in the order of their names."""
    size = max(path.stat().st_size for path in pictures.values()) + _LEAST_PADDING
    for name in sorted(pictures):
        put(padded(pictures[name].read_bytes(), size, f"{seed}:{name}"), folder / name)
    same_time([folder / name for name in pictures])


def same_time(paths: Iterable[Path]) -> None:
    """Give files one time of change, so that their order isn't known from it."""
    for path in paths:
        os.utime(path, (_CHANGED_S, _CHANGED_S))
