"""The command line, called in this process."""

import hashlib
import math
import os
import re
import shutil
import subprocess

import numpy as np
import pytest
from browser import Browser
from PIL import Image

from kogao_core.base import assets
from kogao_core.cli import common, main
from kogao_core.faces.landmarks import MeshSource


@pytest.fixture(autouse=True)
def no_progress(monkeypatch):
    """What a command says doesn't depend on how long it takes here."""
    monkeypatch.setattr(common, "CALM_S", math.inf)


_found = {}


@pytest.fixture(autouse=True)
def searched_once(monkeypatch):
    """A picture is searched for faces once, however many tests work on it."""
    path, find = assets.path, MeshSource.find

    def known(source, rgb, on_face=lambda _: None):
        if assets.path is not path:  # a test takes the networks away, or damages them
            return find(source, rgb, on_face)
        pixels = hashlib.sha256(np.ascontiguousarray(rgb)).digest()
        key = type(source), source._refined, rgb.shape, rgb.dtype, pixels
        if key not in _found:
            _found[key] = find(source, rgb)
        for face in _found[key]:
            on_face(face)
        return list(_found[key])

    monkeypatch.setattr(MeshSource, "find", known)


@pytest.fixture
def cli(capsys):
    """Run the program; return its exit code, and what it printed and complained."""

    def run(*arguments):
        with pytest.raises(SystemExit) as ending:
            main([str(argument) for argument in arguments])
        return ending.value.code, *capsys.readouterr()

    return run


@pytest.fixture
def works(cli):
    """Run a command that must do all of its work without complaint; return what it printed."""

    def run(*arguments):
        code, said, err = cli(*arguments)
        assert (code, err) == (0, ""), err
        return said

    return run


@pytest.fixture
def warns(cli):
    """Run a command that succeeds with warnings; return the output and the warnings."""

    def run(*arguments):
        code, said, err = cli(*arguments)
        assert code == 0
        assert all(line.startswith("kogao-cli: warning: ") for line in err.splitlines()), err
        return said, err

    return run


@pytest.fixture
def fails(cli, tmp_path):
    """Run a command that must fail with a code, one line on stderr, and leave no file behind."""

    def run(code, words, *arguments):
        before = {path: path.lstat().st_mtime_ns for path in tmp_path.rglob("*")}
        found, out, err = cli(*arguments)
        assert (found, out) == (code, "")
        assert re.fullmatch(r"kogao-cli: [^\n]+\n", err), err
        assert re.search(words, err), err
        assert {path: path.lstat().st_mtime_ns for path in tmp_path.rglob("*")} == before

    return run


@pytest.fixture
def faceless(tmp_path):
    """A photo of nobody: a ramp from dark to light."""
    path = tmp_path / "faceless.png"
    shade = np.linspace(40, 200, 160, dtype=np.uint8)
    Image.fromarray(np.dstack([np.tile(shade, (120, 1))] * 3)).save(path)
    return path


@pytest.fixture
def screen():
    """A screen of nobody's, as the environment names it."""
    if shutil.which("Xvfb") is None:
        pytest.skip("needs Xvfb")
    ours, theirs = os.pipe()
    # Without -noreset it begins anew when its last client goes, and the next one finds nobody.
    command = ["Xvfb", "-displayfd", str(theirs), "-noreset", "-screen", "0", "1024x768x24"]
    with subprocess.Popen(command, pass_fds=[theirs], stderr=subprocess.DEVNULL) as server:
        os.close(theirs)
        with os.fdopen(ours) as told:
            yield f":{told.readline().strip()}"
        server.terminate()


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    """A browser for all pages; `afresh` gives it a new page that remembers nothing."""
    browser = Browser(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.kill()
