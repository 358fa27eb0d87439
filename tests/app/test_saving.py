"""What saving says it kept, and what saved copies tell of themselves."""

import cv2
import metadata_cases
import numpy as np
import pytest
from kogao_app.features.preferences import PreferencesDialog
from kogao_app.widgets.controls import Fold
from kogao_app.widgets.form import Form
from PIL import Image
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel
from scenes import oval_face, textured_photo

from kogao_core.photo import has_gain_map, read
from kogao_core.photo.disclosure import label

pytestmark = pytest.mark.usefixtures("one_window")

CONTROL = Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def jpeg(tmp_path):
    path = tmp_path / "portrait.jpg"
    Image.fromarray(textured_photo()).save(path, quality=90)
    return path


class Options:
    """The page of the preferences on what saved files contain."""

    def __init__(self, driver):
        driver.key(Qt.Key.Key_Comma, CONTROL)
        self.dialog = driver.dialog(PreferencesDialog)
        fold = next(one for one in self.dialog.findChildren(Fold) if one.findChild(Form))
        fold.button.setChecked(True)
        self.form = fold.findChild(Form)
        self.note = self.form.parentWidget().findChildren(QLabel)[-1]
        self.values = self.form.values

    def set(self, **values):
        self.form.show_values(values)


def test_saving_says_what_was_kept_of_a_jpeg(opened, jpeg, tmp_path):
    opened.open(jpeg)
    opened.save(tmp_path / "copy.jpg")
    assert opened.say().startswith(f"Saved copy.jpg in {tmp_path}. ")
    assert "of the JPEG unchanged" in opened.say()
    opened.save(tmp_path / "copy.png")
    assert opened.say() == f"Saved copy.png in {tmp_path}."


def test_an_hdr_photo_is_called_one_and_its_copy_is_one(opened, jpeg, tmp_path):
    opened.open(jpeg)
    assert "HDR" not in opened.window.status._photo.text()
    more = metadata_cases.gain_map(metadata_cases.packet('hdrgm:Version="1.0"'))
    jpeg.write_bytes(jpeg.read_bytes() + more)
    opened.open(jpeg)
    assert opened.window.status._photo.text().endswith(" · HDR: the gain map stays")
    opened.save(tmp_path / "copy.jpg")
    assert "ot kept" not in opened.say()
    assert has_gain_map(read(tmp_path / "copy.jpg"))
    opened.save(tmp_path / "copy.png")
    assert opened.say().endswith(". Not kept: the HDR gain map.")
    for brightest, text in ((4.0, " · 32-bit · HDR: values above white stay"), (1.0, " · 32-bit")):
        pixels = brightest * read(jpeg).pixels[..., ::-1].astype(np.float32) / 255.0
        assert cv2.imwrite(str(tmp_path / "f.tif"), pixels)
        opened.open(tmp_path / "f.tif")
        assert opened.window.status._photo.text().partition(" · notes")[0].endswith(text)


def test_saving_names_what_a_copy_does_not_keep(opened, jpeg, tmp_path):
    jpeg.write_bytes(jpeg.read_bytes() + metadata_cases.MP4)
    opened.open(jpeg)
    assert "notes: 1" in opened.window.status._photo.text()
    notes = opened.window.status._photo.toolTip().splitlines()
    assert notes[0] == "not kept: the motion photo's video"
    opened.save(tmp_path / "copy.png")
    assert opened.say() == f"Saved copy.png in {tmp_path}. Not kept: the motion photo's video."


def test_blocks_are_those_of_the_open_photo(opened, jpeg, tmp_path):
    other = tmp_path / "other.jpg"
    Image.fromarray(textured_photo(seed=5)).save(other, quality=70)
    opened.open(jpeg)
    opened.open(other)
    opened.save(tmp_path / "copy.jpg")
    source, copy = read(other), read(tmp_path / "copy.jpg")
    np.testing.assert_array_equal(copy.pixels[:16, :16], source.pixels[:16, :16])
    assert copy.jpeg.tables == source.jpeg.tables


def test_nothing_is_disclosed_by_default(opened, jpeg, tmp_path):
    opened.open(jpeg)
    now = Options(opened).values()
    assert not any(now[name] for name in ("record", "labelled", "film"))
    opened.save(tmp_path / "copy.png")
    copy = read(tmp_path / "copy.png")
    assert copy.xmp is None
    np.testing.assert_array_equal(copy.pixels, opened.shown)


def test_a_record_and_a_label_are_written_and_remembered(start, jpeg, tmp_path):
    opened = start()
    opened.open(jpeg)
    options = Options(opened)
    options.set(record=True, labelled=True, label="retouched by hand")
    options.dialog.close()
    opened.change_something()
    opened.save(tmp_path / "copy.png")
    copy = read(tmp_path / "copy.png")
    assert b"Kogao" in copy.xmp
    changed = np.argwhere((copy.pixels != opened.shown).any(axis=-1))
    assert len(changed)
    top, left = changed.min(axis=0)
    assert top > 0.9 * opened.shown.shape[0]
    assert left > 0
    now = Options(start()).values()
    assert (now["record"], now["label"]) == (True, "retouched by hand")


def test_options_that_cannot_work_are_named_at_once(opened, monkeypatch):
    options = Options(opened)
    monkeypatch.setattr(label, "_OF_SYSTEM", ("missing.ttf",))
    options.set(labelled=True, label="加工")
    assert options.note.text()
    options.set(label="retouched")
    assert not options.note.text()


def test_a_photo_too_small_for_its_label_leads_to_the_options(opened, source, tmp_path):
    source.faces = [oval_face(120, 90)]
    options = Options(opened)
    options.set(labelled=True, label="x" * 100)
    options.dialog.close()
    path = tmp_path / "portrait.png"
    assert cv2.imwrite(str(path), textured_photo(120, 90)[..., ::-1])
    opened.open(path)
    opened.save(tmp_path / "copy.png")
    assert not (tmp_path / "copy.png").exists()
    opened.take_step("Preferences")
    assert opened.dialog(PreferencesDialog).isVisible()
