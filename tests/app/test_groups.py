"""Groups of people: who is made smaller, who starts switched off and why, and finding one's way."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from PySide6.QtCore import Qt
from scenes import oval_face

KEYS = Qt.Key
CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def unsure(start, source, photo):
    """A photo with two faces, of which the source is sure of the first one only."""
    sure = [oval_face(center=(x, 170), size=0.45) for x in (120, 350)]
    scores = (0.9, 0.43)
    source.faces = [
        dataclasses.replace(face, score=score, source="mesh")
        for face, score in zip(sure, scores, strict=True)
    ]
    driver = start()
    driver.open(photo)
    return driver


def test_an_unsure_face_of_a_group_starts_switched_off_and_its_row_says_why(unsure):
    assert unsure.state.off == {1}
    assert unsure.editor.document.saved
    row = unsure.panel("faces").item(1)
    assert row.checkState() == Qt.CheckState.Unchecked
    assert row.text() == "Face 2\n43 %\nunsure"
    assert "starts switched off: it is 43 % sure that this is a face" in row.toolTip()
    assert row.data(Qt.ItemDataRole.AccessibleTextRole) == "Face 2, 43 %, unsure"
    assert "off" not in unsure.panel("faces").item(0).toolTip()


def test_an_unsure_face_that_is_switched_on_comes_back_off_when_faces_are_found_again(unsure):
    unsure.panel("faces").item(1).setCheckState(Qt.CheckState.Checked)
    assert unsure.state.off == frozenset()
    unsure.key(KEYS.Key_F, CONTROL)
    unsure.settle()
    assert unsure.state.off == {1}


def test_the_only_face_of_a_photo_is_on_however_unsure(start, source, photo):
    source.faces = [dataclasses.replace(oval_face(), score=0.43, source="mesh")]
    driver = start()
    driver.open(photo)
    assert driver.state.off == frozenset()
    assert driver.panel("faces").item(0).text() == "Face 1\n43 %"


@pytest.fixture
def thirty(start, source, photo):
    """A photo with 30 small faces, of which none shows more than a few of its landmarks."""
    places = [(40 + 44 * column, 50 + 110 * row) for row in range(3) for column in range(10)]
    hidden = np.full(27, 0.4)
    source.faces = [
        dataclasses.replace(oval_face(center=at, size=0.1), source="mesh", confidence=hidden)
        for at in places
    ]
    driver = start()
    driver.open(photo)
    return driver


def test_no_row_of_thirty_faces_is_cut(thirty):
    rows = thirty.panel("faces").list
    assert rows.verticalScrollBar().isVisible()
    assert rows.item(30).text() == "Face 30\n100 %\nhidden"
    assert rows.sizeHintForColumn(0) <= rows.viewport().width()


def test_the_list_scrolls_to_a_face_that_is_selected_in_the_photo(thirty):
    rows = thirty.panel("faces").list
    for face in (29, 0):
        thirty.click(thirty.canvas.to_screen(thirty.state.faces[face].eye_center).toPoint())
        assert thirty.editor.view.face == face
        assert rows.viewport().rect().contains(rows.visualItemRect(rows.item(face + 1)))
