"""`kogao-cli read` measures a retouch, and writes a project and a preset that reproduce it."""

import json

import numpy as np
import pytest

from kogao_core import photo
from kogao_core.recipe import presets


@pytest.fixture
def pair(works, small_png, tmp_path):
    after = tmp_path / "after.png"
    works("warp", small_png, "-o", after, "--amount", "6", "--no-hold-background")
    return small_png, after


def test_a_retouch_becomes_a_project_and_a_preset(works, fails, pair, tmp_path, monkeypatch):
    monkeypatch.setattr(presets, "user_folder", lambda: tmp_path / "presets")
    project, again = tmp_path / "read.json", tmp_path / "again.png"
    said = works("read", *pair, "--project", project, "--style", "Hers", "--json", "-")
    (face,) = json.loads(said)["pairs"][0]["faces"]
    assert face["settings"]["percent"] == pytest.approx(6.0, abs=0.7)
    assert presets.listed(tmp_path / "presets")["Hers"].percent == face["settings"]["percent"]
    works("warp", pair[0], "-o", again, "--project", project)
    before, after, ours = (photo.read(path).pixels.astype(float) for path in (*pair, again))
    assert np.abs(ours - after).mean() < 0.6 * np.abs(before - after).mean()
    assert "nothing moved" in works("read", pair[0], pair[0])
    fails(2, "name photos in pairs", "read", pair[0])
    fails(2, "is a photo; name another file", "read", *pair, "--project", pair[1], "--force")
