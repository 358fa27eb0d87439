"""What each page says to type works, pasted in order into a fresh folder."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import cv2
import metadata_cases
import numpy as np
import pytest
from named import HEAD, mwg
from PIL import Image
from timeouts import LONGEST_S

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^```(sh|python)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PAGES = (
    "README.md", "docs/install.md", "docs/command-line.md", "docs/python.md",
    "docs/experiments.md", "README.ja.md", "docs/ja/command-line.md", "docs/editor.md",
    "docs/hdr.md",
)  # fmt: skip
# .ci/first-contact and .ci/bundle run these in bare systems; a Flatpak nobody could build yet.
INSTALLS = re.compile(
    r"apt-get|python3 -m venv|pip install|pytest|resources\.packaging|flatpak|resources/packaging"
)
EDITOR = re.compile(r"(\.venv/bin/)?kogao (?!.*--screenshot)")


def typed(page):
    """Yield the language and the text of each line to type; Python's blocks whole."""
    for language, block in BLOCK.findall((ROOT / page).read_text(encoding="utf-8")):
        if language == "python":
            yield language, block
            continue
        for line in block.splitlines():
            for command in line.split(" && "):
                if command.strip() and not INSTALLS.search(command):
                    yield language, command


@pytest.fixture
def reader(tmp_path, monkeypatch, portrait):
    """A place with the programs, and with photos of one's own."""
    home, here = tmp_path / "home", tmp_path / "here"
    for folder in (home, here / "photos", here / "more"):
        folder.mkdir(parents=True)
    programs = Path(sys.executable).parent
    (here / ".venv").symlink_to(programs.parent)
    for place in ("portrait.jpg", "photos/a.jpg", "more/b.jpg"):
        shutil.copy(portrait, here / place)
    with Image.open(portrait) as picture:
        picture.resize((2 * picture.width, 2 * picture.height)).save(here / "big.jpg")
        regions = mwg([("Ann", ((0.5, 0.5), (0.5, 0.5)))], picture.size)
        more = metadata_cases.gain_map(metadata_cases.packet('hdrgm:Version="1.0"'))
        (here / "phone.jpg").write_bytes(portrait.read_bytes() + more)
        bright = np.asarray(picture.convert("RGB"), np.float32)[..., ::-1] / 100.0
        cv2.imwrite(str(here / "render.tif"), bright)
        (here / "wedding").mkdir()
        picture.save(here / "wedding" / "c.jpg", xmp=HEAD.format(regions).encode())
    for name in list(os.environ):
        if name.startswith("XDG_"):
            monkeypatch.delenv(name)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("PATH", f"{programs}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.delenv("QT_QPA_PLATFORM", raising=False)
    monkeypatch.chdir(here)
    return here


def opens(command, photo, display):
    """Whether the editor shows a photo, and goes on until it is ended."""
    environment = os.environ | {"DISPLAY": display}
    with subprocess.Popen(command, shell=True, env=environment, start_new_session=True) as editor:
        ends = time.monotonic() + 2 * LONGEST_S
        found = False
        while not found and editor.poll() is None and time.monotonic() < ends:
            asked = ["xdotool", "search", "--name", photo]
            found = subprocess.run(asked, env=environment, capture_output=True).returncode == 0
            time.sleep(0.2)
        alive = editor.poll() is None
        if alive:
            os.killpg(editor.pid, 15)
    return found and alive


@pytest.mark.slow
@pytest.mark.skipif(
    not (shutil.which("Xvfb") and shutil.which("xdotool") and shutil.which("bash")),
    reason="needs bash, and Xvfb and xdotool for the editor",
)
@pytest.mark.usefixtures("reader")
@pytest.mark.parametrize("page", PAGES)
def test_what_a_page_says_to_type_works_in_order(screen, page):
    failed, names = [], {}
    for kind, command in typed(page):
        if kind == "python":
            exec(compile(command, page, "exec"), names)
        elif EDITOR.match(command):
            if not opens(command, command.split()[-1], screen):
                failed.append((command, "the window didn't come"))
        else:
            done = subprocess.run(
                ["bash", "-euo", "pipefail", "-c", command], capture_output=True, text=True
            )
            if done.returncode:
                failed.append((command, done.returncode, done.stderr))
    assert failed == []


def test_the_pages_with_something_to_type_are_tried():
    found = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
    pages = {one.relative_to(ROOT).as_posix() for one in found}
    assert {page for page in pages if any(True for _ in typed(page))} == set(PAGES)


def test_the_first_command_is_short():
    (_, first), *_ = BLOCK.findall((ROOT / "README.md").read_text(encoding="utf-8"))
    assert len(first.splitlines()) <= 2
