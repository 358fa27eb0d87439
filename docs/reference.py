"""Write `docs/api.md` from the docstrings of the promised names.

``python docs/reference.py`` after a docstring has changed; a test compares the two.
"""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import kogao_core as kogao

PAGE: Final = Path(__file__).with_name("api.md")
_HEAD: Final = """# API reference

Made by `python docs/reference.py` from the docstrings. [python.md](python.md) shows the names at
work. What isn't on this page may change from one version to the next.
"""
_MOST: Final = 8  # parameters of a class in its heading
_DOTS: Final = type("Dots", (), {"__repr__": lambda _: "..."})()  # a long default
_SECTION: Final = re.compile(r"^(\w[\w ]*)\n-+\n", re.MULTILINE)


def page() -> str:
    """Return the page."""
    return "\n".join([_HEAD, *(part for name in kogao.__all__ for part in _entry(name))])


def _entry(name: str) -> Iterator[str]:
    value = getattr(kogao, name)
    if not callable(value):
        notes = "The notes of `Recipe` list the choices that the paper leaves open."
        yield f"## `{name}`\n\n`{type(value).__name__}`: the paper's choices. {notes}\n"
        return
    yield f"## `{name}`\n"
    if signature := _signature(value):
        lines = textwrap.fill(name + signature, 96, subsequent_indent="    ")
        yield f"```text\n{lines}\n```\n"
    yield _text(value)
    if inspect.isclass(value) and not issubclass(value, Exception):
        for member, one in sorted(vars(value).items()):
            if member.startswith("_") or not inspect.getdoc(_bare(one)) or not _is_method(one):
                continue
            call = (
                ""
                if isinstance(one, property) or hasattr(one, "attrname")
                else _signature(_bare(one))
            )
            yield f"### `{name}.{member}{call}`\n"
            yield _text(_bare(one))


def _is_method(one: Any) -> bool:
    kinds = (property, staticmethod, classmethod)
    return isinstance(one, kinds) or inspect.isfunction(one) or hasattr(one, "attrname")


def _bare(one: Any) -> Any:
    if isinstance(one, property):
        return one.fget
    return getattr(one, "__func__", getattr(one, "func", one))


def _signature(value: Any) -> str:
    if inspect.isclass(value) and issubclass(value, Exception):
        return ""
    parameters = []
    for one in inspect.signature(value).parameters.values():
        is_plain = one.default in (None, (), "") or isinstance(one.default, (str, int, float))
        default = one.default if is_plain or one.default is one.empty else _DOTS
        parameters.append(one.replace(annotation=one.empty, default=default))
    parameters = [one for one in parameters if one.name != "self"]
    if inspect.isclass(value) and len(parameters) > _MOST:
        return "(...)"
    return str(inspect.Signature(parameters))


def _text(value: Any) -> str:
    """Return a numpydoc docstring as Markdown."""
    first, *rest = _SECTION.split(inspect.getdoc(value) or "")
    parts = [first.strip(), ""]
    for title, body in zip(rest[::2], rest[1::2], strict=True):
        if title == "Examples":
            parts += ["```pycon", body.strip(), "```", ""]
            continue
        parts += [f"**{title}**", ""]
        if title == "Notes":
            parts += [body.strip(), ""]
            continue
        for entry in re.split(r"\n(?=\S)", body.strip()):
            head, _, what = entry.partition("\n")
            line = f"- `{head}`: {' '.join(what.split())}".rstrip(": ")
            parts.append(textwrap.fill(line, 100, subsequent_indent="  ", break_on_hyphens=False))
        parts.append("")
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
