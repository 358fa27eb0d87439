"""``kogao --screenshot`` and its exit codes."""

import dataclasses
import re
import sys
import threading

import cv2
import pytest
from kogao_app.__main__ import main
from kogao_app.editor import Editor
from kogao_app.start import Screenshot
from scenes import oval_face
from timeouts import LONGEST_S

from kogao_core.recipe import presets
from kogao_core.recipe.recipe import PAPER, Recipe

pytestmark = pytest.mark.usefixtures("qapp")


@pytest.fixture
def shot(tmp_path):
    return tmp_path / "window.png"


def run(source, *arguments):
    return main([str(argument) for argument in arguments], source)


def test_a_photo_that_is_named_is_read_and_searched_ahead_of_the_window_and_only_once(
    source, photo, shot, monkeypatch
):
    monkeypatch.setattr("kogao_app.features.files.opening.read", fail)
    monkeypatch.setattr("kogao_app.features.files.opening.pyramid_of", fail)
    searched, begun = [], threading.Event()

    def find(*given):
        searched.append(given)
        begun.set()
        return type(source).find(source, *given)

    class Late(Editor):
        def __init__(self, *given):
            assert begun.wait(LONGEST_S)
            super().__init__(*given)

    monkeypatch.setattr(source, "find", find)
    monkeypatch.setattr("kogao_app.start.Editor", Late)
    assert run(source, photo, "--screenshot", shot) == 0
    assert shot.is_file()
    assert len(searched) == 1


def test_a_face_of_few_points_is_pictured(source, photo, shot):
    face = oval_face()
    source.faces = [dataclasses.replace(face, outline=face.outline[::7])]
    assert run(source, photo, "--screenshot", shot, "--show", "loupe") == 0


def test_a_picture_shows_what_is_asked_for_and_leaves_nothing_beside_the_photo(source, photo):
    before, shots = set(photo.parent.iterdir()), {}
    common = ("--amount", 9, "--size", "1000x700", "--theme", "light")
    for name, *more in (
        ("landmarks",), ("heat",), ("wipe,loupe",), ("heat", "--protect", "310,100 310,260"),
    ):  # fmt: skip
        path = photo.with_name(f"{len(shots)}.png")
        assert run(source, photo, "--screenshot", path, "--show", name, *common, *more) == 0
        shots[name, *more] = cv2.imread(str(path))
        before.add(path)
    assert set(photo.parent.iterdir()) == before
    assert {shot.shape for shot in shots.values()} == {(700, 1000, 3)}
    assert len({shot.tobytes() for shot in shots.values()}) == len(shots)
    canvas = slice(100, 500), slice(200, 900)
    # The photo's own noise has some of the landmarks' blue, too.
    blue = {
        name: (abs(shots[name,][canvas].astype(int) - (233, 180, 86)).max(axis=2) < 24).sum()
        for name in ("landmarks", "heat")
    }
    assert blue["landmarks"] > 2 * blue["heat"]


def test_a_picture_takes_all_settings_of_warp(source, photo, shot, tmp_path, monkeypatch):
    taken, file = [], tmp_path / "recipe.json"
    presets.write(PAPER, file)
    monkeypatch.setattr(
        Screenshot, "finish", lambda shot: taken.append(shot._editor.document.state.recipe) or 0
    )
    for settings in (("--recipe", file, "--lattice", 0.25), ("--jaw-width", -4)):
        assert run(source, photo, "--screenshot", shot, *settings) == 0
    assert taken == [dataclasses.replace(PAPER, lattice=0.25), Recipe(jaw_width=-4.0)]


@pytest.mark.parametrize(
    ("code", "name", "more", "said"),
    [
        (3, "none.jpg", (), "none"),
        # Windows says in its own words that there is no such file.
        (3, "x" * 300, (), "xxx" if sys.platform == "win32" else r"\(File name too long\)"),
        (2, "portrait.png", ("--protect", "1e9,0 1e9,10"), "protected line 1"),
    ],
)
def test_what_shows_no_window_ends_with_one_line(
    source, photo, shot, capsys, code, name, more, said
):
    assert run(source, photo.with_name(name), *more, "--screenshot", shot) == code
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert re.search(said, line)
    assert not shot.exists()


@pytest.mark.parametrize(
    ("code", "fails", "said"),
    [(4, False, "no face"), (1, True, "no face was found: there is not enough memory")],
)
def test_without_a_face_the_window_is_still_shown(
    source, photo, shot, capsys, monkeypatch, code, fails, said
):
    monkeypatch.setattr(source, *(("find", fail) if fails else ("faces", [])))
    assert run(source, photo, "--screenshot", shot) == code
    assert said in capsys.readouterr().err
    assert shot.is_file()


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX files")
def test_a_picture_replaces_only_files(source, photo, tmp_path, device, capsys):
    link = tmp_path / "window.png"
    link.symlink_to(device)
    assert run(source, photo, "--screenshot", link) == 3
    assert "it is a folder, pipe or device" in capsys.readouterr().err
    assert device.is_char_device()


def test_a_picture_that_cannot_be_written_ends_with_3(source, photo, tmp_path, capsys):
    assert run(source, photo, "--screenshot", tmp_path / "nowhere" / "window.png") == 3
    assert "can't be written" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        (
            "kogao_app.render.live.render",
            "portrait.png can't be rendered: there is not enough memory",
        ),
        ("kogao_app.features.overlays.measure", "The background can't be measured"),
        ("kogao_app.start.Screenshot._edit", "something went wrong in the program itself"),
    ],
)
def test_what_cannot_be_drawn_ends_with_1_and_a_sentence(
    source, photo, shot, capsys, monkeypatch, qtbot, broken, said
):
    monkeypatch.setattr(broken, fail)
    with qtbot.captureExceptions():
        assert run(source, photo, "--screenshot", shot, "--show", "straight") == 1
    assert said in capsys.readouterr().err.splitlines()[-1]
    assert not shot.exists()


def fail(*_, **__):
    raise MemoryError


@pytest.mark.parametrize(
    "wrong",
    [
        ["--size", "big"],
        ["--theme", "pink"],
        ["a.jpg", "--sample"],
        ["--show", "nothing"],
        ["--protect", "1,2"],
        ["--protect", "1,2 nan,3"],
        ["--amount", "nan"],
        ["--amount", "16"],
        ["--sample", "--show", "lattice"],
        ["--sample", "--protect", "80,40 80,600"],
        ["--sample", "--amount", "4"],
        ["--sample", "--screenshot", "a.png", "--recipe", "none.json"],
    ],
)
def test_a_wrong_call_ends_with_2(source, wrong, capsys):
    with pytest.raises(SystemExit) as stop:
        run(source, *wrong)
    assert stop.value.code == 2
    assert re.fullmatch(r"kogao: [^\n]+ \(see kogao --help\)\n", capsys.readouterr().err)
