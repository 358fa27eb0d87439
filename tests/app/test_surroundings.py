"""The window's bend meter is the command line's, and people are shown as its network sees them."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from kogao_app.__main__ import main
from PySide6.QtCore import Qt
from test_overlays import at, hide_marks, pixels_of
from test_saved_projects import save_project

from kogao_core import background, cli
from kogao_core.assets import AssetMissing
from kogao_core.geometry import Affine
from kogao_core.person import PersonLook, PersonMask
from kogao_core.sidecar import sidecar_of

KEYS = Qt.Key
WIDTH, HEIGHT = 960, 720  # of the photo with the door
SHOULDERS = 420  # everybody is below this row


class Finder:
    """Stands in for the network: people are where it is told."""

    def __init__(self):
        self.opacity = np.zeros((WIDTH, WIDTH), np.float32)
        self.opacity[SHOULDERS:HEIGHT] = 1.0

    def find(self, _photo, faces):
        if self.opacity is None:
            raise AssetMissing("selfie_segmentation.tflite isn't here; fetch it")
        still = Affine.similarity(1.0, 0.0, (0.0, 0.0))
        return (
            PersonMask((PersonLook(self.opacity, still, 1.0),), 0, (0,)) if faces else PersonMask()
        )


@pytest.fixture
def finder(monkeypatch):
    """What tells people apart, in the window and on the command line."""
    made = Finder()
    monkeypatch.setattr(background, "PersonFinder", lambda: made)
    return made


def make_smaller(driver, percent):
    recipe = dataclasses.replace(driver.state.recipe, percent=percent)
    driver.editor.document.step(dataclasses.replace(driver.state, recipe=recipe), "Warp")
    driver.settle()


def lines_on_the_command_line(photo, told):
    out = told.with_name("out.png")
    words = ["warp", photo, "-o", out, "--project", sidecar_of(photo), "--json", told]
    with pytest.raises(SystemExit) as ended:
        cli.main([str(word) for word in words])
    assert not ended.value.code
    return json.loads(told.read_text(encoding="utf-8"))["lines"]


@pytest.mark.usefixtures("finder")
def test_window_and_command_line_name_the_same_lines(empty, door, tmp_path):
    path, _ = door
    empty.key(KEYS.Key_S)
    empty.open(path)
    make_smaller(empty, 9.0)
    shown = [dataclasses.asdict(line) for line in empty.editor.view.lines]
    worst = max(shown, key=lambda line: line["unheld_px"])
    assert worst["unheld_px"] > 1.0 > 2.0 * worst["bend_px"]
    assert worst["holding"] == "held"
    assert all(max(line["start_px"][1], line["end_px"][1]) < SHOULDERS for line in shown)
    save_project(empty)
    assert lines_on_the_command_line(path, tmp_path / "told.json") == json.loads(json.dumps(shown))


@pytest.mark.usefixtures("finder")
def test_people_are_tinted_where_they_are_and_nowhere_else(empty, door):
    path, _ = door
    empty.open(path)
    hide_marks(empty)
    bare = pixels_of(empty)
    empty.key(KEYS.Key_U)
    empty.settle()
    tinted = pixels_of(empty)
    green = at(empty, 100, SHOULDERS + 100)
    assert tinted[green][1] - bare[green][1] > tinted[green][0] - bare[green][0] + 20
    left, right = at(empty, 0, SHOULDERS - 10), at(empty, WIDTH - 1, SHOULDERS - 10)
    above = np.s_[: left[0], left[1] : right[1]]
    np.testing.assert_array_equal(tinted[above], bare[above])


def test_without_the_network_it_is_said_once_and_lines_count_as_before(finder, empty, door):
    path, _ = door
    finder.opacity = None
    said = []
    empty.editor.surroundings.message.connect(said.append)
    empty.key(KEYS.Key_S)
    empty.key(KEYS.Key_U)
    empty.open(path)
    assert "kogao-cli doctor" in empty.say()
    make_smaller(empty, 9.0)
    assert empty.editor.view.lines
    assert empty.editor.view.people is None
    assert len(said) == 1
    assert not said[0].wrong


@pytest.mark.usefixtures("finder")
def test_where_no_face_is_there_is_nobody_to_tell_apart(empty, door, source):
    path, _ = door
    source.faces = []
    said = []
    empty.editor.surroundings.message.connect(said.append)
    empty.key(KEYS.Key_S)
    empty.open(path)
    assert not said
    assert not empty.editor.view.lines


@pytest.mark.usefixtures("qapp")
def test_a_picture_is_taken_without_the_network(finder, source, door, tmp_path):
    path, _ = door
    finder.opacity = None
    shot = tmp_path / "shot.png"
    arguments = [str(path), "--screenshot", str(shot), "--show", "straight,people"]
    assert main(arguments, source) == 0
    assert shot.is_file()
