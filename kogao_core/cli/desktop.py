"""Menu entry, icon and file type in a user's folder: desktops ignore virtual environments."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Final

from kogao_core.base import assets
from kogao_core.base.atomic import atomic_write

NAME: Final = "org.kogao.Kogao"
# Files and their folders in ~/.local/share or /usr/share.
PLACES: Final = {
    f"{NAME}.desktop": "applications",
    f"{NAME}.metainfo.xml": "metainfo",
    f"{NAME}.svg": "icons/hicolor/scalable/apps",
    f"{NAME}.xml": "mime/packages",
}
# Programs that rebuild the caches of these folders; a desktop without them needs no cache.
_INDEXERS: Final = {"update-mime-database": "mime", "update-desktop-database": "applications"}
_PROGRAM: Final = re.compile(r"^Exec=kogao\b", re.MULTILINE)
_PHOTO_TYPES: Final = re.compile(r"image/[^;]+;")


def install(share: Path, program: Path) -> None:
    """Write the files below `share`, such as ``~/.local/share``; the menu starts `program`.

    Raises AssetMissing or OSError.
    """
    for name, folder in PLACES.items():
        text = assets.path(f"desktop/{name}").read_text(encoding="utf-8")
        if name.endswith(".desktop"):
            text = f"Exec={_quoted(program)}".join(_PROGRAM.split(text))
            # A user's entry comes before those of the system: with types of photos, Kogao would
            # become the default program for photos.
            text = _PHOTO_TYPES.sub("", text)
        (share / folder).mkdir(parents=True, exist_ok=True)
        atomic_write(text.encode(), share / folder / name)
    _index(share)


def remove(share: Path) -> bool:
    """Delete the files that `install` wrote. Return whether there were any."""
    found = [path for path in (share / d / name for name, d in PLACES.items()) if path.exists()]
    for path in found:
        path.unlink()
    _index(share)
    return bool(found)


def _quoted(program: Path) -> str:
    r"""Quote a path for a desktop entry: first as an argument, then as a string value."""
    inner = re.sub(r'(["`$\\])', r"\\\1", str(program)).replace("%", "%%")
    return '"' + inner.replace("\\", "\\\\") + '"'


def _index(share: Path) -> None:
    for indexer, folder in _INDEXERS.items():
        found = shutil.which(indexer)
        if found and (share / folder).is_dir():
            subprocess.run([found, share / folder], capture_output=True, check=False)


def data_home() -> Path:
    """Return the folder in which a desktop looks for a user's entries."""
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local/share")
