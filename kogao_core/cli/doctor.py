"""``kogao-cli doctor``: check the installation and print the commands that repair it."""

from __future__ import annotations

import hashlib
import os
import platform
import sys
from collections.abc import Iterator
from importlib import import_module, metadata
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any, Final

import kogao_core
from kogao_core.base import assets, installed
from kogao_core.base.language import Text, tr, translated
from kogao_core.cli import common, ending
from kogao_core.cli.licences import DEPENDENCIES, manifest

OK: Final = Text("ok")
_CONFLICTING: Final = ("opencv-python", "opencv-contrib-python", "opencv-python-headless")
# Missing extras are no fault: most photos need none.
_EXTRAS: Final = {
    "cluster": "distributed",
    "heic": "pi-heif",
    "raw": "rawpy",
}
_IMPORTED: Final = {"numpy": "numpy", "opencv-contrib-python-headless": "cv2", "Pillow": "PIL"}
_FOUND: Final = {"PySide6-Essentials": "PySide6", "pyqtgraph": "pyqtgraph"}


def run(args: SimpleNamespace) -> int:
    """Print the findings."""
    common.check_report(args.json_file, args.force)
    findings = examine()
    common.deliver(lambda: findings, lambda: text(findings), args.json_file)
    return 0 if findings["ok"] else ending.BROKEN


def examine() -> dict[str, Any]:
    """Return versions, the state of each asset, missing libraries and repair commands."""
    packages = {name: _package(name) for name in DEPENDENCIES} | _conflicting()
    files = _assets()
    missing = installed.missing_libraries()
    repairs = list(_repairs(packages, files, missing))
    return {
        "ok": not repairs,
        "kogao": kogao_core.__version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": packages,
        "extras": {extra: _package(name)["version"] for extra, name in _EXTRAS.items()},
        "assets": files,
        "missing_libraries": missing,
        "mend": repairs,
    }


def incomplete() -> str:
    """Return a sentence with the faults and the repair command; "" for a complete installation."""
    findings = examine()
    states = {name: package["state"] for name, package in findings["packages"].items()}
    states |= dict.fromkeys(findings["missing_libraries"], Text("missing"))
    wrong = [f"{name} {translated(state)}" for name, state in states.items() if state != OK]
    if not wrong:
        return ""
    return tr(
        "the installation is incomplete ({problems}); repair it: {command}",
        problems=", ".join(wrong),
        command=" && ".join(map(translated, findings["mend"])),
    )


def _package(name: str) -> dict[str, str]:
    try:
        version = metadata.version(name)
    except metadata.PackageNotFoundError:
        return {"version": "", "state": Text("not installed")}
    return {"version": version, "state": _import_state(name)}


def _conflicting() -> dict[str, dict[str, str]]:
    state = Text("conflict: uses the same folder as opencv-contrib-python-headless")
    found = {name: _package(name)["version"] for name in _CONFLICTING}
    return {
        name: {"version": version, "state": state} for name, version in found.items() if version
    }


def _import_state(name: str) -> str:
    try:
        if name in _IMPORTED:
            import_module(_IMPORTED[name])
        elif name in _FOUND and find_spec(_FOUND[name]) is None:  # don't load Qt
            return Text("not installed")
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
    return OK if is_ours else Text("differs from the original file")


def _repairs(
    packages: dict[str, dict[str, str]], files: dict[str, str], missing: dict[str, str]
) -> Iterator[str]:
    conflicting = [name for name in _CONFLICTING if packages.get(name)]
    if conflicting:
        yield installed.without(conflicting)
    wrong_package = conflicting or any(package["state"] != OK for package in packages.values())
    wrong_file = any(state != OK for state in files.values())
    if installed.is_bundle() and (wrong_package or wrong_file):
        yield Text("unpack the bundle again")
    elif wrong_package:
        yield installed.again()
    elif wrong_file:
        yield installed.again("--no-deps")
    if missing:
        is_root = sys.platform == "linux" and os.geteuid() == 0
        sudo = "" if is_root else "sudo "
        yield f"{sudo}apt-get install {' '.join(sorted(set(missing.values())))}"


def text(findings: dict[str, Any]) -> str:
    """Return the findings of `examine` as text."""
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
    lines += [tr("Repair: {command}", command=command) for command in findings["mend"]]
    return "\n".join(lines if findings["mend"] else [*lines, tr("No problems found.")])
