"""Keeps the picture up with the document: a quick preview at once, the whole photo at rest."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QObject, QThreadPool, QTimer, Signal

from kogao_core.pipeline import Rendering

from ..document import Document, State
from ..scene import Scene
from ..surfaces import Frame, FullSurface, PreviewSurface
from ..views.canvas import PhotoCanvas
from ..workers import Lane

# A gesture that moves again within this time isn't worth a whole photo.
REST_MS: Final = 80


class Live(QObject):
    """Renders in workers and shows what they return.

    Signals
    -------
    drawn(Frame)
        A new picture is on the canvas.
    measured(Rendering)
        The newest whole photo, with its pixels counted.
    settled
        The picture shows the document's state at full resolution, and nothing is under way.
    failed(object)
        Rendering raised this exception.
    """

    drawn = Signal(object)
    measured = Signal(object)
    settled = Signal()
    failed = Signal(object)

    def __init__(
        self,
        document: Document,
        scene: Scene,
        canvas: PhotoCanvas,
        pool: QThreadPool,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._document, self._scene, self._canvas = document, scene, canvas
        self._revision = 0
        self._followed: State | None = None
        self._full: FullSurface | None = None
        self._preview: PreviewSurface | None = None
        self._preview_lane, self._full_lane, self._count_lane = (
            Lane(pool, self.failed.emit, self) for _ in range(3)
        )
        self._rest = QTimer(self, singleShot=True, interval=REST_MS)
        self._rest.timeout.connect(self._render_full)
        self._preview_lane.done.connect(self._show_preview)
        self._full_lane.done.connect(self._show_full)
        self._count_lane.done.connect(self._show_counts)
        document.opened.connect(self._open)
        document.changed.connect(self._follow)

    @property
    def busy(self) -> bool:
        """True while the canvas doesn't yet show the newest state at full resolution."""
        lanes = (self._preview_lane, self._full_lane, self._count_lane)
        return self._rest.isActive() or any(lane.busy for lane in lanes)

    def is_final(self, frame: Frame | None) -> bool:
        """Return whether a picture stays as it is unless the document changes."""
        return frame is not None and frame.whole and frame.revision == self._revision

    def stop(self) -> None:
        """Start nothing more."""
        self._rest.stop()
        for lane in (self._preview_lane, self._full_lane, self._count_lane):
            lane.drop()

    def _open(self) -> None:
        self.stop()
        self._followed = None
        photo = self._document.pyramid
        if photo is not None:
            self._full, self._preview = FullSurface(photo), PreviewSurface(photo)
            self._canvas.open(photo)

    def _follow(self) -> None:
        # The overlays are drawn with the preview, a moment from now: drawing them twice would
        # only keep the preview waiting.
        if self._document.pyramid is None:
            return
        state = self._document.state
        if state is self._followed:
            # A gesture has ended with what it last showed: no reason to wait, or to preview again.
            if self._rest.isActive():
                self._rest.stop()
                self._render_full()
            return
        self._followed = state
        self._revision += 1
        self._render_preview()
        self._rest.start()

    def _render_preview(self) -> None:
        surface, view = self._preview, self._canvas.view()
        if surface is None or view is None:
            return
        state, revision = self._document.state, self._revision

        def job() -> Frame:
            return _checked(surface.render(revision, state, view))

        self._preview_lane.submit(job)

    def _render_full(self) -> None:
        surface = self._full
        if surface is None:
            return
        state, revision = self._document.state, self._revision

        def job() -> Frame:
            return _checked(surface.render(revision, state))

        self._full_lane.submit(job)

    def _show_preview(self, frame: Frame) -> None:
        if self._preview is not None:
            self._preview.shown()
        if self._canvas.photo.show_preview(frame):
            self._show(frame)

    def _show_full(self, frame: Frame) -> None:
        if self._full is not None:
            self._full.shown()
        self._canvas.photo.show_full(frame)
        self._show(frame)
        self._count_lane.submit(lambda: _counted(frame.rendering))

    def _show(self, frame: Frame) -> None:
        newest = self._scene.frame
        if newest is None or frame.revision >= newest.revision:
            self._scene.frame = frame
            self._canvas.redraw()
            self.drawn.emit(frame)

    def _show_counts(self, rendering: Rendering) -> None:
        self.measured.emit(rendering)
        if not self._rest.isActive() and not self._preview_lane.busy and not self._full_lane.busy:
            self.settled.emit()


def _checked(frame: Frame) -> Frame:
    # Cached in the rendering; measured here, off the GUI thread, because panels read them at once.
    rendering = frame.rendering
    _ = rendering.one_to_one, rendering.residual, rendering.achieved
    return frame


def _counted(rendering: Rendering) -> Rendering:
    _ = rendering.pixel_counts
    return rendering
