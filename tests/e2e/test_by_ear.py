"""From a photo to a saved copy by keys and ears alone, through a real accessibility bus."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from ears import Ears, desktop
from PIL import Image

from kogao_core.photo import read

pytestmark = pytest.mark.slow


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
def ears():
    with desktop() as env:
        ears = Ears(env)
        command = [sys.executable, "-m", "kogao_app"]
        program = subprocess.Popen(command, env={**env, "QT_QPA_PLATFORM": "xcb"})
        ears.program = program
        try:
            yield ears
        finally:
            program.kill()
            program.wait()
            ears.close()


def test_from_a_photo_to_a_saved_copy_by_ear(ears, two_portraits, tmp_path):
    ears.hears("Faces found: 1")
    ears.in_front("average.jpg")

    ears.keys("ctrl+o")
    ears.focus_on("text File name")
    ears.types(str(two_portraits))
    ears.keys("Return")
    assert ears.hears("Faces found") == "Faces found: 2"
    ears.in_front("both.png")
    assert ears.find("radio button", "Retouch")
    photo = ears.find("list", "Photo")
    first, second = ears.children(photo)
    assert [ears.name(face) for face in (first, second)] == ["Face 1 of 2, 4 %", "Face 2 of 2, 4 %"]
    assert ears.children(second) == []

    ears.tab_to("list Faces")
    ears.keys("Down")
    ears.focus_on("list item Face 1")
    ears.keys("Down")
    ears.focus_on("list item Face 2")
    assert ears.hears("Face 2 of 2") == "Face 2 of 2, selected, 4 %"
    assert ears.selected(second)

    amount = ears.tab_to("slider Amount")
    assert ears.value(amount) == 4.0
    ears.keys("Right")
    ears.until(lambda: ears.value(amount) == 4.1, "4.1")
    ears.keys("Return")
    ears.focus_on("text Amount, in figures")
    ears.types("6.5")
    ears.keys("Return")
    ears.focus_on("slider Amount")
    assert ears.value(amount) == 6.5
    assert [ears.name(face) for face in (first, second)] == [
        "Face 1 of 2, 4 %",
        "Face 2 of 2, selected, 6.5 %",
    ]

    for name in ("outline 1, left temple", "outline 2, left cheek", "outline 3, left cheek"):
        ears.keys("ctrl+period")
        point = ears.focus_on(f"list item {name}")
        assert ears.focused(point)
        assert point in ears.children(second)
    before = ears.extents(point)
    ears.keys("Left", "Left", "Left")
    moved = "3 px left of where it was at first"
    ears.until(lambda: ears.description(point).endswith(moved), moved)
    assert ears.hears("outline 3, left cheek,").endswith("px left, no folds")
    assert ears.extents(point)[0] < before[0]

    ears.keys("ctrl+s")
    ears.focus_on("text File name")
    ears.types(str(tmp_path / "copy.png"))
    ears.keys("Return")
    ears.hears("Saved copy.png.")
    ears.in_front("both.png")
    saved, original = read(tmp_path / "copy.png").pixels, read(two_portraits).pixels
    assert saved.shape == original.shape
    assert not np.array_equal(saved, original)

    ears.press(first)
    assert ears.focus_on("list item Face 1 of 2, selected, 4 %") == first
    ears.keys("ctrl+q")
    assert ears.program.wait(60) == 0
