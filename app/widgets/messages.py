"""Messages over the canvas: what happened, with the next step as a button; never modal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QElapsedTimer, QSize, Qt, QTimer, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QStatusBar

from kogao_core.photo import Photo, formats, has_gain_map
from kogao_core.photo.formats.base import FileFormat
from kogao_core.photo.metadata import kinds

from ..i18n import tr, translated
from ..render.colour import screen_colours, told_screen
from ..theme import GRID_PX
from .controls import Elided, muted_label

# What is done sooner after a message came was done without having read it.
UNREAD_MS: Final = 2000
LINGER_MS: Final = 10_000
_WIDEST_PX: Final = 720


@dataclass(frozen=True, slots=True)
class BarAction:
    """A button of a message: its text and what it does."""

    text: str
    act: Callable[[], object]


@dataclass(frozen=True, slots=True)
class Message:
    """What the bar says."""

    text: str  # what happened
    steps: tuple[BarAction, ...] = ()  # what can be done about it
    wrong: bool = True  # whether something went wrong
    # Whether it still applies; such a message stays until it doesn't, or is answered.
    applies: Callable[[], bool] | None = None


class MessageBar(QFrame):
    """One message at a time: the newest about the last action, else the newest that still applies.

    A message about the last action goes with the next step of the document (`move_on`) or the next
    attempt to open, save or find something (`clear`). One that only informs also goes by itself.
    """

    left = Signal()
    dismissed = Signal()
    appeared = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName(tr("Message"))
        self.text = QLabel()
        self.text.setWordWrap(True)
        self.text.setTextFormat(Qt.TextFormat.PlainText)
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(3 * GRID_PX, 2 * GRID_PX, 2 * GRID_PX, 2 * GRID_PX)
        self._row.setSpacing(2 * GRID_PX)
        self._row.addWidget(self.text, 1)
        self.buttons: list[QPushButton] = []
        self._last: Message | None = None
        self._lasting: list[Message] = []
        self._shown: Message | None = None
        self._since = QElapsedTimer()
        self._since.start()
        self._linger = QTimer(self, singleShot=True, interval=LINGER_MS)
        self._linger.timeout.connect(self._fade)
        # What was said just before a step is read first, and goes then.
        self._unread = QTimer(self, singleShot=True)
        self._unread.timeout.connect(self.clear)
        self.hide()

    def say(self, message: Message) -> None:
        """Show a message, in place of the last one unless that one holds."""
        if message.applies is None:
            self._last = message
        else:
            others = [known for known in self._lasting if known.text != message.text]
            self._lasting = [*others, message]
        self.refresh()

    def move_on(self) -> None:
        """Take a step of the document as the answer to what was said of the last action."""
        unread_ms = UNREAD_MS - self._since.elapsed()
        if unread_ms <= 0:
            self._last = None
        elif self._last is not None:
            self._unread.start(unread_ms)
        self.refresh()

    @property
    def shown(self) -> Message | None:
        """What it says, if anything."""
        return self._shown

    def dismiss(self) -> bool:
        """Send away what is shown, as its last button does; return whether there was anything."""
        if self._shown is None:
            return False
        self._take(self.dismissed.emit)
        return True

    def clear(self) -> None:
        """Say nothing more of the last action."""
        self._last = None
        self.refresh()

    def refresh(self) -> None:
        """Show what still applies, and no more."""
        self._lasting = [
            message for message in self._lasting if message.applies and message.applies()
        ]
        message = self._last or (self._lasting[-1] if self._lasting else None)
        if message is self._shown:
            return
        self._empty()
        self._shown = message
        if message is not None:
            self._fill(message)

    def size_in(self, width_px: int) -> QSize:
        """Return the size at which the text stands in as few lines as fit a width."""
        lines = self.text.text().splitlines()
        text_px = max(map(self.fontMetrics().horizontalAdvance, lines), default=0)
        buttons_px = sum(button.sizeHint().width() + 2 * GRID_PX for button in self.buttons)
        wanted_px = text_px + buttons_px + 8 * GRID_PX
        width_px = min(width_px, _WIDEST_PX, wanted_px)
        self._row.activate()
        return QSize(width_px, self.heightForWidth(width_px))

    def _fade(self) -> None:
        if self.underMouse() or any(button.hasFocus() for button in self.buttons):
            self._linger.start()
        else:
            self.clear()

    def _fill(self, message: Message) -> None:
        self.text.setText(message.text)
        self.setProperty("bar", "wrong" if message.wrong else "hint")
        self.style().polish(self)
        self.setAccessibleDescription(message.text)
        for step in message.steps:
            self._add(step.text, step.act)
        self._add(tr("Dismiss"), self.dismissed.emit)
        self.buttons[-1].setToolTip(tr("Close this message (Escape)"))
        self._since.start()
        if not message.wrong and not message.steps and message.applies is None:
            self._linger.start()
        self.show()
        self.raise_()
        self.appeared.emit()

    def _empty(self) -> None:
        if any(button.hasFocus() for button in self.buttons):
            self.left.emit()
        self._linger.stop()
        self._unread.stop()
        self.hide()
        for button in self.buttons:
            self._row.removeWidget(button)
            button.hide()
            button.deleteLater()
        self.buttons = []

    def _add(self, text: str, act: Callable[[], object]) -> None:
        button = QPushButton(text)
        button.clicked.connect(lambda: self._take(act))
        self._row.addWidget(button)
        self.buttons.append(button)

    def _take(self, act: Callable[[], object]) -> None:
        answered = self._shown
        self._lasting = [message for message in self._lasting if message is not answered]
        self.clear()
        act()


class StatusLine(QStatusBar):
    """Facts on the right, hints on the left."""

    def __init__(self) -> None:
        super().__init__()
        self.setSizeGripEnabled(False)
        self._hint = Elided()
        facts = [muted_label() for _ in range(4)]
        self._cursor, self._photo, self._speed, self._zoom = facts
        self._tool = self._lasting = ""
        self._told = False
        self._hint.setContentsMargins(8, 0, 0, 0)
        self.addWidget(self._hint, 1)
        for label in facts:
            label.setContentsMargins(8, 4, 8, 4)
            self.addPermanentWidget(label)

    def show_tool(self, text: str) -> None:
        """Say what the tool in hand does, once it is another one."""
        if text != self._tool:
            self._tool = text
            self.hint("")

    def hint(self, text: str) -> None:
        """Say what is under way; an empty text brings the tool back."""
        self._told = False
        self._lasting = text or self._tool
        self._hint.setText(self._lasting)

    def tell(self, text: str) -> None:
        """Say what has just been done, until the next step."""
        self.hint(text)
        self._told = True

    def move_on(self) -> None:
        """Take a step of the document as the end of what was done before."""
        if self._told:
            self.hint("")

    def name_point(self, text: str) -> None:
        """Name the point in question; an empty name brings the hint back."""
        self._hint.setText(text or self._lasting)

    @property
    def hint_text(self) -> str:
        """What the hint says."""
        return self._hint.text()

    def show_cursor(self, x: float, y: float) -> None:
        """Show the pixel under the cursor; negative ones are none."""
        inside = x >= -0.5 and y >= -0.5
        self._cursor.setText(tr("x {x:.0f}  y {y:.0f}", x=x, y=y) if inside else "")

    def show_photo(self, photo: Photo) -> None:
        """Show size, depth, colour space, what reading changed and what a copy won't keep.

        How long its picture takes isn't known yet.
        """
        size = f"{photo.width} × {photo.height}"  # noqa: RUF001
        parts = [size, tr("{n}-bit", n=photo.bits)]
        colours = screen_colours(photo)
        if photo.icc_profile is not None:
            unusable = tr("colour profile can't be used")
            parts.append((colours.name or tr("colour profile")) if colours.usable else unusable)
        has_map = has_gain_map(photo)
        if has_map:
            parts.append(tr("HDR"))
        along = (kinds.GAIN_MAP,) if has_map else ()
        lost = _copied_as(photo).not_kept(photo, photo.extras, along)
        notes = [*photo.notes, *filter(None, [lost])]
        if notes:
            parts.append(tr("notes: {n}", n=len(notes)))
        self._photo.setText(" · ".join(parts))
        self._photo.setToolTip("\n".join([*map(translated, notes), told_screen()]))
        self._speed.clear()

    def show_speed(self, took_ms: float) -> None:
        """Show how long the newest picture took."""
        self._speed.setText(tr("drawn in {ms:.0f} ms", ms=took_ms))

    def show_zoom(self, zoom: float) -> None:
        """Show the zoom in %."""
        self._zoom.setText(f"{zoom * 100:.0f} %")


def _copied_as(photo: Photo) -> FileFormat:
    """Return the format of a copy like the photo, or the one that holds most."""
    return next(
        (form for form in formats.WRITTEN if form.name == photo.format), formats.BY_NAME["TIFF"]
    )
