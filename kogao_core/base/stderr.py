"""Capture the messages that C libraries write to stderr.

libjpeg, libtiff, libpng and LibRaw write messages about damaged files directly to stderr, and no
hook turns these messages off.
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
_LOCK, _WARNINGS = threading.RLock(), threading.RLock()
# Pillow passes libtiff a file named tempfile.tif; rawpy passes LibRaw an unnamed file. A libtiff
# line is the name of a function or codec and a sentence with a full stop; lines of Python
# exceptions have no full stop. The other patterns are messages of libjpeg.
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
# Without a handler, Python's default handler would print Pillow's log.
logging.getLogger("PIL").addHandler(logging.NullHandler())


@contextmanager
def no_warnings() -> Iterator[None]:
    """Suppress Python warnings, such as Pillow's. One thread at a time."""
    with _WARNINGS, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@contextmanager
def hushed() -> Iterator[list[str]]:
    """Suppress decoder messages on stderr, and Python warnings. One thread at a time.

    Yield a list that contains the messages about damage after exit. Other text, for example from
    other threads, is written to stderr on exit. If `faulthandler` is enabled or stderr is closed,
    messages are not captured.
    """
    complaints: list[str] = []
    with no_warnings(), _captured() as said:
        yield complaints
    complaints += _complaints_in(b"".join(said or ()))


def if_unsaid(work: Callable[[], _Result]) -> _Result | None:
    """Run `work`. Return the result, or None if any text was written to stderr.

    Decoder messages are discarded. None, without calling `work`: stderr can't be captured.
    """
    with _captured() as said:
        result = None if said is None else work()
    text = b"".join(said or ())
    _complaints_in(text)
    return None if text else result


@contextmanager
def _captured() -> Iterator[list[bytes] | None]:
    """Redirect stderr, one thread at a time; yield a list that holds the text after exit, or None.

    None: stderr can't be captured.
    """
    with _LOCK:
        caught = _memory()
        if caught is None:
            yield None
            return
        said, aside = list[bytes](), os.dup(_FD)
        os.dup2(caught.fileno(), _FD)
        try:
            yield said
        finally:
            os.dup2(aside, _FD)
            os.close(aside)
            with caught:
                caught.seek(0)
                said.append(caught.read())


def _memory() -> IO[bytes] | None:
    """Return an in-memory or temporary file for captured stderr.

    A pipe could fill up and block a library that holds the GIL. None: the file can't be created,
    stderr is closed or `faulthandler` is enabled.
    """
    if sys.__stderr__ is None or faulthandler.is_enabled():
        return None
    try:
        if sys.platform == "linux":
            return os.fdopen(os.memfd_create("stderr"), "w+b")
        else:  # noqa: RET505 (mypy needs this to narrow the platform)
            return TemporaryFile()
    except OSError:
        return None


def _complaints_in(data: bytes) -> list[str]:
    """Return the messages about damage; write all text that isn't from a decoder to stderr."""
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
    """Open missing standard streams as the null device.

    Otherwise an output file could get descriptor 2, and C libraries would write messages into the
    photo.
    """
    while (opened := os.open(os.devnull, os.O_RDWR)) <= _FD:
        os.set_inheritable(opened, True)
    os.close(opened)
