"""A program that is told to end does so at once; a photo that is written is never called failed."""

import sys
from unittest.mock import Mock

import cv2
import numpy as np
import pytest
from programs import ran

from kogao_core import photo
from kogao_core.base.atomic import is_temporary

ENDED = """
import os, signal, sys
import {module} as place
at = place.{name}
def ended(*given, **more):
    os.kill(os.getpid(), signal.{signal})
    return at(*given, **more)
place.{name} = ended
from kogao_core.cli import main
main()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
@pytest.mark.parametrize(
    ("module", "name", "told", "heard"),
    [
        # While a network looks, as whoever starts a program in the background has it hear Ctrl-C.
        ("kogao_core.retouch", "held_of", "SIGINT", "default_int_handler"),
        # While a file is laid aside and standard error is kept from decoders.
        ("kogao_core.photo.jpeg.coefficients", "write", "SIGTERM", "SIG_DFL"),
        # When all is written.
        ("kogao_core.cli.common", "tell", "SIGHUP", "SIG_DFL"),
        # As nohup has it: the signal is ignored.
        ("kogao_core.retouch", "held_of", "SIGHUP", "SIG_IGN"),
    ],
)
def test_a_signal_ends_a_warp_with_one_line_and_nothing_left(
    small_portrait, tmp_path, module, name, told, heard
):
    hear = f"import signal; signal.signal(signal.{told}, signal.{heard})\n"
    program = hear + ENDED.format(module=module, name=name, signal=told)
    output, is_ended = tmp_path / "out.jpg", heard != "SIG_IGN"
    done = ran(program, "warp", small_portrait, "-o", output, ends=130 if is_ended else 0)
    assert done.stderr == ("kogao-cli: interrupted\n" if is_ended else "")
    assert not [path for path in tmp_path.rglob("*") if is_temporary(path)]
    assert output.exists() == (name == "tell" or not is_ended)
    if output.exists():
        photo.read(output)


@pytest.fixture
def fails_with(monkeypatch):
    """Let a function of the command line raise something."""

    def arrange(name, error):
        monkeypatch.setattr(f"kogao_core.cli.{name}", Mock(side_effect=error))

    return arrange


def test_a_figure_that_cant_be_measured_is_a_warning(warns, small_portrait, tmp_path, fails_with):
    fails_with("warping.find.measure", np.linalg.LinAlgError("SVD did not converge"))
    _, said = warns("warp", small_portrait, "-o", tmp_path / "out.jpg")
    assert "straight lines can't be measured: LinAlgError: SVD did not converge" in said
    photo.read(tmp_path / "out.jpg")


def test_numbers_that_stand_for_no_data_leave_lines_measured(cli, small_portrait, tmp_path):
    """As in masks and maps: the lowest float, infinity, none."""
    pixels = cv2.imread(str(small_portrait)).astype(np.float32) / 255.0
    for k, value in enumerate((np.finfo(np.float32).min, np.inf, np.nan)):
        pixels[:30, 40 * k : 40 * k + 30] = value
    source, output = tmp_path / "in.tif", tmp_path / "out.tif"
    cv2.imwrite(str(source), pixels)
    code, said, err = cli("warp", source, "-o", output)
    assert (code, err) == (0, "")
    assert "measured" not in said


@pytest.mark.parametrize(
    ("broken", "error", "words"),
    [
        ("summary.WarpReport.headline", ZeroDivisionError("by zero"), "the report failed: by zero"),
        ("summary.WarpReport.to_dict", ZeroDivisionError("by zero"), "the report failed: by zero"),
        ("common.atomic_write", OSError(28, "No space left on device"), "No space left on device"),
    ],
)
def test_a_summary_that_fails_is_a_note_for_the_photo_is_written(
    cli, small_portrait, tmp_path, fails_with, broken, error, words
):
    fails_with(broken, error)
    output, report = tmp_path / "out.jpg", tmp_path / "report.json"
    code, said, err = cli("warp", small_portrait, "-o", output, "--json", report)
    assert (code, "smaller" in said) == (0, broken != "summary.WarpReport.headline")
    assert "photo saved, but the report failed" in err
    assert words in err
    photo.read(output)
