"""A desktop is told of this very installation: menu, icon, types of files, what shops show.

The wheel lays the same files below its prefix; an environment of its own, pipx's or uv's say, and a
bundle are places where no desktop looks.
"""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path
from typing import Final

NAME: Final = "org.kogao.Kogao"
# Where each file lies, below the folder that desktops look into.
PLACES: Final = {
    f"{NAME}.desktop": "applications",
    f"{NAME}.metainfo.xml": "metainfo",
    f"{NAME}.svg": "icons/hicolor/scalable/apps",
    f"{NAME}.xml": "mime/packages",
}
# What makes desktops' indexes anew; one that isn't here isn't needed by a desktop that is.
_INDEXERS: Final = {"update-mime-database": "mime", "update-desktop-database": "applications"}
_STARTS: Final = re.compile(r"^Exec=kogao\b", re.MULTILINE)


def of_user() -> Path:
    """Return the folder in which a desktop looks for what one user has."""
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local/share")


def install(share: Path, program: Path) -> None:
    """Lay all files in place, and have the indexes made anew. Raises AssetMissing."""
    from kogao_core.base import assets
    from kogao_core.base.atomic import put

    for name, folder in PLACES.items():
        text = assets.path(f"desktop/{name}").read_text(encoding="utf-8")
        if name.endswith(".desktop"):
            text = f"Exec={quoted(program)}".join(_STARTS.split(text))
        (share / folder).mkdir(parents=True, exist_ok=True)
        put(text.encode(), share / folder / name)
    _index(share)


def remove(share: Path) -> None:
    """Take all files away, and have the indexes made anew."""
    for name, folder in PLACES.items():
        (share / folder / name).unlink(missing_ok=True)
    _index(share)


def quoted(program: Path) -> str:
    r"""Return a path as desktop entries quote it: for their commands, and once more as a text."""
    inner = re.sub(r'(["`$\\])', r"\\\1", str(program)).replace("%", "%%")
    return '"' + inner.replace("\\", "\\\\") + '"'


def _index(share: Path) -> None:
    import subprocess  # takes as long to load as most commands

    for indexer, folder in _INDEXERS.items():
        found = shutil.which(indexer)
        if found and (share / folder).is_dir():
            subprocess.run([found, share / folder], capture_output=True, check=False)
