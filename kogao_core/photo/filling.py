"""Decode a file with OpenCV into an array."""

from __future__ import annotations

import os
import sys
from typing import IO, Final

import cv2
import numpy as np

from kogao_core.base.geometry import Image

_MARK_BYTES: Final = 16


def filled(pixels: Image, file: IO[bytes], flags: int) -> bool:
    """Decode an open JPEG or TIFF file into `pixels`. Return True if that succeeds.

    False also if the file has another shape or depth, or on systems other than Linux, where an open
    file has no path. Unlike `imdecode`, `imread` does not copy the pixels, and reports no error.
    """
    if sys.platform != "linux":
        return False
    last = pixels[-1].reshape(-1).view(np.uint8)[-_MARK_BYTES:]
    last[:] = mark = np.frombuffer(os.urandom(len(last)), np.uint8)
    try:
        cv2.imread(f"/proc/self/fd/{file.fileno()}", pixels, flags)
    except (OSError, cv2.error):  # a file in memory; another shape
        return False
    return not np.array_equal(last, mark)  # decoders write the last pixel last
