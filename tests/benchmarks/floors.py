"""Programs for `end_to_end.py`: ``python tests/benchmarks/floors.py picture|window|saves ...``.

``picture IN OUT ...`` decodes files and encodes them again. ``window IN OUT`` loads Qt, decodes a
photo, shows it in a bare window and saves a picture of that. ``saves PHOTO ROUNDS OUT.json`` saves
copies in the real editor, in turns with `cv2.imwrite` of the same pixels; times in ms.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the programs do

import cv2


def picture(*files: str) -> None:
    """Decode and encode pairs of files; nothing else."""
    for source, out in zip(files[::2], files[1::2], strict=True):
        as_is = [cv2.IMWRITE_TIFF_COMPRESSION, 1] if out.endswith(".tif") else []
        cv2.imwrite(out, decoded(source), as_is)


def decoded(file: str) -> object:
    """Return a photo at its own depth."""
    return cv2.imread(file, cv2.IMREAD_ANYDEPTH | cv2.IMREAD_COLOR)


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


def saves(photo: str, rounds: str, out: str) -> None:
    """Write the times of every save and of its floor."""
    from kogao_app.editor import Editor
    from kogao_app.storage import Storage
    from paired import take_turns
    from PySide6.QtWidgets import QApplication

    from kogao_core.base.threads import shorten_switch_interval
    from kogao_core.faces.landmarks import source

    shorten_switch_interval()  # as the program does
    app, pixels = QApplication([]), cv2.imread(photo)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        editor = Editor(app, source(), Storage.in_folder(folder / "home"))

        def settle() -> None:
            while editor.busy:
                app.processEvents()
                time.sleep(0.001)

        def save() -> None:
            editor.files.save(folder / "copy.jpg")
            settle()

        def write() -> None:
            cv2.imwrite(str(folder / "bare.jpg"), pixels)

        editor.window.resize(1280, 800)
        editor.window.show()
        editor.files.open(Path(shutil.copy(photo, folder)))  # edits are kept beside the photo
        settle()
        times = take_turns({"ours": save, "floor": write, "again": write}, int(rounds))
        editor.close()
    Path(out).write_text(json.dumps(times))


if __name__ == "__main__":
    {"picture": picture, "window": window, "saves": saves}[sys.argv[1]](*sys.argv[2:])
