"""On a real X server the picture is shown by the profile that the screen is said to have."""

from __future__ import annotations

import ctypes
import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from colours import delta_e_2000, expected_srgb, lab_of_srgb, profile
from programs import ran

TESTS = Path(__file__).parent.parent
PATCHES = np.array([(200, 60, 40), (40, 160, 80), (60, 70, 190), (128, 128, 128)], np.uint8)
# A program of its own: shows the photo, then whatever X has on its screen, and what is said of it.
SHOWS = """
    import sys
    from pathlib import Path
    import numpy as np
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QApplication
    from kogao_app.editor import Editor
    from kogao_app.storage import Storage
    from scenes import KnownFaces

    app = QApplication([])
    editor = Editor(app, KnownFaces(), Storage.in_folder(Path(sys.argv[2]).parent / "home"))
    editor.window.resize(1000, 700)
    editor.window.show()
    editor.files.read(Path(sys.argv[1]))

    def look():
        canvas = editor.window.canvas
        if editor.busy or editor.document.photo is None or not canvas.isVisible():
            QTimer.singleShot(20, look)
            return
        editor.window.bar.clear()
        editor.window.bar.hide()
        app.processEvents()
        screen = app.primaryScreen().grabWindow(0)
        screen.save(sys.argv[2])
        height = editor.document.photo.height
        for part in range(4):
            at = canvas.to_screen(np.array([part + 0.5, 0.5]) * height).toPoint()
            place = canvas.viewport().mapToGlobal(at)
            print(place.x(), place.y())
        print(editor.window.status._photo.toolTip())
        editor.figure.export(Path(sys.argv[2]).with_name("figure.png"))
        app.exit()

    QTimer.singleShot(0, look)
    app.exec()
"""


def set_property(display: str, name: str, value: bytes) -> None:
    """Put bytes on X's root window, as colord's helpers do; a server without clients forgets."""
    x = ctypes.CDLL("libxcb.so.1")
    x.xcb_connect.restype = x.xcb_get_setup.restype = ctypes.c_void_p
    x.xcb_intern_atom_reply.restype = ctypes.POINTER(ctypes.c_uint32)
    x.xcb_setup_roots_iterator.restype = ctypes.POINTER(ctypes.c_uint32)
    connection = ctypes.c_void_p(x.xcb_connect(display.encode(), None))
    root = x.xcb_setup_roots_iterator(ctypes.c_void_p(x.xcb_get_setup(connection)))[0]
    asked = x.xcb_intern_atom(connection, 0, len(name), name.encode())
    atom = x.xcb_intern_atom_reply(connection, asked, None)[2]
    cardinal = 6
    x.xcb_change_property(connection, 0, root, atom, cardinal, 8, len(value), value)
    # An answer comes after everything that was asked before.
    x.xcb_get_input_focus_reply.restype = ctypes.c_void_p
    x.xcb_get_input_focus_reply(connection, x.xcb_get_input_focus(connection), None)


@pytest.mark.slow
@pytest.mark.parametrize("space", ["Display P3", "Adobe RGB", None])
def test_what_x_shows_is_the_photo_in_the_screens_colours(screen, tmp_path, space):
    photo, out = tmp_path / "patches.png", tmp_path / "screen.png"
    cv2.imwrite(str(photo), np.repeat(np.repeat(PATCHES[None], 200, 0), 200, 1)[..., ::-1])
    if space is not None:
        set_property(screen, "_ICC_PROFILE", profile(space))
    env = {**os.environ, "DISPLAY": screen, "QT_QPA_PLATFORM": "xcb", "PYTHONPATH": str(TESTS)}
    done = ran(SHOWS, photo, out, env=env)
    *places, told = done.stdout.splitlines()
    pixels = cv2.imread(str(out))[..., ::-1]
    shown = np.array([pixels[y, x] for x, y in (map(int, place.split()) for place in places)])
    if space is None:
        np.testing.assert_array_equal(shown, PATCHES)
        assert told == "The screen is taken to be sRGB: the system reports no profile"
        return
    assert told == f"The screen's colours: {space}"
    seen = delta_e_2000(lab_of_srgb(expected_srgb(shown / 255, space)), lab_of_srgb(PATCHES / 255))
    assert seen.max() < 1.0, "on that screen it looks as it is meant to"
    raw = delta_e_2000(lab_of_srgb(expected_srgb(PATCHES / 255, space)), lab_of_srgb(PATCHES / 255))
    assert raw.max() > 3.0, "as it is, it wouldn't"
    figure = cv2.imread(str(tmp_path / "figure.png"))[..., ::-1].reshape(-1, 3).astype(int)
    for colour in PATCHES.astype(int):
        near = np.abs(figure - colour).max(axis=1) <= 2
        assert near.sum() > 1000, "a figure is a file: it is in sRGB"
