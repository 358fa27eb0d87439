"""How this program came here: by pip, or as a bundle, a folder that brings its own Python."""

from __future__ import annotations

import shutil
import sys
import sysconfig
from pathlib import Path

from kogao_core.base.language import Text


def is_bundle() -> bool:
    """Tell whether this is a bundle, into which nothing can be installed."""
    return bool(getattr(sys, "frozen", False))


def program(name: str) -> Path | None:
    """Return where one of our programs lies: beside this one, else on the path.

    Parameters
    ----------
    name : {"kogao", "kogao-cli"}
        The program, without an ending.

    Returns
    -------
    Path or None
        An absolute path; None where it isn't installed.
    """
    ending = ".exe" if sys.platform == "win32" else ""
    folder = Path(sys.executable).parent if is_bundle() else Path(sysconfig.get_path("scripts"))
    beside = folder / (name + ending)
    found = beside if beside.is_file() else shutil.which(name)
    return None if found is None else Path(found).absolute()


def adding(extra: str) -> str:
    """Return how the libraries of an extra are got, as the end of a sentence."""
    command = f"pip install 'kogao[{extra}]'"
    return (
        Text("not in this bundle, but with {command}", command=command) if is_bundle() else command
    )
