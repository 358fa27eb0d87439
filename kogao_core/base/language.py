"""Translate the texts of both programs into the user's language.

A `Text` is the finished English sentence, so that files, logs and other programs read English. The
object also keeps its template and values; `translated` formats them in the current language.
Catalogues are GNU gettext files (`docs/extending.md`).
"""

from __future__ import annotations

import gettext
import importlib
import os
from collections.abc import Iterable
from numbers import Number
from pathlib import Path
from typing import Any, Final

DOMAIN: Final = "kogao"
ENGLISH: Final = "en"
_VARIABLES: Final = ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")  # the first one set counts


class Text(str):
    """An English sentence that keeps its template and values for translation."""

    __slots__ = ("many", "template", "values")
    template: str
    many: str
    values: dict[str, Any]

    def __new__(cls, template: str, /, **values: object) -> Text:
        """Format `template` with `values`."""
        return cls._made(template, "", values)

    @classmethod
    def counted(cls, count: int, one: str, many: str, /, **values: object) -> Text:
        """Format the singular or plural template for `count`, which is also the field ``n``."""
        return cls._made(one, many, {"n": count, **values})

    @classmethod
    def joined(cls, between: str, messages: Iterable[str]) -> Text:
        """Join non-empty messages with `between`."""
        values = {f"part{i}": one for i, one in enumerate(filter(None, messages))}
        return cls._made(between.join(f"{{{name}}}" for name in values), "", values)

    @classmethod
    def _made(cls, template: str, many: str, values: dict[str, Any]) -> Text:
        filled = {k: v if isinstance(v, Number) else str(v) for k, v in values.items()}
        english = many if many and values["n"] != 1 else template
        made = str.__new__(cls, english.format(**filled) if filled else english)
        made.template, made.many, made.values = template, many, filled
        return made

    def __str__(self) -> str:
        """Return this `Text`, so that ``str(exception)`` can still be translated."""
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the template and the values, so that the receiver can translate."""
        return Text._made, (self.template, self.many, self.values)


class TextError(Exception):
    """An exception whose message is a `Text`: ``raise BadFile("{path} is empty", path=path)``."""

    def __init__(self, message: object, /, **values: object) -> None:
        super().__init__(as_text(message, **values))


class BadValue(TextError, ValueError):
    """A value of the wrong form or outside its range."""


def as_text(message: object, /, **values: object) -> Text:
    """Return a message with its values as a `Text`; a ready `Text` stays."""
    said = str(message)
    return said if isinstance(said, Text) else Text(said, **values)


def translated(message: object) -> str:
    """Return ``str(message)`` as plain text in the current language."""
    text = str(message)
    if not isinstance(text, Text):
        return text
    if text.many:
        said = _catalogue.ngettext(text.template, text.many, text.values["n"])
    else:
        said = _catalogue.gettext(text.template) if text.template else ""
    if not text.values:
        return said
    return said.format(
        **{k: translated(v) if isinstance(v, Text) else v for k, v in text.values.items()}
    )


def tr(text: str, /, **values: object) -> str:
    """Translate a literal, then fill in its ``{name}`` fields."""
    return translated(Text(text, **values)) if values else looked_up(text)


def tr_count(count: int, one: str, many: str, /, **values: object) -> str:
    """Translate the singular or plural literal for `count`, then fill in ``{n}`` and fields."""
    return translated(Text.counted(count, one, many, **values))


def looked_up(text: str, /) -> str:
    """Return the translation of a text that is no literal here, such as a library's message."""
    return _catalogue.gettext(text) if text else text


def in_context(context: str, text: str, /) -> str:
    """Translate a text that is ambiguous without a context."""
    return _catalogue.pgettext(context, text)


def languages() -> tuple[str, ...]:
    """Return the codes of all available languages, such as ``ja``; English first."""
    folder = _folder()
    found = () if folder is None else folder.glob(f"*/LC_MESSAGES/{DOMAIN}.mo")
    return (ENGLISH, *sorted(path.parts[-3] for path in found))


def language() -> str:
    """Return the code of the current language."""
    return _code


def system_languages() -> tuple[str, ...]:
    """Return the languages that the environment requests, best first, by gettext's rules."""
    said = next(filter(None, map(os.environ.get, _VARIABLES)), "")
    return tuple(filter(None, said.split(":")))


def use_language(*wanted: str) -> str:
    """Select the first available language, for this process and for processes it starts.

    Return the code of the selected language: English if none is available.
    """
    for code in wanted:
        name = code.replace("-", "_")
        if name.partition(".")[0] in ("C", "POSIX") or name.partition("_")[0] == ENGLISH:
            os.environ["LANGUAGE"] = ENGLISH
            break
        folder = _folder()
        found = None if folder is None else gettext.find(DOMAIN, str(folder), [name])
        if found is not None:
            place = Path(str(found))
            with place.open("rb") as file:
                use_catalogue(place.parts[-3], gettext.GNUTranslations(file))
            # click looks up its texts in this domain.
            gettext.bindtextdomain(DOMAIN, str(folder))
            gettext.textdomain(DOMAIN)
            os.environ["LANGUAGE"] = _code
            return _code
    use_catalogue(ENGLISH, gettext.NullTranslations())
    gettext.textdomain("messages")
    return _code


def use_catalogue(code: str, catalogue: gettext.NullTranslations) -> None:
    """Use a catalogue for all texts from now on."""
    global _code, _catalogue
    _code, _catalogue = code, catalogue


def _folder() -> Path | None:
    try:
        resources = importlib.import_module("kogao_resources")
    except ModuleNotFoundError:
        return None
    return Path(resources.__path__[0], "translations")


_code, _catalogue = ENGLISH, gettext.NullTranslations()
