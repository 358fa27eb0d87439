"""Extract translatable texts, merge them into the catalogues and compile the catalogues.

``python -m resources.catalogues [LANGUAGE ...]``, run in the folder of ARCHITECTURE.md, updates
every catalogue in `resources/translations`, creates catalogues for the named languages and prints
the translated share. Babel is required (`pip install -e '.[dev]'`), as for building a wheel.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Final, NamedTuple

from babel.messages.catalog import Catalog
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po, write_po

ROOT: Final = Path(__file__).resolve().parents[1]
FOLDER: Final = ROOT / "resources" / "translations"
_DOMAIN: Final = "kogao"
_SOURCES: Final = ("app", "kogao_core")
_MACHINERY: Final = "kogao_core/base/language.py"  # not scanned: texts are passed as variables
_COMMENT: Final = "# Translators:"
_WIDTH: Final = 100
# Texts of click shown by the programs; looked up in this catalogue.
LIBRARIES: Final[dict[str, tuple[str | tuple[str, str], ...]]] = {
    "click": (
        "Usage:",
        "Options",
        "Commands",
        "required",
        "default: {default}",
        "Show this message and exit.",
        "Missing command.",
        "Missing argument",
        "Missing option",
        "No such option {name!r}.",
        "No such command {name!r}.",
        "Invalid value: {message}",
        "Invalid value for {param_hint}: {message}",
        "Option {name!r} does not take a value.",
        "{value!r} is not a valid {number_type}.",
        "{value} is not in the range {range}.",
        "{name} {filename!r} does not exist.",
        "{name} {filename!r} is a file.",
        "{name} {filename!r} is a directory.",
        "file",
        "directory",
        "path",
        ("Did you mean {possibility}?", "(Did you mean one of: {possibilities}?)"),
        ("{value!r} is not {choice}.", "{value!r} is not one of {choices}."),
        ("Option {name!r} requires an argument.", "Option {name!r} requires {nargs} arguments."),
        ("Got unexpected extra argument ({args})", "Got unexpected extra arguments ({args})"),
    ),
}
_CONTEXT: Final = "in_context"
# Which arguments of a call are texts: one text, singular and plural, or context and text.
_CALLS: Final = {
    **dict.fromkeys(("tr", "Text"), slice(1)),
    **dict.fromkeys(("tr_count", "counted"), slice(1, 3)),
    _CONTEXT: slice(2),
}
# Exceptions and functions whose first argument is a text, if it is a literal.
RAISED: Final = (
    *("AssetMissing", "BadFile", "BadValue", "BadXmp", "CannotDisclose", "CannotKeepBlocks"),
    *("CannotWrite", "ChangedSince", "ModelRefused", "NoOriginal", "NotRead", "NothingToDo"),
    *("OutOfBounds", "PhotoNotBeside", "RefusedFolder", "RefusedOutput", "UnreadablePhoto"),
    *("Stop", "bad_value", "refusing", "print_message", "_end"),
)
# Which arguments of these, and of the editor's actions, menus and form fields, are texts.
_ACTION: Final = {
    **dict.fromkeys(RAISED, slice(1)),
    "Item": slice(1, 4, 2),
    "Menu": slice(1),
    "FormField": slice(1, 3),
}
_OPTION: Final = "option"  # command-line options: the help is a text, too


class Words(NamedTuple):
    """A translatable text."""

    line: int  # line in the module
    texts: tuple[str, ...]  # one text, or singular and plural
    context: str | None  # meaning of an ambiguous text
    comment: str  # note to translators in the lines above: ``# Translators: ...``


class NotALiteral(ValueError):
    """A translatable text is not a literal, so the catalogues can't contain the text."""


def gathered() -> Catalog:
    """Return the texts of both programs, with their files or libraries."""
    catalog = Catalog(project="Kogao")
    for folder in _SOURCES:
        for path in sorted((ROOT / folder).rglob("*.py")):
            place = path.relative_to(ROOT).as_posix()
            if place == _MACHINERY:
                continue
            for found in words(path.read_text(encoding="utf-8"), place):
                catalog.add(
                    found.texts if len(found.texts) > 1 else found.texts[0],
                    locations=[(place, found.line)],
                    auto_comments=[found.comment] if found.comment else [],
                    flags=["python-brace-format"] if "{" in found.texts[0] else [],
                    context=found.context,
                )
    for library, said in LIBRARIES.items():
        for one in said:
            catalog.add(one, locations=[(library, 0)])
    return catalog


def words(source: str, place: str) -> Iterator[Words]:
    """Yield the texts of a module, including the docstrings of its commands.

    Raises NotALiteral.
    """
    lines = source.splitlines()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and _name(node.func) == _OPTION:
            said = [one.value for one in node.keywords if one.arg == "help"]
            literal = [one for one in said if not _is_marked(one)]
            yield from (Words(node.lineno, (_literal(one, place),), None, "") for one in literal)
        elif isinstance(node, ast.Call) and _name(node.func) in _CALLS:
            name = _name(node.func)
            texts = [_literal(one, place) for one in node.args[_CALLS[name]]]
            context = texts.pop(0) if name == _CONTEXT else None
            yield Words(node.lineno, tuple(texts), context, _comment(lines, node.lineno))
        elif isinstance(node, ast.Call) and (at := _ACTION.get(_name(node.func))):
            shown = [one.value for one in node.keywords if one.arg in ("unit", "lowest")]
            said = [one for one in (*node.args[at], *shown) if not _is_marked(one)]
            said = [one for one in said if not isinstance(one, ast.Constant) or one.value]
            yield from (Words(one.lineno, (_literal(one, place),), None, "") for one in said)
        elif isinstance(node, ast.FunctionDef) and _is_command(node):
            yield Words(node.lineno, (ast.get_docstring(node) or "",), None, "")


def merge(path: Path, template: Catalog) -> Catalog:
    """Update or create a catalogue and remove unused texts.

    Result: the written catalogue.
    """
    catalog = read(path) if path.exists() else _begun(path.stem)
    began = catalog.creation_date
    # No fuzzy matching: each guess would have to be found and corrected.
    catalog.update(template, no_fuzzy_matching=True)
    catalog.obsolete.clear()
    catalog.creation_date = began
    with path.open("wb") as file:
        _write(file, catalog)
    return catalog


def read(path: Path) -> Catalog:
    """Return a catalogue."""
    with path.open("rb") as file:
        return read_po(file, locale=path.stem, abort_invalid=True)


def compile_all(folder: Path = FOLDER) -> list[Path]:
    """Compile every catalogue to the programs' folder; return the files."""
    made = []
    for path in sorted(folder.glob("*.po")):
        target = folder / path.stem / "LC_MESSAGES" / f"{_DOMAIN}.mo"
        target.parent.mkdir(parents=True, exist_ok=True)
        with target.open("wb") as file:
            write_mo(file, read(path))
        made.append(target)
    return made


def _begun(language: str) -> Catalog:
    head = "# The words of Kogao; docs/extending.md says how to translate them."
    return Catalog(language, project="Kogao", version="0.1", header_comment=head, fuzzy=False)


def _write(file: IO[bytes], catalog: Catalog) -> None:
    # Omit line numbers, which change often and cause merge conflicts.
    write_po(file, catalog, width=_WIDTH, include_lineno=False, sort_by_file=True)


def _name(function: ast.expr) -> str:
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""


def _is_marked(node: ast.expr) -> bool:
    """Return True if the texts are marked as translatable elsewhere."""
    if isinstance(node, ast.Call):
        return _name(node.func) != "format"
    return isinstance(node, ast.Name | ast.Attribute | ast.Subscript | ast.Lambda)


def _literal(node: ast.expr, place: str) -> str:
    if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value:
        return node.value
    raise NotALiteral(f"{place}:{node.lineno}: words must be a literal, with {{name}} fields")


def _comment(lines: list[str], line: int) -> str:
    above: list[str] = []
    for text in reversed(lines[: line - 1]):
        if not text.strip().startswith("#"):
            return ""
        above.insert(0, text.strip().removeprefix(_COMMENT).strip("# "))
        if text.strip().startswith(_COMMENT):
            return " ".join(above)
    return ""


def _is_command(node: ast.FunctionDef) -> bool:
    calls = [one.func for one in node.decorator_list if isinstance(one, ast.Call)]
    return any(_name(call) in ("command", "group") for call in calls)


def main(names: list[str]) -> None:
    """Update the catalogues and print the translated share of each."""
    template = gathered()
    paths = {*FOLDER.glob("*.po"), *(FOLDER / f"{name}.po" for name in names)}
    for path in sorted(paths):
        catalog = merge(path, template)
        done = sum(bool(one.string and all(one.string)) for one in catalog if one.id)
        print(f"{path.relative_to(ROOT)}: {done} of {len(catalog)} texts are translated")
    compile_all()


if __name__ == "__main__":
    main(sys.argv[1:])
