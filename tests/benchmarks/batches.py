"""Batches for `kills.py`: small photos of every format, some damaged, some with projects."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageEnhance
from processes import CLI

from kogao_core import photo
from kogao_core.base import assets
from kogao_core.projects.project import Project, Sheet, save, sha256_of
from kogao_core.projects.sidecar import original, sidecar_of
from kogao_core.recipe.recipe import Recipe

BAD_SHARE, PROJECT_SHARE = 0.05, 0.1
SUFFIXES = (".jpg", ".jpg", ".jpg", ".png", ".tif", ".webp")
SIDE_PX = (220, 320)


def make(folder: Path, count: int, rng: np.random.Generator) -> set[Path]:
    """Write photos and projects, and return the damaged ones."""
    from kogao_core.faces.landmarks import source

    portrait = Image.open(assets.path("samples/average.jpg"))
    bad_ones = set(rng.choice(count, round(BAD_SHARE * count), replace=False).tolist())
    damaged = set()
    for k in range(count):
        place = folder / f"{k // 100:02}"
        place.mkdir(parents=True, exist_ok=True)
        path = place / f"{k:04}{SUFFIXES[k % len(SUFFIXES)]}"
        side = int(rng.integers(*SIDE_PX))
        picture = portrait.resize((side, side + int(rng.integers(0, 30))))
        ImageEnhance.Brightness(picture).enhance(float(rng.uniform(0.8, 1.2))).save(path)
        if k in bad_ones:
            _damage(path, rng)
            damaged.add(path)
        elif k % round(1 / PROJECT_SHARE) == 0:
            seen = photo.read(path)
            faces = tuple(source(None).find(seen.pixels))
            sheet = Sheet(faces, recipe=Recipe(percent=6.0))
            about = original(path, sha256_of(path), seen.pixels)
            save(Project(about, "automatic", sheet), sidecar_of(path))
    return damaged


def _damage(path: Path, rng: np.random.Generator) -> None:
    whole = path.read_bytes()
    ways = (
        whole[: len(whole) // int(rng.integers(2, 9))],
        b"",
        bytes(len(whole)),
        b"<html>not found</html>",
        whole[:20] + rng.bytes(len(whole) - 20),
    )
    path.write_bytes(ways[rng.integers(len(ways))])


def command(inputs: Path, out: Path, jobs: int) -> list[str]:
    """Return the command line of the batch."""
    return [*CLI, "batch", str(inputs), "-o", str(out), "--projects", "-j", str(jobs)]


def run(inputs: Path, out: Path, jobs: int) -> None:
    """Run the batch."""
    done = subprocess.run(command(inputs, out, jobs), capture_output=True, text=True, check=False)
    if "Traceback" in done.stderr:
        sys.exit(done.stderr)


def judge(inputs: Path, out: Path, damaged: set[Path], done_as: set[str]) -> list[str]:
    """Return what went wrong; sound photos must be there, ``done`` or ``skipped``."""
    status = {Path(entry["source"]): entry["status"] for entry in report(out)}
    wrong = []
    for path in sorted(inputs.rglob("*")):
        if path.is_dir() or path.suffix == ".json":
            continue
        result = out / path.relative_to(inputs)
        if status.get(path) not in ({"failed"} if path in damaged else done_as):
            wrong.append(f"{path.name} is {status.get(path)}")
        if result.exists() == (path in damaged):
            wrong.append(f"{result.name} is {'there' if result.exists() else 'missing'}")
        elif result.exists() and photo.read(result).pixels.shape != photo.read(path).pixels.shape:
            wrong.append(f"{result.name} has another shape")
    return wrong + [f"{path.name} was left" for path in out.rglob(".kogao-*")]


def report(out: Path) -> list[dict[str, str]]:
    """Return the report's lines; one that a killed program left unended doesn't count."""
    lines = (out / "kogao-batch.jsonl").read_text().splitlines()
    return [json.loads(line) for line in lines if line.endswith("}")]


def digest(folder: Path) -> str:
    """Return a hash of all files in a folder."""
    total = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        total.update(path.name.encode() + path.read_bytes())
    return total.hexdigest()
