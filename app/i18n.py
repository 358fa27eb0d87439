"""Visible text passes through here, so that a translation can take its place."""

from __future__ import annotations

from PySide6.QtCore import QCoreApplication


def tr(text: str, **values: object) -> str:
    """Return `text` in the user's language, with ``{name}`` fields filled in afterwards."""
    translated = QCoreApplication.translate("kogao", text)
    return translated.format(**values) if values else translated


def reason(problem: Exception) -> str:
    """Return what an exception says of itself; some say nothing but their name."""
    if isinstance(problem, MemoryError):
        return tr("there is not enough memory; close other programs or take a smaller photo")
    return str(problem) or type(problem).__name__


def sentence(problem: Exception | str) -> str:
    """Return a message with its own capital and full stop."""
    text = problem if isinstance(problem, str) else reason(problem)
    end = "" if text.endswith((".", "!", "?")) else "."
    return text[0].upper() + text[1:] + end
