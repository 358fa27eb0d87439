"""Undo and redo, the list of steps, and what depends on there being changes."""

from __future__ import annotations

from PySide6.QtCore import QEvent, Signal
from PySide6.QtGui import QKeyEvent, QUndoCommand
from PySide6.QtWidgets import QUndoView

from ..document import ReplaceState
from ..i18n import tr, tr_count
from ..widgets.docks import Dock
from .feature import Context, Feature


class History(Feature):
    """Steps through what was done, and keeps title and actions up with it."""

    name = "history"

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.add_action("undo", tr("&Undo"), "Ctrl+Z", tr("Take the last gesture back"), self.undo)
        self.add_action("redo", tr("&Redo"), "Ctrl+Shift+Z", tr("Do it again"), self.redo)
        self.panel: StepList = StepList(self.document.undo)
        self.panel.left.connect(self._tell)
        self.panel.setEmptyLabel(tr("As it was opened"))
        self.panel.setAccessibleName(tr("History"))
        self.dock = Dock(tr("History"), scrolls=True)
        self.document.undo.indexChanged.connect(self.show)
        for said in (self.window.bar, self.window.status):
            self.document.undo.indexChanged.connect(said.move_on)
        self.document.opened.connect(self.window.bar.move_on)
        self.document.marked.connect(self.show)
        document = self.document
        self.watch(lambda: (document.path, document.in_gesture, document.dirty), self.show)

    def undo(self) -> None:
        """Take the last gesture back; one in hand is only aborted."""
        if self.document.in_gesture:
            self.document.abort()
        else:
            before = self.document.undo.index()
            self.document.undo.undo()
            self._tell(before)

    def redo(self) -> None:
        """Do the gesture again that was taken back."""
        if not self.document.in_gesture:
            before = self.document.undo.index()
            self.document.undo.redo()
            self._tell(before)

    def _tell(self, before: int) -> None:
        """Say which steps lie between the one before and the one at hand."""
        stack = self.document.undo
        now = stack.index()
        low, high = sorted((before, now))
        if low == high:
            self.window.status.move_on()
            return
        count = high - low
        what = tr_count(count, "{n} step", "{n} steps") if count > 1 else _name(stack.command(low))
        undone, again = tr("Undone: {what}", what=what), tr("Done again: {what}", what=what)
        self.did.emit(undone if now < before else again)

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
        named["undo"].setIconText(tr("Undo"))
        named["redo"].setIconText(tr("Redo"))


class StepList(QUndoView):
    """The list of steps; a click or an arrow key goes to another one."""

    left = Signal(int)

    def viewportEvent(self, event: QEvent) -> bool:
        """Tell when the mouse has chosen a step."""
        before = self.stack().index()
        done = super().viewportEvent(event)
        self._compare(before)
        return done

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Tell when a key has."""
        before = self.stack().index()
        super().keyPressEvent(event)
        self._compare(before)

    def _compare(self, before: int) -> None:
        if self.stack().index() != before:
            self.left.emit(before)


def _name(step: QUndoCommand) -> str:
    """Return what a step is called, and whose it is if that is one of several faces."""
    assert isinstance(step, ReplaceState)
    text, before, after = step.text(), step.before, step.after
    fewer, more = sorted((before, after), key=lambda state: len(state.faces))
    changed = {index for index, face in enumerate(more.faces) if face not in fewer.faces}
    if len(more.faces) == len(fewer.faces):
        changed |= before.off ^ after.off
    if len(more.faces) == 1 or len(changed) != 1:
        return text
    return tr("{what} (face {n})", what=text, n=changed.pop() + 1)
