"""Undo and redo, the list of steps, and the title's mark for unsaved changes."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QEvent, QTimer, Signal
from PySide6.QtGui import QKeyEvent, QUndoCommand
from PySide6.QtWidgets import QUndoView

from ..document import ReplaceState
from ..i18n import tr, tr_count
from ..widgets.docks import Dock
from .feature import Context, Feature
from .files.saver import Saver

# Edits that are saved sooner get no star: screen readers would read the title twice for each.
_LATE_MS: Final = 2000


class History(Feature):
    """Undoes and redoes steps, and updates title and actions."""

    name = "history"

    def __init__(self, context: Context, saver: Saver) -> None:
        super().__init__(context)
        self._saver, self._late = saver, QTimer(self.window, singleShot=True)
        self._late.timeout.connect(lambda: self.window.setWindowModified(self.document.dirty))
        self._undo, self._redo = self.bind("undo", self.undo), self.bind("redo", self.redo)
        self._undo.setIconText(tr("Undo"))
        self._redo.setIconText(tr("Redo"))
        self._texts = tuple[str, str]((" ", " "))
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
        self.document.watch(self.show, "photo", "in_gesture")

    def undo(self) -> None:
        """Undo the last step; during a gesture, only cancel the gesture."""
        if self.document.in_gesture:
            self.document.abort()
        else:
            before = self.document.undo.index()
            self.document.undo.undo()
            self._tell(before)

    def redo(self) -> None:
        """Redo the last undone step."""
        if not self.document.in_gesture:
            before = self.document.undo.index()
            self.document.undo.redo()
            self._tell(before)

    def _tell(self, before: int) -> None:
        """Show the undone or redone steps in the status line."""
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
        """Block signals of the undo stack, which also emits on destruction."""
        self.document.undo.blockSignals(True)

    def show(self) -> None:
        """Update the title and the actions."""
        document, stack = self.document, self.document.undo
        path, before, self._texts = document.path, self._texts, (stack.undoText(), stack.redoText())
        self.window.show_title(path.name if path else "")
        if document.dirty and self._saver.keeps:
            self._late.start(_LATE_MS)
        else:
            self._late.stop()
            self.window.setWindowModified(document.dirty)
        self._undo.setEnabled(stack.canUndo() or document.in_gesture)
        self._redo.setEnabled(stack.canRedo())
        if self._texts[0] != before[0]:
            self._undo.setText(tr("&Undo {what}", what=self._texts[0]))
        if self._texts[1] != before[1]:
            self._redo.setText(tr("&Redo {what}", what=self._texts[1]))


class StepList(QUndoView):
    """The list of steps; a click or an arrow key goes to a step."""

    # (step: int): the user has moved on from this undo step.
    left = Signal(int)

    def viewportEvent(self, event: QEvent) -> bool:
        """Emit `left` after a mouse selection."""
        before = self.stack().index()
        done = super().viewportEvent(event)
        self._compare(before)
        return done

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Emit `left` after a selection by key."""
        before = self.stack().index()
        super().keyPressEvent(event)
        self._compare(before)

    def _compare(self, before: int) -> None:
        if self.stack().index() != before:
            self.left.emit(before)


def _name(step: QUndoCommand) -> str:
    """Return the name of a step, with the face's number if only one face changed."""
    assert isinstance(step, ReplaceState)
    text, before, after = step.text(), step.before, step.after
    fewer, more = sorted((before, after), key=lambda state: len(state.faces))
    changed = {index for index, face in enumerate(more.faces) if face not in fewer.faces}
    if len(more.faces) == len(fewer.faces):
        changed |= before.off ^ after.off
    if len(more.faces) == 1 or len(changed) != 1:
        return text
    return tr("{what} (face {n})", what=text, n=changed.pop() + 1)
