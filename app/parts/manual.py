"""Manual mode in the window: its actions, panel, clock and comparison."""

from __future__ import annotations

from PySide6.QtCore import QObject, QThreadPool
from PySide6.QtGui import QActionGroup

from .. import actions, menus
from ..controllers.editing import Editing
from ..controllers.files import Files
from ..controllers.manual import Manual
from ..controllers.modes import Modes
from ..controllers.protecting import Protecting
from ..document import Document
from ..scene import Scene
from ..views.modes import ModesDialog
from ..views.window import Window


class ManualPart(QObject):
    """Builds manual mode and joins it to the window."""

    def __init__(
        self,
        document: Document,
        scene: Scene,
        editing: Editing,
        files: Files,
        window: Window,
        pool: QThreadPool,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._scene, self._window = scene, window
        self.manual = Manual(document, scene, editing, self)
        self.modes = Modes(document, files, self.manual.clock, pool, self)
        self._join_actions()
        self._join_canvas()
        clock = self.manual.clock
        clock.ticked.connect(lambda: window.manual.show_clock(clock))
        window.activated.connect(clock.focus)
        clock.focus(window.isActiveWindow())
        self.manual.changed.connect(self._show)
        self.modes.compared.connect(lambda it: ModesDialog(it, window).open())
        self.modes.said.connect(window.bar.say)
        self._show()

    @property
    def busy(self) -> bool:
        """True while the comparison is rendered."""
        return self.modes.busy

    def stop(self) -> None:
        """Start nothing more, and stop the clock."""
        self.modes.stop()
        self.manual.clock.want(False)

    def take_brush(self, protecting: Protecting) -> None:
        """Let go of the marker when a brush is taken, and of the brush for the marker."""

        def put_marker_away() -> None:
            if self._scene.brush.paints and self._scene.marking:
                self.manual.take_marker(False)

        def put_brush_away() -> None:
            if self._scene.marking and self._scene.brush.paints:
                self._window.actions_by_name[menus.tool_action("points")].trigger()

        protecting.changed.connect(put_marker_away)
        self.manual.changed.connect(put_brush_away)

    def _join_actions(self) -> None:
        named, manual = self._window.actions_by_name, self.manual
        group = QActionGroup(self)
        for mode in ("automatic", "manual"):
            group.addAction(named[f"mode-{mode}"])
        actions.connect(
            named,
            {
                "mode-automatic": lambda: manual.switch("automatic"),
                "mode-manual": lambda: manual.switch("manual"),
                "mirror": manual.mirror,
                "mirror-side": manual.mirror_side,
                "snap": manual.snap,
                "delete": manual.delete,
                "apply": manual.apply,
                "compare-modes": self.modes.compare,
            },
        )
        named["mark"].triggered.connect(manual.take_marker)

    def _join_canvas(self) -> None:
        canvas, manual = self._window.canvas, self.manual
        canvas.grabbed.connect(manual.press)
        canvas.dragged.connect(manual.drag)
        canvas.released.connect(manual.release)

    def _show(self) -> None:
        named, mode = self._window.actions_by_name, self.manual.mode
        named[f"mode-{mode}"].setChecked(True)
        by_hand = mode == "manual"
        named["mark"].setChecked(self._scene.marking)
        for name in ("mark", "mirror", "mirror-side", "snap", "apply"):
            named[name].setEnabled(by_hand)
        self._window.manual.setVisible(by_hand)
        self._window.manual.show_clock(self.manual.clock)
        self._window.canvas.redraw()
