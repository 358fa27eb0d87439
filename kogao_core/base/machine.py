"""The processor, the libraries and the networks that a result was computed with."""

from __future__ import annotations

import hashlib
import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Final

import threadpoolctl

from kogao_core.base import assets

PACKAGES: Final = ("kogao", "numpy", "opencv-contrib-python-headless")


def machine() -> dict[str, object]:
    """Return processor, cores, versions, and the kernels that numpy's products run on."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load": ", ".join(f"{one:.1f}" for one in os.getloadavg())
        if hasattr(os, "getloadavg")
        else "?",
        "system": platform.platform(),
        "python": platform.python_version(),
        "blas": _blas(),
        "packages": {name: _version(name) for name in PACKAGES},
    }


def _processor() -> str:
    try:
        with Path("/proc/cpuinfo").open(encoding="utf-8") as stream:
            names = [line.split(":")[1].strip() for line in stream if line.startswith("model name")]
        return names[0] if names else platform.processor()
    except OSError:
        return platform.processor()


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "absent"


def _blas() -> str:
    found = (one for one in threadpoolctl.threadpool_info() if one["user_api"] == "blas")
    names = ("internal_api", "version", "architecture")
    return "; ".join(" ".join(str(one.get(name, "")) for name in names) for one in found)


def networks() -> dict[str, str]:
    """Return the SHA-256 of each network of this installation."""
    folder = assets.path("assets.json").parent / "models"
    files = sorted(folder.glob("*.tflite"))
    return {one.name: hashlib.sha256(one.read_bytes()).hexdigest() for one in files}
