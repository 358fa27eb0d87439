"""Fine screens, and a window that answers while it works."""

import os

from kogao_app.features.files import opening
from kogao_app.render import live
from programs import ran
from PySide6.QtCore import Qt
from responsiveness import Responsiveness

from kogao_core import retouch

KEYS = Qt.Key


FINE = """
import numpy as np
from kogao_app.document import Document
from kogao_app.pyramid import PicturePyramid
from kogao_app.view_state import ViewState
from kogao_app.canvas.photo_canvas import PhotoCanvas
from PySide6.QtCore import QPointF
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication

app = QApplication([])
pixels = np.random.default_rng(1).integers(0, 255, (300, 400, 3), np.uint8)
document = Document()
document.pyramid = PicturePyramid(pixels)
view = ViewState(document=document)
canvas = PhotoCanvas(view)
canvas.resize(260, 200)
canvas.show()
document.opened.emit()
app.processEvents()
assert canvas.devicePixelRatioF() == 2.0
canvas.zoom_to(1.0)
assert abs(canvas.zoom - 1.0) < 1e-9
corner = canvas.to_screen(np.array([-0.5, -0.5]))
canvas.start_pan(corner)
canvas.pan_to(QPointF(round(2 * corner.x()) / 2 + 0.1, round(2 * corner.y()) / 2 - 0.1))
corner = canvas.to_screen(np.array([-0.5, -0.5]))

def seen():
    image = canvas.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : 3 * image.width()].reshape(image.height(), -1, 3).copy()

picture = seen()
assert picture.shape == (400, 520, 3), picture.shape
left, top = round(2 * corner.x()), round(2 * corner.y())
part = picture[top : top + 300, left : left + 400]
np.testing.assert_array_equal(part, pixels)
view.set(compare="wipe", wipe=0.5)
wiped = seen()
changed = np.flatnonzero((wiped[300] != picture[300]).any(axis=-1))
assert abs(np.median(changed) - 260) <= 2, changed
"""


def test_on_a_fine_screen_100_percent_is_one_pixel_each():
    ran(FINE, env={**os.environ, "QT_QPA_PLATFORM": "offscreen", "QT_SCALE_FACTOR": "2"})


def test_the_window_answers_while_it_works(empty, source, photo, tmp_path, monkeypatch):
    """Opening, finding, rendering and saving each wait for the window."""
    window = Responsiveness()
    work = [(opening, "read"), (retouch, "write"), (retouch, "render"), (live, "render")]
    for module, name in work:
        monkeypatch.setattr(module, name, window.delayed(name, getattr(module, name)))
    source.find = window.delayed("find", source.find)
    empty.open(photo)
    slider = empty.panel("recipe").percent.slider
    empty.press_key(slider, KEYS.Key_PageUp)
    empty.settle()
    empty.key(KEYS.Key_F, Qt.KeyboardModifier.ControlModifier)
    empty.settle()
    empty.save(tmp_path / "copy.png")
    assert (tmp_path / "copy.png").is_file()
    assert window.answered == {"read", "find", "render", "write"}
    assert window.stalled == set()
