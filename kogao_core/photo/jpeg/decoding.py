"""The compressed data of a JPEG file: what they cost to decode, and whether they are all there."""

from __future__ import annotations

import io
from itertools import islice
from pathlib import Path
from typing import IO, Final

import cv2
import numpy as np
from PIL import Image as Pillow
from PIL import ImageChops

from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.base.stderr import if_unsaid
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.jpeg.segments import END, START_OF_SCAN, markers, segments

# Usual files have at most 18. Each takes about 1.2 ns a pixel, and may be a dozen bytes.
MOST_SCANS: Final = 64
_MOST_MARKERS: Final = 16 * MOST_SCANS  # tables and remarks between them
_END: Final = b"\xff\xd9"
_BLOCK_PX: Final = 8
# The fewest bits that Huffman codes spend on a block: its mean, and in sequential files its end.
_LEAST_BITS: Final = {0xC0: 2, 0xC1: 2, 0xC2: 1}
# As Pillow's colour models.
_FLAGS: Final = {
    "L": cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION,
    "RGB": cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION,
}
_ANYTHING: Final = b"\xaa" * 1000  # unlike the zeros that decoders fill in


def check(file: IO[bytes], path: Path) -> bool:
    """Check an open JPEG file before it is decoded; return whether the picture ends with a scan.

    Raises UnreadablePhoto.
    """
    frame = next((body for code, body in segments(file) if code in _LEAST_BITS), None)
    for _ in segments(file):
        pass  # the file is then at its first scan
    data = file.read()
    if frame is not None and 8 * len(data) < _LEAST_BITS[frame[1]] * _blocks(frame):
        raise ValueError(Text("fewer data than blocks"))
    codes = [code for code, _, _ in islice(markers(data, 0), _MOST_MARKERS + 1)]
    is_long = len(codes) > _MOST_MARKERS and codes[-1] != END
    if is_long or codes.count(START_OF_SCAN) > MOST_SCANS:
        raise UnreadablePhoto(
            Text(
                "{path} is a JPEG in more than {most_scans} scans, which would take "
                "very long; save it as an ordinary JPEG or as PNG first",
                path=path,
                most_scans=MOST_SCANS,
            )
        )
    return codes[-2:] == [START_OF_SCAN, END]


def _blocks(frame: bytes) -> int:
    """Return how many blocks the segment of a frame announces."""
    height, width = (int.from_bytes(frame[at : at + 2], "big") for at in (5, 7))
    parts = [divmod(factors, 16) for factors in frame[11::3][: frame[9]]]
    most_across, most_down = (max((part[axis] for part in parts), default=1) for axis in (0, 1))
    return sum(
        (width * across // max(1, most_across) // _BLOCK_PX)
        * (height * down // max(1, most_down) // _BLOCK_PX)
        for across, down in parts
    )


def pixels(data: bytes, size: tuple[int, int], mode: str) -> Image | None:
    """Return the pixels of a JPEG file that OpenCV has no word to say about, else None.

    They are those of Pillow, from the same libjpeg, in half the time and less memory. What Pillow
    takes for damage OpenCV complains of, or refuses; but it doesn't hear of damage behind a scan.
    Result uint8 (H, W) or (H, W, 3).
    """
    if mode not in _FLAGS:
        return None

    def decode() -> Image | None:
        try:
            return cv2.imdecode(np.frombuffer(data, np.uint8), _FLAGS[mode])
        except cv2.error:  # it has a limit of its own
            return None

    found = if_unsaid(decode)
    return found if found is not None and found.shape[1::-1] == size else None


def without_end(data: bytes) -> Pillow.Image | None:
    """Return the picture of a JPEG file that lacks nothing but its end marker, else None.

    Decoders fill in what is missing from whatever follows: where that makes no difference, nothing
    is missing.
    """
    try:
        if not _is_whole(data, small=True):  # most that end early do so by far
            return None
        return _decoded(data + _END) if _is_whole(data, small=False) else None
    except OSError:
        return None


def _is_whole(data: bytes, *, small: bool) -> bool:
    first, second = (_decoded(data + more + _END, small=small) for more in (b"", _ANYTHING))
    return ImageChops.difference(first, second).getbbox() is None


def _decoded(data: bytes, *, small: bool = False) -> Pillow.Image:
    image = Pillow.open(io.BytesIO(data), formats=["JPEG"])
    if small:
        image.draft(None, (1, 1))  # an eighth of the width and height
    image.load()
    return image
