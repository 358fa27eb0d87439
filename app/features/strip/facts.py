"""Edits, stars and thumbnail of a photo on the film strip, read by a worker."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np
from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QImage, QImageReader

from kogao_core.background.find import BackgroundFinder, MeasuredLines, held_of, measure
from kogao_core.background.holding import NOTHING_HELD
from kogao_core.base.display import Rgb8, eight_bits, png, reduced, rgb8
from kogao_core.base.geometry import Box
from kogao_core.base.json_reader import BadFile
from kogao_core.faces.doubt import verdicts
from kogao_core.photo import READABLE, UnreadablePhoto, profiles, read
from kogao_core.photo.metadata.rating import UNRATED, Rated, rating_of
from kogao_core.photo.picture import sha256_of
from kogao_core.pipeline import render
from kogao_core.projects import sidecar
from kogao_core.projects.edits import Edits
from kogao_core.projects.project import Project, load
from kogao_core.projects.results import Results

from ...i18n import tr, translated
from ...render.colour import on_screen
from ...render.pictures import qt_image

THUMBNAIL_PX: Final = 72
LARGEST_PX: Final = 200
_MEASURED_PX: Final = 800  # enough to find straight lines
_RAW: Final = "RAW"  # takes seconds to develop
_HEAD_BYTES: Final = 1 << 17  # where a file holds its profile
_LIMITED: Final = 0.995  # a face below this share of its displacement was limited
Mark = Literal["", "edited", "saved", "doubtful", "result", "failed"]


@dataclass(frozen=True, slots=True)
class Facts:
    """Mark and rating of a photo."""

    mark: Mark = ""
    rated: Rated = UNRATED


def facts_of(path: Path, results: Results, edits: Edits) -> Facts:
    """Return the mark and the rating of a photo."""
    rating = UNRATED
    with suppress(OSError):  # opening the photo shows the reason
        rating = rating_of(path)
    return Facts(_mark_of(path, results, edits), rating)


def _mark_of(path: Path, results: Results, edits: Edits) -> Mark:
    """Return the mark: result, edited or saved; empty without edits."""
    if results.origin(path) is not None:
        return "result"
    file, saved = edits.newest(path), results.edits_of(path)
    if file is None:
        return "saved" if saved else ""
    return "saved" if sha256_of(file) in saved else "edited"


@dataclass(frozen=True, eq=False)
class Preview:
    """A thumbnail with edits, and a warning; empty without problems."""

    picture: QImage
    warning: str


@dataclass(frozen=True, eq=False)
class Sample:
    """A photo reduced for thumbnails, and its project."""

    picture: QImage
    pixels: Rgb8
    project: Project
    side_px: int

    @staticmethod
    def of(path: Path, side_px: int, project: Project, read_px: int = LARGEST_PX) -> Sample:
        """Read a photo for previews of this size, at least at `read_px`. Raises BadFile."""
        picture = _read(path, max(read_px, side_px))
        if picture.isNull():
            raise BadFile(path.name)
        kinds = QImage.Format
        kind = kinds.Format_RGBA8888 if picture.hasAlphaChannel() else kinds.Format_RGB888
        return Sample(picture, _pixels(picture.convertToFormat(kind)), project, side_px)

    def drawn(self, project: Project, finder: BackgroundFinder | None = None) -> Preview:
        """Return the thumbnail with a project. Raises BadFile.

        With a finder, lines of the background are held, and lines that turn are a warning.
        """
        done = sidecar.apply(project, self.pixels)
        held = NOTHING_HELD if finder is None else held_of(self.pixels, done, finder)
        rendering = render(
            *(self.pixels, done.faces, done.recipe),
            protection=done.protection,
            held=held,
            brushwork=done.brushwork,
        )
        lines = None if finder is None else measure(self.pixels, rendering, done, finder)
        # QImage doesn't copy the array.
        made = qt_image(np.ascontiguousarray(rendering.pixels)).copy()
        made.setColorSpace(self.picture.colorSpace())
        return Preview(_reduced(made, self.side_px), _warning(project, rendering.shares, lines))


def _warning(project: Project, shares: Sequence[float], lines: MeasuredLines | None) -> str:
    """Return the reasons to check a result, one per line."""
    size, sheet = project.original, sidecar.sheet_of(project)
    judged = verdicts(sheet.faces, Box(0, 0, size.width, size.height))
    asks = ((n, one) for n, one in enumerate(judged) if one.reason is None or n in sheet.off)
    why = [translated(verdict.told(n + 1)) for n, verdict in asks]
    if min(shares, default=1.0) < _LIMITED:
        why.append(tr("limited to {n:.0f} % to avoid folding", n=100 * min(shares)))
    why.append(translated(lines.told) if lines else "")
    return "\n".join(filter(None, why))


def thumbnail(
    path: Path,
    side_px: int = THUMBNAIL_PX,
    edits: Edits | None = None,
    finder: BackgroundFinder | None = None,
) -> Preview:
    """Return a small upright preview of a photo with its edits; null for raw and damaged files.

    With a finder, its warning tells of lines that turn.
    """
    file = None if edits is None else edits.newest(path)
    if file is not None:
        with suppress(BadFile):  # the reason is shown when the photo is opened
            project = load(file)
            read_px = LARGEST_PX if finder is None else _MEASURED_PX
            return Sample.of(path, side_px, project, read_px).drawn(project, finder)
    return Preview(on_screen(_read(path, side_px)), "")


def _reduced(picture: QImage, side_px: int) -> QImage:
    keep, smooth = Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
    return on_screen(picture.scaled(side_px, side_px, keep, smooth))


def _read(path: Path, side_px: int) -> QImage:
    reader = QImageReader(str(path))
    reader.setAutoTransform(True)
    size = reader.size()
    if size.isValid():
        room = QSize(side_px, side_px)
        reader.setScaledSize(size.scaled(room, Qt.AspectRatioMode.KeepAspectRatio))
    picture = reader.read()
    is_unknown = picture.isNull() or _names_colours(path)
    if is_unknown and READABLE.get(path.suffix.lower()) != _RAW:
        picture = _decoded(path, side_px)
    return picture


def _names_colours(path: Path) -> bool:
    """Return whether a photo has colours that Qt doesn't know: a CICP name, or XYB."""
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    return b"cICP" in head or b"A2B0" in head


def _decoded(path: Path, side_px: int) -> QImage:
    """Return a thumbnail of a format or of colours that Qt doesn't read, such as HEIC."""
    try:
        photo = read(path, bits=8)
    except UnreadablePhoto:
        return QImage()
    pixels = reduced(eight_bits(photo.pixels), side_px)
    if photo.icc_profile is not None:
        with suppress(*profiles.DAMAGED):
            pixels = profiles.to_srgb(pixels, photo.icc_profile)
    return QImage.fromData(png(rgb8(pixels)))


def _pixels(picture: QImage) -> Rgb8:
    """Return the pixels of a picture of 8-bit channels, (H, W, 3) or (H, W, 4)."""
    rows = np.frombuffer(picture.constBits(), np.uint8).reshape(picture.height(), -1)
    channels = 4 if picture.hasAlphaChannel() else 3
    plain = rows[:, : channels * picture.width()].reshape(picture.height(), -1, channels)
    return plain.copy()  # copy: the view refers to the image's memory
