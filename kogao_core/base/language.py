"""The words of both programs in the user's language.

A `Text` is its finished English sentence, so files, logs and other programs read English
wherever it goes; it keeps the template and the values that it was made of, and whoever shows it to
people asks `translated` for it. Catalogues are GNU gettext's (`docs/extending.md`).
"""

from __future__ import annotations

import gettext
import importlib
import os
from collections.abc import Iterable, Iterator
from numbers import Number
from pathlib import Path
from typing import Any, Final

DOMAIN: Final = "kogao"
ENGLISH: Final = "en"
_VARIABLES: Final = ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")  # the first one set counts


class Text(str):
    """An English sentence that knows how to be said in another language."""

    __slots__ = ("many", "template", "values")
    template: str
    many: str
    values: dict[str, Any]

    def __new__(cls, template: str, /, **values: object) -> Text:
        """Make one."""
        return cls._made(template, "", values)

    @classmethod
    def counted(cls, count: int, one: str, many: str, /, **values: object) -> Text:
        """Make one that counts."""
        return cls._made(one, many, {"n": count, **values})

    @classmethod
    def joined(cls, between: str, messages: Iterable[str]) -> Text:
        """Return messages one after the other, something between two; empty ones are skipped."""
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
        """Return the message itself, so that an exception's text is still one."""
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """Go to another process whole."""
        return Text._made, (self.template, self.many, self.values)


def translated(what: object) -> str:
    """Return what something says of itself, in the language at work. Result: plain."""
    text = str(what)
    if not isinstance(text, Text):
        return text
    if text.many:
        said = _catalogue.ngettext(text.template, text.many, text.values["n"])
    else:
        said = _catalogue.gettext(text.template) if text.template else ""
    return said.format(**dict(_spoken(text.values))) if text.values else said


def tr(text: str, /, **values: object) -> str:
    """Return a literal in the language at work, with ``{name}`` fields filled in afterwards."""
    return translated(Text(text, **values)) if values else looked_up(text)


def tr_count(count: int, one: str, many: str, /, **values: object) -> str:
    """Return a sentence that counts, ``{n}`` and all, in the language at work."""
    return translated(Text.counted(count, one, many, **values))


def looked_up(text: str, /) -> str:
    """Return what the language at work has for a text that isn't ours, such as a library's."""
    return _catalogue.gettext(text) if text else text


def in_context(context: str, text: str, /) -> str:
    """Return a text that alone could mean several things, in the language at work."""
    return _catalogue.pgettext(context, text)


def languages() -> tuple[str, ...]:
    """Return the languages there are, English first, by their codes, such as ``ja``."""
    folder = _folder()
    found = () if folder is None else folder.glob(f"*/LC_MESSAGES/{DOMAIN}.mo")
    return (ENGLISH, *sorted(path.parts[-3] for path in found))


def language() -> str:
    """Return the code of the language at work."""
    return _code


def system_languages() -> tuple[str, ...]:
    """Return what the environment asks for, best first, after gettext's rules; nothing if unset."""
    said = next(filter(None, map(os.environ.get, _VARIABLES)), "")
    return tuple(filter(None, said.split(":")))


def use_language(*wanted: str) -> str:
    """Let everything be said in a language from here on, by this process and those it starts.

    Result: the code of the first one that there is; English if none is.
    """
    for code in wanted:
        name = code.replace("-", "_")
        if name.partition(".")[0] in ("C", "POSIX") or name.partition("_")[0] == ENGLISH:
            break
        folder = _folder()
        found = None if folder is None else gettext.find(DOMAIN, str(folder), [name])
        if found is not None:
            place = Path(str(found))
            with place.open("rb") as file:
                use_catalogue(place.parts[-3], gettext.GNUTranslations(file))
            # Here click and argparse look for their own words.
            gettext.bindtextdomain(DOMAIN, str(folder))
            gettext.textdomain(DOMAIN)
            os.environ["LANGUAGE"] = _code
            return _code
    use_catalogue(ENGLISH, gettext.NullTranslations())
    gettext.textdomain("messages")
    return _code


def use_catalogue(code: str, catalogue: gettext.NullTranslations) -> None:
    """Let a catalogue have the word from here on, wherever it comes from."""
    global _code, _catalogue
    _code, _catalogue = code, catalogue


def _folder() -> Path | None:
    try:
        resources = importlib.import_module("kogao_resources")
    except ModuleNotFoundError:
        return None
    return Path(resources.__path__[0], "translations")


def _spoken(values: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    point = in_context("decimal point", ".")
    for name, value in values.items():
        if isinstance(value, Text):
            yield name, translated(value)
        elif isinstance(value, float) and point != ".":
            yield name, _Float(value, point)
        else:
            yield name, value


class _Float(float):
    """A number that is written with a language's own decimal point."""

    def __new__(cls, value: float, point: str) -> _Float:
        made = super().__new__(cls, value)
        made.point = point
        return made

    point: str

    def __format__(self, form: str) -> str:
        return super().__format__(form).replace(".", self.point)


_code, _catalogue = ENGLISH, gettext.NullTranslations()
