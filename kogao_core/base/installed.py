"""Installation source, user data folder and missing system libraries."""

from __future__ import annotations

import ctypes
import json
import os
import shlex
import shutil
import socket
import sys
import sysconfig
from importlib.util import find_spec
from pathlib import Path
from typing import Final
from urllib.parse import unquote

from kogao_core.base.language import Text

# System libraries loaded by QtGui and QtWidgets of the PySide6 wheel, and by Qt's plugin for each
# platform. A test compares this list with the installed wheel.
_ALWAYS: Final = (
    *("libEGL.so.1", "libGL.so.1", "libX11.so.6", "libdbus-1.so.3", "libfontconfig.so.1"),
    *("libfreetype.so.6", "libglib-2.0.so.0", "libgthread-2.0.so.0", "libxkbcommon.so.0"),
    *("libz.so.1", "libzstd.so.1"),
)
LIBRARIES: Final = {
    "wayland": (*_ALWAYS, "libwayland-client.so.0", "libwayland-cursor.so.0"),
    "xcb": (
        *(*_ALWAYS, "libX11-xcb.so.1", "libxcb-cursor.so.0", "libxcb-icccm.so.4"),
        *("libxcb-image.so.0", "libxcb-keysyms.so.1", "libxcb-randr.so.0", "libxcb-render.so.0"),
        *("libxcb-render-util.so.0", "libxcb-shape.so.0", "libxcb-shm.so.0", "libxcb-sync.so.1"),
        *("libxcb-util.so.1", "libxcb-xfixes.so.0", "libxcb-xkb.so.1", "libxcb.so.1"),
        "libxkbcommon-x11.so.0",
    ),
}
# Debian packages with irregular names, by library.
_CALLED: Final = {
    "libglib-2.0.so.0": "libglib2.0-0",
    "libgthread-2.0.so.0": "libglib2.0-0",
    "libz.so.1": "zlib1g",
}


def missing_libraries() -> dict[str, str]:
    """Return Qt's missing system libraries, with the Debian package of each. Linux only.

    Qt takes Wayland where a compositor answers; X only if that fails.
    """
    if sys.platform != "linux":
        return {}
    missing = {
        platform: {name: _package(name) for name in names if not _loads(name)}
        for platform, names in LIBRARIES.items()
    }
    has_x = bool(os.environ.get("DISPLAY"))
    wayland = has_compositor() and (not missing["wayland"] or not has_x)
    return missing["wayland" if wayland else "xcb"]


def has_compositor() -> bool:
    """Return whether a Wayland compositor answers."""
    name = os.environ.get("WAYLAND_DISPLAY")
    if sys.platform == "win32" or not name:
        return False
    with socket.socket(socket.AF_UNIX) as asked:
        return asked.connect_ex(str(Path(os.environ.get("XDG_RUNTIME_DIR", "/"), name))) == 0


def _package(library: str) -> str:
    stem, _, version = library.lower().partition(".so.")
    between = "-" if stem[-1].isdigit() else ""
    return _CALLED.get(library, f"{stem}{between}{version}")


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def is_bundle() -> bool:
    """Return True if this is a bundle. Packages can't be installed into a bundle."""
    return bool(getattr(sys, "frozen", False))


def program(name: str) -> Path | None:
    """Return the path of ``kogao`` or ``kogao-cli``, or None if not installed.

    Search the folder of this installation first, then PATH.
    """
    ending = ".exe" if sys.platform == "win32" else ""
    folder = Path(sys.executable).parent if is_bundle() else Path(sysconfig.get_path("scripts"))
    beside = folder / (name + ending)
    found = beside if beside.is_file() else shutil.which(name)
    return None if found is None else Path(found).absolute()


def has_laboratory() -> bool:
    """Return True if the laboratory is installed. Experiments are hidden otherwise."""
    return find_spec("kogao_core.lab") is not None


def data_folder() -> Path:
    """Return the user's data folder for this program. All parts of the program ask here."""
    home = Path.home()
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = home / "Library" / "Application Support"
    else:
        named = Path(os.environ.get("XDG_DATA_HOME", ""))
        base = named if named.is_absolute() else home / ".local" / "share"
    return base / "kogao"


def adding(extra: str) -> str:
    """Return instructions for installing an extra, as the end of a sentence."""
    if is_bundle():
        return Text("not in this bundle; install Kogao with pip")
    what = _requirement(extra)
    return Text("install Kogao with [{extra}]", extra=extra) if what is None else _pip(*what)


def again(*options: str) -> str:
    """Return the command that reinstalls Kogao from the original source, or instructions."""
    what = _requirement()
    if what is None:  # never use an index: the name may belong to another package there
        return Text("install Kogao again from its original source")
    return _pip("--force-reinstall", *options, *what)


def without(packages: list[str]) -> str:
    """Return the command that uninstalls packages."""
    return _pip(*packages, does="uninstall")


def _pip(*words: str, does: str = "install") -> str:
    """Return a pip command for the running Python. Fall back to uv if pip is missing."""
    if find_spec("pip") is None and shutil.which("uv"):
        return shlex.join(["uv", "pip", does, "--python", sys.executable, *words])
    return shlex.join([sys.executable, "-m", "pip", does, *words])


def _requirement(extra: str = "") -> list[str] | None:
    """Return pip's arguments to install Kogao from the original source. None if unknown."""
    from importlib import metadata  # loads a lot

    try:
        told = metadata.distribution("kogao").read_text("direct_url.json")
        origin = json.loads(told or "")
        url = str(origin["url"])
    except (metadata.PackageNotFoundError, ValueError, KeyError):
        return None
    asked = f"[{extra}]" if extra else ""
    if url.startswith("file:"):
        # Of Windows: file:///C:/folder, file://server/folder.
        start = "///" if sys.platform == "win32" else "//"
        path = str(Path(unquote(url.removeprefix("file:")).removeprefix(start)))
        if not os.path.exists(path):
            return None
        return [*(["-e"] if origin.get("dir_info", {}).get("editable") else []), path + asked]
    version_control = origin.get("vcs_info")
    if version_control:
        url = f"{version_control['vcs']}+{url}@{version_control['commit_id']}"
    return [f"kogao{asked} @ {url}"]
