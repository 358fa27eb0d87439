"""Make a folder that runs where no Python is: ``python3 -m resources.packaging.bundle dist``.

The wheel is installed into an environment of its own, together with what it uses; PyInstaller
gathers both programs from there into ``dist/kogao``. On Debian this needs python3-venv,
libpython3.11, binutils, gcc, libc6-dev and icu-devtools; licences of the system's libraries are
asked of dpkg. There the folder is made lighter, too, and refused where it outgrew its bound or
lacks a library.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import venv
from pathlib import Path
from typing import Final

from .libraries import leave_to_the_system, missing, run
from .lighter import lighten

HERE: Final = Path(__file__).resolve().parent
ROOT: Final = HERE.parents[1]
_PYINSTALLER: Final = "pyinstaller>=6.16,<7"
_EXTRAS: Final = "heic,raw"
_MOST_MB: Final = 256
# Qt plug-ins that the window doesn't use: it has no OpenGL, no network and no virtual keyboard.
# Delete these first: PyInstaller would collect their dependencies, such as GTK.
_UNUSED_PLUGINS: Final = (
    "egldeviceintegrations", "generic", "networkinformation", "platforms/*egl*", "platforms/*fb*",
    "platforms/*minimal*", "platforms/*vk*", "platforms/*vnc*", "platformthemes/*gtk*",
    "platforminputcontexts/*virtualkeyboard*", "imageformats/*pdf*", "tls",
    "wayland-graphics-integration-client", "xcbglintegrations",
)  # fmt: skip


def main() -> None:
    """Make a bundle in the folder of the command line."""
    (folder,) = map(Path, sys.argv[1:])
    with tempfile.TemporaryDirectory(prefix="kogao-bundle-") as work:
        made = bundle(folder.resolve(), Path(work))
    if sys.platform == "linux":
        refuse(made)
    print(f"{made}: {_size(made) / 1e6:.0f} MB")


def bundle(folder: Path, work: Path) -> Path:
    """Make the folder `kogao` with both programs and return its path."""
    venv.create(work / "venv", with_pip=True)
    linux = sys.platform == "linux"
    python = work / "venv" / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    run(python, "-m", "pip", "install", "--quiet", f"{ROOT}[{_EXTRAS}]", _PYINSTALLER)
    site = Path(run(python, "-c", "import sysconfig; print(sysconfig.get_path('platlib'))").strip())
    _drop_unused_plugins(site / "PySide6")
    if linux:
        lighten(site)
    run(python, "-m", "PyInstaller", "--noconfirm", "--log-level", "WARN",
        "--distpath", folder, "--workpath", work / "build", HERE / "kogao.spec")  # fmt: skip
    made = folder / "kogao"
    licences = made / "licences"
    licences.mkdir()
    shutil.copy(HERE / "licences.md", licences / "README.md")
    if linux:
        leave_to_the_system(made / "_internal")
        _add_licences_of_the_system(made, licences)
    return made


def refuse(made: Path) -> None:
    """Exit with an error if a bundle lacks a library or is too large."""
    if lacks := missing(made):
        asks = (f"{name}, for {', '.join(files)}" for name, files in sorted(lacks.items()))
        raise SystemExit(f"{made} lacks libraries:\n" + "\n".join(asks))
    if _size(made) > _MOST_MB * 1e6:
        files = sorted((file.lstat().st_size, file) for file in made.rglob("*") if file.is_file())
        largest = (f"{size / 1e6:.1f}  {file.relative_to(made)}" for size, file in files[:-21:-1])
        raise SystemExit(
            f"{made}: {_size(made) / 1e6:.0f} MB, more than {_MOST_MB}. The largest files, in MB:\n"
            + "\n".join(largest)
        )


def _size(folder: Path) -> int:
    return sum(file.lstat().st_size for file in folder.rglob("*") if not file.is_dir())


def _drop_unused_plugins(pyside: Path) -> None:
    for plugins in (pyside / "Qt" / "plugins", pyside / "plugins"):  # the second: Windows
        for pattern in _UNUSED_PLUGINS:
            for found in plugins.glob(pattern):
                shutil.rmtree(found) if found.is_dir() else found.unlink()


def _add_licences_of_the_system(made: Path, licences: Path) -> None:
    """Copy the licences of the Debian packages that own the collected libraries."""
    inside = made / "_internal"
    names = [file.name for file in inside.glob("*.so*") if not file.is_symlink()]
    libraries = [f"*/{name}" for name in names if ".cpython-" not in name]
    owners = run("dpkg-query", "-S", *libraries)
    for package in sorted({line.split(":")[0] for line in owners.splitlines()}):
        source = Path("/usr/share/doc", package, "copyright")
        if source.is_file():
            shutil.copy(source, licences / f"{package}.txt")
    for name in ("GPL-2", "GPL-3", "LGPL-2.1", "LGPL-3", "Apache-2.0", "MPL-2.0"):
        shutil.copy(Path("/usr/share/common-licenses", name), licences / f"{name}.txt")


if __name__ == "__main__":
    main()
