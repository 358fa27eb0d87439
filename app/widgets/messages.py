"""Messages over the canvas: an event, with the next step as a button; never modal."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

from PySide6.QtCore import QElapsedTimer, QSize, Qt, QTimer, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QStatusBar

from kogao_core.photo import Photo, formats, has_gain_map
from kogao_core.photo.formats.base import FileFormat
from kogao_core.photo.metadata import kinds
from kogao_core.photo.profiles import is_hdr

from ..i18n import tr, translated
from ..render.colour import screen_colours, told_screen
from ..theme import GRID_PX
from .controls import Elided, muted_label

# Minimum display time, ms. An earlier action doesn't clear the message.
UNREAD_MS: Final = 2000
LINGER_MS: Final = 10_000
_WIDEST_PX: Final = 720
_MOST_LINES: Final = 2  # of a message; the rest of a longer one is behind *Details*
_SENTENCE: Final = re.compile(r"(?<=[.!?])\s+|(?<=。)|\n")  # where the first sentence ends


@dataclass(frozen=True, slots=True)
class BarAction:
    """A button of a message: text and callback."""

    text: str
    act: Callable[[], object]


@dataclass(frozen=True, slots=True)
class Message:
    """A message for the bar."""

    text: str  # the event
    steps: tuple[BarAction, ...] = ()  # buttons for possible next steps
    wrong: bool = True  # True for a problem
    # Whether the message still applies. Such a message stays until False or dismissed.
    applies: Callable[[], bool] | None = None


class MessageBar(QFrame):
    """Shows one message: the newest about the last action, else the newest that still applies.

    A message about the last action disappears at the next edit (`move_on`) or the next attempt
    to open, save or find something (`clear`). A purely informative message also times out.
    """

    # (): the bar had the keyboard focus and hides.
    left = Signal()
    # (): the user has closed the message.
    dismissed = Signal()
    # (): a message is shown.
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
        self._linger = QTimer(self, singleShot=True)
        self._linger.timeout.connect(self._fade)
        self.hide()

    def say(self, message: Message) -> None:
        """Show a message; messages that still apply are shown again later."""
        if message.applies is None:
            self._last = message
        else:
            others = [known for known in self._lasting if known.text != message.text]
            self._lasting = [*others, message]
        self.refresh()

    def move_on(self) -> None:
        """Clear the last message after an edit. A message stays for at least UNREAD_MS."""
        unread_ms = UNREAD_MS - self._since.elapsed()
        if unread_ms <= 0:
            self._last = None
        elif self._last is not None:
            self._linger.start(unread_ms)
        self.refresh()

    @property
    def shown(self) -> Message | None:
        """The visible message, or None."""
        return self._shown

    def dismiss(self) -> bool:
        """Dismiss the visible message, as the close button does; return whether one was visible."""
        if self._shown is None:
            return False
        self._take(self.dismissed.emit)
        return True

    def clear(self) -> None:
        """Clear the message about the last action."""
        self._last = None
        self.refresh()

    def refresh(self) -> None:
        """Drop messages that no longer apply, and show the current message."""
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
        """Return the size with as few lines of text as possible, at most `width_px` wide."""
        lines = self.text.text().splitlines()
        text_px = max(map(self.fontMetrics().horizontalAdvance, lines), default=0)
        buttons_px = sum(button.sizeHint().width() + 2 * GRID_PX for button in self.buttons)
        wanted_px = text_px + buttons_px + 8 * GRID_PX
        width_px = min(width_px, _WIDEST_PX, wanted_px)
        self._row.activate()
        return QSize(width_px, self.heightForWidth(width_px))

    def _fade(self) -> None:
        if self.underMouse() or any(button.hasFocus() for button in self.buttons):
            self._linger.start(LINGER_MS)
        else:
            self.clear()

    def _fill(self, message: Message) -> None:
        self.text.setText(message.text)
        first, *rest = _SENTENCE.split(message.text, maxsplit=1)
        if rest and self.fontMetrics().horizontalAdvance(message.text) > _MOST_LINES * _WIDEST_PX:
            self.text.setText(first)
            self._add(tr("Details"), self._show_details)
        self.setProperty("bar", "wrong" if message.wrong else "hint")
        self.style().polish(self)
        self.setAccessibleDescription(message.text)
        for step in message.steps:
            self._add(step.text, partial(self._take, step.act))
        self._add(tr("Dismiss"), partial(self._take, self.dismissed.emit))
        self.buttons[-1].setToolTip(tr("Close this message (Escape)"))
        self._since.start()
        if not message.wrong and not message.steps and message.applies is None:
            self._linger.start(LINGER_MS)
        self.show()
        self.raise_()
        self.appeared.emit()

    def _show_details(self) -> None:
        """Show all of a long message."""
        self.buttons[1].setFocus()
        self.buttons[0].hide()
        self.text.setText(self.accessibleDescription())
        self.appeared.emit()

    def _empty(self) -> None:
        if any(button.hasFocus() for button in self.buttons):
            self.left.emit()
        self._linger.stop()
        self.hide()
        for button in self.buttons:
            self._row.removeWidget(button)
            button.hide()
            button.deleteLater()
        self.buttons = []

    def _add(self, text: str, act: Callable[[], object]) -> None:
        button = QPushButton(text)
        button.clicked.connect(lambda: act())
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
        """Show a hint for the selected tool, if the tool has changed."""
        if text != self._tool:
            self._tool = text
            self.hint("")

    def hint(self, text: str) -> None:
        """Show an activity; an empty text shows the tool's hint again."""
        self._told = False
        self._lasting = text or self._tool
        self._hint.setText(self._lasting)

    def tell(self, text: str) -> None:
        """Show a completed action, until the next edit."""
        self.hint(text)
        self._told = True

    def move_on(self) -> None:
        """Clear the last completed action after an edit."""
        if self._told:
            self.hint("")

    def name_point(self, text: str) -> None:
        """Show the name of a point; an empty name shows the hint again."""
        self._hint.setText(text or self._lasting)

    @property
    def hint_text(self) -> str:
        return self._hint.text()

    def show_cursor(self, cursor: tuple[float, float] | None) -> None:
        """Show the pixel position of the cursor; None or negative values clear the text."""
        inside = cursor is not None and min(cursor) >= -0.5
        x, y = cursor or (0.0, 0.0)
        self._cursor.setText(tr("x {x:.0f}  y {y:.0f}", x=x, y=y) if inside else "")

    def show_photo(self, photo: Photo) -> None:
        """Show size, depth, colour space, changes on reading and limits of a copy.

        The drawing time is not known yet.
        """
        size = f"{photo.width} × {photo.height}"  # noqa: RUF001
        parts = [size] if photo.bits == 8 else [size, tr("{n}-bit", n=photo.bits)]
        colours = screen_colours(photo)
        if photo.icc_profile is not None:
            unusable = tr("colour profile can't be used")
            parts.append((colours.name or tr("colour profile")) if colours.usable else unusable)
        has_map = has_gain_map(photo)
        parts += _hdr(photo, has_map)
        along = (kinds.GAIN_MAP,) if has_map else ()
        lost = _copied_as(photo).not_kept(photo, photo.extras, along)
        notes = [*photo.notes, *filter(None, [lost])]
        if notes:
            parts.append(tr("notes: {n}", n=len(notes)))
        self._photo.setText(" · ".join(parts))
        self._photo.setToolTip("\n".join([*map(translated, notes), told_screen()]))
        self._speed.clear()

    def show_speed(self, took_ms: float) -> None:
        """Show the drawing time of the newest frame."""
        self._speed.setText(tr("drawn in {ms:.0f} ms", ms=took_ms))

    def show_times(self, shown: bool) -> None:
        self._speed.setVisible(shown)

    def show_zoom(self, zoom: float) -> None:
        """Show the zoom in %."""
        self._zoom.setText(f"{zoom * 100:.0f} %")


def _hdr(photo: Photo, has_map: bool) -> list[str]:
    """Return a text on what makes a photo HDR, and whether a copy keeps it."""
    if has_map:
        return [tr("HDR: the gain map stays")]
    if is_hdr(photo.icc_profile):
        stays = _copied_as(photo).holds_hdr
        return [tr("HDR: PQ or HLG stays") if stays else tr("HDR: tone-mapped in a copy")]
    is_above = photo.pixels.dtype.kind == "f" and bool((photo.pixels > 1.0).any())
    return [tr("HDR: values above white stay")] if is_above else []


def _copied_as(photo: Photo) -> FileFormat:
    """Return the format of a copy: the photo's own if writable, else TIFF."""
    return next(
        (form for form in formats.WRITTEN if form.name == photo.format), formats.BY_NAME["TIFF"]
    )
