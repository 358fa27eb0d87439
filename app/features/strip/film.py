"""The film strip: a row of thumbnails with marks, a filter, an order and the sync button."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from PySide6.QtCore import (
    QEvent,
    QModelIndex,
    QPersistentModelIndex,
    QPoint,
    QRect,
    QSignalBlocker,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import (
    QAction,
    QColor,
    QFont,
    QIcon,
    QKeyEvent,
    QKeySequence,
    QPainter,
    QPalette,
    QPen,
    QPixmap,
    QResizeEvent,
)
from PySide6.QtWidgets import (
    QApplication,
    QListView,
    QListWidget,
    QListWidgetItem,
    QMenu,
    QPushButton,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QToolButton,
    QWidget,
)

from kogao_core.faces.names import folded
from kogao_core.photo.metadata.rating import LABELS, MOST_STARS, REJECTED

from ...i18n import tr, tr_count
from ...render.pictures import untinted
from ...theme import GRID_PX, OKABE_ITO
from ...widgets.controls import ChoiceBox, Elided, column_of, row_of
from .facts import LARGEST_PX, THUMBNAIL_PX, Facts, Mark, Preview

_PATH: Final = Qt.ItemDataRole.UserRole
_FACTS: Final = Qt.ItemDataRole.UserRole + 1
_WARNING: Final = Qt.ItemDataRole.UserRole + 2
_SEEN: Final = Qt.ItemDataRole.UserRole + 3
_COUNTED: Final = Qt.ItemDataRole.UserRole + 4  # mark under which `FilmStrip.marks` counts a photo
_LABEL_PX: Final = 10
_NARROW_PX: Final = 760  # below, chips show their number without a word
_BADGE_PX: Final = 16
_BELOW_PX: Final = 52  # height of name, frame and scroll bar
_NAME: Final = "IMG_0000_00.jpg"  # a name of this length isn't elided
_SELECTED: Final = 0.22  # opacity of the accent under a selected photo
_STAR: Final = "★"
_REJECTED: Final = "✕"
_COLOURS: Final = {
    label: QColor(OKABE_ITO[name])
    for label, name in zip(LABELS, ("vermilion", "yellow", "green", "blue", "purple"), strict=True)
}
# Sign and colour of a badge at the lower right of a thumbnail; chips over the strip name them.
_SIGNS: Final[dict[Mark, tuple[str, str]]] = {
    "edited": ("", OKABE_ITO["sky"]),
    "doubtful": ("!", OKABE_ITO["orange"]),
    "failed": ("✕", OKABE_ITO["vermilion"]),
    "saved": ("✓", OKABE_ITO["green"]),
    "result": ("R", "#8a8a8a"),
}
Test = Callable[[Facts], bool]


class FilmStrip(QListWidget):
    """A row of thumbnails."""

    # (photo: Path): open a photo of the strip.
    wanted = Signal(object)
    # (): the number of visible photos may have changed.
    counted = Signal()
    # (): the thumbnails have another size.
    resized = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName(tr("Film strip"))
        self.setAccessibleDescription(tr("Photos to open with a click or the Return key"))
        self.setViewMode(QListView.ViewMode.IconMode)
        self.setFlow(QListView.Flow.LeftToRight)
        self.setWrapping(False)
        self.setMovement(QListView.Movement.Static)
        self.setUniformItemSizes(True)
        self._fit_height(THUMBNAIL_PX)
        self.setTextElideMode(Qt.TextElideMode.ElideLeft)  # the last digits tell photos apart
        self.setMinimumHeight(THUMBNAIL_PX + _BELOW_PX)
        self.setSelectionMode(QListView.SelectionMode.ExtendedSelection)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        self.setItemDelegate(_Marked(self))
        self.setProperty("film", "true")
        self._passed: Path | None = None
        self._opened: Path | None = None
        self._items: dict[Path, QListWidgetItem] = {}
        self.marks = Counter[Mark]()  # photos by mark
        self._shows: Test = lambda _: True
        self.hidden = 0  # number of photos hidden by the filter
        self.itemClicked.connect(self._tell)
        self.itemActivated.connect(self._tell)

    def event(self, event: QEvent) -> bool:
        """Handle Ctrl+A before the window's shortcuts."""
        if (
            event.type() == QEvent.Type.ShortcutOverride
            and isinstance(event, QKeyEvent)
            and event.matches(QKeySequence.StandardKey.SelectAll)
        ):
            event.accept()
            return True
        return super().event(event)

    def sizeHint(self) -> QSize:
        """Return the size of a single row, so that the photo gets the remaining height."""
        return QSize(super().sizeHint().width(), self.minimumHeight())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Scale the thumbnails to the height of the strip."""
        super().resizeEvent(event)
        side = min(max(event.size().height() - _BELOW_PX + 4, THUMBNAIL_PX), LARGEST_PX)
        if side != self.iconSize().width():
            self._fit_height(side)
            self.resized.emit()

    def _fit_height(self, side_px: int) -> None:
        name_px = self.fontMetrics().horizontalAdvance(_NAME)
        self.setIconSize(QSize(side_px, side_px))
        self.setGridSize(QSize(max(side_px, name_px) + 24, side_px + 32))
        self.scheduleDelayedItemsLayout()

    def show_paths(self, paths: Sequence[Path]) -> None:
        """Show these photos; thumbnails load later."""
        self.clear()
        self._passed, self._items, self.hidden = None, {}, 0
        self.marks = Counter[Mark]({"": len(paths)})
        picture = QPixmap(THUMBNAIL_PX, THUMBNAIL_PX)
        picture.fill(Qt.GlobalColor.transparent)
        blank = QIcon(picture)
        for path in paths:
            item = self._items[path] = QListWidgetItem(blank, path.name)
            item.setData(_PATH, str(path))
            item.setToolTip(str(path))
            self.addItem(item)
        self.counted.emit()

    def show_thumbnail(self, path: Path, preview: Preview) -> None:
        """Show the thumbnail of a photo, and mark a photo that should be checked."""
        item = self._items.get(path)
        if item is None or preview.picture.isNull():
            return
        item.setIcon(untinted(QPixmap.fromImage(preview.picture)))
        if (item.data(_WARNING) or "") != preview.warning:
            item.setData(_WARNING, preview.warning)
            item.setData(_SEEN, False)
            self._describe(item)
            self.counted.emit()

    def next_to_check(self) -> tuple[Path, str] | None:
        """Mark the next photo that needs a look as seen; return it with the reasons, or None."""
        first = 1 + (-1 if (row := self._row_of(self._opened)) is None else row)
        for row in (*range(first, self.count()), *range(first)):
            item = self.item(row)
            if not item.isHidden() and _facts(item).mark == "doubtful":
                item.setData(_SEEN, True)
                self._describe(item)
                self.counted.emit()
                return self.path(row), item.data(_WARNING) or ""
        return None

    def show_facts(self, path: Path, facts: Facts) -> None:
        """Show the mark and the rating of a photo."""
        item = self._items.get(path)
        if item is None or item.data(_FACTS) == facts:
            return
        item.setData(_FACTS, facts)
        self._describe(item)
        self._hide(item)
        self.counted.emit()

    def _describe(self, item: QListWidgetItem) -> None:
        now = _facts(item).mark
        self.marks[item.data(_COUNTED) or ""] -= 1
        self.marks[now] += 1
        item.setData(_COUNTED, now)
        words = [*_words(_facts(item)), *filter(None, [item.data(_WARNING)])]
        item.setToolTip("\n".join([item.data(_PATH), *words]))
        name = ", ".join([item.text(), *words]) if words else None
        item.setData(Qt.ItemDataRole.AccessibleTextRole, name)

    def __contains__(self, path: object) -> bool:
        """Return whether a photo is on the strip, also if hidden."""
        return path in self._items

    def show_only(self, shows: Test) -> None:
        self._shows = shows
        for item in self._items.values():
            self._hide(item)
        self.counted.emit()
        self._keep_in_sight()

    def sort(self, *, by_stars: bool) -> None:
        """Sort by name, or by stars with most stars first."""
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
        """Return one of these photos, preferably a visible one; None for no photos."""
        step, middle = self.gridSize().width(), self.viewport().height() // 2
        for x in range(step // 2, self.viewport().width() + step, step):
            item = self.itemAt(QPoint(x, middle))
            if item is not None and Path(item.data(_PATH)) in paths:
                return Path(item.data(_PATH))
        return next(iter(paths), None)

    def mark(self, path: Path | None) -> None:
        """Select the open photo."""
        self._passed, self._opened = None, path
        with QSignalBlocker(self):
            row = self._row_of(path)
            self.setCurrentRow(-1 if row is None else row)
        self.viewport().update()

    def pass_over(self, path: Path | None) -> None:
        """Start the next step at a photo that isn't open."""
        self._passed = path

    def path(self, row: int) -> Path:
        return Path(self.item(row).data(_PATH))

    def step(self, by: int) -> None:
        """Request the next or previous visible photo, counted from the open one; skip results."""
        row = self._row_of(self._passed or self._opened)
        row = (self.currentRow() if row is None else row) + by
        while 0 <= row < self.count() and not self._is_stop(row):
            row += by
        if 0 <= row < self.count():
            self.wanted.emit(self.path(row))

    def listed(self, *, chosen: bool = False) -> list[Path]:
        """Return the visible or the selected photos in order, without results."""
        stops = (row for row in range(self.count()) if self._is_stop(row))
        return [self.path(row) for row in stops if self.item(row).isSelected() or not chosen]

    def named(self, name: str) -> list[Path]:
        """Return the visible photos whose metadata have a person's name, without results."""
        wanted = folded(name)
        items = ((path, self._items[path]) for path in self.listed())
        return [path for path, item in items if wanted in map(folded, _facts(item).rated.people)]

    def _is_stop(self, row: int) -> bool:
        item = self.item(row)
        return not item.isHidden() and _facts(item).mark != "result"

    def _hide(self, item: QListWidgetItem) -> bool:
        """Apply the filter to a photo; return whether the visibility changed."""
        hidden = not self._shows(_facts(item))
        if hidden == item.isHidden():
            return False
        item.setHidden(hidden)
        self.hidden += 1 if hidden else -1
        return True

    def _keep_in_sight(self) -> None:
        if self.currentItem() is not None:
            self.scrollToItem(self.currentItem())

    @property
    def opened(self) -> Path | None:
        return self._opened

    def _row_of(self, path: Path | None) -> int | None:
        item = self._items.get(path) if path else None
        return None if item is None else self.row(item)

    def _tell(self, item: QListWidgetItem) -> None:
        held = QApplication.keyboardModifiers()
        if held & (Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier):
            return  # the click extends the selection
        self.wanted.emit(self.path(self.row(item)))


class StripPanel(QWidget):
    """The film strip with filter, order and progress."""

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
        self._running, self._selected = "", 0
        self._stop: Callable[[], object] = lambda: None
        self.halt.clicked.connect(lambda: self._stop())
        self.film.counted.connect(self._count)
        for box, title in ((self.order, tr("Sort")), (self.choice, tr("Filter"))):
            box.setAccessibleName(title)
            box.setToolTip(title)
        self.chips = {mark: self._chip(mark) for mark in _SIGNS if mark != "result"}
        self.sync = QToolButton()
        self.sync.setPopupMode(QToolButton.ToolButtonPopupMode.MenuButtonPopup)
        self.sync.setProperty("segment", "true")
        self.sync.hide()
        self.person = QToolButton()
        self.person.setProperty("segment", "true")
        self.person.hide()
        self.groups = Elided()
        boxes = self.halt, self.person, self.sync, self.choice, self.order
        bar = row_of(*self.chips.values(), self.line, self.groups, *boxes, spacing=GRID_PX)
        bar.setStretchFactor(self.line, 1)
        bar.setStretchFactor(self.groups, 1)
        bar.setContentsMargins(2 * GRID_PX, GRID_PX, 2 * GRID_PX, 0)
        column_of(self, bar, self.film, spacing=0)
        self.show_running("")

    def _chip(self, mark: Mark) -> QToolButton:
        """Return a button that names a badge, counts it, and shows only its photos."""
        chip, name, every = QToolButton(), _filters()[mark], self.choice.itemText(0)
        chip.setProperty("chip", "true")
        chip.setCheckable(True)
        chip.setIcon(QIcon(_badge_picture(mark, self.devicePixelRatioF())))
        chip.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        chip.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        chip.setToolTip(tr("Show only: {what}", what=name))
        chip.clicked.connect(lambda on: self.choice.setCurrentText(name if on else every))
        return chip

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Shorten the chips of a narrow strip."""
        super().resizeEvent(event)
        self._count()

    def offer_sync(self, action: QAction, groups: QMenu, person: QAction) -> None:
        """Add the buttons that sync settings, with a menu of groups of settings."""
        self.person.clicked.connect(person.trigger)
        self.person.setToolTip(person.toolTip())
        self.sync.clicked.connect(action.trigger)
        self.sync.setMenu(groups)
        self.sync.setToolTip(action.toolTip())

    def show_groups(self, names: str) -> None:
        """Show what the sync button copies."""
        self.groups.setText(names)

    def show_person(self, text: str) -> None:
        """Show the button of a person; "" hides the button."""
        self.person.setText(text)
        self._count()

    def show_selected(self, count: int) -> None:
        """Show the sync button while photos are selected."""
        self.sync.setText(tr_count(count, "Apply to {n} photo", "Apply to {n} photos"))
        self._selected = count
        self._count()

    def show_all(self) -> None:
        self.choice.setCurrentIndex(0)

    def sort(self) -> None:
        """Sort by the selected order, with the current stars."""
        self.film.sort(by_stars=self.order.currentIndex() == 1)

    def show_running(self, text: str, stop: Callable[[], object] = lambda: None) -> None:
        """Show the progress of a job and a stop button; "" hides both."""
        self._stop = stop
        self._running = text
        self.halt.setVisible(bool(text))
        self._count()

    def _count(self) -> None:
        total, hidden = self.film.count(), self.film.hidden
        some = tr("{n} of {total} shown", n=total - hidden, total=total) if hidden else ""
        self.line.setText(self._running or some)
        self.sync.setVisible(bool(self._selected) and not self._running)
        self.person.setVisible(bool(self.person.text()) and not self._running)
        self.line.setHidden(self.sync.isVisibleTo(self))
        self.groups.setVisible(self.sync.isVisibleTo(self))
        filters, marks = _filters(), _marks()
        for mark, chip in self.chips.items():
            name, here = filters[mark], self.choice.currentText()
            count = sum(self.film.marks[one] for one in _shown_with(mark))
            chip.setText(f"{count}" if self.width() < _NARROW_PX else f"{marks[mark]} {count}")
            chip.setAccessibleName(f"{name}, {count}")
            chip.setChecked(here == name)
            chip.setVisible(bool(count) or here == name)


class _Marked(QStyledItemDelegate):
    """Draws the marks of a photo over its thumbnail: edits, stars, label, warning."""

    def sizeHint(
        self,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> QSize:
        """Return the size of a grid cell, so that the name has the whole width."""
        view = option.widget
        if isinstance(view, QListView):
            return view.gridSize()
        return super().sizeHint(option, index)

    def initStyleOption(
        self,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> None:
        """Reserve a square for each thumbnail, so that marks don't cover the name."""
        super().initStyleOption(option, index)
        view = option.widget
        if isinstance(view, FilmStrip):
            option.decorationSize = view.iconSize()
            if str(view.opened) == index.data(_PATH):
                option.font.setWeight(QFont.Weight.DemiBold)

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> None:
        accent, cell = QApplication.palette().accent().color(), option.rect.adjusted(1, 1, -1, -1)
        if option.state & QStyle.StateFlag.State_Selected:
            painter.setOpacity(_SELECTED)
            painter.fillRect(cell, accent)
            painter.setOpacity(1.0)
        super().paint(painter, option, index)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if isinstance(option.widget, FilmStrip) and str(option.widget.opened) == index.data(_PATH):
            painter.setPen(QPen(accent, 2.0))
            painter.drawRoundedRect(cell, 5, 5)
        facts = _facts(index)
        area = option.rect.adjusted(GRID_PX, GRID_PX, -GRID_PX, -GRID_PX)
        low = option.rect.top() + option.decorationSize.height() + GRID_PX
        if facts.mark:
            badge = QRect(0, 0, _BADGE_PX, _BADGE_PX)
            right = area.center().x() + option.decorationSize.width() // 2
            badge.moveBottomRight(QPoint(right + GRID_PX, low))
            _draw_badge(painter, badge, facts.mark)
        painter.setPen(option.palette.color(QPalette.ColorRole.ToolTipText))
        stars = facts.rated.stars
        if stars:
            words = _REJECTED if stars == REJECTED else _STAR * stars
            space = _ground(painter, words)
            space.moveBottomLeft(QPoint(area.left(), low))
            _write(painter, option, space, words)
        if facts.rated.label:
            square = QRect(area.topLeft(), QSize(_LABEL_PX, _LABEL_PX))
            painter.setBrush(_COLOURS.get(facts.rated.label, QColor("#808080")))
            painter.drawRect(square)
        painter.restore()


def _draw_badge(painter: QPainter, box: QRect, mark: Mark) -> None:
    """Draw a coloured disc in a dark case, with a sign."""
    sign, colour = _SIGNS[mark]
    ink, inset = QColor("#101010"), 1 if sign else 4
    painter.setPen(QPen(ink, 1.5))
    painter.setBrush(QColor(colour))
    painter.drawEllipse(box.adjusted(inset, inset, -inset, -inset))
    font = QFont(painter.font())
    font.setPixelSize(_BADGE_PX - 5)
    font.setBold(True)
    painter.setFont(font)
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, sign)


def _badge_picture(mark: Mark, ratio: float) -> QPixmap:
    picture = QPixmap(QSize(_BADGE_PX, _BADGE_PX) * ratio)
    picture.setDevicePixelRatio(ratio)
    picture.fill(Qt.GlobalColor.transparent)
    with QPainter(picture) as painter:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        _draw_badge(painter, QRect(0, 0, _BADGE_PX, _BADGE_PX), mark)
    return picture


def _ground(painter: QPainter, words: str) -> QRect:
    return painter.fontMetrics().boundingRect(words).adjusted(-GRID_PX, -1, GRID_PX, 1)


def _write(painter: QPainter, option: QStyleOptionViewItem, space: QRect, words: str) -> None:
    painter.fillRect(space, option.palette.color(QPalette.ColorRole.ToolTipBase))
    painter.drawText(space, Qt.AlignmentFlag.AlignCenter, words)


def _facts(item: QListWidgetItem | QModelIndex | QPersistentModelIndex) -> Facts:
    """Return mark and rating; a warning asks for a look like a doubtful face, until seen."""
    facts = item.data(_FACTS)
    facts = facts if isinstance(facts, Facts) else Facts()
    if item.data(_SEEN):
        return replace(facts, mark="edited") if facts.mark == "doubtful" else facts
    asks = item.data(_WARNING) and facts.mark in ("", "edited")
    return replace(facts, mark="doubtful") if asks else facts


def _words(facts: Facts) -> list[str]:
    """Return mark, rating and label of a photo as words."""
    stars, label = facts.rated.stars, facts.rated.label
    rated = tr("rejected") if stars == REJECTED else _STAR * stars
    return [
        part for part in (_marks().get(facts.mark, ""), rated, labels().get(label, label)) if part
    ]


def _marks() -> dict[Mark, str]:
    return {
        "edited": tr("edited"),
        "saved": tr("copy saved"),
        "doubtful": tr("to check"),
        "result": tr("result"),
        "failed": tr("not done"),
    }


def _filters() -> dict[Mark, str]:
    """Return the name of the filter for a mark."""
    return {
        "edited": tr("Edited, no copy saved"),
        "saved": tr("Copy saved"),
        "doubtful": tr("To check"),
        "failed": tr("Not done"),
    }


def _shown_with(mark: Mark) -> tuple[Mark, ...]:
    """Return the marks of the photos that the filter for a mark shows."""
    return ("edited", "doubtful") if mark == "edited" else (mark,)


def labels() -> dict[str, str]:
    """Return the visible names of the labels."""
    words = (tr("red"), tr("yellow"), tr("green"), tr("blue"), tr("purple"))
    return dict(zip(LABELS, words, strict=True))


def _choices() -> dict[str, Test]:
    """Return the filters by visible name."""

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
        **{name: marked(*_shown_with(mark)) for mark, name in _filters().items()},
    }
