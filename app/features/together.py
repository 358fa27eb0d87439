"""Photos side by side: the photos selected on the film strip, with one zoom and pan for all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QGridLayout

from kogao_core.background.find import BackgroundFinder
from kogao_core.base.geometry import Box
from kogao_core.photo.optics import optics_of

from ..actions import TABLE, Item
from ..canvas.photo_canvas import ARROWS
from ..canvas.viewport import Viewport, plate_on
from ..document import Document
from ..i18n import reason, tr, translated
from ..pyramid import PicturePyramid
from ..render.live import Holding, Surface
from ..theme import GRID_PX
from ..view_state import ViewState, VisiblePart
from ..widgets.controls import Elided, action_button, column_of, row_of
from ..widgets.dialogs import Dialog
from ..window import Window
from .feature import Context, Feature
from .files.opening import Opened, open_photo
from .strip import Strip

_MOST: Final = 6
_IN_A_ROW: Final = 3
# Longer side of the copies, from 0.75 to 1.5 times as much: full photos would need gigabytes.
_SIDE_PX: Final = 1600
_STEP: Final = 1.5
_AROUND: Final = 0.5  # margin around faces, as a fraction of their width
_PAN_PX: Final = 40.0


@dataclass(frozen=True, eq=False)
class Versions:
    """A photo before and after its edits, reduced; `told` names the edits."""

    before: PicturePyramid
    after: PicturePyramid
    told: str
    faces: QRectF  # around all faces, px of the reduced photo; null without faces


def versions_of(opened: Opened, finder: BackgroundFinder) -> Versions:
    """Return reduced versions of an opened photo; without edits, both are the original."""
    photo, whole, state = opened.photo, opened.pyramid, opened.state
    level = whole.level_for(_SIDE_PX / max(photo.width, photo.height))
    before = PicturePyramid(whole.levels[level], whole.show)
    if state is None:
        return Versions(before, before, tr("no edits"), QRectF())
    state = replace(state, optics=optics_of(photo), image=Box.of(photo.pixels))
    holding = Holding(photo.pixels, finder)
    holding.whole(state)
    part = VisiblePart(level, Box.of(whole.levels[level]))
    made = Surface(whole, holding).render(0, state, part).rendering.pixels
    faces = QRectF()
    for face in state.active:
        left, top, width, height = (side / 2**level for side in face.box)
        more = _AROUND * width
        faces |= QRectF(left, top, width, height).adjusted(-more, -more, more, more)
    return Versions(before, PicturePyramid(made, whole.show), translated(state.done.what), faces)


class LinkedView(Viewport):
    """One of several photos. The wheel, a pinch and a drag move all; with Shift, only this one."""

    # (photo: Path): the user opens this photo.
    wanted = Signal(object)

    def __init__(self, path: Path, linked: list[LinkedView]) -> None:
        super().__init__(ViewState(document=Document()))
        self.path, self._linked, self._alone = path, linked, False
        self.versions: Versions | None = None
        self.plate = plate_on(self)
        self.setProperty("linked", "true")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setToolTip(tr("Double click or Return opens it; with Shift, a drag moves it alone"))
        self.tell("…")

    def tell(self, text: str) -> None:
        """Show the name of the photo and a text."""
        self.plate.setText(f"{self.path.name} · {text}")
        self.plate.adjustSize()
        self.setAccessibleName(self.plate.text())

    def take(self, versions: Versions, before: bool) -> None:
        """Show a photo that was read."""
        self.versions = versions
        self.show_version(before)
        self.fit()

    def show_version(self, before: bool) -> None:
        """Show the photo before or after its edits."""
        if (versions := self.versions) is not None:
            self.shown.document.recolour(versions.before if before else versions.after)
            self.tell(tr("before") if before else versions.told)

    def zoom_to(self, zoom: float, about: QPointF | None = None) -> None:
        """Zoom all photos by a factor, each at its own place below the pointer."""
        factor = zoom / self.zoom
        for one in self._linked:
            Viewport.zoom_to(one, factor * one.zoom, about)

    def pan(self, start: QPointF, end: QPointF) -> None:
        """Move all photos; with Shift, only this one."""
        for one in [self] if self.panning and self._alone else self._linked:
            Viewport.pan(one, start, end)

    def look_at_faces(self) -> None:
        """Zoom to the faces, or to the whole photo without known faces."""
        if self.versions is None or self.versions.faces.isNull():
            self.fit()
        else:
            self.look_at(self.versions.faces)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Start to pan."""
        self._alone = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        super().mousePressEvent(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: ARG002
        """Open the photo."""
        self.wanted.emit(self.path)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Pan with the arrow keys; open the photo with Return."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.wanted.emit(self.path)
        elif (step := ARROWS.get(Qt.Key(event.key()))) is not None:
            self.pan(QPointF(*step) * _PAN_PX, QPointF())
        else:
            event.ignore()


class TogetherDialog(Dialog):
    """Photos in one or two rows, with a switch between before and after."""

    def __init__(self, window: Window, paths: Sequence[Path]) -> None:
        title = tr("Photos side by side")
        super().__init__(title, window, window.size().toTuple())
        self.views: list[LinkedView] = []
        self.views += [LinkedView(path, self.views) for path in paths]
        grid, columns = QGridLayout(), -(-len(paths) // (1 + (len(paths) > _IN_A_ROW)))
        grid.setSpacing(GRID_PX // 2)
        for place, view in enumerate(self.views):
            view.setBackground(window.canvas.backgroundBrush())
            grid.addWidget(view, *divmod(place, columns))
        first = self.views[0]
        tip = tr("Show all photos before their edits")
        self.before = Item("", tr("Before"), "F4", tip, also=("\\",)).action(self)
        self.before.setCheckable(True)
        self.before.toggled.connect(self._show)
        acts: dict[str, Callable[[], object]] = {
            "fit": partial(self._each, LinkedView.fit),
            "zoom-face": partial(self._each, LinkedView.look_at_faces),
            "closer": lambda: first.zoom_to(first.zoom * _STEP),
            "farther": lambda: first.zoom_to(first.zoom / _STEP),
        }
        actions = [self.before, *(TABLE[name].action(self) for name in acts)]
        for action, act in zip(actions[1:], acts.values(), strict=True):
            action.triggered.connect(lambda _=False, act=act: act())
        self.addActions(actions)
        note = Elided()
        note.setText(tr("Large photos are reduced; open one to see each of its pixels"))
        note.setProperty("muted", "true")
        below = row_of(*map(action_button, actions), note, self.closing())
        below.setStretchFactor(note, 1)
        column_of(self, grid, below, margin=2 * GRID_PX).setStretchFactor(grid, 1)

    def _each(self, act: Callable[[LinkedView], None]) -> None:
        for view in self.views:
            act(view)

    def _show(self, before: bool) -> None:
        for view in self.views:
            view.show_version(before)


class Together(Feature):
    """Reads the selected photos one after the other and shows them side by side."""

    def __init__(self, context: Context, strip: Strip) -> None:
        super().__init__(context)
        self._strip, self._waiting = strip, list[LinkedView]()
        self.dialog: TogetherDialog | None = None  # the one that is open
        strip.film.addAction(self.bind("photos-side", self.start))
        self._reading = self.lane(self._show, self._fail)

    def start(self) -> None:
        """Show the selected photos, or ask for a selection."""
        paths = self._strip.chosen()
        if not 2 <= len(paths) <= _MOST:
            self.say(tr("Select two to six photos on the film strip first, with Shift or Ctrl."))
            return
        self.dialog = dialog = TogetherDialog(self.window, paths)
        for view in dialog.views:
            view.wanted.connect(dialog.accept)
            view.wanted.connect(self._strip.open)
        dialog.finished.connect(self._end)
        self._waiting = list(dialog.views)
        dialog.open()
        dialog.views[0].setFocus()
        self._next()

    def _end(self) -> None:
        self._reading.drop()
        self._waiting, self.dialog = [], None

    def _next(self) -> None:
        """Read the next photo; of the open photo, show the newest edits."""
        if not self._waiting:
            return
        path, photo, pyramid = self._waiting[0].path, self.document.photo, self.document.pyramid
        opened, finder = None, BackgroundFinder(self.live.finder.people)
        if photo is not None and pyramid is not None and path == self.document.path:
            opened = Opened(photo, pyramid, self.document.committed)
        storage = self.storage
        self._reading.submit(lambda: versions_of(opened or open_photo(path, storage), finder))

    def _show(self, versions: Versions) -> None:
        before = self.dialog is not None and self.dialog.before.isChecked()
        self._waiting.pop(0).take(versions, before)
        self._next()

    def _fail(self, problem: Exception) -> None:
        view = self._waiting.pop(0)
        view.tell(tr("can't be read"))
        view.setToolTip(reason(problem))
        self._next()
