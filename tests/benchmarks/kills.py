"""Kill programs that are saving: ``python tests/benchmarks/kills.py [--kills N]`` (not on Windows).

A child saves photos and a sidecar over and over, its own source among them, and is killed at a
random moment. Afterwards every file must be whole: the old version or the new one.
"""

from __future__ import annotations

import argparse
import collections
import json
import os
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np

from kogao_core import atomic, photo

LONGEST_SECONDS = 0.12
SUFFIXES = (".jpg", ".png", ".tif", ".webp")


def prepare(folder: Path) -> None:
    """Write a source of every format, and keep a copy aside."""
    noise = np.random.default_rng(0).integers(0, 256, (240, 320, 3), np.uint8)
    picture = cv2.GaussianBlur(noise, (0, 0), 2.0)
    (folder / "aside").mkdir()
    for suffix in SUFFIXES:
        cv2.imwrite(str(folder / f"source{suffix}"), picture)
        shutil.copy(folder / f"source{suffix}", folder / "aside")


def save_for_ever(folder: Path, seed: int) -> None:
    """Save results, a sidecar and over the sources themselves until somebody ends it."""
    rng = np.random.default_rng(seed)
    while True:
        suffix = SUFFIXES[rng.integers(len(SUFFIXES))]
        source = photo.read(folder / f"source{suffix}")
        pixels = source.pixels.copy()
        pixels[40:90, 60:140] = rng.integers(0, 256)
        photo.write(source, pixels, folder / f"result{suffix}", force=True)
        atomic.put(json.dumps({"numbers": list(range(2000))}).encode(), folder / "side.json")
        if rng.random() < 0.3:
            photo.write(source, pixels, source.path, force=True)


def harm(folder: Path) -> list[str]:
    """Return what is no longer whole."""
    found = []
    for path in sorted(folder.glob("*.*")):
        if path.name.endswith(".partial"):
            continue
        try:
            if path.suffix == ".json":
                json.loads(path.read_text())
            elif photo.read(path).pixels.shape != (240, 320, 3):
                found.append(f"{path.name}: other size")
        except (photo.UnreadablePhoto, ValueError) as problem:
            found.append(f"{path.name}: {problem}")
    for kept in (folder / "aside").iterdir():
        original = folder / f"{kept.stem}.original{kept.suffix}"
        current = original if original.exists() else folder / kept.name
        if current.read_bytes() != kept.read_bytes():
            found.append(f"the original of {kept.name} is lost")
    return found


def main() -> None:
    """Run and print the counts; end with 1 if anything was harmed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    counts: collections.Counter[str] = collections.Counter()
    with tempfile.TemporaryDirectory(prefix="kills-") as name:
        folder = Path(name)
        prepare(folder)
        for kill in range(options.kills):
            child = os.fork()
            if not child:
                save_for_ever(folder, kill)
            time.sleep(rng.uniform(0.0, LONGEST_SECONDS))
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            counts["kills"] += 1
            counts["left a partial file"] += bool(list(folder.glob(".*.partial")))
            for partial in folder.glob(".*.partial"):
                partial.unlink()
            counts.update(harm(folder))
    print(json.dumps({"seed": options.seed, **counts}, indent=1))
    sys.exit(bool(set(counts) - {"kills", "left a partial file"}))


if __name__ == "__main__":
    main()
