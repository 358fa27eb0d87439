"""The window's meter of lines is the command line's."""

import dataclasses
import json

import numpy as np
import pytest
from kogao_app.__main__ import main
from PySide6.QtCore import Qt
from test_overlays import hide_marks

from kogao_core import cli
from kogao_core.background import find as background
from kogao_core.background.people import PersonLook, PersonMask
from kogao_core.base.assets import AssetMissing
from kogao_core.base.geometry import Affine
from kogao_core.projects.edits import sidecar_of
from kogao_core.projects.project import load

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
    empty.edit(6.0)
    shown = [dataclasses.asdict(line) for line in empty.editor.view.lines]
    worst = max(shown, key=lambda line: line["unheld_turn_degrees"])
    assert worst["unheld_turn_degrees"] > 2.0 * worst["turn_degrees"] > 0.0
    assert worst["holding"] == "held"
    assert all(max(line["start_px"][1], line["end_px"][1]) < SHOULDERS for line in shown)
    empty.settle()
    assert lines_on_the_command_line(path, tmp_path / "told.json") == json.loads(json.dumps(shown))


def test_without_the_network_it_is_said_once_and_lines_count_as_before(finder, empty, door):
    path, _ = door
    finder.opacity = None
    said = []
    empty.editor.surroundings.message.connect(said.append)
    empty.key(KEYS.Key_S)
    empty.open(path)
    assert "kogao-cli doctor" in empty.say()
    empty.edit(6.0)
    assert empty.editor.view.lines
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
    arguments = [str(path), "--screenshot", str(shot), "--show", "straight"]
    assert main(arguments, source) == 0
    assert shot.is_file()


def held_line(driver):
    return max(driver.editor.view.lines, key=lambda line: line.unheld_turn_degrees)


@pytest.mark.usefixtures("finder")
def test_lines_are_let_go_and_held_one_by_one_and_all_and_the_project_carries_it(empty, door):
    path, _ = door
    empty.open(path)
    hide_marks(empty)
    empty.key(KEYS.Key_S)
    empty.edit(6.0)
    line = held_line(empty)
    assert (line.holding, line.turn_degrees < 1.5) == ("held", True)
    middle = np.mean([line.start_px, line.end_px], axis=0)
    for holding, turns, text in (("let go", True, "Let a line go"), ("held", False, "Hold a line")):
        empty.click(empty.canvas.to_screen(middle).toPoint())
        empty.settle()
        clicked = min(
            empty.editor.view.lines, key=lambda one: abs(one.start_px[0] - line.start_px[0])
        )
        assert (clicked.holding, clicked.turn_degrees > 1.5) == (holding, turns)
        assert empty.editor.document.undo.undoText() == text
    empty.window.actions_by_name["lines-go"].trigger()
    empty.settle()
    assert {line.holding for line in empty.editor.view.lines} == {"let go"}
    free = held_line(empty)
    assert free.turn_degrees == pytest.approx(free.unheld_turn_degrees, rel=0.01)
    assert free.turn_degrees > 1.5
    empty.settle()
    loose = empty.state.loose
    assert np.array(load(sidecar_of(path)).loose) == pytest.approx(np.array(loose))
    empty.window.actions_by_name["lines-hold"].trigger()
    empty.settle()
    assert {line.holding for line in empty.editor.view.lines} == {"held"}
    assert held_line(empty).turn_degrees < 1.5


def bend(along, across):
    """How far a move across a line departs from a shift and a turn."""
    return np.abs(across - np.polyval(np.polyfit(along, across, 1), along)).max()


@pytest.mark.usefixtures("finder")
def test_a_preview_holds_what_the_whole_photo_does(empty, door):
    path, x = door
    empty.open(path)
    empty.edit(6.0)
    whole = empty.editor.view.frame
    recipe = dataclasses.replace(empty.state.recipe, percent=8.9)
    drawn = empty.drawn()
    empty.pause_never()
    empty.editor.document.preview(dataclasses.replace(empty.state, recipe=recipe), "Warp")
    empty.qtbot.waitUntil(lambda: bool(drawn))
    assert not drawn[0].whole
    rows = np.linspace(100.0, SHOULDERS - 40.0, 40)
    points = np.column_stack([np.full(40, float(x)), rows])
    to_photo = drawn[0].to_photo
    across = drawn[0].rendering.field.at(to_photo.inverse(points))[:, 0] * to_photo.scale
    free = whole.rendering.unheld.at(points)[:, 0]
    assert bend(rows, free) > 1.0
    assert bend(rows, across) < 0.3
