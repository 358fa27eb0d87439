"""Where something lacks that the programs need: a sentence that says what to do, and its code."""

import os
import subprocess
import sys

import pytest
from few_cases import few_of

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
EDITOR = "from kogao_app.__main__ import main; sys.exit(main(sys.argv[1:]))"
CLI = "from kogao_core.cli import main; main(sys.argv[1:])"
# The system's libraries are all there but one, whatever the machine has that runs this.
LIBRARY = "from kogao_core.base import installed; installed._loads = lambda name: name != '{}'; "
ALL_LIBRARIES = LIBRARY.format("")

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Qt's libraries of Linux")


def start(program, *arguments, **named):
    """Run a program in a Python of its own, without a screen."""
    environment = {name: value for name, value in os.environ.items() if name not in SCREENS}
    return subprocess.run(
        [sys.executable, "-c", f"import sys; {program}", *map(str, arguments)],
        env=environment | {name: str(value) for name, value in named.items()},
        capture_output=True, text=True,
    )  # fmt: skip


def ends_in_a_sentence(done, *words):
    """Whether a program has ended with 1 and one line that has all of some words."""
    assert done.returncode == 1, done.stderr
    (line,) = done.stderr.splitlines()
    assert all(word in line for word in words), line


@pytest.mark.parametrize(
    ("arguments", "screen"),
    [
        ([], {}),
        (["--sample"], {"DISPLAY": ":7654"}),
        (["--edit", "a.jpg"], {"WAYLAND_DISPLAY": "nobodys", "XDG_RUNTIME_DIR": "/tmp"}),
    ],
)
def test_the_editor_says_that_there_is_no_display(arguments, screen):
    done = start(ALL_LIBRARIES + EDITOR, *arguments, **screen)
    ends_in_a_sentence(done, "no display", "kogao-cli")


def test_the_editor_names_the_library_that_lacks_and_its_package():
    done = start(LIBRARY.format("libxcb-cursor.so.0") + EDITOR, "--sample", DISPLAY=":7654")
    ends_in_a_sentence(done, "libxcb-cursor.so.0", "apt-get install libxcb-cursor0")


def test_a_picture_of_the_window_needs_the_library_that_is_named(tmp_path):
    (tmp_path / "PySide6.py").write_text('raise ImportError("libEGL.so.1: cannot open it")')
    shot = "--sample", "--screenshot", tmp_path / "window.png"
    done = start(LIBRARY.format("libEGL.so.1") + EDITOR, *shot, PYTHONPATH=tmp_path)
    ends_in_a_sentence(done, "libEGL.so.1 missing", "apt-get install libegl1")


@pytest.mark.parametrize(
    ("program", "module"),
    few_of([(EDITOR, "numpy"), (CLI, "cv2"), (EDITOR, "cv2"), (CLI, "numpy")], 2),
)
def test_a_package_that_does_not_load_is_named(tmp_path, program, module):
    (tmp_path / f"{module}.py").write_text('raise ImportError("libany.so.1: cannot open it")')
    shot, warp = ("--sample", "--screenshot", tmp_path / "a.png"), ("warp", "--sample", "-o")
    done = start(
        program, *(shot if program == EDITOR else (*warp, tmp_path / "a.png")), PYTHONPATH=tmp_path
    )
    package = {"cv2": "opencv-contrib-python-headless"}.get(module, module)
    ends_in_a_sentence(done, package, "repair it: ", " -m pip install --force-reinstall ")
    assert not (tmp_path / "a.png").exists()


def test_what_is_no_fault_of_the_installation_is_told_as_such(tmp_path):
    (tmp_path / "broken.py").write_text("from kogao_core import nothing_of_that_name")
    breaks = "from kogao_core.cli import warp; warp.run = lambda _: __import__('broken'); "
    done = start(
        ALL_LIBRARIES + breaks + CLI, "warp", "--sample", "-o", "x.png", PYTHONPATH=tmp_path
    )
    assert done.returncode == 70
    assert "internal error" in done.stderr


def test_a_failing_search_beside_another_opencv_says_what_doctor_says(tmp_path):
    """As after the installation of mediapipe, which needs opencv-contrib-python."""
    info = tmp_path / "opencv_contrib_python-5.1.0.95.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: opencv-contrib-python\nVersion: 5.1.0.95\n"
    )
    (tmp_path / "broken.py").write_text("import cv2; raise cv2.error('OpenCV: !empty()')")
    breaks = "from kogao_core.cli import warp; warp.run = lambda _: __import__('broken'); "
    done = start(
        ALL_LIBRARIES + breaks + CLI, "warp", "--sample", "-o", "x.png", PYTHONPATH=tmp_path
    )
    ends_in_a_sentence(done, "opencv-contrib-python conflict", "repair it: ", " -m pip uninstall")
