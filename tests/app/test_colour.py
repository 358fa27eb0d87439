"""Photos are shown in the screen's colours; their own colours stay as they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from colours import SPACES, delta_e_2000, expected_srgb, lab_of_srgb, profile
from kogao_app.ahead import Ahead
from kogao_app.document import State
from kogao_app.features.strip.facts import thumbnail
from kogao_app.pyramid import PicturePyramid
from kogao_app.render.colour import pyramid_of, screen_colours, use_screen
from kogao_app.render.live import Surface
from kogao_app.view_state import VisiblePart
from PIL import ImageCms
from PySide6.QtCore import QPointF
from scenes import KnownFaces, oval_face, textured_photo
from test_overlays import at, hide_marks, pixels_of

from kogao_core.base.display import rgb8
from kogao_core.base.geometry import Box
from kogao_core.photo import Photo, profiles, read, write

pytestmark = pytest.mark.usefixtures("one_window")

CHART_PX = 6  # side of a patch
ON_8_BITS = 1.5  # what a wide screen of 8 bits is off by, at worst


def chart(dtype, channels: int = 3) -> np.ndarray:
    """Return patches of 9 x 9 x 9 colours, or 256 steps of grey."""
    most = np.iinfo(dtype).max
    if channels == 1:
        flat = np.linspace(0, most, 256).round().astype(dtype).reshape(16, 16)
    else:
        steps = np.linspace(0, most, 9).round().astype(dtype)
        flat = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(27, 27, 3)
    return np.repeat(np.repeat(flat, CHART_PX, axis=0), CHART_PX, axis=1)


def with_profile(pixels: np.ndarray, icc: bytes | None) -> Photo:
    return Photo(pixels, Path("chart.png"), "PNG", icc_profile=icc)


def on_screen(photo: Photo) -> np.ndarray:
    return PicturePyramid(rgb8(photo.pixels), screen_colours(photo).show).shown[0]


def apart(shown: np.ndarray, pixels: np.ndarray, name: str) -> np.ndarray:
    """Return the colour difference between what is shown and what an exact conversion gives."""
    wanted = expected_srgb(pixels / np.iinfo(pixels.dtype).max, name)
    return delta_e_2000(lab_of_srgb(shown / 255.0), lab_of_srgb(wanted))


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("name", list(SPACES))
def test_wide_gamut_charts_are_shown_as_an_exact_conversion_would(name, dtype):
    pixels = chart(dtype)
    photo = with_profile(pixels, profile(name))
    assert screen_colours(photo).name == name
    difference = apart(on_screen(photo), pixels, name)
    assert difference.max() < 1.0
    # Without the conversion they would be plainly wrong.
    assert apart(on_screen(with_profile(pixels, None)), pixels, name).max() > 4.0


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_grey_goes_by_its_own_profile(dtype):
    pixels = chart(dtype, 1)
    shown = on_screen(with_profile(pixels, profile("grey")))
    assert shown.shape == (*pixels.shape, 3)
    assert apart(shown, pixels, "grey").max() < 1.0
    alpha = np.full_like(pixels, np.iinfo(dtype).max)
    with_alpha = with_profile(np.dstack([pixels, alpha]), profile("grey"))
    np.testing.assert_array_equal(on_screen(with_alpha), shown)


def test_transparency_is_no_colour():
    pixels = chart(np.uint8)
    photo = with_profile(pixels, profile("Display P3"))
    seen_through = with_profile(np.dstack([pixels, pixels[..., 0]]), photo.icc_profile)
    np.testing.assert_array_equal(on_screen(seen_through), on_screen(photo))


def test_srgb_stays_byte_for_byte_and_costs_nothing():
    srgb = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    pixels = chart(np.uint8)
    assert on_screen(with_profile(pixels, srgb)) is pixels


@pytest.mark.parametrize("icc", [b"", b"nonsense", profile("Display P3")[:200], profile("grey")])
def test_a_profile_that_cannot_be_used_leaves_the_colours_alone(icc):
    pixels = chart(np.uint8)
    photo = with_profile(pixels, icc)
    assert not screen_colours(photo).usable
    assert on_screen(photo) is pixels


@pytest.fixture
def wide(tmp_path):
    """A photo in a wide space, and its file."""
    pixels = textured_photo()
    path = tmp_path / "wide.png"
    write(with_profile(pixels, profile("Adobe RGB")), pixels, path)
    return path, pixels


def test_before_and_after_are_shown_alike_and_saved_as_they_were(opened, wide, tmp_path):
    path, pixels = wide
    opened.open(path)
    hide_marks(opened)
    photo = opened.editor.document.pyramid
    before, after = photo.shown[0], opened.editor.view.frame.levels[0]
    assert apart(before, pixels, "Adobe RGB").max() < 1.0
    result = opened.rendered(pixels)
    assert apart(after, result, "Adobe RGB").max() < 1.0
    # Where nothing moves the two are the same on every level, so the difference is black there.
    changed = (result != pixels).any(axis=-1)
    assert changed.any()
    np.testing.assert_array_equal(before[~changed], after[~changed])
    # What is painted is that very picture, before and after.
    spot = QPointF(opened.canvas.to_screen(np.array([240.0, 280.0])))
    opened.canvas.zoom_to(7.0, spot)
    opened.settle()
    x, y = np.round(opened.canvas.to_photo(spot)).astype(int).tolist()
    seen = at(opened, x, y)
    np.testing.assert_array_equal(pixels_of(opened)[seen], after[y, x])
    opened.window.original_wanted.emit(True)
    np.testing.assert_array_equal(pixels_of(opened)[seen], before[y, x])
    opened.window.original_wanted.emit(False)
    # Saving knows nothing of the screen.
    opened.save(tmp_path / "copy.png")
    copy = read(tmp_path / "copy.png")
    np.testing.assert_array_equal(copy.pixels, result)
    assert copy.icc_profile == profile("Adobe RGB")


def test_a_gestures_preview_is_shown_alike():
    pixels = textured_photo(1500, 1100)
    wide = with_profile(pixels, profile("wide"))
    photo = PicturePyramid(pixels, screen_colours(wide).show)
    view = VisiblePart(1, Box(100, 50, 700, 500))
    frame = Surface(photo).render(1, State(faces=(oval_face(1500, 1100, size=0.45),)), view)
    stays = (frame.rendering.pixels == photo.levels[1][view.box.slices]).all(axis=-1)
    assert 0.1 < stays.mean() < 0.9
    np.testing.assert_array_equal(frame.levels[0][stays], photo.shown[1][view.box.slices][stays])
    assert apart(frame.levels[0], frame.rendering.pixels, "wide").max() < 1.0


def test_the_status_line_names_the_space(opened, wide, tmp_path):
    opened.open(wide[0])
    assert "Adobe RGB" in opened.window.status._photo.text()
    pixels = textured_photo()
    broken = tmp_path / "broken.png"
    write(with_profile(pixels, b"nonsense"), pixels, broken)
    opened.open(broken)
    assert "can't be used" in opened.window.status._photo.text()
    np.testing.assert_array_equal(opened.editor.document.pyramid.levels[0], pixels)


def test_thumbnails_are_shown_alike(tmp_path):
    pixels = np.full((40, 40, 3), (0, 200, 40), np.uint8)
    path = tmp_path / "green.png"
    write(with_profile(pixels, profile("Adobe RGB")), pixels, path)
    picture = thumbnail(path).picture.pixelColor(20, 20)
    shown = np.array([[picture.red(), picture.green(), picture.blue()]])
    assert apart(shown, pixels[:1, 0], "Adobe RGB").max() < 1.5


def test_the_thumbnail_of_a_png_that_names_pq_is_neither_grey_nor_flat(tmp_path):
    levels = np.array([0, 89, 148], np.uint8)  # 0, 18 and 203 cd/m² as PQ
    pixels = np.repeat(np.repeat(levels, 20)[None, :, None], 40, axis=0).repeat(3, axis=2)
    icc = profiles.of_name((9, 16), pixels)
    path = tmp_path / "pq.png"
    write(with_profile(pixels, icc), pixels, path)
    picture = thumbnail(path).picture
    seen = [picture.pixelColor(x, 20).red() for x in (10, 30, 50)]
    assert seen[0] < 10
    assert 75 < seen[1] < 95
    assert seen[2] > 250


@pytest.fixture
def moved(monkeypatch):
    """Puts the window on the screen of a profile; the next editor is on its own again."""

    def move(driver, icc):
        monkeypatch.setattr("kogao_app.features.screen.profile_of", lambda *_: icc)
        driver.window.windowHandle().screenChanged.emit(driver.window.screen())
        driver.settle()

    yield move
    use_screen(None)


def seen_on(shown: np.ndarray, name: str) -> np.ndarray:
    """Return what a screen of a space shows, as sRGB."""
    return expected_srgb(shown / 255.0, name)


def test_another_screen_shows_the_same_colours_and_nothing_else_changes(opened, moved, pixels):
    opened.change_something()
    opened.settle()
    opened.canvas.zoom_to(2.0)
    states, result = opened.editor.document.steps.states, opened.shown.copy()
    moved(opened, profile("Adobe RGB"))
    for shown, wanted in (
        (opened.editor.document.pyramid.shown[0], pixels),
        (opened.editor.view.frame.levels[0], result),
        (opened.window.original.photo.pyramid.shown[0], pixels),
    ):
        seen = lab_of_srgb(seen_on(shown, "Adobe RGB"))
        assert delta_e_2000(seen, lab_of_srgb(wanted / 255.0)).max() < ON_8_BITS
    assert opened.editor.document.steps.states == states
    assert opened.canvas.zoom == pytest.approx(2.0)
    np.testing.assert_array_equal(opened.shown, result)
    assert "Adobe RGB" in opened.window.status._photo.toolTip()
    for icc in (b"nonsense", profile("grey"), None):
        moved(opened, profile("Display P3"))
        moved(opened, icc)
        assert "taken to be sRGB" in opened.window.status._photo.toolTip()
        np.testing.assert_array_equal(opened.editor.view.frame.levels[0], result)


def test_a_photo_that_was_read_before_the_screen_was_known_is_shown_alike(opened, moved, photo):
    ahead = Ahead(photo)
    ahead.seek(KnownFaces())
    assert ahead.pyramid.result().show is None
    moved(opened, profile("Display P3"))
    opened.editor.files.open(photo, ahead)
    opened.settle()
    pyramid = opened.editor.document.pyramid
    seen = lab_of_srgb(seen_on(pyramid.shown[0], "Display P3"))
    assert delta_e_2000(seen, lab_of_srgb(pyramid.levels[0] / 255.0)).max() < ON_8_BITS


@pytest.mark.usefixtures("moved")
def test_thumbnails_and_grey_photos_follow_the_screen(tmp_path):
    assert use_screen(profile("Display P3"))
    pixels = np.full((40, 40, 3), (60, 180, 40), np.uint8)
    write(with_profile(pixels, None), pixels, tmp_path / "green.png")
    picture = thumbnail(tmp_path / "green.png").picture.pixelColor(20, 20)
    seen = seen_on(np.array([picture.red(), picture.green(), picture.blue()]), "Display P3")
    assert delta_e_2000(lab_of_srgb(seen), lab_of_srgb(pixels[0, 0] / 255.0)) < 1.5
    grey = with_profile(chart(np.uint8, 1), None)
    shown = pyramid_of(grey).shown[0]
    seen = lab_of_srgb(seen_on(shown, "Display P3"))
    wanted = lab_of_srgb(np.repeat(grey.pixels[..., None], 3, axis=-1) / 255.0)
    assert delta_e_2000(seen, wanted).max() < 1.0
