"""The film strip as it is seen: photos in a row, what is told of each, and which are shown."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Final

from PySide6.QtCore import (
    QModelIndex,
    QPersistentModelIndex,
    QPoint,
    QRect,
    QSignalBlocker,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QIcon, QImage, QPainter, QPalette, QPixmap
from PySide6.QtWidgets import (
    QApplication,
    QGridLayout,
    QListView,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from kogao_core.photo.metadata.glance import LABELS, MOST_STARS, REJECTED

from ...i18n import tr
from ...render.pictures import untinted
from ...theme import GRID_PX, OKABE_ITO
from ...widgets.controls import ChoiceBox, Elided, column_of, named, row_of
from .facts import THUMBNAIL_PX, Facts, Mark

_PATH: Final = Qt.ItemDataRole.UserRole
_FACTS: Final = Qt.ItemDataRole.UserRole + 1
_LABEL_PX: Final = 10
_CONTROLS_PX: Final = 208
_STAR: Final = "★"
_REJECTED: Final = "✕"
_COLOURS: Final = {
    label: QColor(OKABE_ITO[name])
    for label, name in zip(LABELS, ("vermilion", "yellow", "green", "blue", "purple"), strict=True)
}
Test = Callable[[Facts], bool]


class FilmStrip(QListWidget):
    """A row of thumbnails."""

    wanted = Signal(object)
    counted = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName(tr("Film strip"))
        self.setAccessibleDescription(tr("Photos to open with a click or the Return key"))
        self.setViewMode(QListView.ViewMode.IconMode)
        self.setFlow(QListView.Flow.LeftToRight)
        self.setWrapping(False)
        self.setMovement(QListView.Movement.Static)
        self.setUniformItemSizes(True)
        self.setIconSize(QSize(THUMBNAIL_PX, THUMBNAIL_PX))
        self.setGridSize(QSize(THUMBNAIL_PX + 24, THUMBNAIL_PX + 32))
        self.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.setMinimumHeight(THUMBNAIL_PX + 52)
        self.setSelectionMode(QListView.SelectionMode.ExtendedSelection)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        self.setItemDelegate(_Marked(self))
        self._passed: Path | None = None
        self._items: dict[Path, QListWidgetItem] = {}
        self._shows: Test = lambda _: True
        self.hidden = 0  # photos that aren't shown
        self.itemClicked.connect(self._tell)
        self.itemActivated.connect(self._tell)

    def sizeHint(self) -> QSize:
        """Return room for one row: what lies below it is the photo's."""
        return QSize(super().sizeHint().width(), self.minimumHeight())

    def show_paths(self, paths: Sequence[Path]) -> None:
        """Show these photos; their thumbnails come later."""
        self.clear()
        self._passed, self._items, self.hidden = None, {}, 0
        picture = QPixmap(THUMBNAIL_PX, THUMBNAIL_PX)
        picture.fill(Qt.GlobalColor.transparent)
        blank = QIcon(picture)
        for path in paths:
            item = self._items[path] = QListWidgetItem(blank, path.name)
            item.setData(_PATH, str(path))
            item.setToolTip(str(path))
            self.addItem(item)
        self.counted.emit()

    def show_thumbnail(self, path: Path, image: QImage) -> None:
        """Show the thumbnail of a photo."""
        item = self._items.get(path)
        if item is not None and not image.isNull():
            item.setIcon(untinted(QPixmap.fromImage(image)))

    def show_facts(self, path: Path, facts: Facts) -> None:
        """Show what was done to a photo, and its stars."""
        item = self._items.get(path)
        if item is None or item.data(_FACTS) == facts:
            return
        item.setData(_FACTS, facts)
        words = ", ".join(_words(facts))
        item.setToolTip(f"{path}\n{words}" if words else str(path))
        name = f"{path.name}, {words}" if words else ""
        item.setData(Qt.ItemDataRole.AccessibleTextRole, name or None)
        if self._hide(item):
            self.counted.emit()

    def __contains__(self, path: object) -> bool:
        """Tell whether a photo is on it, shown or not."""
        return path in self._items

    def facts(self, path: Path) -> Facts:
        """Return what is shown of a photo."""
        return _facts(self._items[path])

    def show_only(self, shows: Test) -> None:
        """Show the photos that pass a test, and no others."""
        self._shows = shows
        for item in self._items.values():
            self._hide(item)
        self.counted.emit()
        self._keep_in_sight()

    def sort(self, *, by_stars: bool) -> None:
        """Put the photos into the order of their names, or those with most stars first."""
        items = list(self._items.values())
        if by_stars:
            items.sort(key=lambda item: -_facts(item).rated.stars)
        if items == [self.item(row) for row in range(self.count())]:
            return
        current, chosen = self.currentItem(), self.selectedItems()
        hidden = {str(item.data(_PATH)) for item in items if item.isHidden()}
        with QSignalBlocker(self):
            for row in reversed(range(self.count())):
                self.takeItem(row)
            for item in items:
                self.addItem(item)
                item.setHidden(item.data(_PATH) in hidden)
            if current is not None:
                self.setCurrentItem(current)
            for item in chosen:
                item.setSelected(True)
        self._keep_in_sight()

    def next_of(self, paths: Collection[Path]) -> Path | None:
        """Return one of these photos, one that is in sight if there is any."""
        step, middle = self.gridSize().width(), self.viewport().height() // 2
        for x in range(step // 2, self.viewport().width() + step, step):
            item = self.itemAt(QPoint(x, middle))
            if item is not None and Path(item.data(_PATH)) in paths:
                return Path(item.data(_PATH))
        return next(iter(paths), None)

    def mark(self, path: Path | None) -> None:
        """Select the photo that is open."""
        self._passed = None
        with QSignalBlocker(self):
            row = self._row_of(path)
            self.setCurrentRow(-1 if row is None else row)

    def pass_over(self, path: Path | None) -> None:
        """Let the next step begin at a photo that isn't open."""
        self._passed = path

    def path(self, row: int) -> Path:
        """Return which photo stands in a row."""
        return Path(self.item(row).data(_PATH))

    def step(self, by: int) -> None:
        """Ask for the next or an earlier photo among those that are shown; results are none."""
        row = self._row_of(self._passed)
        row = (self.currentRow() if row is None else row) + by
        while 0 <= row < self.count() and not self._is_stop(row):
            row += by
        if 0 <= row < self.count():
            self.wanted.emit(self.path(row))

    def listed(self, *, chosen: bool = False) -> list[Path]:
        """Return the photos that are shown, or chosen, in their order; no results."""
        stops = (row for row in range(self.count()) if self._is_stop(row))
        return [self.path(row) for row in stops if self.item(row).isSelected() or not chosen]

    def picked(self) -> list[Path]:
        """Return all that is chosen, results among it."""
        return [Path(item.data(_PATH)) for item in self.selectedItems() if not item.isHidden()]

    def _is_stop(self, row: int) -> bool:
        item = self.item(row)
        return not item.isHidden() and _facts(item).mark != "result"

    def _hide(self, item: QListWidgetItem) -> bool:
        """Show a photo or not; return whether that is new."""
        hidden = not self._shows(_facts(item))
        if hidden == item.isHidden():
            return False
        item.setHidden(hidden)
        self.hidden += 1 if hidden else -1
        return True

    def _keep_in_sight(self) -> None:
        if self.currentItem() is not None:
            self.scrollToItem(self.currentItem())

    def _row_of(self, path: Path | None) -> int | None:
        item = self._items.get(path) if path else None
        return None if item is None else self.row(item)

    def _tell(self, item: QListWidgetItem) -> None:
        held = QApplication.keyboardModifiers()
        if held & (Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier):
            return  # it is being chosen
        self.wanted.emit(self.path(self.row(item)))


class StripPanel(QWidget):
    """The film strip, and beside it what it shows, in which order, and what is under way."""

    def __init__(self) -> None:
        super().__init__()
        self.film = FilmStrip()
        self._choices = _choices()
        self.order, self.choice = ChoiceBox(), ChoiceBox()
        self.order.addItems([tr("By name"), tr("Most stars first")])
        self.choice.addItems(list(self._choices))
        self.order.currentIndexChanged.connect(self.sort)
        self.choice.currentTextChanged.connect(
            lambda name: self.film.show_only(self._choices[name])
        )
        self.line, self.halt = Elided(), QPushButton(tr("Stop"))
        self.halt.setToolTip(tr("After the photos in hand"))
        self._running = ""
        self._stop: Callable[[], object] = lambda: None
        self.halt.clicked.connect(lambda: self._stop())
        self.film.counted.connect(self._count)
        controls, rows = QWidget(), QGridLayout()
        controls.setFixedWidth(_CONTROLS_PX)
        for row, (title, box) in enumerate(((tr("Order"), self.order), (tr("Shown"), self.choice))):
            rows.addWidget(named(title, box), row, 0)
            rows.addWidget(box, row, 1)
        rows.setColumnStretch(1, 1)
        below = row_of(self.line, self.halt)
        column_of(controls, rows, below, None, margin=GRID_PX, spacing=GRID_PX)
        column_of(self, row_of(controls, self.film, spacing=GRID_PX))
        self.show_running("")

    def show_all(self) -> None:
        """Show every photo, whatever was chosen before."""
        self.choice.setCurrentIndex(0)

    def sort(self) -> None:
        """Put the photos into the chosen order, by the stars they have now."""
        self.film.sort(by_stars=self.order.currentIndex() == 1)

    def show_running(self, text: str, stop: Callable[[], object] = lambda: None) -> None:
        """Show what is under way with photos of the strip, and stop it there; "" for nothing."""
        self._stop = stop
        self._running = text
        self.halt.setVisible(bool(text))
        self._count()

    def _count(self) -> None:
        total, hidden = self.film.count(), self.film.hidden
        some = tr("{n} of {total} shown", n=total - hidden, total=total) if hidden else ""
        self.line.setText(self._running or some)


class _Marked(QStyledItemDelegate):
    """Draws what was done to a photo, and its stars, over its thumbnail."""

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> None:
        """Draw a thumbnail, and what there is to tell."""
        super().paint(painter, option, index)
        facts = index.data(_FACTS)
        if not isinstance(facts, Facts):
            return
        painter.save()
        painter.setPen(option.palette.color(QPalette.ColorRole.ToolTipText))
        area = option.rect.adjusted(GRID_PX, GRID_PX, -GRID_PX, -GRID_PX)
        if facts.mark:
            words = _marks()[facts.mark]
            space = _ground(painter, words)
            space.moveTopRight(area.topRight())
            _write(painter, option, space, words)
        stars = facts.rated.stars
        if stars:
            words = _REJECTED if stars == REJECTED else _STAR * stars
            space = _ground(painter, words)
            space.moveBottomLeft(QPoint(area.left(), option.rect.top() + THUMBNAIL_PX + GRID_PX))
            _write(painter, option, space, words)
        if facts.rated.label:
            square = QRect(area.topLeft(), QSize(_LABEL_PX, _LABEL_PX))
            painter.setBrush(_COLOURS.get(facts.rated.label, QColor("#808080")))
            painter.drawRect(square)
        painter.restore()


def _ground(painter: QPainter, words: str) -> QRect:
    return painter.fontMetrics().boundingRect(words).adjusted(-GRID_PX, -1, GRID_PX, 1)


def _write(painter: QPainter, option: QStyleOptionViewItem, space: QRect, words: str) -> None:
    painter.fillRect(space, option.palette.color(QPalette.ColorRole.ToolTipBase))
    painter.drawText(space, Qt.AlignmentFlag.AlignCenter, words)


def _facts(item: QListWidgetItem) -> Facts:
    facts = item.data(_FACTS)
    return facts if isinstance(facts, Facts) else Facts()


def _words(facts: Facts) -> list[str]:
    """Return what there is to tell of a photo, in words."""
    stars, label = facts.rated.stars, facts.rated.label
    rated = tr("rejected") if stars == REJECTED else _STAR * stars
    return [
        part for part in (_marks().get(facts.mark, ""), rated, labels().get(label, label)) if part
    ]


def _marks() -> dict[Mark, str]:
    return {
        "edited": tr("edited"),
        "saved": tr("copy saved"),
        "doubtful": tr("doubtful"),
        "result": tr("result"),
        "failed": tr("not done"),
    }


def labels() -> dict[str, str]:
    """Return what the labels are called."""
    words = (tr("red"), tr("yellow"), tr("green"), tr("blue"), tr("purple"))
    return dict(zip(LABELS, words, strict=True))


def _choices() -> dict[str, Test]:
    """Return which photos there are to choose, by their names."""

    def at_least(stars: int) -> Test:
        return lambda facts: facts.rated.stars >= stars

    def labelled(label: str) -> Test:
        return lambda facts: facts.rated.label == label

    def marked(*marks: Mark) -> Test:
        return lambda facts: facts.mark in marks

    every = {_STAR * stars: at_least(stars) for stars in range(1, MOST_STARS)}
    return {
        tr("All photos"): lambda _: True,
        tr("Not rejected"): at_least(0),
        **{tr("{stars} or more", stars=stars): test for stars, test in every.items()},
        _STAR * MOST_STARS: at_least(MOST_STARS),
        tr("Without stars"): lambda facts: facts.rated.stars == 0,
        tr("Rejected"): lambda facts: facts.rated.stars == REJECTED,
        **{tr("Label: {name}", name=labels()[one]): labelled(one) for one in LABELS},
        tr("Untouched"): marked(""),
        tr("Edited, no copy saved"): marked("edited", "doubtful"),
        tr("Copy saved"): marked("saved"),
        tr("Doubtful"): marked("doubtful"),
        tr("Not done"): marked("failed"),
    }
