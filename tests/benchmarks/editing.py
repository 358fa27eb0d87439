"""Save copies in the editor: ``python tests/benchmarks/editing.py PHOTO ROUNDS OUT.json``.

Opens the photo in the real editor, without a screen, and saves it again and again; in turns with
`cv2.imwrite` of the same pixels. Times in ms.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cv2
from kogao_app.editor import Editor
from kogao_app.storage import Storage
from paired import take_turns
from PySide6.QtWidgets import QApplication

from kogao_core.base.threads import shorten_switch_interval
from kogao_core.faces.landmarks import source


def main(photo: str, rounds: str, out: str) -> None:
    """Write the times of every save and of its floor."""
    shorten_switch_interval()  # as the program does
    app = QApplication([])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        editor = Editor(app, source(), Storage.in_folder(folder / "home"))
        editor.window.resize(1280, 800)
        editor.window.show()
        editor.files.open(Path(shutil.copy(photo, folder)))  # edits are kept beside the photo
        settle(app, editor)
        pixels = cv2.imread(photo)
        copy, bare = folder / "copy.jpg", str(folder / "bare.jpg")

        def save() -> None:
            editor.files.save(copy)
            settle(app, editor)

        def write() -> None:
            cv2.imwrite(bare, pixels)

        times = take_turns({"ours": save, "floor": write, "again": write}, int(rounds))
        editor.close()
    Path(out).write_text(json.dumps(times))


def settle(app: QApplication, editor: Editor) -> None:
    """Handle events until the editor has nothing more to do."""
    while editor.busy:
        app.processEvents()
        time.sleep(0.001)


if __name__ == "__main__":
    main(*sys.argv[1:])
