"""Kill programs that are saving: ``python tests/benchmarks/kills.py [--kills N]`` (not on Windows).

A child saves photos and their projects over and over, its own source among them and others in
place, or works on a batch with projects, and is killed at a random moment. Afterwards every file
must be whole: the old version or the new one, and nothing may lie in the folder for temporary
files; what was changed in place must come back. What a program left beside its target must be gone
when the next one has saved there. A batch that is let alone in the end must do the rest.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import functools
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np

from kogao_core import photo
from kogao_core.base.atomic import is_aside, put
from kogao_core.base.originals import NoOriginal, Originals
from kogao_core.base.strict import BadFile
from kogao_core.projects import project
from kogao_core.projects.project import Project, Sheet
from kogao_core.projects.sidecar import original, sidecar_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from benchmarks import thousand
from scenes import oval_face

LONGEST_SECONDS = 0.12
# A batch is killed between starting its workers and ending.
BATCH_SECONDS = (0.5, 4.0)
BATCH_SHARE = 0.1
EXPECTED = (
    *("killed while saving", "killed in a batch", "batch had ended before"),
    "left something aside until the next run",
)
SUFFIXES = (".jpg", ".png", ".tif", ".webp")


def prepare(folder: Path) -> None:
    """Write a source of every format, and keep a copy aside."""
    noise = np.random.default_rng(0).integers(0, 256, (240, 320, 3), np.uint8)
    picture = cv2.GaussianBlur(noise, (0, 0), 2.0)
    (folder / "aside").mkdir()
    for suffix in SUFFIXES:
        cv2.imwrite(str(folder / f"source{suffix}"), picture)
        shutil.copy(folder / f"source{suffix}", folder / "aside")
        for place in (folder, folder / "aside"):
            shutil.copy(folder / f"source{suffix}", place / f"in-place{suffix}")


def save_for_ever(folder: Path, seed: int) -> None:
    """Save results, a sidecar and over the sources themselves until somebody ends it."""
    rng = np.random.default_rng(seed)
    while True:
        suffix = SUFFIXES[rng.integers(len(SUFFIXES))]
        source = photo.read(folder / f"source{suffix}")
        pixels = source.pixels.copy()
        pixels[40:90, 60:140] = rng.integers(0, 256)
        photo.write(source, pixels, folder / f"result{suffix}", force=True)
        project.save(some_project(source, rng), sidecar_of(source.path))
        if rng.random() < 0.3:
            photo.write(source, pixels, source.path, force=True)
        change_in_place(folder / f"in-place{suffix}", rng)


def store_of(folder: Path) -> Originals:
    """Return where originals of photos that are changed in place are kept."""
    return Originals(folder / "store")


def change_in_place(path: Path, rng: np.random.Generator) -> None:
    """Write over a photo once or twice, as an editor does, or bring it back."""
    store = store_of(path.parent)
    if rng.random() < 0.3:
        with contextlib.suppress(NoOriginal):  # nothing was changed yet
            store.restore(path)
        return
    shown = photo.read(path)
    for _ in range(rng.integers(1, 3)):
        pixels = shown.pixels.copy()
        pixels[40:90, 60:140] = rng.integers(0, 256)
        photo.write_in_place(shown, pixels, store)


def some_project(source: photo.Photo, rng: np.random.Generator) -> Project:
    """Return a project with a face or some."""
    faces = tuple(oval_face(center=(160.0, 120.0), size=0.3) for _ in range(rng.integers(1, 9)))
    return Project(original(source.path, "0" * 64, source.pixels), "automatic", Sheet(faces))


def unreadable(folder: Path) -> list[str]:
    """Return which photos and projects in a folder are no longer whole."""
    found = []
    for path in sorted(folder.rglob("*.*")):
        if is_aside(path) or path.suffix == ".jsonl" or {"aside", "store"} & {*path.parts}:
            continue
        try:
            if path.suffix == ".json":
                project.load(path)
            else:
                photo.read(path)
        except (photo.UnreadablePhoto, BadFile) as problem:
            found.append(f"{path.name}: {problem}")
    return found


def harm(folder: Path) -> list[str]:
    """Return what saving has harmed."""
    found = unreadable(folder)
    for kept in (folder / "aside").glob("in-place*"):
        path = folder / kept.name
        if path.read_bytes() == kept.read_bytes():
            continue
        in_child(functools.partial(store_of(folder).restore, path))
        if path.read_bytes() != kept.read_bytes():
            found.append(f"{kept.name} doesn't come back")
    for kept in (folder / "aside").glob("source*"):
        original = folder / f"{kept.stem}.original{kept.suffix}"
        current = original if original.exists() else folder / kept.name
        if current.read_bytes() != kept.read_bytes():
            found.append(f"the original of {kept.name} is lost")
    return found


def in_child(act: Callable[[], object]) -> None:
    """Do something in a process of its own: each looks once for what others have left."""
    child = os.fork()
    if not child:
        try:
            act()
        finally:
            os._exit(0)
    os.waitpid(child, 0)


def left_aside(folder: Path) -> bool:
    """Return whether a killed program has left something beside its targets."""
    return any(is_aside(path) for path in folder.rglob("*"))


def left_for_good(folder: Path, temporary: Path) -> list[str]:
    """Return what nobody would ever remove once another program has saved in the folder."""
    for place in {folder, *(path.parent for path in folder.rglob("*") if is_aside(path))}:
        if not is_aside(place):
            in_child(functools.partial(put, b"", place / "next.jsonl"))
    stayed = [f"{path.name} was never removed" for path in folder.rglob("*") if is_aside(path)]
    return stayed + [f"{path} lies in the temporary folder" for path in temporary.iterdir()]


@contextlib.contextmanager
def _folders() -> Iterator[tuple[Path, Path]]:
    """Make a folder to work in, and one that programs take for the system's temporary one."""
    with tempfile.TemporaryDirectory(prefix="kills-") as name:
        folder, temporary = Path(name, "work"), Path(name, "temporary")
        folder.mkdir()
        temporary.mkdir()
        before, os.environ["TMPDIR"] = os.environ.get("TMPDIR"), str(temporary)
        tempfile.tempdir = None  # asked again
        try:
            yield folder, temporary
        finally:
            tempfile.tempdir = None
            del os.environ["TMPDIR"]
            os.environ.update({"TMPDIR": before} if before else {})


def kill_savers(kills: int, seed: int, counts: collections.Counter[str]) -> None:
    """Kill programs that save, and count what happened."""
    rng = np.random.default_rng(seed)
    with _folders() as (folder, temporary):
        prepare(folder)
        for kill in range(kills):
            child = os.fork()
            if not child:
                save_for_ever(folder, kill)
            time.sleep(rng.uniform(0.0, LONGEST_SECONDS))
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            counts["killed while saving"] += 1
            counts["left something aside until the next run"] += left_aside(folder)
            counts.update(harm(folder))
            counts.update(left_for_good(folder, temporary))


def kill_batches(kills: int, photos: int, seed: int, counts: collections.Counter[str]) -> None:
    """Kill batches with all their workers, let a last one end, and count what happened."""
    rng = np.random.default_rng(seed)
    with _folders() as (folder, temporary):
        inputs, out = folder / "in", folder / "out"
        bad = thousand.make(inputs, photos, rng)
        before = thousand.digest(inputs)
        for _ in range(kills):
            if rng.random() < 0.5:
                shutil.rmtree(out, ignore_errors=True)
            running = subprocess.Popen(
                thousand.command(inputs, out, 2), stderr=subprocess.DEVNULL, start_new_session=True
            )
            time.sleep(rng.uniform(*BATCH_SECONDS))
            counts["batch had ended before"] += running.poll() is not None
            with contextlib.suppress(ProcessLookupError):
                os.killpg(running.pid, signal.SIGKILL)
            running.wait()
            counts["killed in a batch"] += 1
            counts["left something aside until the next run"] += left_aside(out)
            counts.update(unreadable(out))
            counts.update(left_for_good(folder, temporary))
            if before != thousand.digest(inputs):
                counts["a source or a project has changed"] += 1
        thousand.run(inputs, out, 2)
        counts.update(thousand.judge(inputs, out, bad, {"done", "skipped"}))


def main() -> None:
    """Run and print the counts; end with 1 if anything was harmed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=300, help="one in ten in a batch")
    parser.add_argument("--photos", type=int, default=60, help="in a batch")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    counts: collections.Counter[str] = collections.Counter()
    in_batches = round(BATCH_SHARE * options.kills)
    kill_savers(options.kills - in_batches, options.seed, counts)
    kill_batches(in_batches, options.photos, options.seed, counts)
    harmed = {what: count for what, count in counts.items() if what not in EXPECTED}
    print(json.dumps({"seed": options.seed, **counts, "harmed": sum(harmed.values())}, indent=1))
    sys.exit(bool(harmed))


if __name__ == "__main__":
    main()
