"""Read model files; check networks against the hashes locked at build time (decision 12)."""

from __future__ import annotations

import hashlib
import json
import struct
import zipfile
import zlib
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from kogao_core.base import assets
from kogao_core.base.language import TextError

DETECTOR: Final = "models/face_detection_back.tflite"
MESH: Final = "models/face_landmarks_detector.tflite"
PERSON: Final = "models/selfie_segmentation.tflite"
_DAMAGED: Final = (
    *(OSError, EOFError, KeyError, ValueError, RuntimeError),
    *(zipfile.BadZipFile, struct.error, zlib.error),
)


class ModelRefused(TextError, RuntimeError):
    """A file is damaged or not a model of the requested kind; the message is one sentence."""


def network(name: str) -> Path:
    """Return the path of a network after a check of its hash, which takes 2 ms.

    A damaged network would miss or misplace faces. Raises AssetMissing, ModelRefused.
    """
    path = assets.path(name)
    manifest = json.loads(assets.path("assets.json").read_text(encoding="utf-8"))
    locked = {entry["file"]: entry["sha256"] for entry in manifest["assets"]}
    if hashlib.sha256(path.read_bytes()).hexdigest() != locked[path.name]:
        raise ModelRefused(
            "{path} is damaged or another file than Kogao came with; kogao-cli "
            "doctor says how to mend the installation",
            path=path,
        )
    return path


def arrays(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Return the arrays of one of Kogao's own models (.npz). Raises ModelRefused."""
    try:
        with path.open("rb") as data, np.load(data, allow_pickle=False) as file:
            return dict(file)
    except _DAMAGED as error:
        raise ModelRefused(
            "{path} is damaged ({error}); reinstall Kogao", path=path, error=error
        ) from error
