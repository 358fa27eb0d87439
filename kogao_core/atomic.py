"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Callable
from pathlib import Path


def put(
    data: bytes, path: str | os.PathLike[str], check: Callable[[], object] | None = None
) -> None:
    """Write a file aside, flush it to the disk, and put it in place in one step.

    Parameters
    ----------
    data : bytes
        What the file is to hold.
    path : path
        Where; a link is followed to the file it names. A file there keeps its permissions.
    check : callable, optional
        Called last before the file is put in place; what it raises leaves everything as it was.

    Raises
    ------
    OSError
        If the folder is missing or not writable, or the disk is full.
    """
    # Through a link to the file it names, and beside it: a rename must not cross file systems.
    target = Path(os.path.realpath(path))
    partial = target.with_name(f".{target.name}.{secrets.token_hex(4)}.partial")
    try:
        with partial.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if target.exists():
            shutil.copymode(target, partial)
        if check is not None:
            check()
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)
