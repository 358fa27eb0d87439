"""Write files atomically: completely or not at all."""

from __future__ import annotations

import ctypes
import errno
import os
import re
import shutil
import stat
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, Final

from kogao_core.base import interrupts
from kogao_core.base.language import Text

if sys.platform != "win32":
    import fcntl

_PREFIX, _SUFFIX = ".kogao-", ".partial"
_NAMES: Final = f"{_PREFIX}*{_SUFFIX}"
# Names of devices, and letters that Windows doesn't allow in names; a colon starts a stream's name.
_RESERVED: Final = re.compile(
    r"(con|prn|aux|nul|(com|lpt)\d)(\..*)?|.*[<>:\"|?*\0-\x1f].*|.*[. ]", re.IGNORECASE | re.DOTALL
)
_swept: Final[set[Path]] = set()
# Temporary folders of this process, with the descriptors that lock them.
_mine: Final[dict[Path, int | None]] = {}
_TRIES: Final = 100
_LONG: Final = 200  # letters of a folder; files in a folder inside could exceed 260 on Windows

Chunks = Sequence[bytes | memoryview]
"""Consecutive parts of a file; joining the parts would copy the data."""


class NotAFile(OSError):
    """The output path isn't a file that can be replaced."""


def check_target(path: str | os.PathLike[str]) -> None:
    """Check that `path` is a regular file or doesn't exist, after resolving links.

    On Windows, also check the name, and that the file isn't read-only. Raises NotAFile.
    """
    if sys.platform == "win32" and _RESERVED.fullmatch(Path(path).name):
        raise NotAFile(errno.EINVAL, Text("Windows doesn't allow this name"), str(path))
    try:
        mode = Path(path).stat().st_mode
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise NotAFile(
                errno.ELOOP, Text("it is a link that leads in a circle"), str(path)
            ) from None
        return  # writing the file will report the error, if any
    if not stat.S_ISREG(mode):
        raise NotAFile(errno.EEXIST, Text("it is a folder, pipe or device"), str(path))
    if sys.platform == "win32" and not mode & stat.S_IWRITE:
        raise NotAFile(errno.EACCES, Text("it is read-only"), str(path))


def atomic_write(
    data: bytes | Chunks,
    path: str | os.PathLike[str],
    check: Callable[[], object] | None = None,
    like: Path | None = None,
    *,
    private: bool = False,
) -> None:
    """Write a temporary file, flush it to the disk, and rename it to `path`.

    `check` runs just before the rename. The file gets the owner and permissions of `like`, or of
    the file that it replaces; with `private` only its owner may read it.
    """
    check_target(path)
    # Resolve symbolic links and use the target's folder: a rename can't cross file systems.
    target = Path(os.path.realpath(path))
    with temporary_folder(target.parent) as place:
        fresh = place / "fresh"
        with fresh.open("xb") as file:
            file.writelines([data] if isinstance(data, bytes) else data)
            file.flush()
            if like is not None or target.exists():
                _resemble(like or target, fresh)
            if private:
                fresh.chmod(0o600)
            os.fsync(file.fileno())
        if check is not None:
            check()
        check_target(target)
        try:
            fresh.replace(target)
        except PermissionError:
            if sys.platform == "win32" and target.exists():
                raise NotAFile(errno.EBUSY, Text("another program uses it"), str(path)) from None
            raise
    _flush(target.parent)


def _resemble(old: Path, new: Path) -> None:
    """Copy owner, extended attributes and permissions from `old` to `new`.

    On Windows: the attributes, but neither permissions nor alternate streams.
    """
    if sys.platform != "win32":
        state = old.stat()
        for owner in (state.st_uid, -1):  # -1: at least the group
            with suppress(OSError):
                os.chown(new, owner, state.st_gid)
                break
    if sys.platform == "linux":  # extended attributes include access control lists
        with suppress(OSError):  # a file system without extended attributes
            wanted, there = os.listxattr(old), os.listxattr(new)
            for name in set(there) - set(wanted):
                with suppress(OSError):
                    os.removexattr(new, name)
            for name in wanted:
                with suppress(OSError):
                    os.setxattr(new, name, os.getxattr(old, name))
    if sys.platform == "win32":
        # Hidden and the like. A copy that were read-only could be neither renamed nor deleted.
        attributes = old.stat().st_file_attributes & ~stat.FILE_ATTRIBUTE_READONLY
        ctypes.windll.kernel32.SetFileAttributesW(str(new), attributes)
        return
    with suppress(OSError):  # a drive without permissions: the bytes matter more
        shutil.copymode(old, new)


def _flush(folder: Path) -> None:
    """Flush a folder's entries to the disk. No effect on Windows."""
    if sys.platform == "win32":
        return
    with suppress(OSError):
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)


def appended(path: Path) -> BinaryIO:
    """Open a file for appending lines. Create the file and the folder if needed.

    Add a line break after an incomplete last line, left by a killed program.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    check_target(path)
    file = path.open("a+b")
    if file.tell() and (file.seek(-1, os.SEEK_END), file.read(1))[1] != b"\n":
        file.write(b"\n")
    return file


@contextmanager
def temporary_folder(folder: Path) -> Iterator[Path]:
    """Yield a locked, hidden temporary folder inside `folder`; delete the folder on exit.

    The first call per process also deletes leftovers of killed programs.
    """
    if folder not in _swept:
        _swept.add(folder)
        _sweep(folder)
    place = _made(folder)
    try:
        yield place
    finally:
        _delete(place)


def _delete(place: Path) -> None:
    """Unlock and delete a temporary folder of this process."""
    lock = _mine.pop(place, None)
    if lock is not None:
        os.close(lock)
    shutil.rmtree(place, ignore_errors=True)


def _clear() -> None:
    """Delete the temporary folders of this process. Retry: other threads may still be writing."""
    for place in tuple(_mine):
        for _ in range(_TRIES):
            _delete(place)
            if not place.exists():
                break


interrupts.leaving(_clear)
if sys.platform != "win32":
    os.register_at_fork(after_in_child=_mine.clear)


def is_temporary(path: Path) -> bool:
    """Return True if a path is inside a temporary folder of `temporary_folder`."""
    return any(part.startswith(_PREFIX) and part.endswith(_SUFFIX) for part in path.parts)


def _made(folder: Path) -> Path:
    if sys.platform == "win32" and len(name := os.path.realpath(folder)) > _LONG:
        folder = Path(rf"\\?\{name}")
    while True:
        place = folder / f"{_PREFIX}{os.urandom(8).hex()}{_SUFFIX}"
        _mine[place] = None
        place.mkdir(mode=0o700)
        try:
            _mine[place] = _locked(place)
            if place.is_dir():
                return place
        except (BlockingIOError, FileNotFoundError):
            pass
        _delete(place)  # another program deleted the folder as stale


def _locked(place: Path) -> int | None:
    """Lock a folder until this program ends. Return the descriptor, or None without locks.

    Raises BlockingIOError if another program has locked the folder.
    """
    opened: int | None
    if sys.platform == "win32":
        lock = place / "lock"
        try:
            lock.unlink(missing_ok=True)  # fails while it is open
            opened = os.open(lock, os.O_CREAT | os.O_EXCL)
        except (PermissionError, FileExistsError) as error:
            raise BlockingIOError(*error.args) from None
    else:
        opened = os.open(place, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
        try:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(opened)
            if isinstance(error, BlockingIOError):
                raise
            opened = None
    return opened


def _sweep(folder: Path) -> None:
    """Delete temporary folders of programs that have ended; skip locked folders."""
    for place in folder.glob(_NAMES):
        with suppress(OSError):
            lock = _locked(place)
            if lock is not None:
                _mine[place] = lock
                _delete(place)
