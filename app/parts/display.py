"""What the window shows of the document: title, panels, history, readings."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QObject, SignalInstance

from kogao_core.pipeline import Rendering

from ..controllers.choices import Choices
from ..controllers.live import Live
from ..document import Document
from ..hints import hint
from ..i18n import tr
from ..scene import Scene
from ..surfaces import Frame
from ..views.window import Window


class DisplayPart(QObject):
    """Follows the document and the renderings, and brings the window up to date.

    Parameters
    ----------
    tools : sequence of SignalInstance
        What tells that another tool is in hand.
    """

    def __init__(
        self,
        document: Document,
        scene: Scene,
        choices: Choices,
        live: Live,
        window: Window,
        tools: Sequence[SignalInstance],
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._document, self._scene, self._live, self._window = document, scene, live, window
        choices.chosen.connect(self._show_document)
        for changed in (document.changed, choices.chosen, *tools):
            changed.connect(self._show_tool)
        document.opened.connect(self._show_photo)
        document.changed.connect(self._show_document)
        document.marked.connect(self._show_title)
        document.undo.indexChanged.connect(self._show_history)
        window.canvas.view_changed.connect(self._show_zoom)
        live.drawn.connect(self._show_frame)
        live.measured.connect(self._show_measures)
        self._show_document()

    def stop(self) -> None:
        """Follow no more: a stack of undo steps tells of its own end, too."""
        self._document.undo.blockSignals(True)

    def _show_photo(self) -> None:
        if self._document.photo is not None and self._document.pyramid is not None:
            self._window.recipe.clear_readings()
            self._window.faces.open(self._document.pyramid)
            self._window.status.show_photo(self._document.photo)
            self._window.readings.forget()

    def _show_document(self) -> None:
        self._window.recipe.show_state(self._document.state, self._scene.face)
        self._window.recipe.mark_readings(final=self._live.is_final(self._scene.frame))
        self._window.faces.show_state(self._document.state, self._scene.face)
        self._show_title()
        self._show_history()

    def _show_tool(self) -> None:
        self._window.status.show_tool(hint(self._scene))

    def _show_zoom(self) -> None:
        if self._document.photo is not None:
            self._window.status.show_zoom(self._window.canvas.zoom)

    def _show_title(self) -> None:
        path = self._document.path
        self._window.show_title(path.name if path else "", dirty=self._document.dirty)

    def _show_history(self) -> None:
        stack, named = self._document.undo, self._window.actions_by_name
        opened = self._document.photo is not None
        named["undo"].setEnabled(stack.canUndo() or self._document.in_gesture)
        named["redo"].setEnabled(stack.canRedo())
        named["undo"].setText(tr("&Undo {what}", what=stack.undoText()))
        named["redo"].setText(tr("&Redo {what}", what=stack.redoText()))
        for name in ("undo", "redo"):
            named[name].setIconText(tr("Undo") if name == "undo" else tr("Redo"))
        for name in ("save", "fit", "actual", "closer", "farther", "find", "place"):
            named[name].setEnabled(opened)

    def _show_frame(self, frame: Frame) -> None:
        self._window.recipe.show_frame(frame)
        self._window.recipe.mark_readings(final=self._live.is_final(frame))
        self._window.status.show_speed(frame.took_ms)

    def _show_measures(self, rendering: Rendering) -> None:
        self._window.readings.show_rendering(rendering)
