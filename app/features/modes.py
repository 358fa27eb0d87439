"""Renders what was set by hand and what the machine found, in a worker, for the comparison."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from PySide6.QtWidgets import (
    QGridLayout,
    QLabel,
    QTableWidget,
    QWidget,
)

from kogao_core.background.find import held_of
from kogao_core.background.holding import Held
from kogao_core.base.display import Rgb8, reduced
from kogao_core.base.geometry import Box
from kogao_core.faces.targets import Differences, differences, matching
from kogao_core.pipeline import Rendering, render
from kogao_core.projects.project import Mode, Sheet
from kogao_core.projects.sidecar import Applied

from ..canvas.handles import name
from ..document import State
from ..i18n import reason, tr
from ..render.pictures import PicturePyramid, scaled
from ..theme import GRID_PX
from ..view_state import Handle
from ..widgets.controls import column_of, heading, muted_label
from ..widgets.dialogs import Dialog, table
from .faces import Faces
from .feature import Context, Feature
from .manual import Manual

MODES: Final[tuple[Mode, ...]] = ("manual", "automatic")
_MARGIN: Final = 0.25  # of the faces' larger side
_LONGEST_SIDE_PX: Final = 1024
_PICTURE_PX = 320
_HEIGHT_PX = 800
_NONE = "–"  # noqa: RUF001


# A face set by hand, the one found there, by their places in their modes, and how they differ.
FaceCompared = tuple[int, int, Differences]


@dataclass(frozen=True, eq=False)
class Side:
    """One mode's result: the part of it round the faces, and the two times of table 2, s."""

    mode: Mode
    faces: int
    pixels: Rgb8
    setting_s: float | None
    computing_s: float | None
    cold: bool | None = None  # whether networks were loaded in the setting time; None for people


@dataclass(frozen=True, eq=False)
class ModesCompared:
    """Both modes, and how far each face's points lie apart; pairs of face indices first."""

    sides: list[Side]
    faces: tuple[FaceCompared, ...]


class Modes(Feature):
    """Compares the two modes of the document."""

    def __init__(self, context: Context, faces: Faces, manual: Manual) -> None:
        super().__init__(context)
        self._faces, self._clock = faces, manual.clock
        self._lane = self.lane(self._show, self._not_compared)
        self.comparing = self.add_action(
            "compare-modes",
            tr("&Both modes…"),
            "F4",
            tr("Manual and automatic side by side, with their times"),
            self.compare,
        )
        manual.panel.add_button(self.comparing)

    def compare(self) -> None:
        """Render both modes as they are now."""
        pyramid, photo, state = self.document.pyramid, self.document.photo, self.document.state
        if pyramid is None or photo is None:
            return
        self.window.bar.clear()
        # Time spent without marking anything sets nothing.
        by_hand = self._clock.elapsed_s if state.sheet("manual").faces else None
        held = partial(held_of, photo.pixels, finder=self.live.finder)
        times, cold = (by_hand, self._faces.finding_s), self._faces.finding_was_cold
        self._lane.submit(lambda: compared(pyramid, held, state, times, cold))

    def _show(self, both: ModesCompared) -> None:
        ModesDialog(both, self.window).open()

    def _not_compared(self, problem: Exception) -> None:
        text = tr("The two modes can't be compared ({why}).", why=reason(problem))
        self.say(text)


def compared(
    photo: PicturePyramid,
    held: Callable[[Applied], Held],
    state: State,
    times: tuple[float | None, float | None],
    cold: bool,
) -> ModesCompared:
    """Render both modes of `state`; `times` are the setting times, manual first, s.

    `held` tells what is held of the background, `cold` whether networks were loaded meanwhile.
    """
    manual, automatic = state.sheet("manual"), state.sheet("automatic")
    box = _round_faces(manual, automatic, Box.of(photo.levels[0]))
    given = zip(MODES, times, (None, cold), strict=True)
    sides = [_side(*one, state, held, photo, box) for one in given]
    return ModesCompared(sides, faces_compared(state))


def faces_compared(state: State) -> tuple[FaceCompared, ...]:
    """Return how far the points of each face set by hand lie from those found."""
    manual, automatic = state.sheet("manual"), state.sheet("automatic")
    faces = []
    for index, face in enumerate(manual.faces):
        other = matching(face, automatic.faces)
        if other is not None:
            found = automatic.faces[other]
            apart = differences(face, found, (manual.recipe, automatic.recipe))
            faces.append((index, other, apart))
    return tuple(faces)


def _side(
    mode: Mode,
    setting_s: float | None,
    cold: bool | None,
    state: State,
    held: Callable[[Applied], Held],
    photo: PicturePyramid,
    box: Box,
) -> Side:
    done = state.done_by(mode)
    rendering = render(
        *(photo.levels[0], done.faces, done.recipe),
        protection=done.protection,
        held=held(done),
        brushwork=done.brushwork,
    )
    rows, columns = box.slices
    # Here, off the GUI thread: a face of a large photo has many times a dialog's pixels.
    small = reduced(rendering.pixels[rows, columns], _LONGEST_SIDE_PX)
    seen = PicturePyramid(small, photo.show).shown[0]
    computing_s = computing_s_of(rendering) if done.faces else None
    return Side(mode, len(done.faces), seen, setting_s, computing_s, cold)


def computing_s_of(rendering: Rendering) -> float:
    """Return what table 2 calls the computing time, s."""
    return sum(rendering.timings_ms.values()) / 1e3


def _round_faces(first: Sheet, second: Sheet, image: Box) -> Box:
    faces = (*first.faces, *second.faces)
    if not faces:
        return image
    points = np.vstack([face.points for face in faces])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = _MARGIN * float((high - low).max())
    left, top = np.floor(low - margin).astype(int).tolist()
    right, bottom = np.ceil(high + margin).astype(int).tolist()
    return Box(left, top, right, bottom).clipped(image)


class ModesDialog(Dialog):
    """Two pictures above the times of table 2 and a table of points."""

    def __init__(self, comparison: ModesCompared, parent: QWidget) -> None:
        width_px = 2 * _PICTURE_PX + 12 * GRID_PX
        super().__init__(tr("Manual and automatic"), parent, (width_px, _HEIGHT_PX))
        self.times = _times_table(comparison.sides)
        self.points = _points_table(comparison)
        grid = QGridLayout()
        grid.setSpacing(3 * GRID_PX)
        for column, side in enumerate(comparison.sides):
            grid.addWidget(heading(_title(side)), 0, column)
            grid.addWidget(_picture(side, self.devicePixelRatioF()), 1, column)
        rows = column_of(
            self,
            grid,
            self.times,
            heading(tr("How far the points lie apart")),
            muted_label(summary(comparison.faces)),
            self.points,
            self.closing(),
            margin=4 * GRID_PX,
            spacing=3 * GRID_PX,
        )
        rows.setStretchFactor(self.points, 1)


def summary(faces: Sequence[FaceCompared]) -> str:
    """Return mean and largest difference of landmarks and targets over all faces."""
    if not faces:
        return tr("No face is marked by hand where one was found.")
    return "\n".join(
        tr(
            "face {n}: landmarks {mean:.1f} px on average, up to {most:.1f} px; "
            "targets {t_mean:.1f} px, up to {t_most:.1f} px",
            n=index + 1,
            mean=apart.landmarks_px.mean(),
            most=apart.landmarks_px.max(),
            t_mean=apart.targets_px.mean(),
            t_most=apart.targets_px.max(),
        )
        for index, _, apart in faces
    )


def seconds(
    setting_s: float | None, computing_s: float | None, cold: bool | None = None
) -> list[str]:
    """Return the two times of table 2 and their sum in words; a dash for what there isn't.

    `cold` tells of automatic setting whether the networks were loaded in it.
    """
    known = setting_s is not None and computing_s is not None
    total = (setting_s or 0.0) + (computing_s or 0.0) if known else None
    times = (setting_s, computing_s, total)
    texts = [_NONE if s is None else tr("{s:.2f} s", s=s) for s in times]
    if setting_s is not None and cold is not None:
        texts[0] = (
            tr("{s:.2f} s, cold", s=setting_s) if cold else tr("{s:.2f} s, warm", s=setting_s)
        )
    return texts


def title_of(mode: Mode) -> str:
    """Return what a mode is called beside the other one."""
    return tr("Manual") if mode == "manual" else tr("Automatic")


def _title(side: Side) -> str:
    return tr("{mode}, faces: {n}", mode=title_of(side.mode), n=side.faces)


def _picture(side: Side, ratio: float) -> QLabel:
    label = QLabel()
    label.setPixmap(scaled(side.pixels, _PICTURE_PX, ratio))
    label.setAccessibleName(_title(side))
    return label


def _times_table(sides: list[Side]) -> QTableWidget:
    head = [tr("Time"), tr("Setting"), tr("Computing"), tr("Total")]
    rows = []
    for side in sides:
        times = seconds(side.setting_s, side.computing_s, side.cold)
        rows.append([title_of(side.mode), *times])
    made = table(tr("Times"), head, rows)
    made.setFixedHeight(
        made.horizontalHeader().sizeHint().height() + len(rows) * made.rowHeight(0) + 4
    )
    return made


def _points_table(comparison: ModesCompared) -> QTableWidget:
    head = [tr("Face"), tr("By hand"), tr("Found"), tr("Landmark"), tr("Target")]
    rows = []
    for index, _, apart in comparison.faces:
        for point, partner in enumerate(apart.partners.tolist()):
            label = name(Handle("outline", index, point), len(apart.partners))
            px = (apart.landmarks_px[point], apart.targets_px[point])
            far = (tr("{px:.1f} px", px=value) for value in px)
            rows.append([str(index + 1), label, str(partner + 1), *far])
    return table(tr("Points"), head, rows)
