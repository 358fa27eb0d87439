"""Undo and redo, the list of steps, and what depends on there being a photo and changes."""

from __future__ import annotations

from PySide6.QtWidgets import QUndoView

from ..actions import Spec
from ..document import State
from ..i18n import tr
from ..widgets.docks import Dock
from .feature import Context, Feature

_ON_A_PHOTO = (
    *("save", "save-project", "fit", "actual", "closer", "farther", "find", "place"),
    "import-landmarks",
)


class History(Feature):
    """Steps through what was done, and keeps title and actions up with it."""

    name = "history"

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.add_actions(
            Spec("undo", tr("&Undo"), "Ctrl+Z", tr("Take the last gesture back"), self.undo),
            Spec("redo", tr("&Redo"), "Ctrl+Shift+Z", tr("Do it again"), self.redo),
        )
        self.panel: QUndoView = QUndoView(self.document.undo)
        self.panel.setEmptyLabel(tr("As it was opened"))
        self.panel.setAccessibleName(tr("History"))
        self.dock = Dock(tr("History"))
        self.document.undo.indexChanged.connect(self.show)
        self.document.undo.indexChanged.connect(self.window.bar.move_on)
        self.document.opened.connect(self.window.bar.move_on)
        self.document.marked.connect(self.show)
        document = self.document
        self.watch(lambda: (document.path, document.in_gesture, document.dirty), self.show)

    def undo(self) -> None:
        """Take the last gesture back; one in hand is only aborted."""
        if self.document.in_gesture:
            self.document.abort()
        else:
            text, before = self.document.undo.undoText(), self.document.committed
            self.document.undo.undo()
            what = _step_name(text, before, self.document.committed)
            self.working.emit(tr("Undone: {what}", what=what) if text else "")

    def redo(self) -> None:
        """Do the gesture again that was taken back."""
        if not self.document.in_gesture:
            text, before = self.document.undo.redoText(), self.document.committed
            self.document.undo.redo()
            what = _step_name(text, before, self.document.committed)
            self.working.emit(tr("Done again: {what}", what=what) if text else "")

    def stop(self) -> None:
        """Follow no more: a stack of undo steps tells of its own end, too."""
        self.document.undo.blockSignals(True)

    def show(self) -> None:
        """Show what can be done now."""
        path, stack, named = self.document.path, self.document.undo, self.actions
        self.window.show_title(path.name if path else "", dirty=self.document.dirty)
        named["undo"].setEnabled(stack.canUndo() or self.document.in_gesture)
        named["redo"].setEnabled(stack.canRedo())
        named["undo"].setText(tr("&Undo {what}", what=stack.undoText()))
        named["redo"].setText(tr("&Redo {what}", what=stack.redoText()))
        for name in ("undo", "redo"):
            named[name].setIconText(tr("Undo") if name == "undo" else tr("Redo"))
        for name in _ON_A_PHOTO:
            named[name].setEnabled(path is not None)


def _step_name(text: str, before: State, after: State) -> str:
    """Return what a step is called, and whose it is if that is one of several faces."""
    fewer, more = sorted((before, after), key=lambda state: len(state.faces))
    changed = {index for index, face in enumerate(more.faces) if face not in fewer.faces}
    if len(more.faces) == len(fewer.faces):
        changed |= before.off ^ after.off
    if len(more.faces) == 1 or len(changed) != 1:
        return text
    return tr("{what} (face {n})", what=text, n=changed.pop() + 1)
