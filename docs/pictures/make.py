"""Make the pictures of the documentation from the program's own sample.

``python docs/pictures/make.py docs/pictures``

The window in Japanese needs a font with Japanese letters (Debian: fonts-noto-cjk).
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.base import assets
from kogao_core.base.atomic import put
from kogao_core.base.geometry import Image
from kogao_core.faces.landmarks import MeshSource
from kogao_core.photo import read
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe

PERCENT: Final = 6.0
GAP_PX: Final = 12
_INSPECT: Final = ("--workspace", "inspect")
WINDOWS: Final = {
    "window": (),
    "japanese": ("--language", "ja", "--show", "landmarks,targets"),
    "both": ("--workspace", "compare"),
    "inspect": (*_INSPECT, "--show", "landmarks,targets,centre,lattice,domains,legend"),
    "maps": (*_INSPECT, "--show", "heat,landmarks", "--percent", "7"),
    "compare": (*_INSPECT, "--show", "wipe,loupe", "--percent", "8"),
    "protect": (
        *("--show", "protection,line,landmarks", "--theme", "light"),
        *("--protect", "262,230 262,660", "--percent", "5"),
    ),
}


def before_after() -> Image:
    """Return the sample and its warp side by side, cut to head and shoulders, RGB."""
    photo = read(assets.sample()).pixels
    faces = MeshSource().find(photo)
    after = render(photo, faces, Recipe(percent=PERCENT)).pixels
    x, y, width, height = faces[0].box
    rows = slice(max(0, int(y - 0.9 * height)), int(y + 1.6 * height))
    columns = slice(max(0, int(x - 0.6 * width)), int(x + 1.6 * width))
    gap = np.full((rows.stop - rows.start, GAP_PX, 3), 255, np.uint8)
    return np.hstack([photo[rows, columns], gap, after[rows, columns]])


def main(arguments: list[str]) -> None:
    """Write ``before-after.jpg`` and the pictures of the window into the folder named."""
    folder = Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    bgr = cv2.cvtColor(before_after(), cv2.COLOR_RGB2BGR)
    jpeg = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 90])[1]
    put(jpeg.tobytes(), folder / "before-after.jpg")
    offscreen = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
    for name, options in WINDOWS.items():
        window = ["--sample", "--screenshot", str(folder / f"{name}.png"), *options]
        subprocess.run([sys.executable, "-m", "kogao_app", *window], check=True, env=offscreen)


if __name__ == "__main__":
    main(sys.argv[1:])
