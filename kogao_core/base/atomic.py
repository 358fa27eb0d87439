"""Files that appear whole or not at all."""

from __future__ import annotations

import errno
import os
import shutil
import stat
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, Final

from kogao_core.base.language import Text

if sys.platform != "win32":
    import fcntl

_PREFIX, _SUFFIX = ".kogao-", ".partial"
_NAMES: Final = f"{_PREFIX}*{_SUFFIX}"
_DAY_S: Final = 86400.0
_KINDS: Final = (
    (stat.S_ISDIR, Text("a folder")),
    (stat.S_ISCHR, Text("a device")),
    (stat.S_ISBLK, Text("a device")),
    (stat.S_ISFIFO, Text("a pipe")),
    (stat.S_ISSOCK, Text("a socket")),
)
_swept: Final[set[Path]] = set()

Pieces = Sequence[bytes | memoryview]
"""What a file holds, one behind the other; not joined, for that would copy them."""


class NotAFile(OSError):
    """What is there isn't a regular file and must not be replaced by one."""


def check_target(path: str | os.PathLike[str]) -> None:
    """Check that a regular file is there, or nothing yet, at the end of all links.

    Raises NotAFile.
    """
    try:
        mode = Path(path).stat().st_mode
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise NotAFile(
                errno.ELOOP, Text("it is a link that leads in a circle"), str(path)
            ) from None
        return  # whoever writes there finds out what is wrong, if anything
    for is_kind, name in _KINDS:
        if is_kind(mode):
            raise NotAFile(errno.EEXIST, Text("it is {name}, not a file", name=name), str(path))


def put(
    data: bytes | Pieces,
    path: str | os.PathLike[str],
    check: Callable[[], object] | None = None,
    like: Path | None = None,
) -> None:
    """Write a file aside, flush it to the disk, and put it in place in one step."""
    check_target(path)
    # Through a link to the file it names, and beside it: a rename must not cross file systems.
    target = Path(os.path.realpath(path))
    with aside(target.parent) as place:
        fresh = place / "fresh"
        with fresh.open("xb") as file:
            file.writelines([data] if isinstance(data, bytes) else data)
            file.flush()
            if like is not None or target.exists():
                _resemble(like or target, fresh)
            os.fsync(file.fileno())
        if check is not None:
            check()
        check_target(target)
        fresh.replace(target)
    _flush(target.parent)


def _resemble(old: Path, new: Path) -> None:
    """Give a file the owner, attributes and permissions of another one."""
    if sys.platform != "win32":
        state = old.stat()
        for owner in (state.st_uid, -1):  # -1: at least the group
            with suppress(OSError):
                os.chown(new, owner, state.st_gid)
                break
    if sys.platform == "linux":  # access control lists are among them
        with suppress(OSError):  # a file system without any
            wanted, there = os.listxattr(old), os.listxattr(new)
            for name in set(there) - set(wanted):
                with suppress(OSError):
                    os.removexattr(new, name)
            for name in wanted:
                with suppress(OSError):
                    os.setxattr(new, name, os.getxattr(old, name))
    shutil.copymode(old, new)


def _flush(folder: Path) -> None:
    """Flush the names in a folder to the disk, where the system can."""
    if sys.platform == "win32":
        return
    with suppress(OSError):
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)


def appended(path: Path) -> BinaryIO:
    """Open a file to add lines to it; it and its folder are made if need be.

    A line that a killed program left unfinished doesn't swallow the next one.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    check_target(path)
    file = path.open("a+b")
    if file.tell() and (file.seek(-1, os.SEEK_END), file.read(1))[1] != b"\n":
        file.write(b"\n")
    return file


@contextmanager
def aside(folder: Path) -> Iterator[Path]:
    """Make a hidden folder for what isn't finished, and remove it in the end.

    It is held while this program runs. What programs that were killed have left in the same folder
    is removed first, once a process.
    """
    if folder not in _swept:
        _swept.add(folder)
        _sweep(folder)
    place, lock = _made(folder)
    try:
        yield place
    finally:
        shutil.rmtree(place, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def is_aside(path: Path) -> bool:
    """Tell whether a path leads into a folder of `aside`."""
    return any(part.startswith(_PREFIX) and part.endswith(_SUFFIX) for part in path.parts)


def _made(folder: Path) -> tuple[Path, int | None]:
    while True:
        place = folder / f"{_PREFIX}{os.urandom(8).hex()}{_SUFFIX}"
        place.mkdir(mode=0o700)
        try:
            lock = _locked(place)
            if place.is_dir():
                return place, lock
            if lock is not None:
                os.close(lock)
        except (BlockingIOError, FileNotFoundError):
            pass  # another program was sweeping just now and took it for an old one


def _locked(place: Path) -> int | None:
    """Lock a folder for as long as this program runs; None where the system can't."""
    if sys.platform == "win32":
        return None
    opened = os.open(place, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(opened)
        if isinstance(error, BlockingIOError):
            raise
        return None
    return opened


def _sweep(folder: Path) -> None:
    """Remove what programs left that are gone; what a running one holds stays."""
    for place in folder.glob(_NAMES):
        with suppress(OSError):
            if sys.platform == "win32":
                if time.time() - place.stat().st_mtime > _DAY_S:
                    shutil.rmtree(place)
                continue
            lock = _locked(place)
            if lock is not None:
                shutil.rmtree(place, ignore_errors=True)
                os.close(lock)
