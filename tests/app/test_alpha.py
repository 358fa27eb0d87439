"""A photo that something shows through lies on a checkerboard, before and after alike."""

import cv2
import numpy as np
import pytest
from kogao_app import theme
from kogao_app.pyramid import PicturePyramid
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from scenes import textured_photo
from test_overlays import hide_marks, pixels_of

from kogao_core.base.display import rgba8
from kogao_core.photo import read

pytestmark = pytest.mark.usefixtures("one_window")

SQUARE_PX = 8


@pytest.fixture
def cut_out(tmp_path):
    """A photo whose left part is clear, whose middle is glass and whose right is opaque."""
    pixels = np.dstack([textured_photo(), np.zeros((360, 480), np.uint8)])
    pixels[:, 160:320, 3], pixels[:, 320:, 3] = 128, 255
    path = tmp_path / "cut-out.png"
    assert cv2.imwrite(str(path), cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGRA))
    return path, pixels


@pytest.fixture
def bare(start, cut_out):
    """An editor with that photo and no marks over it."""
    driver = start(cut_out[0])
    hide_marks(driver)
    return driver


def greys(driver, x, y):
    """The colours of two neighbouring squares of the screen round a point of the photo."""
    picture = pixels_of(driver)
    at = driver.canvas.to_screen(np.array([x, y])).toPoint()
    column, row = at.x() // SQUARE_PX * SQUARE_PX + 4, at.y() // SQUARE_PX * SQUARE_PX + 4
    return [tuple(picture[row, column + shift].tolist()) for shift in (0, SQUARE_PX)]


@pytest.mark.parametrize("look", ["light", "dark"])
def test_what_is_clear_shows_squares_of_the_theme(bare, look, qapp):
    bare.window.dress(theme.apply(qapp, look))
    colours = theme.LIGHT if look == "light" else theme.DARK
    board = {tuple(bytes.fromhex(grey[1:])) for grey in (colours.window, colours.line)}
    assert set(greys(bare, 60, 60)) == board
    assert not set(greys(bare, 440, 60)) & board
    bare.key(Qt.Key.Key_Backslash)


def test_glass_mixes_the_photo_with_the_squares(start, cut_out):
    path, pixels = cut_out
    driver = start(path)
    hide_marks(driver)
    driver.set("percent", 0.0)
    driver.key(Qt.Key.Key_1)
    driver.settle()
    at = np.array([240, 40])
    palette = QApplication.palette()
    seen = pixels_of(driver)
    # The middle of a pixel of the screen.
    spot = driver.canvas.to_screen(at.astype(float))
    shown = seen[int(spot.y()), int(spot.x())].astype(float)
    behind = [palette.window().color().red(), palette.mid().color().red()]
    mixed = [0.5 * pixels[at[1], at[0], :3] + 0.5 * grey for grey in behind]
    assert min(np.abs(shown - one).max() for one in mixed) <= 4.0


def test_a_preview_lies_on_the_board_and_not_on_the_last_picture(bare):
    before = greys(bare, 60, 60)
    bare.pause_never()
    bare.editor.recipe.set_field("percent", 9.0)
    bare.qtbot.waitUntil(lambda: not bare.editor.view.frame.whole)
    assert greys(bare, 60, 60) == before
    bare.editor.document.commit()
    bare.settle()
    assert greys(bare, 60, 60) == before


def test_the_original_the_wipe_and_the_loupe_show_the_board_too(bare):
    before = greys(bare, 60, 60)
    bare.editor.view.set(original=True)
    assert greys(bare, 60, 60) == before
    bare.editor.view.set(original=False)
    bare.key(Qt.Key.Key_W)
    assert greys(bare, 60, 60) == before


def test_the_difference_shows_what_has_changed_in_alpha(bare):
    bare.key(Qt.Key.Key_X)
    picture = pixels_of(bare)
    assert picture.max() > 30
    corner = bare.canvas.to_screen(np.array([5.0, 5.0])).toPoint()
    assert picture[corner.y(), corner.x()].max() == 0


def test_an_opaque_alpha_costs_nothing(start, tmp_path):
    path = tmp_path / "opaque.png"
    pixels = np.dstack([textured_photo(), np.full((360, 480), 255, np.uint8)])
    assert cv2.imwrite(str(path), pixels)
    driver = start(path)
    assert driver.editor.document.pyramid.levels[0].shape[2] == 3


def test_a_copy_keeps_its_alpha_and_what_is_shown_is_what_is_saved(start, cut_out, tmp_path):
    path, pixels = cut_out
    driver = start(path)
    copy = tmp_path / "copy.png"
    driver.save(copy)
    np.testing.assert_array_equal(read(copy).pixels, driver.rendered(pixels))
    np.testing.assert_array_equal(driver.shown, driver.rendered(pixels))


def test_what_is_clear_lends_no_colour_to_the_smaller_levels():
    pixels = np.zeros((600, 600, 4), np.uint8)
    pixels[:, ::2] = (200, 100, 50, 255)
    (level,) = PicturePyramid(pixels).levels[1:]
    assert level[..., :3].reshape(-1, 3).min(axis=0).tolist() == [200, 100, 50]
    assert set(level[..., 3].ravel().tolist()) <= {127, 128}


def test_a_grey_photo_with_alpha_comes_with_it():
    grey = np.dstack([np.full((4, 4), 90, np.uint16) * 257, np.full((4, 4), 0, np.uint16)])
    assert rgba8(grey).shape == (4, 4, 4)
    assert rgba8(grey)[0, 0].tolist() == [90, 90, 90, 0]
