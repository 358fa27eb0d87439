"""What no program can do without: ``python tests/benchmarks/floors.py picture|window IN OUT ...``.

``picture`` decodes files and encodes them again, IN and OUT in turns. ``window`` loads Qt, decodes
a photo, shows it in a bare window and saves a picture of that.
"""

from __future__ import annotations

import sys

import cv2


def picture(*files: str) -> None:
    """Decode and encode pairs of files; nothing else."""
    for source, out in zip(files[::2], files[1::2], strict=True):
        cv2.imwrite(out, decoded(source), _as_is(out))


def decoded(file: str) -> object:
    """Return a photo at its own depth."""
    return cv2.imread(file, cv2.IMREAD_ANYDEPTH | cv2.IMREAD_COLOR)


def _as_is(out: str) -> list[int]:
    return [cv2.IMWRITE_TIFF_COMPRESSION, 1] if out.endswith(".tif") else []


def window(source: str, out: str) -> None:
    """Show a photo in a window of the editor's size and grab that."""
    from PySide6.QtGui import QImage, QPixmap
    from PySide6.QtWidgets import QApplication, QLabel

    app = QApplication(sys.argv[:1])
    pixels = decoded(source)
    height, width = pixels.shape[:2]
    image = QImage(pixels.data, width, height, pixels.strides[0], QImage.Format.Format_BGR888)
    label = QLabel()
    label.setScaledContents(True)
    label.setPixmap(QPixmap.fromImage(image))
    label.resize(1280, 800)
    label.show()
    app.processEvents()
    label.grab().save(out)


if __name__ == "__main__":
    {"picture": picture, "window": window}[sys.argv[1]](*sys.argv[2:])
