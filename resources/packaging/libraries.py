"""Dependencies of the libraries in a bundle, read with readelf of binutils."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Final

_C: Final = r"(ld-linux-[\w-]+|lib(c|dl|gcc_s|m|pthread|rt|stdc\+\+|util))\.so\.\d+"
# The system's versions of these libraries fit its drivers, fonts and services.
_DESKTOP: Final = (
    r"lib(EGL|GL|X11|X11-xcb|dbus-1|fontconfig|freetype|glib-2\.0|gthread-2\.0|wayland-\w+|xcb)"
    r"\.so\.\d+"
)
_OF_THE_SYSTEM: Final = re.compile(f"{_C}|{_DESKTOP}")


def libraries(folder: Path) -> Iterator[Path]:
    """Yield every ELF file below a folder, without links."""
    for file in sorted(folder.rglob("*")):
        if file.is_file() and not file.is_symlink():
            with file.open("rb") as stream:
                if stream.read(4) == b"\x7fELF":
                    yield file


def needed(library: Path) -> set[str]:
    """Return the names of the libraries that the loader loads for a library."""
    return set(re.findall(r"\(NEEDED\).*\[(.*)\]", _readelf("--dynamic", library)))


def undefined_symbols(library: Path) -> dict[str, str]:
    """Return the undefined symbols of a library, with versions ("" for none)."""
    names = (row[7] for row in _symbols(library) if row[6] == "UND")
    return {name: version for name, _, version in (one.partition("@") for one in names)}


def exported_symbols(library: Path) -> set[str]:
    """Return the names of the exported functions and data of a library."""
    return {
        row[7].partition("@")[0]
        for row in _symbols(library)
        if row[6] != "UND" and row[3] in ("FUNC", "IFUNC", "OBJECT")
    }


def can_be_mapped(library: Path) -> bool:
    """Return True if each segment has the same offset in its page in the file and in memory."""
    segments = re.findall(r"^ +LOAD +(\w+) +(\w+)", _readelf("--segments", library), re.MULTILINE)
    return all((int(offset, 16) - int(address, 16)) % 4096 == 0 for offset, address in segments)


def leave_to_the_system(folder: Path) -> None:
    """Delete the system's libraries from a folder, then libraries that are no longer needed."""
    brought = [file for file in folder.glob("lib*.so.*") if not file.is_symlink()]
    dropped = [file for file in brought if _OF_THE_SYSTEM.fullmatch(file.name)]
    while dropped:
        for file in dropped:
            file.unlink()
            brought.remove(file)
        asked = set[str]().union(*map(needed, libraries(folder)))
        # PyInstaller's boot loader opens Python's library by name.
        keep = {file for file in brought if file.name in asked or "libpython" in file.name}
        dropped = [file for file in brought if file not in keep]


def missing(folder: Path) -> dict[str, list[str]]:
    """Return missing libraries: for each name, the files below the folder that need it."""
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
    """Run a program and return its output."""
    done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, text=True, check=True)
    return done.stdout
