"""What the film strip shows of a photo, read by a worker: what was done to it, stars, a picture."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np
from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QColorSpace, QImage, QImageReader

from kogao_core.base.display import Rgb8, preview
from kogao_core.base.geometry import Box
from kogao_core.base.strict import BadFile
from kogao_core.faces.doubt import doubtful
from kogao_core.photo import READABLE, UnreadablePhoto, read
from kogao_core.photo.metadata.glance import UNRATED, Rated, rating_of
from kogao_core.pipeline import render
from kogao_core.projects import sidecar
from kogao_core.projects.project import Project, load, sha256_of
from kogao_core.projects.results import Results

from ...render.colour import on_screen
from ...render.pictures import qt_image

THUMBNAIL_PX: Final = 72
_RAW: Final = "RAW"  # takes seconds to develop
_FINER: Final = 3  # how much larger than it is shown an edited photo is warped
Mark = Literal["", "edited", "saved", "doubtful", "result", "failed"]


@dataclass(frozen=True, slots=True)
class Facts:
    """What there is to tell of a photo."""

    mark: Mark = ""
    rated: Rated = UNRATED


def facts_of(path: Path, results: Results, edits: Path) -> Facts:
    """Return what was done to a photo, and its stars."""
    rating = UNRATED
    with suppress(OSError):  # whoever opens it finds a sentence
        rating = rating_of(path)
    return Facts(_mark_of(path, results, edits), rating)


def _mark_of(path: Path, results: Results, edits: Path) -> Mark:
    """Return whether a photo is edited, a copy of that is there, and whether to look at it."""
    if results.origin(path) is not None:
        return "result"
    file, made = sidecar.kept(path, edits), results.of(path)
    if file is None:
        return "saved" if made else ""
    digest = sha256_of(file)
    if any(one.edit == digest for one in made):
        return "saved"
    return "doubtful" if _has_doubts(file) else "edited"


def _has_doubts(file: Path) -> bool:
    """Tell whether a project leaves faces alone that were doubted."""
    try:
        project = load(file)
    except BadFile:  # it is said when the photo is opened
        return False
    size, sheet = project.original, project.automatic
    doubted = doubtful(sheet.faces, Box(0, 0, size.width, size.height))
    return project.mode == "automatic" and bool(sheet.off & doubted)


def thumbnail(path: Path, side_px: int = 2 * THUMBNAIL_PX, edits: Path | None = None) -> QImage:
    """Return a small upright picture of a photo, with its edits; null of raw and damaged files."""
    file = None if edits is None else sidecar.kept(path, edits)
    picture = _read(path, side_px if file is None else _FINER * side_px)
    if file is not None and not picture.isNull():
        picture = _edited(picture, file)
        keep = Qt.AspectRatioMode.KeepAspectRatio
        smooth = Qt.TransformationMode.SmoothTransformation
        picture = picture.scaled(side_px, side_px, keep, smooth)
    return on_screen(picture)


def _read(path: Path, side_px: int) -> QImage:
    reader = QImageReader(str(path))
    reader.setAutoTransform(True)
    size = reader.size()
    if size.isValid():
        room = QSize(side_px, side_px)
        reader.setScaledSize(size.scaled(room, Qt.AspectRatioMode.KeepAspectRatio))
    picture = reader.read()
    if picture.isNull() and READABLE.get(path.suffix.lower()) != _RAW:
        picture = _decoded(path, side_px)
    return picture


def _decoded(path: Path, side_px: int) -> QImage:
    """Return a small picture of what the core reads and Qt doesn't, such as HEIC."""
    try:
        photo = read(path, bits=8)
    except UnreadablePhoto:
        return QImage()
    picture = QImage.fromData(preview(photo.pixels, side_px))
    if photo.icc_profile is not None:
        picture.setColorSpace(QColorSpace.fromIccProfile(photo.icc_profile))
    return picture


def _edited(picture: QImage, file: Path) -> QImage:
    """Return a picture as a project makes it; as it is where the project can't be used."""
    try:
        return _rendered(picture, load(file))
    except BadFile:  # it is said when the photo is opened
        return picture


def _rendered(picture: QImage, project: Project) -> QImage:
    kinds = QImage.Format
    kind = kinds.Format_RGBA8888 if picture.hasAlphaChannel() else kinds.Format_RGB888
    pixels = _pixels(picture.convertToFormat(kind))
    done = sidecar.apply(project, pixels)
    rendering = render(
        *(pixels, done.faces, done.recipe),
        protection=done.protection,
        brushwork=done.brushwork,
    )
    # Qt's view of an array doesn't own it.
    made = qt_image(np.ascontiguousarray(rendering.pixels)).copy()
    made.setColorSpace(picture.colorSpace())
    return made


def _pixels(picture: QImage) -> Rgb8:
    """Return the pixels of a picture of 8-bit channels, (H, W, 3) or (H, W, 4)."""
    rows = np.frombuffer(picture.constBits(), np.uint8).reshape(picture.height(), -1)
    channels = 4 if picture.hasAlphaChannel() else 3
    plain = rows[:, : channels * picture.width()].reshape(picture.height(), -1, channels)
    return plain.copy()  # what it views goes with the picture
