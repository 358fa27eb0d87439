"""What C libraries write to standard error, which no hook of theirs turns off.

libjpeg, libtiff, libpng and LibRaw complain there about damaged files, past Python, amid what the
program itself says.
"""

from __future__ import annotations

import faulthandler
import logging
import os
import re
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from tempfile import TemporaryFile
from typing import IO, Final, TypeVar

_Result = TypeVar("_Result")
_FD: Final = 2
_LOCK: Final = threading.RLock()
# Pillow hands libtiff a file of this name, rawpy hands LibRaw one without a name. libtiff's lines
# are the name of a function or codec and a sentence with its full stop, which those of Python's
# exceptions lack. The rest are what libjpeg says of files.
_DAMAGE: Final = re.compile(r"(?:\w+: )?Corrupt JPEG data: (.+)|unknown file: (.+)")
_NOISE: Final = re.compile(
    r"tempfile\.tif: |unknown file: |libpng (?:warning|error): "
    r"|(?!\w*(?:Error|Exception|Warning): )\w+: .*\.$"
    r"|(?:JPEGLib: )?(?:Corrupt JPEG data: |Premature end of |Not a JPEG file: |Invalid JPEG file "
    r"|Inconsistent progression sequence|Unknown Adobe color transform|Warning: unknown JFIF "
    r"|Invalid (?:SOS parameters|progressive|component ID|crop request|scan script|restart)"
    r"|Unsupported (?:JPEG|marker type|color conversion)|Sampling factors too large"
    r"|Bogus (?:\w+ )?(?:marker|sampling|colorspace|buffer|virtual|Huffman|D\w+ (?:index|value))"
    r"|Improper call to JPEG|(?:Huffman|Quantization) table 0x|Missing Huffman code"
    r"|Huffman code size |Too many (?:color components|markers)|Empty (?:JPEG image|input file)"
    r"|Insufficient memory \(case |Fractional sampling|CCIR601 sampling|IDCT output block"
    r"|Maximum supported image dimension "
    r"|DCT coefficient |Didn't expect more than|JPEG datastream contains no |Cannot transcode "
    r"|Sorry, |Caution: |Requested feature was omitted|Not implemented yet|Image too wide for )"
)
# Without a handler of the user's, Python's own prints what Pillow logs.
logging.getLogger("PIL").addHandler(logging.NullHandler())


@contextmanager
def hushed() -> Iterator[list[str]]:
    """Keep decoders' complaints from standard error, and Python's warnings.

    Whatever else comes meanwhile, from other threads say, is passed on at the end. Where
    `faulthandler` is on, to tell of crashes, or there is no standard error, nothing is kept. One
    thread at a time. Result: filled at the end: the complaints about damage, in words for a note.
    """
    complaints: list[str] = []
    with _LOCK, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        caught = _memory()
        if caught is None:
            yield complaints
            return
        with caught:
            with _led_into(caught):
                yield complaints
            complaints += _complaints_in(caught.read())


def if_unsaid(work: Callable[[], _Result]) -> _Result | None:
    """Return what some work of decoders returns, if nothing comes to standard error meanwhile.

    Their complaints are forgotten. None, too, where nothing can be kept from there (`hushed`).
    """
    with _LOCK:
        caught = _memory()
        if caught is None:
            return None
        with caught:
            with _led_into(caught):
                result = work()
            said = caught.read()
            _complaints_in(said)
    return None if said else result


@contextmanager
def _led_into(caught: IO[bytes]) -> Iterator[None]:
    """Lead standard error into a file, which is at its start at the end."""
    aside = os.dup(_FD)
    os.dup2(caught.fileno(), _FD)
    try:
        yield
    finally:
        os.dup2(aside, _FD)
        os.close(aside)
        caught.seek(0)


def _memory() -> IO[bytes] | None:
    """Return a file that nothing waits for, however much is written.

    A pipe could fill up under a library that holds Python's lock. None where there is no room, and
    where nothing may be kept from standard error.
    """
    if sys.__stderr__ is None or faulthandler.is_enabled():
        return None
    try:
        if sys.platform == "linux":
            return os.fdopen(os.memfd_create("stderr"), "w+b")
        else:  # noqa: RET505 (mypy knows platforms by it)
            return TemporaryFile()
    except OSError:
        return None


def _complaints_in(data: bytes) -> list[str]:
    """Return the complaints about damage; pass on what no decoder wrote."""
    complaints = []
    for line in data.splitlines(keepends=True):
        text = line.decode(errors="replace").strip()
        damage = _DAMAGE.match(text)
        if damage:
            complaints.append(damage[1] or damage[2])
        elif not _NOISE.match(text):
            os.write(_FD, line)
    return list(dict.fromkeys(complaints))


def open_standard_streams() -> None:
    """Open what a program was started without: a file of ours would get the descriptor.

    What a C library writes to standard error would then stand in a photo.
    """
    while (opened := os.open(os.devnull, os.O_RDWR)) <= _FD:
        os.set_inheritable(opened, True)
    os.close(opened)
