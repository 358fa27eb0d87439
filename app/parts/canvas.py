"""What works on the canvas besides points: protection, before and after, straight lines."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QObject, QThreadPool
from PySide6.QtGui import QActionGroup

from .. import actions, menus
from ..before_after import comparisons
from ..controllers.before_after import BeforeAfter
from ..controllers.bending import Bending
from ..controllers.editing import Editing
from ..controllers.live import Live
from ..controllers.protecting import Protecting
from ..document import Document
from ..scene import Scene
from ..tools import tools
from ..views.window import Window

_WIPE_STEP: Final = 1 / 40


class CanvasPart(QObject):
    """Builds these tools and joins them to the window."""

    def __init__(
        self,
        document: Document,
        scene: Scene,
        editing: Editing,
        live: Live,
        window: Window,
        pool: QThreadPool,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._document, self._scene, self._window = document, scene, window
        self.protecting = Protecting(document, scene, editing, self)
        self.before_after = BeforeAfter(scene, self)
        self.bending = Bending(document, scene, pool, self)
        self._join_protection()
        self._join_tools()
        self._join_before_after()
        live.measured.connect(self.bending.follow)
        self.bending.measured.connect(window.canvas.redraw)
        self.bending.said.connect(window.bar.say)
        look = window.actions_by_name[menus.overlay_action("straight")]
        look.toggled.connect(self.bending.refresh)
        document.opened.connect(self._open)
        document.changed.connect(self._show)
        self._show()

    @property
    def busy(self) -> bool:
        """True while lines are being looked for."""
        return self.bending.busy

    def stop(self) -> None:
        """Start nothing more."""
        self.bending.stop()

    def _join_protection(self) -> None:
        canvas, panel, protecting = self._window.canvas, self._window.protect, self.protecting
        canvas.stroke_begun.connect(protecting.begin)
        canvas.stroked.connect(protecting.extend)
        canvas.stroke_ended.connect(protecting.end)
        panel.resized.connect(protecting.set_radius)
        panel.reset.connect(protecting.fit_brush)
        protecting.changed.connect(canvas.take_tool)
        protecting.changed.connect(lambda: panel.show_brush(self._scene.brush))
        protecting.restyled.connect(canvas.redraw)

    def _join_tools(self) -> None:
        named, protecting, group = self._window.actions_by_name, self.protecting, QActionGroup(self)
        for tool in tools():
            action = group.addAction(named[menus.tool_action(tool.name)])
            action.triggered.connect(lambda _=False, name=tool.name: protecting.take(name))
        named["hard"].toggled.connect(protecting.set_hard)
        slots = {
            "smaller": lambda: protecting.resize(-1),
            "larger": lambda: protecting.resize(1),
            "unprotect": protecting.clear,
        }
        actions.connect(named, slots)

    def _join_before_after(self) -> None:
        window, before_after, group = self._window, self.before_after, QActionGroup(self)
        window.canvas.wiped.connect(before_after.wipe_to)
        before_after.changed.connect(window.canvas.redraw)
        before_after.changed.connect(lambda: window.twin.setVisible(self._scene.compare == "side"))
        group.setExclusionPolicy(QActionGroup.ExclusionPolicy.ExclusiveOptional)
        named = window.actions_by_name
        for way in comparisons():
            action = group.addAction(named[menus.compare_action(way.name)])
            action.toggled.connect(lambda on, name=way.name: before_after.toggle(name, on))
        named["loupe"].toggled.connect(before_after.use_loupe)
        slots = {
            "wipe-left": lambda: before_after.wipe_by(-_WIPE_STEP),
            "wipe-right": lambda: before_after.wipe_by(_WIPE_STEP),
        }
        actions.connect(named, slots)

    def _open(self) -> None:
        if self._document.pyramid is not None:
            self._window.twin.open(self._document.pyramid)

    def _show(self) -> None:
        self._window.protect.show_count(len(self._document.state.protection.strokes))
