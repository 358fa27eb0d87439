"""View commands: zoom, comparison, window size and hints in the status line."""

from __future__ import annotations

from functools import partial
from typing import Final

from PySide6.QtCore import QByteArray, QSize, Signal
from PySide6.QtGui import QActionGroup, QScreen

from kogao_core.photo import Photo

from ..canvas.tools import marking
from ..i18n import tr
from ..pyramid import PicturePyramid
from ..render.colour import profile_of, pyramid_of, screen_colours, use_screen
from ..view_state import CompareName
from ..widgets.dialogs import room
from ..workspaces import Workspace
from .feature import Context, Feature

FIRST_PX: Final = (1280, 800)
_STEP = 1.5
_GEOMETRY = "window/geometry"
_WIPE_STEP: Final = 1 / 40


class Screen(Feature):
    """Zooms, shows the original, and stores the window size."""

    # (): the window is on a screen with another colour profile.
    screen_changed = Signal()

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        canvas, docks = self.window.canvas, self.window.docks
        self.bind("fit", canvas.fit)
        self.bind("actual", lambda: canvas.zoom_to(1.0))
        self.bind("closer", lambda: self._zoom_by(_STEP))
        self.bind("farther", lambda: self._zoom_by(1 / _STEP))
        self.bind("hide-panels", toggled=docks.hide_all)
        self.window.original_wanted.connect(lambda on: self.view.set(original=on))
        canvas.view_changed.connect(self._show_zoom)
        status = self.window.status
        self.view.watch(lambda: status.show_cursor(self.view.cursor), "cursor")
        self.view.watch(self._show_speed, "frame")
        self.window.arranged.connect(lambda workspace: status.show_times(not workspace.plain))
        self.document.opened.connect(self._show_photo)
        self._recolouring = self.lane(self._recolour, lambda _: None)

    def restore(self) -> None:
        """Restore the window size; at first, use the default size within the screen."""
        geometry = self.settings.value(_GEOMETRY)
        if not isinstance(geometry, QByteArray) or not self.window.restoreGeometry(geometry):
            self.window.resize(QSize(*FIRST_PX).boundedTo(room(self.window)))
        self.window.winId()  # the window is on a screen from now on
        self.window.windowHandle().screenChanged.connect(self._follow_screen)
        # The profile of a screen may be changed in another window; no event tells.
        self.window.activated.connect(lambda _: self._follow_screen(self.window.screen()))
        self._follow_screen(self.window.screen())

    def _follow_screen(self, screen: QScreen) -> None:
        """Use the colour profile of the window's screen."""
        if not use_screen(profile_of(screen, self.window.winId())):
            return
        self.screen_changed.emit()
        self._check_colours()

    def _check_colours(self) -> None:
        """Convert the open photo again, if converted for another screen profile."""
        photo, pyramid = self.document.photo, self.document.pyramid
        if photo and pyramid and pyramid.show is not screen_colours(photo).show:
            self._recolouring.submit(lambda: (photo, pyramid_of(photo)))

    def _recolour(self, coloured: tuple[Photo, PicturePyramid]) -> None:
        photo, pyramid = coloured
        if photo is self.document.photo:
            self.document.recolour(pyramid)
            self._show_photo()

    def stop(self) -> None:
        super().stop()
        self.settings.setValue(_GEOMETRY, self.window.saveGeometry())

    def _zoom_by(self, factor: float) -> None:
        canvas = self.window.canvas
        canvas.zoom_to(canvas.zoom * factor)

    def _show_speed(self) -> None:
        if self.view.frame is not None:
            self.window.status.show_speed(self.view.frame.took_ms)

    def _show_zoom(self) -> None:
        if self.document.photo is not None:
            self.window.status.show_zoom(self.window.canvas.zoom)

    def _show_photo(self) -> None:
        if self.document.photo is not None:
            self.window.status.show_photo(self.document.photo)
            self._check_colours()


class Hints(Feature):
    """Updates the hint in the status line for the current tool."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._quiet = False
        self.window.arranged.connect(self._arrange)
        self.window.canvas.view_changed.connect(self._show)
        self.view.watch(
            self._show, "brush", "marking", "unapplied", "placing", "face", "following", "frame"
        )
        self.document.watch(self._show, "faces", "draft", "mode")

    def _arrange(self, workspace: Workspace) -> None:
        self._quiet = workspace.quiet
        self._show()

    def _show(self) -> None:
        # If the selected face is deleted, a signal follows in a moment.
        if self.view.face is None or self.view.face < len(self.view.state.faces):
            self.window.status.show_tool(self._hint())

    def _hint(self) -> str:
        view, faces = self.view, self.view.state.faces
        if view.brush.paints:
            return self.actions[f"tool-{view.brush.tool}"].statusTip()
        if view.marking:
            return marking.next_hint(view.state)
        if not faces:
            return ""
        if view.unapplied:
            key = self.actions["apply"].shortcut().toString()
            return tr("Apply ({key}) shows the result", key=key)
        if view.placing is not None:
            return tr("Drag the frame onto the face; a corner turns and sizes it")
        if len(faces) > 1 and view.face is None:
            return tr("Click a face to select it; drag to move the photo")
        if not self.window.canvas.shows_points(view.face or 0):
            key = self.actions["zoom-face"].shortcut().toString()
            return tr("Zoom to the face ({key}) to correct its points", key=key)
        if view.following.soft:
            return tr("Drag a point: neighbours follow; the wheel sets the range")
        if self._quiet and view.state.mode == "automatic":
            return tr("Hover over the face to show its points; drag one to correct it")
        return tr("Drag a point to correct it")


class Compare(Feature):
    """Selects the comparison mode."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        for kind in ("wipe", "side", "difference"):
            self.bind(f"compare-{kind}", toggled=partial(self.toggle, kind))
        self.bind("wipe-left", lambda: self._wipe_by(-_WIPE_STEP))
        self.bind("wipe-right", lambda: self._wipe_by(_WIPE_STEP))
        self.bind("loupe", toggled=lambda on: self.view.set(loupe=on))
        kinds = self.one_of("compare-wipe", "compare-side", "compare-difference")
        kinds.setExclusionPolicy(QActionGroup.ExclusionPolicy.ExclusiveOptional)

    def toggle(self, name: CompareName, on: bool) -> None:
        """Enable or disable a comparison mode."""
        if on:
            self.view.set(compare=name)
        elif self.view.compare == name:
            self.view.set(compare="off")
        self.window.original.setVisible(self.view.compare == "side")

    def _wipe_by(self, share: float) -> None:
        if self.view.compare == "wipe":
            self.view.set(wipe=min(max(self.view.wipe + share, 0.0), 1.0))
