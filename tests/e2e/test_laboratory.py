"""The laboratory has one door: with its folder taken away everything else works."""

import os
import shutil
import subprocess
import sys

import cv2
import pytest
from modules import ROOT, modules

LABORATORY = "kogao_core.lab"


@pytest.fixture(scope="module")
def without(tmp_path_factory):
    """Run a program without the laboratory and a display; return what it prints."""
    place = tmp_path_factory.mktemp("without")
    for here, there in (
        ("kogao_core",) * 2,
        ("app", "kogao_app"),
        ("resources", "kogao_resources"),
    ):
        shutil.copytree(ROOT / here, place / there)
    shutil.rmtree(place / "kogao_core" / "lab")
    outside = {"PYTHONPATH": str(place), "HOME": str(place)}
    screens = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
    surroundings = {name: value for name, value in os.environ.items() if name not in screens}

    def run(*arguments, code=0):
        done = subprocess.run(
            [sys.executable, *map(str, arguments)],
            cwd=place, env=surroundings | outside, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == code, done.stderr
        return done.stdout + done.stderr

    return run


PROGRAM = ("-c", "from kogao_core.cli import main; main()")


def test_the_core_is_the_one_without(without):
    every = (
        "import pkgutil, importlib, kogao_core; "
        "[importlib.import_module(m.name) for m in pkgutil.walk_packages("
        "kogao_core.__path__, 'kogao_core.') if not m.name.endswith('__main__')]; "
        "print(kogao_core.__path__[0])"
    )
    assert "without" in without("-c", every)


def test_the_command_line_offers_no_experiment_and_warps(without, small_png, tmp_path):
    assert "experiment" not in without(*PROGRAM, "--help")
    assert "no command 'experiment'" in without(*PROGRAM, "experiment", code=2)
    without(*PROGRAM, "warp", small_png, "-o", tmp_path / "small.png")
    assert (tmp_path / "small.png").is_file()
    without(*PROGRAM, "batch", small_png, "-o", tmp_path / "out", "--jobs", "1")
    assert len(list((tmp_path / "out").glob("*.*"))) >= 1


def test_a_picture_of_the_window_needs_neither_it_nor_a_display(without, small_png, tmp_path):
    window = ("-c", "import sys; from kogao_app.__main__ import main; sys.exit(main())")
    without(*window, small_png, "--screenshot", tmp_path / "window.png")
    assert cv2.imread(str(tmp_path / "window.png")) is not None


def test_nothing_but_the_door_knows_it():
    """Of the core nothing imports it; of the editor the folder that its door alone opens."""
    knowing, opening = set(), set()
    for package, top in (("kogao_core", ROOT), ("app", ROOT), ("resources", ROOT)):
        for name, path in modules(package, top).items():
            if name.startswith(LABORATORY):
                continue
            text = path.read_text(encoding="utf-8")
            if LABORATORY in text:
                knowing.add(name)
            if "features.experiments" in text:
                opening.add(name)
    assert {name for name in knowing if not name.startswith("app.features.experiments")} == {
        "kogao_core.base.installed",
        "kogao_core.cli.declarations",
    }
    assert opening == {"app.editor"}
