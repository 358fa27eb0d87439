"""A desktop is told of this very installation: menu, icon, types of files, what shops show.

The wheel lays the same files below its prefix; an environment of its own, pipx's or uv's say, and a
bundle are places where no desktop looks.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Final

from kogao_core.base import assets
from kogao_core.base.atomic import put
from kogao_core.cli import default_programs

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
_TYPES: Final = re.compile(r"^MimeType=(.*)\n", re.MULTILINE)
_ENTRY: Final = f"{NAME}.desktop"
_KEPT: Final = "X-Kogao-Kept"  # a key of our own, for the way back


def install(share: Path, program: Path) -> None:
    """Lay all files in place, and have the indexes made anew; nobody's default changes.

    ``share`` is such as ``~/.local/share``, ``program`` what the menu starts. Raises AssetMissing
    if this installation lacks the files, OSError if they can't be written.
    """
    for name, folder in PLACES.items():
        text = assets.path(f"desktop/{name}").read_text(encoding="utf-8")
        if name.endswith(".desktop"):
            text = f"Exec={quoted(program)}".join(_STARTS.split(text))
            text = _with_kept(text, share)
        (share / folder).mkdir(parents=True, exist_ok=True)
        put(text.encode(), share / folder / name)
    _index(share)


def _with_kept(entry: str, share: Path) -> str:
    """Name the defaults that our entry would come before, and note in it which those were."""
    types = _TYPES.search(entry)
    photos = [kind for kind in (types[1] if types else "").split(";") if kind.startswith("image/")]
    kept = default_programs.implied(photos, _ENTRY)
    default_programs.name(kept, default_programs.file_for(share))
    kept = _kept(share) | kept
    note = "".join(f"{kind}={program};" for kind, program in kept.items())
    return _TYPES.sub(lambda found: f"{found[0]}{_KEPT}={note}\n" if note else found[0], entry)


def _kept(share: Path) -> dict[str, str]:
    """Return the defaults that were named when we came."""
    entry = share / PLACES[_ENTRY] / _ENTRY
    text = entry.read_text(encoding="utf-8") if entry.exists() else ""
    note = re.search(f"^{_KEPT}=(.*)$", text, re.MULTILINE)
    pairs = (one.partition("=") for one in (note[1] if note else "").split(";") if one)
    return {kind: program for kind, _, program in pairs}


def remove(share: Path) -> None:
    """Take all files away, and have the indexes made anew."""
    default_programs.forget(_kept(share), default_programs.file_for(share))
    for name, folder in PLACES.items():
        (share / folder / name).unlink(missing_ok=True)
    _index(share)


def quoted(program: Path) -> str:
    r"""Return a path as desktop entries quote it: for their commands, and once more as a text."""
    inner = re.sub(r'(["`$\\])', r"\\\1", str(program)).replace("%", "%%")
    return '"' + inner.replace("\\", "\\\\") + '"'


def _index(share: Path) -> None:
    for indexer, folder in _INDEXERS.items():
        found = shutil.which(indexer)
        if found and (share / folder).is_dir():
            subprocess.run([found, share / folder], capture_output=True, check=False)
