"""Which program opens a type of files by default, and keeping it so when another one comes.

By the standard for ``mimeapps.list``: a default that nobody has named is the first program that is
found, and a program in the user's own folder is found before all of the system's.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from configparser import ConfigParser, Error
from pathlib import Path
from typing import Final

from kogao_core.base.atomic import put

_NAMED: Final = "Default Applications"
_ADDED: Final = "Added Associations"
_REMOVED: Final = "Removed Associations"
_CACHE: Final = "MIME Cache"
_LIST: Final = "mimeapps.list"


def file_for(share: Path) -> Path:
    """Return the file that names defaults before programs in a folder are looked for."""
    if share == data_home():
        return _home("XDG_CONFIG_HOME", ".config") / _LIST
    return share / "applications" / _LIST


def data_home() -> Path:
    """Return the folder in which a desktop looks for what one user has."""
    return _home("XDG_DATA_HOME", ".local/share")


def implied(kinds: list[str], newcomer: str) -> dict[str, str]:
    """Return the default of each type that has one which is nowhere named; `newcomer` is none."""
    places = list(_places())
    found = {}
    for kind in kinds:
        if any(_listed(lists, _NAMED, kind) for lists, _ in places):
            continue
        removed: set[str] = {newcomer}
        for lists, cache in places:
            there = [*_listed(lists, _ADDED, kind), *_listed([cache], _CACHE, kind)]
            first = next((name for name in there if name not in removed), None)
            if first is not None:
                found[kind] = first
                break
            removed.update(_listed(lists, _REMOVED, kind))
    return found


def name(defaults: Mapping[str, str], file: Path) -> None:
    """Name defaults in a file, in front of what stands there."""
    if not defaults:
        return
    lines = _lines(file)
    if f"[{_NAMED}]" not in lines:
        lines += [f"[{_NAMED}]"]
    at = lines.index(f"[{_NAMED}]") + 1
    lines[at:at] = [f"{kind}={program}" for kind, program in defaults.items()]
    _write(lines, file)


def forget(defaults: Mapping[str, str], file: Path) -> None:
    """Take defaults out of a file where they are still those that were named."""
    ours = {f"{kind}={program}{end}" for kind, program in defaults.items() for end in ("", ";")}
    lines = _lines(file)
    section, kept = "", []
    for line in lines:
        section = line if line.startswith("[") else section
        if section != f"[{_NAMED}]" or line not in ours:
            kept.append(line)
    if [line for line in kept if line] == [f"[{_NAMED}]"]:
        file.unlink()
    elif kept != lines:
        _write(kept, file)


def _home(variable: str, usual: str) -> Path:
    return Path(os.environ.get(variable) or Path.home() / usual)


def _folders(variable: str, usual: str) -> list[Path]:
    return [Path(one) for one in (os.environ.get(variable) or usual).split(":") if one]


def _places() -> Iterator[tuple[list[ConfigParser], ConfigParser]]:
    """Yield the lists of each folder that is looked into, in turn, and its cache of programs."""
    desktops = os.environ.get("XDG_CURRENT_DESKTOP", "").lower().split(":")
    lists = [*(f"{one}-{_LIST}" for one in desktops if one), _LIST]
    configured = [_home("XDG_CONFIG_HOME", ".config"), *_folders("XDG_CONFIG_DIRS", "/etc/xdg")]
    shared = [data_home(), *_folders("XDG_DATA_DIRS", "/usr/local/share:/usr/share")]
    for folder in [*configured, *(one / "applications" for one in shared)]:
        yield [_read(folder / one) for one in lists], _read(folder / "mimeinfo.cache")


def _read(file: Path) -> ConfigParser:
    parser = ConfigParser(delimiters="=", interpolation=None, strict=False)
    try:
        parser.read(file, encoding="utf-8")
    except (Error, ValueError):  # a damaged one names nothing
        return ConfigParser()
    return parser


def _listed(files: list[ConfigParser], section: str, kind: str) -> list[str]:
    texts = [file.get(section, kind, fallback="") for file in files]
    return [one for text in texts for one in text.split(";") if one]


def _lines(file: Path) -> list[str]:
    return file.read_text(encoding="utf-8").splitlines() if file.exists() else []


def _write(lines: list[str], file: Path) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    put("".join(f"{line}\n" for line in lines).encode(), file)
