"""What a bundle's libraries ask of each other and of the system, as binutils' readelf tells."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Final

_C: Final = r"(ld-linux-[\w-]+|lib(c|dl|gcc_s|m|pthread|rt|stdc\+\+|util))\.so\.\d+"
# A system's own fit its drivers, fonts and services better than older ones from a bundle.
_DESKTOP: Final = (
    r"lib(EGL|GL|X11|X11-xcb|dbus-1|fontconfig|freetype|glib-2\.0|gthread-2\.0|wayland-\w+|xcb)"
    r"\.so\.\d+"
)
_OF_THE_SYSTEM: Final = re.compile(f"{_C}|{_DESKTOP}")


def libraries(folder: Path) -> Iterator[Path]:
    """Yield every ELF file below a folder, but no links."""
    for file in sorted(folder.rglob("*")):
        if file.is_file() and not file.is_symlink():
            with file.open("rb") as stream:
                if stream.read(4) == b"\x7fELF":
                    yield file


def needed(library: Path) -> set[str]:
    """Return the names of the libraries that the loader brings along."""
    return set(re.findall(r"\(NEEDED\).*\[(.*)\]", _readelf("--dynamic", library)))


def asked_for(library: Path) -> dict[str, str]:
    """Return the symbols that a library takes from others, with their versions, some of them ""."""
    names = (row[7] for row in _symbols(library) if row[6] == "UND")
    return {name: version for name, _, version in (one.partition("@") for one in names)}


def offered(library: Path) -> set[str]:
    """Return the names of the functions and data that a library has for others."""
    return {
        row[7].partition("@")[0]
        for row in _symbols(library)
        if row[6] != "UND" and row[3] in ("FUNC", "IFUNC", "OBJECT")
    }


def can_be_mapped(library: Path) -> bool:
    """Tell whether each segment lies as far into a page of the file as into one of memory."""
    segments = re.findall(r"^ +LOAD +(\w+) +(\w+)", _readelf("--segments", library), re.MULTILINE)
    return all((int(offset, 16) - int(address, 16)) % 4096 == 0 for offset, address in segments)


def leave_to_the_system(folder: Path) -> None:
    """Delete a system's libraries from the top of a folder, and what nothing needs after that."""
    brought = [file for file in folder.glob("lib*.so.*") if not file.is_symlink()]
    dropped = [file for file in brought if _OF_THE_SYSTEM.fullmatch(file.name)]
    while dropped:
        for file in dropped:
            file.unlink()
            brought.remove(file)
        asked = set[str]().union(*map(needed, libraries(folder)))
        # PyInstaller's beginning opens Python's library by its name.
        keep = {file for file in brought if file.name in asked or "libpython" in file.name}
        dropped = [file for file in brought if file not in keep]


def missing(folder: Path) -> dict[str, list[str]]:
    """Return what libraries below a folder need and neither it nor a system has.

    Result: for each name the files that need it, relative to the folder.
    """
    here = {file.name for file in folder.rglob("*")}
    lacks: dict[str, list[str]] = {}
    for file in libraries(folder):
        for name in needed(file) - here:
            if not _OF_THE_SYSTEM.fullmatch(name):
                lacks.setdefault(name, []).append(str(file.relative_to(folder)))
    return lacks


def _symbols(library: Path) -> list[list[str]]:
    rows = map(str.split, _readelf("--dyn-syms", library).splitlines())
    return [row for row in rows if len(row) >= 8 and row[0].endswith(":")]


def _readelf(what: str, library: Path) -> str:
    return run("readelf", "--wide", what, library)


def run(*command: Path | str) -> str:
    """Run a program and return what it prints."""
    done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, text=True, check=True)
    return done.stdout
