"""Live display: a quick preview during a gesture, the full result afterwards."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from functools import partial
from typing import Any, Final, TypeVar

from PySide6.QtCore import QObject, QThreadPool, QTimer, Signal

from kogao_core.background.find import Background, BackgroundFinder
from kogao_core.background.holding import NOTHING_HELD, Held
from kogao_core.base.geometry import Affine, Image
from kogao_core.field.protection import Protection
from kogao_core.pipeline import measure, render
from kogao_core.resample.canvas import Canvas

from ..document import State
from ..pyramid import PicturePyramid, to_photo
from ..view_state import RenderedFrame, ViewState, VisiblePart
from ..workers import Lane

# Delay before the full photo is rendered, ms. A new movement restarts the delay.
REST_MS: Final = 80
_Mapped = TypeVar("_Mapped", Protection, Held)


class Holding:
    """Analyses the background once per set of faces. Previews reuse the last result."""

    def __init__(self, photo: Image, finder: BackgroundFinder) -> None:
        self._photo, self._finder = photo, finder
        self._last: Background | None = None

    @property
    def background(self) -> Background | None:
        """The last background analysis, or None."""
        return self._last

    def whole(self, state: State) -> Held:
        """Analyse the background; return the edges and people to keep in place, px of the photo."""
        done = state.done
        if done.faces and done.recipe.hold_background:
            self._last = self._finder.find(self._photo, done.faces, done.others)
        return self.preview(state)

    def preview(self, state: State) -> Held:
        """Return the constraints of the last analysis, or `NOTHING_HELD` if it fits other faces."""
        if self._last is None or not state.recipe.hold_background:
            return NOTHING_HELD
        held = self._last.held(state.loose)
        return held if len(held.neighbours) == len(state.active) else NOTHING_HELD


class Surface:
    """Two buffers for one picture: one is on screen, the other is rendered to.

    A worker calls `render`; the GUI thread calls `shown` while no worker runs. A buffer is
    discarded after a failed rendering, since the pyramid levels may be inconsistent.
    """

    def __init__(self, photo: PicturePyramid, holding: Holding | None = None) -> None:
        self._photo, self._holding = photo, holding
        self._part: VisiblePart | None = None
        self._front: tuple[Canvas, PicturePyramid] | None = None
        self._back: tuple[Canvas, PicturePyramid] | None = None
        # Protection and constraints, and each mapped to the part. The warp is updated partially
        # only if the protection is the same object; the mapped constraints cache results.
        self._mapped: dict[type, tuple[Any, Any]] = {}
        self._is_lent = False

    def render(self, revision: int, state: State, part: VisiblePart | None = None) -> RenderedFrame:
        """Render to the buffer off screen and return the frame."""
        start = time.perf_counter()
        if part != self._part:
            self._part, self._front, self._back, self._mapped = part, None, None, {}
        (canvas, result), self._back = self._back or self._buffer(), None
        faces, recipe, protection = state.active, state.done.recipe, state.protection
        brushwork = state.brushwork
        held, back, whole = self._held(state, part), to_photo(0), None
        if part is not None:
            back = to_photo(part.level, (part.box.left, part.box.top))
            there = back.inverse
            faces, brushwork = [face.mapped(there) for face in faces], brushwork.mapped(there)
            protection, held = self._mapped_to(there, protection), self._mapped_to(there, held)
            whole = self._photo.whole_of(part.level, part.box)
            recipe = dataclasses.replace(recipe.at_scale(there.scale), interpolation="bilinear")
        rendering = render(
            canvas.source,
            faces,
            recipe,
            protection=protection,
            held=held,
            brushwork=brushwork,
            canvas=canvas,
            whole=whole,
        )
        result.refresh(rendering.changed)
        self._back = canvas, result
        took_ms = (time.perf_counter() - start) * 1e3
        figures = measure(rendering, counts=part is None)
        shown, done = result.shown, state.done
        return RenderedFrame(revision, rendering, figures, done, shown, back, took_ms, part)

    def _mapped_to(self, there: Affine, what: _Mapped) -> _Mapped:
        known = self._mapped.get(type(what))
        if known is None or known[0] is not what:
            known = self._mapped[type(what)] = what, what.mapped(there)
        mapped: _Mapped = known[1]
        return mapped

    def _held(self, state: State, part: VisiblePart | None) -> Held:
        if self._holding is None:
            return NOTHING_HELD
        return self._holding.whole(state) if part is None else self._holding.preview(state)

    def shown(self) -> None:
        """Swap the buffers after the last frame went on screen."""
        self._front, self._back = self._back, None if self._is_lent else self._front
        self._is_lent = False

    def lent(self) -> Image | None:
        """Return the pixels of the visible frame. The buffer is not reused for later frames."""
        self._is_lent = self._front is not None
        return None if self._front is None else self._front[0].pixels

    def _buffer(self) -> tuple[Canvas, PicturePyramid]:
        part = self._part
        source = self._photo if part is None else self._photo.part(part.level, part.box)
        canvas = Canvas(source.levels[0])
        return canvas, source.over(canvas.pixels)


class Live(QObject):
    """Renders the document to `ViewState.frame` and `ViewState.full`.

    0. While a photo opens and faces are detected, only marks are drawn (`wait`, `go_on`).
    1. The document changes: `_follow` takes the state and a revision, and requests a preview of
       the visible part. A request replaces the waiting request.
    2. A worker renders the preview into the buffer off screen.
    3. `_show_preview` swaps the buffers and sets the frame, unless a newer full result is shown.
    4. After a pause, the full photo is rendered the same way, with the recipe's kernel.
       `settled` is emitted when both lanes are idle.
    """

    # (): the final frame is on screen, and no job runs or waits.
    settled = Signal()
    # (problem: Exception): a job failed; the frame stays.
    failed = Signal(object)

    def __init__(
        self,
        view: ViewState,
        visible_part: Callable[[], VisiblePart | None],
        pool: QThreadPool,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._view, self._document, self._visible_part = view, view.document, visible_part
        self._revision = 0
        self._followed: State | None = None
        self.finder = BackgroundFinder()
        self._holding: Holding | None = None
        self._whole: Surface | None = None
        self._preview: Surface | None = None
        self._lanes = tuple(Lane(pool, self.failed.emit, self) for _ in range(2))
        self._preview_lane, self._whole_lane = self._lanes
        self._rest = QTimer(self, singleShot=True, interval=REST_MS)
        self._rest.timeout.connect(self._render_whole)
        self._preview_lane.done.connect(self._show_preview)
        self._whole_lane.done.connect(self._show_whole)
        self._document.opened.connect(self._open)
        self._document.recoloured.connect(self._recolour)
        self._document.watch(self._follow)

    @property
    def busy(self) -> bool:
        """True until the canvas shows the newest state at full resolution."""
        return self._rest.isActive() or any(lane.busy for lane in self._lanes)

    @property
    def background(self) -> Background | None:
        """The last background analysis, or None."""
        return None if self._holding is None else self._holding.background

    def is_final(self, frame: RenderedFrame | None) -> bool:
        """Return whether a frame is the full result of the newest state."""
        return frame is not None and frame.whole and frame.revision == self._revision

    def lent(self) -> Image | None:
        """Return the rendered pixels of the newest state if on screen, else None.

        Later frames don't change the returned pixels. None for 16-bit, float and grey photos.
        """
        document = self._document
        photo, pyramid = document.photo, document.pyramid
        is_own = photo is not None and pyramid is not None and pyramid.levels[0] is photo.pixels
        is_newest = not document.in_gesture and document.state is self._followed
        if self._whole is None or not (is_own and is_newest and self.is_final(self._view.frame)):
            return None
        return self._whole.lent()

    def wait(self) -> None:
        """Draw marks only, until `go_on`: face detection needs the processors."""
        self._view.set(marks_only=True)

    def go_on(self) -> None:
        """Resume rendering; a delayed frame is rendered at full resolution at once."""
        waited = self._view.marks_only
        self._view.set(marks_only=False)
        if waited and self._document.in_gesture:
            self._follow()
        elif waited and self._document.state is not self._followed:
            self._render_now()

    def stop(self) -> None:
        """Cancel the timer and the waiting jobs."""
        self._rest.stop()
        for lane in self._lanes:
            lane.drop()

    def _open(self) -> None:
        self.stop()
        self._followed = None
        # The first faces arrive in a moment. Without faces there is no displacement to render.
        self._view.set(marks_only=True, frame=None, full=None)
        photo = self._document.pyramid
        if photo is not None and self._document.photo is not None:
            self._holding = Holding(self._document.photo.pixels, self.finder)
            self._whole, self._preview = (Surface(photo, self._holding) for _ in range(2))

    def _recolour(self) -> None:
        photo = self._document.pyramid
        if photo is None:
            return
        self.stop()
        self._whole, self._preview = (Surface(photo, self._holding) for _ in range(2))
        self._view.set(frame=None, full=None)
        if not self._view.marks_only:
            self._render_now()

    def _render_now(self) -> None:
        self._followed = self._document.state
        self._revision += 1
        self._render_whole()

    def _follow(self) -> None:
        surface, state = self._preview, self._document.state
        if surface is None:
            return
        if self._view.marks_only:
            if self._document.touched:
                self.go_on()  # an edit during the search for faces
            return
        if state is self._followed:
            # The gesture ended with the last previewed state: render the full photo at once.
            if self._rest.isActive():
                self._rest.stop()
                self._render_whole()
            return
        self._followed = state
        self._revision += 1
        part = self._visible_part()
        if part is not None:
            self._preview_lane.submit(partial(surface.render, self._revision, state, part))
        self._rest.start()

    def _render_whole(self) -> None:
        if self._whole is not None:
            state, revision = self._document.state, self._revision
            self._whole_lane.submit(partial(self._whole.render, revision, state))

    def _show_preview(self, frame: RenderedFrame) -> None:
        if self._preview is not None:
            self._preview.shown()
        full = self._view.full
        if full is None or frame.revision > full.revision:
            self._view.set(frame=frame)
        self._tell_settled(self._preview_lane)

    def _show_whole(self, frame: RenderedFrame) -> None:
        if self._whole is not None:
            self._whole.shown()
        newest = self._view.frame
        is_newer = newest is not None and newest.revision > frame.revision
        self._view.set(full=frame, frame=newest if is_newer else frame)
        self._tell_settled(self._whole_lane)

    def _tell_settled(self, last: Lane) -> None:
        """Emit `settled` if the final frame is visible, the timer stopped and other lanes idle."""
        others = (lane for lane in self._lanes if lane is not last)
        under_way = self._rest.isActive() or any(lane.busy for lane in others)
        if self.is_final(self._view.frame) and not under_way:
            self.settled.emit()
