"""``kogao-cli doctor``: what this installation lacks, and the one command that mends it."""

from __future__ import annotations

import ctypes
import hashlib
import platform
import sys
from collections.abc import Iterator
from importlib import import_module, metadata
from pathlib import Path
from typing import Any, Final

import click

import kogao_core
from kogao_core.base import assets, installed
from kogao_core.base.language import Text, tr, translated
from kogao_core.cli import common, ending, words
from kogao_core.cli import json_file as to_json
from kogao_core.cli.licences import DEPENDENCIES, manifest

OK: Final = Text("ok")
# What Qt 6's xcb and offscreen plugins, QtGui and QtWidgets of the PySide6 wheel load from the
# system, by Debian package; a test derives it from the installed wheel.
LIBRARIES: Final = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libX11-xcb.so.1": "libx11-xcb1",
    "libX11.so.6": "libx11-6",
    "libdbus-1.so.3": "libdbus-1-3",
    "libfontconfig.so.1": "libfontconfig1",
    "libfreetype.so.6": "libfreetype6",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libgthread-2.0.so.0": "libglib2.0-0",
    "libxcb-cursor.so.0": "libxcb-cursor0",
    "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-image.so.0": "libxcb-image0",
    "libxcb-keysyms.so.1": "libxcb-keysyms1",
    "libxcb-randr.so.0": "libxcb-randr0",
    "libxcb-render-util.so.0": "libxcb-render-util0",
    "libxcb-render.so.0": "libxcb-render0",
    "libxcb-shape.so.0": "libxcb-shape0",
    "libxcb-shm.so.0": "libxcb-shm0",
    "libxcb-sync.so.1": "libxcb-sync1",
    "libxcb-util.so.1": "libxcb-util1",
    "libxcb-xfixes.so.0": "libxcb-xfixes0",
    "libxcb-xkb.so.1": "libxcb-xkb1",
    "libxcb.so.1": "libxcb1",
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libz.so.1": "zlib1g",
    "libzstd.so.1": "libzstd1",
}
# Qt is never loaded here, so of these two only the version is looked up.
_QT: Final = ("pyqtgraph", "PySide6-Essentials")
_IN_THE_WAY: Final = ("opencv-python", "opencv-contrib-python", "opencv-python-headless")
# What is lacking here is nothing to mend: most photos need none of them.
_EXTRAS: Final = {
    "heic": "pi-heif",
    "raw": "rawpy",
    "credentials": "c2pa-python",
    "experiments": "scikit-image",
    "cluster": "distributed",
}
_IMPORTED: Final = {"numpy": "numpy", "opencv-contrib-python-headless": "cv2", "Pillow": "PIL"}


@words.command("doctor")
@to_json.writes_json
@common.forces
@click.pass_context
def command(context: click.Context, json_file: Path | None, force: bool) -> None:
    """Check versions, face networks and, on Linux, the libraries that Qt needs."""
    to_json.check(json_file, force)
    findings = examine()
    to_json.deliver(lambda: findings, lambda: text(findings), json_file)
    context.exit(0 if findings["ok"] else ending.BROKEN)


def examine() -> dict[str, Any]:
    """Return versions, the state of each asset, missing libraries and commands that mend."""
    packages = {name: _package(name) for name in DEPENDENCIES} | _in_the_way()
    files = _assets()
    missing = _missing_libraries() if sys.platform == "linux" else {}
    mend = list(_mend(packages, files, missing))
    return {
        "ok": not mend,
        "kogao": kogao_core.__version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": packages,
        "extras": {extra: _package(name)["version"] for extra, name in _EXTRAS.items()},
        "assets": files,
        "missing_libraries": missing,
        "mend": mend,
    }


def _package(name: str) -> dict[str, str]:
    try:
        version = metadata.version(name)
    except metadata.PackageNotFoundError:
        return {"version": "", "state": Text("not installed")}
    return {"version": version, "state": _import_state(_IMPORTED.get(name))}


def _in_the_way() -> dict[str, dict[str, str]]:
    state = Text("in the way: it shares its folder with opencv-contrib-python-headless")
    found = {name: _package(name)["version"] for name in _IN_THE_WAY}
    return {
        name: {"version": version, "state": state} for name, version in found.items() if version
    }


def _import_state(module: str | None) -> str:
    try:
        if module:
            import_module(module)
    except ImportError as error:  # such as a system library that OpenCV needs
        return Text("doesn't load: {error}", error=" ".join(str(error).split()))
    return OK


def _assets() -> dict[str, str]:
    try:
        assets.path("assets.json")
    except assets.AssetMissing as error:
        return {"assets.json": str(error)}
    return {entry["file"]: _asset(entry) for entry in manifest()}


def _asset(entry: dict[str, Any]) -> str:
    try:
        data = assets.path(f"models/{entry['file']}").read_bytes()
    except assets.AssetMissing:
        return Text("missing")
    is_ours = hashlib.sha256(data).hexdigest() == entry["sha256"]
    return OK if is_ours else Text("not the file it should be")


def _missing_libraries() -> dict[str, str]:
    return {name: package for name, package in LIBRARIES.items() if not _loads(name)}


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def _mend(
    packages: dict[str, dict[str, str]], files: dict[str, str], missing: dict[str, str]
) -> Iterator[str]:
    in_the_way = [name for name in _IN_THE_WAY if packages.get(name)]
    if in_the_way:
        yield f"pip uninstall {' '.join(in_the_way)}"
    wrong_package = in_the_way or any(package["state"] != OK for package in packages.values())
    wrong_file = any(state != OK for state in files.values())
    if installed.is_bundle() and (wrong_package or wrong_file):
        yield Text("unpack the bundle anew")
    elif wrong_package:
        yield "pip install --force-reinstall kogao"
    elif wrong_file:
        yield "pip install --force-reinstall --no-deps kogao"
    if missing:
        yield f"sudo apt-get install {' '.join(sorted(set(missing.values())))}"


def text(findings: dict[str, Any]) -> str:
    """Return what `examine` found, for people to read."""
    lines = [f"Kogao {findings['kogao']}, Python {findings['python']}, {findings['platform']}"]
    for name, package in findings["packages"].items():
        lines.append(f"  {name} {package['version']}: {translated(package['state'])}")
    for extra, version in findings["extras"].items():
        absent = tr("not installed ({how})", how=installed.adding(extra))
        lines.append(tr("  extra [{extra}]: {state}", extra=extra, state=version or absent))
    lines += [f"  {name}: {translated(state)}" for name, state in findings["assets"].items()]
    for library, package in findings["missing_libraries"].items():
        lines.append(
            tr(
                "  {library}: missing (Debian and Ubuntu: {package})",
                library=library,
                package=package,
            )
        )
    lines += [tr("To mend it: {command}", command=command) for command in findings["mend"]]
    return "\n".join(lines if findings["mend"] else [*lines, tr("All is well.")])
