"""Translation of visible text."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

from PySide6.QtCore import QCoreApplication, QLibraryInfo, QLocale, QTranslator

from kogao_core.base.language import (
    ENGLISH,
    in_context,
    language,
    languages,
    system_languages,
    tr,
    tr_count,
    translated,
    use_language,
)
from kogao_core.base.wording import system_reason

_LETTER: Final = re.compile(r"\(&\w\)")
_QT: Final = "qtbase"  # texts of Qt: buttons of dialogs, menus of text fields


def speak(app: QCoreApplication, asked: str) -> None:
    """Set the language of all texts, including Qt's texts, numbers and dates."""
    system = QLocale.system()
    if asked:
        use_language(asked)
    else:
        # Some systems don't set the language in the environment.
        use_language(*(system_languages() or system.uiLanguages()))
    code = language()
    if asked and QLocale(code).language() != system.language():
        QLocale.setDefault(QLocale(code))
    if code != ENGLISH:
        words = QTranslator(app)
        if words.load(
            QLocale(code), _QT, "_", QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath)
        ):
            app.installTranslator(words)


def bare(text: str) -> str:
    """Return a text without mnemonic: the ``&`` or ``(&X)`` at the end."""
    return _LETTER.sub("", text).replace("&", "")


def lettered(text: str, letter: str) -> str:
    """Return a text with a mnemonic: ``&`` before the letter, or ``(&X)`` at the end."""
    if letter in text:
        return text.replace(letter, f"&{letter}", 1)
    return f"{text}(&{letter.upper()})"


def language_names() -> dict[str, str]:
    """Return the native name of each available language, by code."""
    named = {code: QLocale(code).nativeLanguageName() for code in languages()}
    return {**named, ENGLISH: "English"}


def reason(problem: Exception) -> str:
    """Return the message of an exception, or the class name for an empty message."""
    if isinstance(problem, MemoryError):
        return tr("there is not enough memory; close other programs or take a smaller photo")
    said = system_reason(problem) if isinstance(problem, OSError) else translated(problem)
    return said or type(problem).__name__


def sentence(problem: Exception | str) -> str:
    """Return a message in the user's language, capitalised and with a full stop."""
    text = reason(problem) if isinstance(problem, Exception) else translated(problem)
    stop = in_context("end of a sentence", ".")
    end = "" if text.endswith((".", "!", "?", stop)) else stop
    return text[0].upper() + text[1:] + end


def unwritten(path: str | Path, problem: OSError) -> str:
    """Return a message with path and reason for a failed write."""
    return tr("{path} can't be written ({reason}).", path=path, reason=system_reason(problem))
