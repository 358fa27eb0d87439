"""How this program came here, by pip or as a bundle, and where it keeps a user's data."""

from __future__ import annotations

import os
import shutil
import sys
import sysconfig
from importlib.util import find_spec
from pathlib import Path

from kogao_core.base.language import Text


def is_bundle() -> bool:
    """Tell whether this is a bundle, into which nothing can be installed."""
    return bool(getattr(sys, "frozen", False))


def program(name: str) -> Path | None:
    """Return where one of our programs lies: beside this one, else on the path.

    Result: an absolute path; None where it isn't installed.
    """
    ending = ".exe" if sys.platform == "win32" else ""
    folder = Path(sys.executable).parent if is_bundle() else Path(sysconfig.get_path("scripts"))
    beside = folder / (name + ending)
    found = beside if beside.is_file() else shutil.which(name)
    return None if found is None else Path(found).absolute()


def has_laboratory() -> bool:
    """Tell whether the laboratory is here; without it nothing offers an experiment."""
    return find_spec("kogao_core.lab") is not None


def data_folder() -> Path:
    """Return where the system keeps this user's data of this program, as Qt would say."""
    home = Path.home()
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = home / "Library" / "Application Support"
    else:
        named = Path(os.environ.get("XDG_DATA_HOME", ""))
        base = named if named.is_absolute() else home / ".local" / "share"
    return base / "kogao"


def adding(extra: str) -> str:
    """Return how the libraries of an extra are got, as the end of a sentence."""
    command = f"pip install 'kogao[{extra}]'"
    return (
        Text("not in this bundle, but with {command}", command=command) if is_bundle() else command
    )
