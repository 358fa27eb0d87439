"""A desktop is told of this very installation: menu, icon, types of files, what shops show.

The wheel lays the same files below its prefix; an environment of its own, pipx's or uv's say, and a
bundle are places where no desktop looks. Which program opens a type of files by default stays so:
by the standard for ``mimeapps.list`` a default that nobody has named is the first program that is
found, and a program in the user's own folder is found before all of the system's.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from configparser import ConfigParser, Error
from pathlib import Path
from typing import Final

from kogao_core.base import assets
from kogao_core.base.atomic import put

NAME: Final = "org.kogao.Kogao"
# Where each file lies, below the folder that desktops look into.
PLACES: Final = {
    f"{NAME}.desktop": "applications",
    f"{NAME}.metainfo.xml": "metainfo",
    f"{NAME}.svg": "icons/hicolor/scalable/apps",
    f"{NAME}.xml": "mime/packages",
}
# What makes desktops' indexes anew; one that isn't here isn't needed by a desktop that is.
_INDEXERS: Final = {"update-mime-database": "mime", "update-desktop-database": "applications"}
_STARTS: Final = re.compile(r"^Exec=kogao\b", re.MULTILINE)
_TYPES: Final = re.compile(r"^MimeType=(.*)\n", re.MULTILINE)
_ENTRY: Final = f"{NAME}.desktop"
_KEPT: Final = "X-Kogao-Kept"  # a key of our own, for the way back
# Of lists of defaults and of caches of programs.
_NAMED: Final = "Default Applications"
_ADDED: Final = "Added Associations"
_REMOVED: Final = "Removed Associations"
_CACHE: Final = "MIME Cache"
_LIST: Final = "mimeapps.list"


def install(share: Path, program: Path) -> None:
    """Lay all files in place, and have the indexes made anew; nobody's default changes.

    ``share`` is such as ``~/.local/share``, ``program`` what the menu starts. Raises AssetMissing
    if this installation lacks the files, OSError if they can't be written.
    """
    for name, folder in PLACES.items():
        text = assets.path(f"desktop/{name}").read_text(encoding="utf-8")
        if name.endswith(".desktop"):
            text = f"Exec={_quoted(program)}".join(_STARTS.split(text))
            text = _with_kept(text, share)
        (share / folder).mkdir(parents=True, exist_ok=True)
        put(text.encode(), share / folder / name)
    _index(share)


def _with_kept(entry: str, share: Path) -> str:
    """Name the defaults that our entry would come before, and note in it which those were."""
    types = _TYPES.search(entry)
    photos = [kind for kind in (types[1] if types else "").split(";") if kind.startswith("image/")]
    kept = _implied(photos, _ENTRY)
    _name(kept, _file_for(share))
    kept = _kept(share) | kept
    note = "".join(f"{kind}={program};" for kind, program in kept.items())
    return _TYPES.sub(lambda found: f"{found[0]}{_KEPT}={note}\n" if note else found[0], entry)


def _kept(share: Path) -> dict[str, str]:
    """Return the defaults that were named when we came."""
    entry = share / PLACES[_ENTRY] / _ENTRY
    text = entry.read_text(encoding="utf-8") if entry.exists() else ""
    note = re.search(f"^{_KEPT}=(.*)$", text, re.MULTILINE)
    pairs = (one.partition("=") for one in (note[1] if note else "").split(";") if one)
    return {kind: program for kind, _, program in pairs}


def remove(share: Path) -> None:
    """Take all files away, and have the indexes made anew."""
    _forget(_kept(share), _file_for(share))
    for name, folder in PLACES.items():
        (share / folder / name).unlink(missing_ok=True)
    _index(share)


def _quoted(program: Path) -> str:
    r"""Return a path as desktop entries quote it: for their commands, and once more as a text."""
    inner = re.sub(r'(["`$\\])', r"\\\1", str(program)).replace("%", "%%")
    return '"' + inner.replace("\\", "\\\\") + '"'


def _index(share: Path) -> None:
    for indexer, folder in _INDEXERS.items():
        found = shutil.which(indexer)
        if found and (share / folder).is_dir():
            subprocess.run([found, share / folder], capture_output=True, check=False)


def _file_for(share: Path) -> Path:
    """Return the file that names defaults before programs in a folder are looked for."""
    if share == data_home():
        return _home("XDG_CONFIG_HOME", ".config") / _LIST
    return share / "applications" / _LIST


def data_home() -> Path:
    """Return the folder in which a desktop looks for what one user has."""
    return _home("XDG_DATA_HOME", ".local/share")


def _implied(kinds: list[str], newcomer: str) -> dict[str, str]:
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


def _name(defaults: Mapping[str, str], file: Path) -> None:
    """Name defaults in a file, in front of what stands there."""
    if not defaults:
        return
    lines = _lines(file)
    if f"[{_NAMED}]" not in lines:
        lines += [f"[{_NAMED}]"]
    at = lines.index(f"[{_NAMED}]") + 1
    lines[at:at] = [f"{kind}={program}" for kind, program in defaults.items()]
    _write(lines, file)


def _forget(defaults: Mapping[str, str], file: Path) -> None:
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
