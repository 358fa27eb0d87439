"""What saving says it kept, and what saved copies tell of themselves."""

from __future__ import annotations

import cv2
import metadata_cases
import numpy as np
import pytest
from kogao_app.features.files.options import SavingDialog
from PIL import Image
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialogButtonBox
from scenes import oval_face, textured_photo

from kogao_core.photo import has_gain_map, read
from kogao_core.photo.disclosure import label

CONTROL, ALT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.AltModifier


@pytest.fixture
def jpeg(tmp_path):
    path = tmp_path / "portrait.jpg"
    Image.fromarray(textured_photo()).save(path, quality=90)
    return path


def save(driver, path):
    driver.editor.files.save(path)
    driver.settle()


def options(driver):
    driver.key(Qt.Key.Key_O, CONTROL, ALT)
    return driver.dialog(SavingDialog)


def accept(box):
    ok = box.buttons.button(QDialogButtonBox.StandardButton.Ok)
    QTest.mouseClick(ok, Qt.MouseButton.LeftButton)


def test_saving_says_what_was_kept_of_a_jpeg(empty, jpeg, tmp_path):
    empty.open(jpeg)
    save(empty, tmp_path / "copy.jpg")
    assert empty.say().startswith(f"Saved copy.jpg in {tmp_path}. ")
    assert "blocks" in empty.say()
    save(empty, tmp_path / "copy.png")
    assert empty.say() == f"Saved copy.png in {tmp_path}."


def test_an_hdr_photo_is_called_one_and_its_copy_is_one(empty, jpeg, tmp_path):
    empty.open(jpeg)
    assert "HDR" not in empty.window.status._photo.text()
    more = metadata_cases.gain_map(metadata_cases.packet('hdrgm:Version="1.0"'))
    jpeg.write_bytes(jpeg.read_bytes() + more)
    empty.open(jpeg)
    assert empty.window.status._photo.text().endswith(" · HDR")
    save(empty, tmp_path / "copy.jpg")
    assert "ot kept" not in empty.say()
    assert has_gain_map(read(tmp_path / "copy.jpg"))
    save(empty, tmp_path / "copy.png")
    assert empty.say().endswith(". Not kept: the HDR gain map.")


def test_saving_names_what_a_copy_does_not_keep(empty, jpeg, tmp_path):
    jpeg.write_bytes(jpeg.read_bytes() + metadata_cases.MP4)
    empty.open(jpeg)
    assert "notes: 1" in empty.window.status._photo.text()
    notes = empty.window.status._photo.toolTip().splitlines()
    assert notes[0] == "not kept: the motion photo's video"
    save(empty, tmp_path / "copy.png")
    assert empty.say() == f"Saved copy.png in {tmp_path}. Not kept: the motion photo's video."


def test_blocks_are_those_of_the_open_photo(empty, jpeg, tmp_path):
    other = tmp_path / "other.jpg"
    Image.fromarray(textured_photo(seed=5)).save(other, quality=70)
    empty.open(jpeg)
    empty.open(other)
    save(empty, tmp_path / "copy.jpg")
    source, copy = read(other), read(tmp_path / "copy.jpg")
    np.testing.assert_array_equal(copy.pixels[:16, :16], source.pixels[:16, :16])
    assert copy.jpeg.tables == source.jpeg.tables


def test_nothing_is_told_unless_it_is_wanted(empty, jpeg, tmp_path):
    empty.open(jpeg)
    box = options(empty)
    assert not box.record.isChecked()
    assert not box.labelled.isChecked()
    box.reject()
    save(empty, tmp_path / "copy.png")
    copy = read(tmp_path / "copy.png")
    assert copy.xmp is None
    np.testing.assert_array_equal(copy.pixels, empty.shown)


def test_a_record_and_a_label_are_told_and_remembered(empty, start, jpeg, tmp_path):
    empty.open(jpeg)
    box = options(empty)
    QTest.keyClick(box.record, Qt.Key.Key_Space)
    QTest.keyClick(box.labelled, Qt.Key.Key_Space)
    box.label.setText("retouched by hand")
    accept(box)
    empty.change_something()
    save(empty, tmp_path / "copy.png")
    copy = read(tmp_path / "copy.png")
    assert b"Kogao" in copy.xmp
    changed = np.argwhere((copy.pixels != empty.shown).any(axis=-1))
    assert len(changed)
    top, left = changed.min(axis=0)
    assert top > 0.9 * empty.shown.shape[0]
    assert left > 0
    other = start()
    box = options(other)
    assert box.record.isChecked()
    assert box.label.text() == "retouched by hand"


@pytest.fixture
def mark(tmp_path):
    path = tmp_path / "mark.png"
    Image.new("RGB", (30, 30), "red").save(path)
    return path


def want_picture(box, mark):
    QTest.keyClick(box.pictured, Qt.Key.Key_Space)
    box.picture.line.setText(str(mark))
    box.corner.setCurrentIndex(box.corner.findData("bottom-left"))
    box.share.setValue(10)
    accept(box)


def test_a_picture_is_laid_over_copies_and_remembered(empty, start, jpeg, tmp_path, mark):
    empty.open(jpeg)
    box = options(empty)
    assert not box.pictured.isChecked()
    assert not box.corner.isEnabled()
    want_picture(box, mark)
    empty.change_something()
    save(empty, tmp_path / "copy.png")
    red = (read(tmp_path / "copy.png").pixels == [255, 0, 0]).all(axis=2)
    rows, columns = np.nonzero(red)
    assert (rows.max(), columns.min()) == (red.shape[0] - 1, 0)
    assert red.mean() == pytest.approx(0.1, abs=0.01)
    box = options(start())
    assert (box.pictured.isChecked(), box.picture.path) == (True, str(mark))
    assert (box.corner.currentData(), box.share.value()) == ("bottom-left", 10)


def test_a_copy_is_signed_by_the_users_own_certificate(empty, start, jpeg, tmp_path):
    from signers import Person  # or skips

    person = Person(tmp_path / "person")
    empty.open(jpeg)
    box = options(empty)
    QTest.keyClick(box.signed, Qt.Key.Key_Space)
    box.certificate.line.setText(person.certificate)
    box.key.line.setText(person.certificate)
    accept(box)
    assert "holds no private key" in box.note.text()
    box.key.line.setText(person.key_file)
    accept(box)
    assert not box.isVisible()
    empty.change_something()
    save(empty, tmp_path / "copy.jpg")
    assert "signed, with the photo as its source" in empty.say()
    assert person.told(tmp_path / "copy.jpg")[0] == "Trusted"
    box = options(start())
    assert (box.signed.isChecked(), box.key.path) == (True, person.key_file)


def test_a_picture_that_cant_be_read_is_said_at_once(empty, tmp_path):
    box = options(empty)
    want_picture(box, tmp_path / "none.png")
    assert box.isVisible()
    assert "none.png doesn't exist" in box.note.text()


def test_a_label_that_cannot_be_drawn_is_said_at_once(empty, monkeypatch):
    monkeypatch.setattr(label, "_OF_SYSTEM", ("missing.ttf",))
    box = options(empty)
    QTest.keyClick(box.labelled, Qt.Key.Key_Space)
    box.label.setText("加工")
    accept(box)
    assert box.isVisible()
    assert box.note.text()
    box.label.setText("retouched")
    accept(box)
    assert not box.isVisible()


def test_a_photo_too_small_for_its_label_leads_to_the_options(empty, source, tmp_path):
    source.faces = [oval_face(120, 90)]
    box = options(empty)
    QTest.keyClick(box.labelled, Qt.Key.Key_Space)
    box.label.setText("x" * 100)
    accept(box)
    path = tmp_path / "portrait.png"
    assert cv2.imwrite(str(path), textured_photo(120, 90)[..., ::-1])
    empty.open(path)
    save(empty, tmp_path / "copy.png")
    assert not (tmp_path / "copy.png").exists()
    empty.take_step("Save options")
    assert empty.dialog(SavingDialog).isVisible()
