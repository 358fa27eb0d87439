"""Format values and sentences for messages: short, on one line, without control codes."""

from __future__ import annotations

import reprlib
import unicodedata
from datetime import UTC, datetime
from typing import Final

from kogao_core.base.language import Text

_REASONS: Final[dict[str, str]] = {
    reason: reason
    for reason in (
        Text("No such file or directory"),
        Text("Permission denied"),
        Text("Operation not permitted"),
        Text("No space left on device"),
        Text("Disk quota exceeded"),
        Text("Read-only file system"),
        Text("Is a directory"),
        Text("Not a directory"),
        Text("File exists"),
        Text("File name too long"),
        Text("File too large"),
        Text("Input/output error"),
        Text("Device or resource busy"),
        Text("Connection refused"),
        Text("Address already in use"),
    )
}
_LONGEST_VALUE: Final = 40
_LONGEST_SENTENCE: Final = 600
_END: Final = 200  # characters kept at the end of a long sentence, which says what to do


def shown(value: object) -> str:
    """Return the repr of an untrusted value, cut to 40 characters."""
    # reprlib doesn't format the parts that would be cut.
    text = repr(value) if isinstance(value, int | float) else _SHORT.repr(value)
    return text if len(text) <= _LONGEST_VALUE else f"{text[:_LONGEST_VALUE]}…"


def system_reason(error: OSError) -> str:
    """Return the reason of an OSError; the usual reasons can be translated."""
    said = error.strerror or str(error)
    return _REASONS.get(said, said)


def sentence(text: str) -> str:
    """Return a message as one safe line: '?' for unprintable characters, '…' for a long middle.

    File names may contain terminal control codes and thousands of characters.
    """
    if len(text) > _LONGEST_SENTENCE:
        text = f"{text[: _LONGEST_SENTENCE - _END]} … {text[-_END:]}"
    return printable(text)


def local_time(time_ns: int) -> datetime:
    """Return a time of the file system in the local time zone."""
    return datetime.fromtimestamp(time_ns / 1e9, UTC).astimezone()


def printable(text: str) -> str:
    """Replace unprintable characters, which may be terminal control codes, by '?'.

    Keeps all kinds of spaces: `str.isprintable` rejects the wide spaces of Japanese and macOS.
    """
    return "".join(
        letter if letter.isprintable() or unicodedata.category(letter) == "Zs" else "?"
        for letter in text
    )


def columns(text: str) -> int:
    """Return the width of a text in terminal columns; Chinese and Japanese letters take two."""
    return len(text) + sum(unicodedata.east_asian_width(letter) in "WF" for letter in text)


_SHORT: Final = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 3 * _LONGEST_VALUE  # `shown` cuts before these gaps
