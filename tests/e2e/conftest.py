"""The command line, called in this process."""

import math

import numpy as np
import pytest
from PIL import Image

from kogao_core.cli import main, progress


@pytest.fixture(autouse=True)
def no_progress(monkeypatch):
    """What a command says doesn't depend on how long it takes here."""
    monkeypatch.setattr(progress, "CALM_S", math.inf)


@pytest.fixture
def cli(capsys):
    """Run the program; return its exit code, and what it printed and complained."""

    def run(*arguments):
        with pytest.raises(SystemExit) as ending:
            main([str(argument) for argument in arguments])
        return ending.value.code, *capsys.readouterr()

    return run


@pytest.fixture
def faceless(tmp_path):
    """A photo of nobody: a ramp from dark to light."""
    path = tmp_path / "faceless.png"
    shade = np.linspace(40, 200, 160, dtype=np.uint8)
    Image.fromarray(np.dstack([np.tile(shade, (120, 1))] * 3)).save(path)
    return path
