"""The pages of a rating session: welcome, picture, end."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from PySide6.QtCore import QSignalBlocker, Qt, Signal, SignalInstance
from PySide6.QtGui import QPalette, QPixmap
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QProgressBar,
    QPushButton,
    QSlider,
    QVBoxLayout,
    QWidget,
)

from kogao_core.experiments.study.plan import Study
from kogao_core.experiments.study.results import LARGEST_GRADE

from ..controllers.rating import Begun
from ..i18n import tr
from ..panels.controls import column_of, heading
from ..theme import GRID_PX
from .rating_picture import Picture

_TEXT_PX: Final = 560
_BUTTON_PX: Final = 200


class Welcome(QWidget):
    """What will be asked, and under which code.

    Signals
    -------
    begin(str)
        The code of the session.
    """

    begin = Signal(str)

    def __init__(self, study: Study, begun: Sequence[Begun], code: str) -> None:
        super().__init__()
        self._new = code
        self.sessions, self.code = QComboBox(), QLineEdit(code)
        self.sessions.addItem(tr("A new session"), code)
        for one in begun:
            text = tr("{code}: {done} of {total}", code=one.rater, done=one.done, total=one.total)
            self.sessions.addItem(text, one.rater)
        self.sessions.setAccessibleName(tr("Session"))
        self.sessions.currentIndexChanged.connect(self._choose)
        self.code.setAccessibleName(tr("Your code"))
        self.code.setMaxLength(32)
        self.code.returnPressed.connect(self._begin)
        self.button = QPushButton(tr("&Begin"))
        self.button.clicked.connect(self._begin)
        self.button.setDefault(True)
        form = QFormLayout()
        form.addRow(tr("&Session"), self.sessions)
        form.addRow(tr("Your &code"), self.code)
        inner = QWidget()
        inner.setFixedWidth(_TEXT_PX)
        column = column_of(inner, spacing=4 * GRID_PX)
        column.addWidget(heading(tr("Natural or unnatural?")))
        column.addWidget(_wrapped(_task(study)))
        column.addWidget(_wrapped(_keeping()))
        column.addLayout(form)
        column.addWidget(self.button, alignment=Qt.AlignmentFlag.AlignLeft)
        outer = QVBoxLayout(self)
        outer.addWidget(inner, alignment=Qt.AlignmentFlag.AlignCenter)

    def _choose(self) -> None:
        self.code.setText(self.sessions.currentData())
        self.code.setEnabled(self.sessions.currentIndex() == 0)

    def _begin(self) -> None:
        self.begin.emit(self.code.text().strip())


def _task(study: Study) -> str:
    text = tr(
        "You will see {n} pictures one after another. Say of each, without thinking long, whether "
        "the face looks natural (F) or unnatural (J). Backspace takes the last answer back.",
        n=len(study.ratings),
    )
    if study.satisfaction:
        text += " " + tr("Then you grade some pictures from 0 to 100.")
    return text


def _keeping() -> str:
    return tr(
        "You may stop at any time and go on later. Kept are your answers and how long each took, "
        "under the code below: leave it as it is unless you were given one, and write no name."
    )


def _wrapped(text: str) -> QLabel:
    label = QLabel(text)
    label.setWordWrap(True)
    return label


class Judging(QWidget):
    """A picture with its question, and how far the session is.

    Signals
    -------
    natural, unnatural, skipped, back
        Buttons; the window has their keys.
    graded(int)
        A grade from 0 to 100.
    """

    natural, unnatural, skipped, back = Signal(), Signal(), Signal(), Signal()
    graded = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        self.question, self.picture, self.trouble = QLabel(), Picture(), QLabel()
        self.trouble.setProperty("warn", "true")
        self.trouble.setWordWrap(True)
        self.trouble.hide()
        self.progress = QProgressBar()
        self.progress.setFormat(tr("%v of %m"))
        self.progress.setAccessibleName(tr("Progress"))
        palette = self.progress.palette()
        # Nothing but the picture has a colour.
        palette.setColor(QPalette.ColorRole.Highlight, palette.color(QPalette.ColorRole.Mid))
        palette.setColor(QPalette.ColorRole.HighlightedText, palette.color(QPalette.ColorRole.Text))
        self.progress.setPalette(palette)
        self.take_back = _button(tr("Take back (Backspace)"), self.back)
        self.answers, self.grades = self._answers(), self._grades()
        foot = QHBoxLayout()
        foot.addWidget(self.progress, 1)
        foot.addWidget(self.take_back)
        column = column_of(self, margin=4 * GRID_PX, spacing=3 * GRID_PX)
        column.addWidget(self.question, alignment=Qt.AlignmentFlag.AlignCenter)
        column.addWidget(self.picture, 1)
        for part in (self.answers, self.grades):
            column.addWidget(part, alignment=Qt.AlignmentFlag.AlignCenter)
        column.addWidget(self.trouble)
        column.addLayout(foot)

    def ask(self, pixmap: QPixmap, done: int, total: int, *, grading: bool) -> None:
        """Show the next picture with its question."""
        self.picture.done_with()  # the progress bar paints at once whatever is to be painted
        self.question.setText(
            tr("How satisfied are you with this picture of yourself?")
            if grading
            else tr("Does this face look natural or unnatural?")
        )
        self.trouble.hide()
        self.answers.setVisible(not grading)
        self.grades.setVisible(grading)
        self._forget_grade()
        self.progress.setMaximum(total)
        self.progress.setValue(done)
        self.take_back.setEnabled(done > 0)
        self.picture.show_picture(pixmap)
        (self.slider if grading else self.picture).setFocus()

    def complain(self, text: str) -> None:
        """Say what went wrong; the picture stays."""
        self.trouble.setText(text)
        self.trouble.show()

    def grade(self) -> None:
        """Take the slider's grade, once it was moved."""
        if self.enter.isEnabled():
            self.graded.emit(self.slider.value())

    def _answers(self) -> QWidget:
        row, box = QWidget(), QHBoxLayout()
        row.setLayout(box)
        box.setSpacing(4 * GRID_PX)
        box.addWidget(_button(tr("Natural (F)"), self.natural, _BUTTON_PX))
        box.addWidget(_button(tr("Unnatural (J)"), self.unnatural, _BUTTON_PX))
        return row

    def _grades(self) -> QWidget:
        group = QWidget()
        group.setFixedWidth(_TEXT_PX)
        self.slider, self.value = QSlider(Qt.Orientation.Horizontal), QLabel()
        self.slider.setRange(0, LARGEST_GRADE)
        self.slider.setAccessibleName(tr("Satisfaction, 0 to 100"))
        self.slider.valueChanged.connect(self._show_grade)
        self.slider.sliderPressed.connect(lambda: self._show_grade(self.slider.value()))
        self.value.setFixedWidth(self.value.fontMetrics().horizontalAdvance("100 "))
        self.enter = QPushButton(tr("Next (Enter)"))
        self.enter.clicked.connect(self.grade)
        top, row = QHBoxLayout(), QHBoxLayout()
        top.addWidget(self.slider, 1)
        top.addWidget(self.value)
        row.addWidget(self.enter)
        row.addWidget(_button(tr("Not my picture (S)"), self.skipped))
        row.addStretch()
        column = column_of(group, spacing=2 * GRID_PX)
        column.addWidget(QLabel(tr("0 not at all satisfied, 100 wholly satisfied")))
        column.addLayout(top)
        column.addLayout(row)
        return group

    def _forget_grade(self) -> None:
        with QSignalBlocker(self.slider):
            self.slider.setValue(LARGEST_GRADE // 2)
        self.value.setText("\N{EN DASH}")
        self.enter.setEnabled(False)

    def _show_grade(self, grade: int) -> None:
        self.value.setText(str(grade))
        self.enter.setEnabled(True)


class Ending(QWidget):
    """Thanks, and a way back to the last picture."""

    back = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.said = _wrapped("")
        self.said.setFixedWidth(_TEXT_PX)
        column = column_of(self, spacing=4 * GRID_PX)
        column.addStretch()
        for part in (heading(tr("Thank you")), self.said):
            column.addWidget(part, alignment=Qt.AlignmentFlag.AlignCenter)
        button = _button(tr("Take the last answer back (Backspace)"), self.back)
        column.addWidget(button, alignment=Qt.AlignmentFlag.AlignCenter)
        column.addStretch()


def _button(text: str, pressed: SignalInstance, least_px: int = 0) -> QPushButton:
    button = QPushButton(text)
    button.setAutoDefault(False)
    button.setMinimumWidth(least_px)
    button.clicked.connect(lambda: pressed.emit())
    return button
