"""What tests need beyond the repository: shared photographs and the networks' weights."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from kogao_core import assets

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of labelled photographs; they may not be copied into the repository."""
    folder = Path(os.environ.get("KOGAO_SHARED", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"the folder of test photographs is absent: {folder} (set KOGAO_SHARED)")
    return folder


@pytest.fixture(scope="session")
def weights() -> Path:
    """Folder of the network weights, fetched by the build hook."""
    try:
        assets.path("models/face_detection_back.tflite")
        return assets.path("models/face_landmarks_detector.tflite").parent
    except assets.AssetMissing as missing:
        pytest.skip(f"the network weights are absent: {missing}")
