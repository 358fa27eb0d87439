"""Edits follow their picture whatever happens to files and folders meanwhile."""

import pytest
from stories import tell


@pytest.mark.parametrize("seed", [*range(6), 1625])
def test_no_story_loses_an_edit_or_shows_a_wrong_picture(tmp_path, seed):
    wrong, log = tell(tmp_path / "story", seed)
    assert not wrong, "\n".join(log)


@pytest.mark.slow
def test_many_stories(tmp_path):
    """Two thousand stories were run when the rules were written."""
    for seed in range(100, 300):
        wrong, log = tell(tmp_path / "story", seed)
        assert not wrong, (seed, "\n".join(log))
