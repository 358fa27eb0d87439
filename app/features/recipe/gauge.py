"""How natural such a face was found in the paper's survey: Table 1 as a row of five blocks."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QPainter, QPaintEvent, QPalette
from PySide6.QtWidgets import QHBoxLayout, QSizePolicy, QWidget

from kogao_core.faces.naturalness import DISTANCES, STUDENTS, SUBJECTS, Naturalness, worst

from ...document import State
from ...i18n import tr
from ...theme import GRID_PX, OKABE_ITO
from ...widgets.controls import WarningLabel

_BLOCK_PX: Final = (10.0, 10.0)
_WARNING: Final = QBrush(QColor(OKABE_ITO["vermilion"]))


class NaturalnessGauge(QWidget):
    """Blocks for the distances that were asked about, filled up to the face's own; and a figure."""

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName(tr("Naturalness"))
        self.blocks = _Blocks()
        self._plain = False
        self.text = WarningLabel(wraps=True)
        self.text.setTextFormat(Qt.TextFormat.PlainText)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(2 * GRID_PX)
        row.addWidget(self.blocks)
        row.addWidget(self.text, 1)

    def show_state(self, state: State, chosen: int | None = None) -> None:
        """Show what Table 1 says about the chosen face, or else about the one that moves most."""
        faces = [
            (pairs, state.recipe.of_face(face.recipe))
            for index, (face, pairs) in enumerate(zip(state.faces, state.pairs, strict=True))
            if index not in state.off and chosen in (None, index)
        ]
        found = worst(faces)
        self.setVisible(found is not None)
        if found is None:
            return
        self.blocks.show_naturalness(found)
        self._say(found)
        self.setAccessibleDescription(self.text.text())
        self.text.warn(found.warns)

    def show_words(self, *, plain: bool) -> None:
        """Say it in a word, with the survey's figure in the tooltip, or say the figure."""
        self._plain = plain

    def _say(self, found: Naturalness) -> None:
        figure = _of_whom(found, _words(found))
        self.text.setText(_of_whom(found, _word(found)) if self._plain else figure)
        source = _source() if found.face_alone else f"{_source()}\n\n{_other()}"
        self.setToolTip(f"{figure}\n\n{source}" if self._plain else source)


class _Blocks(QWidget):
    """One block for each column of the table; the last ones are beyond the paper's limit."""

    def __init__(self) -> None:
        super().__init__()
        self._percent, self._warns = 0.0, False
        width, height = _BLOCK_PX
        self.setFixedSize(round(len(DISTANCES) * (width + 2)), round(height))
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)

    def show_naturalness(self, found: Naturalness) -> None:
        self._percent, self._warns = found.percent if found.whole_face else 0.0, found.warns
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: ARG002
        painter = QPainter(self)
        (width, height), before = _BLOCK_PX, 0.0
        for column, distance in enumerate(DISTANCES):
            share = min(max((self._percent - before) / (distance - before), 0.0), 1.0)
            block = QRectF(column * (width + 2.0), 0.0, width, height)
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            painter.drawRect(block.adjusted(0.5, 0.5, -0.5, -0.5))
            block.setWidth(share * width)
            painter.fillRect(block, _WARNING if self._warns else self.palette().accent())
            before = distance


def _of_whom(found: Naturalness, words: str) -> str:
    """Return words of the survey, and that they are of another warp where they are."""
    if found.face_alone or not _asked(found):
        return words
    return tr("the face alone: {words}", words=words)


def _asked(found: Naturalness) -> bool:
    return found.percent > 0.0 and found.whole_face


def _unasked(found: Naturalness) -> str:
    if found.percent and not found.whole_face:
        return tr("parts move: nobody was asked")
    return tr("larger: nobody was asked") if found.percent < 0.0 else tr("nothing moves")


def _word(found: Naturalness) -> str:
    if not _asked(found):
        return _unasked(found)
    if found.percent > DISTANCES[-1]:
        return tr("⚠ looks unnatural") if found.warns else tr("looks unnatural")
    if found.beyond_limit:
        return tr("⚠ may look unnatural") if found.warns else tr("may look unnatural")
    return tr("looks natural")


def _words(found: Naturalness) -> str:
    share = tr("{n:.1f} % found it unnatural", n=found.unnatural)
    if not _asked(found):
        return _unasked(found)
    if found.percent < DISTANCES[0]:
        return tr("≤ {n:.1f} % found it unnatural", n=found.unnatural)
    if found.percent > DISTANCES[-1]:
        share = tr("≥ {n:.0f} % found it unnatural", n=found.unnatural)
    return tr("⚠ {words}", words=share) if found.warns else share


def _other() -> str:
    return tr(
        "The survey's faces moved alone. Here what surrounds the face goes along, or eyes and "
        "mouth keep their shape: nobody was asked about such pictures."
    )


def _source() -> str:
    return tr(
        "Seo, Chen and Aoki (2011), Table 1: {students} students were asked about {faces} faces, "
        "each at 2, 4, 6, 8 and 10 % of D towards each centre: natural or unnatural? Between "
        "these distances the figure is interpolated. The paper advises less than 6 %. Its faces "
        "came a little closer than these figures say, since its fit goes past the targets by about "
        "13 %: an exact fit of the same percentage moves a little less than they saw.",
        students=STUDENTS,
        faces=SUBJECTS,
    )
