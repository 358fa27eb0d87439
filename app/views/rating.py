"""The window of a rating session: one picture on neutral grey, and nothing that hints at it."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtGui import QCloseEvent, QColor, QKeyEvent, QPalette, QPixmap
from PySide6.QtWidgets import QDialog, QLabel, QStackedLayout, QVBoxLayout, QWidget

from kogao_core.strict import BadFile

from ..controllers.rating import Rating
from ..i18n import tr
from .rating_pages import Ending, Judging, Welcome

_SIZE_PX: Final = (1000, 860)
_ENTER: Final = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class RatingWindow(QDialog):
    """Asks for a code, then about picture after picture.

    Parameters
    ----------
    rating : Rating
        The study and its session.
    ground : str
        The canvas grey of the theme.
    parent : QWidget
        The editor's window.
    """

    def __init__(self, rating: Rating, ground: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Rate pictures"))
        self.setWindowFlag(Qt.WindowType.WindowMaximizeButtonHint, True)
        self.setModal(True)
        self._rating = rating
        rating.setParent(self)
        self._next: tuple[str | None, QPixmap] = (None, QPixmap())
        self._missing = False
        self.welcome = Welcome(rating.study, rating.begun(), rating.new_code())
        self.judging, self.ending = Judging(), Ending()
        self.problem = QLabel()
        self.problem.setProperty("warn", "true")
        self.problem.setWordWrap(True)
        self.problem.hide()
        self.pages = QStackedLayout()
        for page in (self.welcome, self.judging, self.ending):
            self.pages.addWidget(page)
        column = QVBoxLayout(self)
        column.addWidget(self.problem)
        column.addLayout(self.pages, 1)
        palette = self.palette()
        palette.setColor(QPalette.ColorRole.Window, QColor(ground))
        self.setPalette(palette)
        self.resize(*_SIZE_PX)
        self._join()

    def _join(self) -> None:
        rating, judging = self._rating, self.judging
        self.welcome.begin.connect(self._begin)
        rating.changed.connect(self._show)
        rating.failed.connect(judging.complain)
        judging.picture.painted.connect(rating.shown)
        judging.natural.connect(self._natural)
        judging.unnatural.connect(self._unnatural)
        judging.graded.connect(self._grade)
        judging.skipped.connect(lambda: self._grade(None))
        judging.back.connect(rating.back)
        self.ending.back.connect(rating.back)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Answer by keys; a held one answers once."""
        plain = event.modifiers() in (
            Qt.KeyboardModifier.NoModifier,
            Qt.KeyboardModifier.KeypadModifier,
        )
        if self.pages.currentWidget() is self.welcome or not plain:
            super().keyPressEvent(event)
            return
        acts = {
            Qt.Key.Key_F: self._natural,
            Qt.Key.Key_J: self._unnatural,
            Qt.Key.Key_S: lambda: self._grade(None),
            Qt.Key.Key_Backspace: self._rating.back,
            **dict.fromkeys(_ENTER, self.judging.grade),
        }
        act = acts.get(Qt.Key(event.key()))
        if act is None:
            super().keyPressEvent(event)
        elif not event.isAutoRepeat():
            act()

    def closeEvent(self, event: QCloseEvent) -> None:
        """Let the session go; it can go on later."""
        self._rating.stop()
        super().closeEvent(event)

    def done(self, result: int) -> None:
        """Let the session go on Escape, too."""
        self._rating.stop()
        super().done(result)

    def _natural(self) -> None:
        if not self._missing:
            self._rating.answer("natural")

    def _unnatural(self) -> None:
        if not self._missing:
            self._rating.answer("unnatural")

    def _grade(self, grade: int | None) -> None:
        if not self._missing:
            self._rating.grade(grade)

    def _begin(self, code: str) -> None:
        try:
            self._rating.start(code)
        except (BadFile, OSError) as problem:
            self.problem.setText(str(problem))
            self.problem.show()
            return
        self.problem.hide()

    def _show(self) -> None:
        session = self._rating.session
        if session is None:
            return
        if session.current is None:
            self.ending.said.setText(
                tr(
                    "{n} answers are kept under the code {code}. You may close this window.",
                    n=len(session.answered),
                    code=session.rater,
                )
            )
            self.pages.setCurrentWidget(self.ending)
            return
        self.pages.setCurrentWidget(self.judging)
        pixmap = self._picture(session.current)
        done, total = len(session.answered), session.total
        self.judging.ask(pixmap, done, total, grading=session.grading)
        self._missing = pixmap.isNull()
        if self._missing:
            self.judging.complain(
                tr("{name} is missing: copy the whole folder again.", name=session.current)
            )
        self._next = (session.following, self._picture(session.following))

    def _picture(self, name: str | None) -> QPixmap:
        if name is None:
            return QPixmap()
        known, pixmap = self._next
        return pixmap if name == known else QPixmap(str(self._rating.path(name)))
