"""A program that is told to end does so at once; a photo that is written is never called failed."""

import subprocess
import sys

import cv2
import numpy as np
import pytest
from timeouts import LONGEST_S

from kogao_core import photo
from kogao_core.base.atomic import is_aside

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
# While a network looks; while a file is laid aside and standard error is kept from decoders; when
# all is written.
PLACES = [
    ("kogao_core.retouch", "held_of"),
    ("kogao_core.photo.jpeg.coefficients", "write"),
    ("kogao_core.cli.summary", "as_text"),
]


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
@pytest.mark.parametrize("told", ["SIGINT", "SIGTERM", "SIGHUP"])
@pytest.mark.parametrize(("module", "name"), PLACES, ids=[name for _, name in PLACES])
def test_a_signal_ends_a_warp_with_one_line_and_nothing_left(
    portrait, tmp_path, told, module, name
):
    program = ENDED.format(module=module, name=name, signal=told)
    # Whoever starts a program in the background may have it ignore Ctrl-C.
    hear = f"import signal; signal.signal(signal.{told}, signal.{DEFAULT[told]})\n"
    output = tmp_path / "out.jpg"
    done = subprocess.run(
        [sys.executable, "-c", hear + program, "warp", str(portrait), "-o", str(output)],
        capture_output=True, text=True, check=False, timeout=LONGEST_S,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (130, "kogao-cli: interrupted\n")
    assert not [path for path in tmp_path.rglob("*") if is_aside(path)]
    assert output.exists() == (name == "as_text")
    if output.exists():
        photo.read(output)


DEFAULT = {"SIGINT": "default_int_handler", "SIGTERM": "SIG_DFL", "SIGHUP": "SIG_DFL"}


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
def test_whoever_has_a_signal_ignored_is_let_alone(portrait, tmp_path):
    program = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n" + ENDED.format(
        module="kogao_core.retouch", name="held_of", signal="SIGHUP"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, "warp", str(portrait), "-o", str(tmp_path / "out.jpg")],
        capture_output=True, text=True, check=False, timeout=LONGEST_S,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")


def test_a_figure_that_cant_be_measured_is_a_note(works, portrait, tmp_path, monkeypatch):
    def fail(*_):
        raise np.linalg.LinAlgError("SVD did not converge")

    monkeypatch.setattr("kogao_core.cli.warp.measure", fail)
    said = works("warp", portrait, "-o", tmp_path / "out.jpg")
    assert "the straight lines couldn't be measured (LinAlgError: SVD did not converge)" in said
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


@pytest.mark.parametrize("broken", ["as_text", "as_json"])
def test_a_summary_that_fails_is_a_note_for_the_photo_is_written(
    cli, portrait, tmp_path, monkeypatch, broken
):
    def fail(*_):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(f"kogao_core.cli.summary.{broken}", fail)
    code, _, err = cli("warp", portrait, "-o", tmp_path / "out.jpg", "--json", tmp_path / "a.json")
    assert code == 0
    assert "the photo is written, but what was done can't be told (division by zero)" in err
    photo.read(tmp_path / "out.jpg")


def test_a_report_that_cant_be_written_is_a_note_for_the_photo_is(
    cli, portrait, tmp_path, monkeypatch
):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("kogao_core.cli.json_file.put", full)
    output, report = tmp_path / "out.jpg", tmp_path / "report.json"
    code, out, err = cli("warp", portrait, "-o", output, "--json", report)
    assert (code, "written to" in out) == (0, True)
    assert "the photo is written; " in err
    assert "No space left on device" in err
    photo.read(output)
