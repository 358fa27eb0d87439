"""Make the files of a release: ``python3 -m resources.packaging.release dist BUNDLE``.

BUNDLE is the folder that ``resources.packaging.bundle`` made. Result in ``dist``: wheel, sdist, the
bundle as ``.tar.zst`` and as a Debian package, an SBOM (CycloneDX) and SHA-256 sums. Needs tar,
zstd, dpkg-deb, and an environment with Kogao's extra [dev].
"""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
import tempfile
from importlib import metadata
from pathlib import Path
from typing import Any, Final

import kogao_core
from kogao_core.cli.desktop import PLACES
from kogao_core.cli.licences import DEPENDENCIES, OWN, manifest

ROOT: Final = Path(__file__).resolve().parents[2]
VERSION: Final = kogao_core.__version__
_CONTROL: Final = """Package: kogao
Version: {version}
Architecture: amd64
Maintainer: The Kogao founders <noreply@kogao.invalid>
Installed-Size: {kilobytes}
Depends: libc6 (>= 2.36), libdbus-1-3, libegl1, libfontconfig1, libgl1,
 libglib2.0-0 | libglib2.0-0t64, libx11-6, libx11-xcb1
Section: graphics
Priority: optional
Description: make the faces in a photo slightly smaller
 Kogao is an editor and a command line. It moves head, ears and hair together
 and leaves the rest of the photo as it was, byte for byte.
"""


def main() -> None:
    """Make all files of a release in one folder."""
    folder, bundle = (Path(argument).resolve() for argument in sys.argv[1:])
    folder.mkdir(parents=True, exist_ok=True)
    _run(sys.executable, "-m", "build", "--outdir", folder, ROOT)
    archive = folder / f"kogao-{VERSION}-linux-x86_64.tar.zst"
    _run("tar", "-I", "zstd -19 -T0", "-cf", archive, "-C", bundle.parent, bundle.name)
    make_debian_package(bundle, folder / f"kogao_{VERSION}_amd64.deb")
    (folder / f"kogao-{VERSION}.cdx.json").write_text(json.dumps(sbom(), indent=1) + "\n")
    write_sums(folder)


def make_debian_package(bundle: Path, package: Path) -> None:
    """Pack a bundle into /opt/kogao, with links in /usr/bin and the entries of the menus."""
    with tempfile.TemporaryDirectory() as work:
        tree = Path(work, "tree")
        shutil.copytree(bundle, tree / "opt/kogao", symlinks=True)
        (tree / "usr/bin").mkdir(parents=True)
        for program in ("kogao", "kogao-cli"):
            (tree / "usr/bin" / program).symlink_to(f"/opt/kogao/{program}")
        for name, place in PLACES.items():
            (tree / "usr/share" / place).mkdir(parents=True)
            shutil.copy(ROOT / "resources/desktop" / name, tree / "usr/share" / place)
        size = sum(file.lstat().st_size for file in tree.rglob("*") if not file.is_dir())
        (tree / "DEBIAN").mkdir()
        control = _CONTROL.format(version=VERSION, kilobytes=size // 1024)
        (tree / "DEBIAN/control").write_text(control, encoding="utf-8")
        _run("dpkg-deb", "--root-owner-group", "-Zxz", "--build", tree, package)


def sbom() -> dict[str, Any]:
    """Return the bill of materials: the program, its dependencies and its networks."""
    packages = [
        {
            "type": "library",
            "name": name,
            "version": metadata.version(name),
            "purl": f"pkg:pypi/{name.lower()}@{metadata.version(name)}",
            "licenses": [{"license": {"name": _licence(name)}}],
        }
        for name in (*DEPENDENCIES, "shiboken6")
    ]
    networks = [
        {
            "type": "machine-learning-model",
            "name": asset["file"],
            "description": asset["what"],
            "licenses": [{"license": {"name": asset["licence"]}}],
            "hashes": [{"alg": "SHA-256", "content": asset["sha256"]}],
        }
        for asset in manifest()
    ]
    program = {
        "type": "application",
        "name": "kogao",
        "version": VERSION,
        "licenses": [{"license": {"id": OWN}}],
    }
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": program},
        "components": packages + networks,
    }


def _licence(name: str) -> str:
    about = metadata.metadata(name)
    stated = [about.get_all(field) or [] for field in ("License-Expression", "License")]
    (first, *_) = [*stated[0], *stated[1], "see its package"]
    return str(first).strip().splitlines()[0]


def write_sums(folder: Path) -> None:
    """Write SHA256SUMS for every other file of a folder, as ``sha256sum --check`` reads it."""
    files = sorted(file for file in folder.iterdir() if file.name != "SHA256SUMS")
    lines = [f"{hashlib.sha256(file.read_bytes()).hexdigest()}  {file.name}\n" for file in files]
    (folder / "SHA256SUMS").write_text("".join(lines), encoding="utf-8")


def _run(*command: object) -> None:
    subprocess.run([str(word) for word in command], check=True)


if __name__ == "__main__":
    main()
