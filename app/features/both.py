"""Compare manual and automatic landmarks: two pictures, setting and computing times, distances."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, get_args

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QWidget

from kogao_core.faces.targets import Differences, differences, matching
from kogao_core.photo import Photo
from kogao_core.pipeline import Rendering
from kogao_core.projects.project import Mode

from ..ahead import FaceSearch
from ..canvas.tools import marking
from ..canvas.viewport import OtherModeView, plate_on
from ..document import State
from ..i18n import reason, tr
from ..render.live import Holding, Surface
from ..theme import GRID_PX
from ..view_state import RenderedFrame
from ..widgets.controls import action_button, column_of, heading, muted_label, row_of
from ..widgets.docks import Dock
from ..workspaces import Workspace
from .faces import Faces
from .feature import Context, Feature
from .manual import Manual

_NONE: Final = "–"  # noqa: RUF001
# Index of a face set by hand, index of the matching face found, and their differences.
FaceCompared = tuple[int, int, Differences]


class ComparisonPanel(QWidget):
    """Table 2 of the paper for this photo, and the distances between the two sets of landmarks."""

    def __init__(self, methods: QAction | None) -> None:
        super().__init__()
        grid = QGridLayout()
        grid.setHorizontalSpacing(4 * GRID_PX)
        for column, title in enumerate((tr("Setting"), tr("Computing"), tr("Total")), 1):
            head = muted_label(title)
            head.setAlignment(Qt.AlignmentFlag.AlignRight)
            grid.addWidget(head, 0, column)
        self.times: dict[Mode, list[QLabel]] = {}
        for row, mode in enumerate(get_args(Mode), 1):
            grid.addWidget(QLabel(title_of(mode)), row, 0)
            self.times[mode] = [QLabel() for _ in range(3)]
            for column, cell in enumerate(self.times[mode], 1):
                cell.setAlignment(Qt.AlignmentFlag.AlignRight)
                grid.addWidget(cell, row, column)
        self.apart = muted_label(wraps=True)
        times, points = QWidget(), QWidget()
        column_of(times, heading(tr("Times")), grid, None)
        head = heading(tr("How far the points lie apart"))
        below = row_of(*(() if methods is None else (action_button(methods),)), None)
        right = column_of(points, head, self.apart, below, spacing=2 * GRID_PX)
        right.setStretchFactor(self.apart, 1)
        beside = QHBoxLayout(self)
        beside.setContentsMargins(3 * GRID_PX, 2 * GRID_PX, 3 * GRID_PX, 2 * GRID_PX)
        beside.setSpacing(8 * GRID_PX)
        beside.addWidget(times)
        beside.addWidget(points, 1)

    def show_times(
        self,
        mode: Mode,
        setting_s: float | None,
        computing_s: float | None,
        cold: bool | None = None,
    ) -> None:
        """Show the times of a mode in s; None: nothing was set or computed."""
        texts = _as_text(setting_s, computing_s, cold)
        for cell, text in zip(self.times[mode], texts, strict=True):
            cell.setText(text)


class BothModes(Feature):
    """Updates the other mode's picture, the times and the guide in *Manual vs automatic*.

    While the clock of manual mode runs, the automatic points, their result and all distances are
    hidden: they would show the answer.
    """

    name = "both"

    def __init__(
        self,
        context: Context,
        faces: Faces,
        manual: Manual,
        methods: QAction | None,
    ) -> None:
        super().__init__(context)
        self._faces, self._clock = faces, manual.clock
        self._surface: Surface | None = None
        self._revision, self._on, self._listens = 0, False, False
        self._followed: tuple[object, ...] = ()
        self._compared: tuple[FaceCompared, ...] = ()
        self._computing_s: dict[Mode, float] = {}
        self._lane = self.lane(self._take, self._not_drawn)
        self._timing = self.lane(self._timed, lambda _: None)
        self.beside = OtherModeView(self.window.canvas)
        self.window.stage.add_view(self.beside)
        self.here = plate_on(self.window.canvas)
        self.guide = QLabel()
        self.guide.setProperty("bar", "hint")
        self.guide.setContentsMargins(3 * GRID_PX, 2 * GRID_PX, 3 * GRID_PX, 2 * GRID_PX)
        self.guide.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.guide.setWordWrap(True)
        self.guide.setAccessibleName(tr("What to do next"))
        self.window.stage.show_below(self.guide)
        self.panel: ComparisonPanel = ComparisonPanel(methods)
        self.dock = Dock(tr("Comparison"))
        self.window.arranged.connect(self._arrange)
        self.document.opened.connect(self._open)
        self.document.recoloured.connect(self._open)
        self.view.watch(self._measure, "full")
        manual.changed.connect(self._follow)
        self._clock.ticked.connect(self._show_times)
        self._faces.found.connect(lambda _: self._time_search())
        self._show_views()

    def _arrange(self, workspace: Workspace) -> None:
        self._on, self._followed = self.name in workspace.panels, ()
        self._time_search()
        self._show_views()
        # Other workspaces have one listener less.
        if self._on and not self._listens:
            self._listens = True
            self.document.watch(self._follow)
        else:
            self._follow()

    def _show_views(self) -> None:
        for widget in (self.beside, self.here, self.guide):
            widget.setVisible(self._on and self.document.photo is not None)

    def _open(self) -> None:
        self._lane.drop()
        pyramid, photo = self.document.pyramid, self.document.photo
        self._followed, self._computing_s = (), {}
        if pyramid is not None and photo is not None:
            self._surface = Surface(pyramid, Holding(photo.pixels, self.live.finder))
            self.beside.shown.set(frame=None, full=None)
        self._show_views()

    def _follow(self) -> None:
        if not self._on or self._surface is None:
            return
        state, beside = self.document.state, self.beside
        self.window.stage.put_last(beside if state.mode == "automatic" else self.window.canvas)
        self.here.setText(title_of(state.mode))
        self.here.adjustSize()
        setting = state.mode == "manual" and not self._clock.applied
        hidden = tr("Automatic: hidden until Apply")
        beside.plate.setText(hidden if setting else title_of(state.other_mode))
        beside.plate.adjustSize()
        self.guide.setText(next_step(state, self._clock.applied))
        beside.shown.set(pointed=frozenset() if setting else None, original=setting)
        self._show_distances()
        self._show_times()
        # A gesture moves points of this mode only: the result of the other mode stays valid.
        now = (
            *(state.mode, state.kept, state.protection, state.loose, state.brushwork),
            self.document.committed,
        )
        if now != self._followed and not self.document.in_gesture:
            self._followed = now
            self._revision += 1
            surface, revision = self._surface, self._revision
            self._lane.submit(
                lambda: (surface.render(revision, state.in_other_mode), faces_compared(state))
            )

    def _take(self, compared: tuple[RenderedFrame, tuple[FaceCompared, ...]]) -> None:
        frame, faces = compared
        if self._surface is not None:
            self._surface.shown()
        self.beside.shown.set(frame=frame, full=frame)
        self._computing_s[self.document.state.other_mode] = computing_s_of(frame.rendering)
        self._compared = faces
        self._show_distances()
        self._show_times()

    def _show_distances(self) -> None:
        setting = self.document.state.mode == "manual" and not self._clock.applied
        hidden = tr("Shown after Apply (Ctrl+Return).")
        self.panel.apart.setText(hidden if setting else summary(self._compared))

    def _measure(self) -> None:
        if self.view.full is not None:
            rendering = self.view.full.rendering
            self._computing_s[self.document.state.mode] = computing_s_of(rendering)
        self._show_times()

    def _show_times(self) -> None:
        if not self._on:
            return
        setting_s = {"manual": self._clock.elapsed_s, "automatic": self._faces.finding_s}
        for mode in get_args(Mode):
            there = bool(self.document.state.sheet(mode).active)
            times = setting_s[mode], self._computing_s.get(mode)
            cold = self._faces.finding_was_cold if mode == "automatic" else None
            self.panel.show_times(mode, *(times if there else (None, None)), cold)

    def _time_search(self) -> None:
        """Time a search for faces if the faces of the photo come from saved edits."""
        photo, faces = self.document.photo, self._faces
        if self._on and photo is not None and faces.finding_s is None and not faces.busy:
            search = faces.search()
            self._timing.submit(lambda: (photo, search, search.run(photo)))
        self._show_times()

    def _timed(self, ran: tuple[Photo, FaceSearch, object]) -> None:
        photo, search, _ = ran
        if photo is self.document.photo and self._faces.finding_s is None:
            self._faces.finding_s, self._faces.finding_was_cold = search.took_s, search.cold
            self._show_times()

    def _not_drawn(self, problem: Exception) -> None:
        text = tr("The two modes can't be compared ({why}).", why=reason(problem))
        revision = self._revision
        self.say(text, applies=lambda: self._on and self._revision == revision)


def next_step(state: State, applied: bool) -> str:
    """Return the next step of the comparison, in a sentence or two."""
    by_hand = state.sheet("manual")
    if state.mode == "automatic" and not by_hand.faces:
        return tr(
            "1 of 3: The machine has set its points. Press Manual (F3) and set yours; the clock "
            "runs from there."
        )
    if state.mode == "manual" and not state.faces:
        return tr("2 of 3: {what}", what=marking.next_hint(state))
    if state.mode == "manual" and not applied:
        return tr(
            "2 of 3: {what}. Once the outline is complete, Apply (Ctrl+Return) stops the clock.",
            what=marking.next_hint(state),
        )
    return tr(
        "3 of 3: The table below compares manual and automatic. Methods (Ctrl+Alt+4) applies other "
        "warps to the same points."
    )


def faces_compared(state: State) -> tuple[FaceCompared, ...]:
    """Return the differences between each face set by hand and the matching face found."""
    manual, automatic = state.sheet("manual"), state.sheet("automatic")
    faces = []
    for index, face in enumerate(manual.faces):
        other = matching(face, automatic.faces)
        if other is not None:
            found = automatic.faces[other]
            apart = differences(face, found, (manual.recipe, automatic.recipe))
            faces.append((index, other, apart))
    return tuple(faces)


def computing_s_of(rendering: Rendering) -> float:
    """Return the computing time as in table 2, s."""
    return sum(rendering.timings_ms.values()) / 1e3


def summary(faces: Sequence[FaceCompared]) -> str:
    """Return mean and largest distance of landmarks and targets for each face."""
    if not faces:
        return tr("No face marked by hand matches a face found.")
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


def _as_text(setting_s: float | None, computing_s: float | None, cold: bool | None) -> list[str]:
    """Return setting time, computing time and their sum, as text; a dash if one is unknown.

    `cold`: whether the automatic setting time contains loading the networks.
    """
    known = setting_s is not None and computing_s is not None
    total_s = (setting_s or 0.0) + (computing_s or 0.0) if known else None
    times_s = setting_s, computing_s, total_s
    texts = [_NONE if s is None else _duration(s) for s in times_s]
    if setting_s is not None and cold is not None:
        words = tr("{time}, cold", time=texts[0]) if cold else tr("{time}, warm", time=texts[0])
        texts[0] = words
    return texts


def _duration(time_s: float) -> str:
    """Return a time in ms, or in seconds from 10 s."""
    return tr("{ms:,.0f} ms", ms=1e3 * time_s) if time_s < 10.0 else tr("{s:,.1f} s", s=time_s)


def title_of(mode: Mode) -> str:
    """Return the name of a mode."""
    return tr("Manual") if mode == "manual" else tr("Automatic")
