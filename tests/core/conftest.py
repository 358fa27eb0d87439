"""The networks, and the shared portraits with the faces that they find; found once a run."""

from __future__ import annotations

from pathlib import Path

import pytest
from real_photos import Scene, found_in

from kogao_core.faces.landmarks import MeshSource


@pytest.fixture(scope="session")
def source(weights: Path) -> MeshSource:
    """What finds faces with the networks."""
    assert weights.is_dir()
    return MeshSource()


@pytest.fixture(scope="session")
def portraits(shared_data: Path, source: MeshSource) -> list[Scene]:
    """Every ninth shared portrait, 640 px."""
    return found_in(sorted((shared_data / "portraits").glob("*.jpg"))[4::9], source)
