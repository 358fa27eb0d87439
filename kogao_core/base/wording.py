"""Values and sentences as messages show them: short, on one line, no orders to a terminal."""

from __future__ import annotations

import reprlib
import unicodedata
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
_END: Final = 200  # letters of a long sentence that stay behind the gap: they say what to do


def shown(value: object) -> str:
    """Return a value as Python writes it, at most 40 letters: somebody else may have written it."""
    # Nothing that is cut anyway is written out, whatever its size and depth.
    text = repr(value) if isinstance(value, int | float) else _SHORT.repr(value)
    return text if len(text) <= _LONGEST_VALUE else f"{text[:_LONGEST_VALUE]}…"


def system_reason(error: OSError) -> str:
    """Return why the system refuses something; the usual reasons can be said in any language."""
    said = error.strerror or str(error)
    return _REASONS.get(said, said)


def sentence(text: str) -> str:
    """Return a message as one line: what can't be printed becomes '?', a long middle a gap.

    Names of files may hold anything, orders to the terminal too, and thousands of letters.
    """
    if len(text) > _LONGEST_SENTENCE:
        text = f"{text[: _LONGEST_SENTENCE - _END]} … {text[-_END:]}"
    return printable(text)


def printable(text: str) -> str:
    """Return a line with '?' for whatever a terminal doesn't print but may obey.

    Python takes spaces of other widths, as in names of macOS and in Japanese, for unprintable.
    """
    return "".join(
        letter if letter.isprintable() or unicodedata.category(letter) == "Zs" else "?"
        for letter in text
    )


def columns(text: str) -> int:
    """Return how wide a text is in a terminal: Chinese and Japanese letters are as wide as two."""
    return len(text) + sum(unicodedata.east_asian_width(letter) in "WF" for letter in text)


_SHORT: Final = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 3 * _LONGEST_VALUE  # its gaps lie behind ours
