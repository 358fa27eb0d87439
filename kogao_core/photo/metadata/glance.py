"""What XMP says of a photo at a glance: whether this program made it; the photo isn't read."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Final

_HEAD_BYTES: Final = 1 << 18
_TAIL_BYTES: Final = 1 << 16
_OURS: Final = re.compile(rb"""stEvt:softwareAgent(?:\s*=\s*["']|>)Kogao """)


def is_ours(path: Path) -> bool:
    """Tell whether an edit record near a file's beginning or end says that this program made it."""
    if not path.is_file():  # a pipe would be waited for
        return False
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
        left = os.fstat(file.fileno()).st_size - len(head)
        file.seek(-min(_TAIL_BYTES, left), os.SEEK_END)
        return any(map(_OURS.search, (head, file.read())))
