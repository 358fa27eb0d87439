"""From a photo to a saved copy by keys and a screen reader alone, over a real AT-SPI bus."""

from __future__ import annotations

import re
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from screen_reader import ScreenReader, desktop

from kogao_core.photo import read

pytestmark = pytest.mark.slow

# A number with its sign, then or before a unit.
VALUE = re.compile(r"(?P<before>[^\d+-]*)(?P<number>[+-]?\d+(?:\.\d+)?)(?P<after>.*)")


@pytest.fixture
def two_portraits(portrait, tmp_path):
    one = Image.open(portrait).resize((400, 400))
    both = Image.new("RGB", (800, 400))
    for x in (0, 400):
        both.paste(one, (x, 0))
    path = tmp_path / "both.png"
    both.save(path)
    return path


@pytest.fixture
def reader():
    with desktop() as env:
        reader = ScreenReader(env)
        command = [sys.executable, "-m", "kogao_app"]
        program = subprocess.Popen(command, env={**env, "QT_QPA_PLATFORM": "xcb"})
        reader.program = program
        try:
            yield reader
        finally:
            program.kill()
            program.wait()
            reader.close()


def test_from_a_photo_to_a_saved_copy_with_a_screen_reader(reader, two_portraits, tmp_path):
    reader.hears("Faces found: 1")
    reader.in_front("average.jpg")

    reader.keys("ctrl+o")
    reader.focus_on("text File name")
    reader.types(str(two_portraits))
    reader.keys("Return")
    assert reader.hears("Faces found") == "Faces found: 2"
    reader.in_front("both.png")
    assert reader.find("radio button", "Retouch")
    photo = reader.find("list", "Photo")
    first, second = reader.children(photo)
    assert [reader.name(face) for face in (first, second)] == [
        "Face 1 of 2, 6 %",
        "Face 2 of 2, 6 %",
    ]
    assert reader.children(second) == []

    reader.tab_to("list Faces")
    reader.keys("Down")
    reader.focus_on("list item Face 1")
    reader.keys("Down")
    reader.focus_on("list item Face 2")
    assert reader.hears("Face 2 of 2") == "Face 2 of 2, selected, 6 %"
    assert reader.selected(second)

    amount = reader.tab_to("slider Amount")
    assert reader.value(amount) == 6.0
    for slider in (one for one in reader.all() if reader.role(one) == "slider"):
        told = reader.description(slider).split("\n")[0]
        found = VALUE.fullmatch(told)
        assert float(found["number"]) == pytest.approx(reader.value(slider), abs=0.006), told
        assert (found["before"] + found["after"]).strip(), "each value has its unit"
    reader.keys("Right")
    reader.until(lambda: reader.value(amount) == 6.1, "6.1")
    assert reader.description(amount) == "6.1 %", "a step tells the value alone"
    reader.keys("Return")
    reader.focus_on("text Amount, in figures")
    reader.types("6.5")
    reader.keys("Return")
    reader.focus_on("slider Amount")
    assert reader.value(amount) == 6.5
    assert [reader.name(face) for face in (first, second)] == [
        "Face 1 of 2, 6 %",
        "Face 2 of 2, selected, 6.5 %",
    ]

    for name in ("outline 1, left temple", "outline 2, left cheek", "outline 3, left cheek"):
        reader.keys("ctrl+period")
        point = reader.focus_on(f"list item {name}")
        assert reader.focused(point)
        assert point in reader.children(second)
    before = reader.extents(point)
    reader.keys("Left", "Left", "Left")
    moved = "3 px left of the first position"
    reader.until(lambda: reader.description(point).endswith(moved), moved)
    assert reader.hears("outline 3, left cheek,").endswith("px left, no folds")
    assert reader.extents(point)[0] < before[0]

    reader.keys("ctrl+s")
    reader.focus_on("push button Add record")
    reader.keys("Return")
    reader.focus_on("text File name")
    reader.types(str(tmp_path / "copy.png"))
    reader.keys("Return")
    reader.hears("Saved copy.png in")
    reader.in_front("both.png")
    saved, original = read(tmp_path / "copy.png").pixels, read(two_portraits).pixels
    assert saved.shape == original.shape
    assert not np.array_equal(saved, original)

    reader.press(first)
    assert reader.focus_on("list item Face 1 of 2, selected, 6 %") == first
    reader.keys("ctrl+q")
    assert reader.program.wait(60) == 0
