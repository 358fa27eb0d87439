"""Kill programs, or tell them to end: ``python tests/benchmarks/kills.py`` (not on Windows).

A child saves photos and their projects over and over, its own source among them and others in
place, or works on a batch with projects, and is killed at a random moment. Afterwards every file
must be whole: the old version or the new one, and nothing may lie in the folder for temporary
files; what was changed in place must come back. What a program left beside its target must be gone
when the next one has saved there. A batch that is let alone in the end must do the rest.

With ``--signals N`` each of `warp`, `batch`, `detect` and the editor's `--edit` gets N signals
instead (SIGINT, SIGTERM, SIGHUP; a batch also as a group), at random moments between its first
handler and its end. It must end in 2 s with 130 and one line, or finish, and leave nothing aside.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
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
from PIL import Image, ImageEnhance

from kogao_core import photo
from kogao_core.base import assets
from kogao_core.base.atomic import atomic_write, is_temporary
from kogao_core.base.json_reader import BadFile
from kogao_core.faces.landmarks import source as landmark_source
from kogao_core.photo.originals import NoOriginal, Originals
from kogao_core.projects import project
from kogao_core.projects.edits import sidecar_of
from kogao_core.projects.project import Project, Sheet
from kogao_core.projects.sidecar import original
from kogao_core.recipe.recipe import Recipe

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from processes import CLI, EDITOR
from scenes import oval_face

LONGEST_SECONDS = 0.12
LONGEST_END_S = 2.0
_QT_OFFSCREEN = "This plugin does not support"
# A batch is killed between starting its workers and ending.
BATCH_SECONDS = (0.5, 4.0)
BATCH_SHARE = 0.1
EXPECTED = (
    *("killed while saving", "killed in a batch", "batch had ended before"),
    *("left something aside until the next run", "ended by 130 and one line", ": had ended"),
)
SUFFIXES = (".jpg", ".png", ".tif", ".webp")
Rng = np.random.Generator
Counts = collections.Counter[str]


# ---- programs that save ---------------------------------------------------------------------


def prepare(folder: Path) -> None:
    """Write two photos of every format, and copies of them aside."""
    noise = np.random.default_rng(0).integers(0, 256, (240, 320, 3), np.uint8)
    picture = cv2.GaussianBlur(noise, (0, 0), 2.0)
    (folder / "aside").mkdir()
    for suffix in SUFFIXES:
        for place in (folder, folder / "aside"):
            cv2.imwrite(str(place / f"source{suffix}"), picture)
            cv2.imwrite(str(place / f"in-place{suffix}"), picture)


def save_for_ever(folder: Path, seed: int) -> None:
    """Save results, a sidecar and in place until the process is killed."""
    rng = np.random.default_rng(seed)
    while True:
        suffix = SUFFIXES[rng.integers(len(SUFFIXES))]
        source = photo.read(folder / f"source{suffix}")
        pixels = source.pixels.copy()
        pixels[40:90, 60:140] = rng.integers(0, 256)
        photo.write(source, pixels, folder / f"result{suffix}", force=True)
        faces = (oval_face(center=(160.0, 120.0), size=0.3),) * int(rng.integers(1, 9))
        about = original(source)
        project.save(Project(about, "automatic", Sheet(faces)), sidecar_of(source.path))
        change_in_place(folder / f"in-place{suffix}", rng)


def change_in_place(path: Path, rng: Rng) -> None:
    """Write over a photo once or twice, as an editor does, or restore it."""
    store = Originals(path.parent / "data" / "store")
    if rng.random() < 0.3:
        with contextlib.suppress(NoOriginal):  # nothing was changed yet
            store.restore(path)
        return
    shown = photo.read(path)
    for _ in range(rng.integers(1, 3)):
        pixels = shown.pixels.copy()
        pixels[40:90, 60:140] = rng.integers(0, 256)
        photo.write_in_place(shown, pixels, store)


def unreadable(folder: Path) -> list[str]:
    """Return which photos and projects in a folder are no longer whole."""
    found = []
    for path in sorted(folder.rglob("*.*")):
        if is_temporary(path) or path.suffix == ".jsonl" or {"aside", "data"} & {*path.parts}:
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
        in_child(lambda path=path: Originals(folder / "data" / "store").restore(path))
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


def left_aside(folder: Path) -> list[Path]:
    """Return what a killed program has left beside its targets."""
    return [path for path in folder.rglob("*") if is_temporary(path)]


def left_for_good(folder: Path, temporary: Path) -> list[str]:
    """Return what stays once another program has saved in the same folders."""
    for place in {folder, *(path.parent for path in left_aside(folder))}:
        if not is_temporary(place):
            in_child(lambda place=place: atomic_write(b"", place / "next.jsonl"))
    stayed = [f"{path.name} was never removed" for path in left_aside(folder)]
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


def kill_savers(kills: int, seed: int, counts: Counts) -> None:
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
            counts["left something aside until the next run"] += bool(left_aside(folder))
            counts.update(harm(folder))
            counts.update(left_for_good(folder, temporary))


# ---- batches --------------------------------------------------------------------------------


def make_photos(folder: Path, count: int, rng: Rng) -> set[Path]:
    """Write photos of every format, some with projects; return some that are damaged."""
    portrait, damaged = Image.open(assets.sample()), set()
    bad_ones = set(rng.choice(count, round(0.05 * count), replace=False).tolist())
    folder.mkdir()
    for number in range(count):
        path = folder / f"{number:04}{SUFFIXES[number % len(SUFFIXES)]}"
        picture = portrait.resize(rng.integers(220, 350, 2).tolist())
        ImageEnhance.Brightness(picture).enhance(float(rng.uniform(0.8, 1.2))).save(path)
        if number in bad_ones:
            whole = path.read_bytes()
            ways = (whole[: len(whole) // 3], b"", bytes(len(whole)), whole[:20] + rng.bytes(999))
            path.write_bytes(ways[rng.integers(len(ways))])
            damaged.add(path)
        elif number % 10 == 0:
            read = photo.read(path)
            faces = tuple(landmark_source().find(read.pixels))
            sheet = Sheet(faces, recipe=Recipe(percent=6.0))
            about = original(read)
            project.save(Project(about, "automatic", sheet), sidecar_of(path))
    return damaged


def batch_of(inputs: Path, out: Path) -> list[str]:
    """Return the command line of a batch."""
    return [*CLI, "batch", str(inputs), "-o", str(out), "--projects", "-j", "2"]


def unfinished(inputs: Path, out: Path, damaged: set[Path]) -> list[str]:
    """Return the photos whose result or report is wrong after the whole batch."""
    # A killed program may leave a line without its end.
    lines = (out / "kogao-batch.jsonl").read_text().splitlines()
    entries = [json.loads(line) for line in lines if line.endswith("}")]
    status = {Path(entry["source"]): entry["status"] for entry in entries}
    wrong = []
    for path in sorted(set(inputs.iterdir()) - set(inputs.glob("*.json"))):
        result = out / path.name
        if status.get(path) not in ({"failed"} if path in damaged else {"done", "skipped"}):
            wrong.append(f"{path.name} is {status.get(path)}")
        if result.exists() == (path in damaged):
            wrong.append(f"{result.name} is {'there' if result.exists() else 'missing'}")
        elif result.exists() and photo.read(result).pixels.shape != photo.read(path).pixels.shape:
            wrong.append(f"{result.name} has another shape")
    return wrong + [f"{path.name} was left" for path in left_aside(out)]


def kill_batches(kills: int, photos: int, seed: int, counts: Counts) -> None:
    """Kill batches with all their workers, let a last one end, and count what happened."""
    rng = np.random.default_rng(seed)
    with _folders() as (folder, temporary):
        inputs, out = folder / "in", folder / "out"
        damaged = make_photos(inputs, photos, rng)
        before = {path: path.read_bytes() for path in inputs.iterdir()}
        for _ in range(kills):
            if rng.random() < 0.5:
                shutil.rmtree(out, ignore_errors=True)
            running = subprocess.Popen(
                batch_of(inputs, out), stderr=subprocess.DEVNULL, start_new_session=True
            )
            time.sleep(rng.uniform(*BATCH_SECONDS))
            counts["batch had ended before"] += running.poll() is not None
            with contextlib.suppress(ProcessLookupError):
                os.killpg(running.pid, signal.SIGKILL)
            running.wait()
            counts["killed in a batch"] += 1
            counts["left something aside until the next run"] += bool(left_aside(out))
            counts.update(unreadable(out))
            counts.update(left_for_good(folder, temporary))
        counts["a source or a project has changed"] += before != {
            path: path.read_bytes() for path in inputs.iterdir() if path in before
        }
        subprocess.run(batch_of(inputs, out), capture_output=True, check=False)
        counts.update(unfinished(inputs, out, damaged))


# ---- signals --------------------------------------------------------------------------------


def told_to_end(words: list[str], folder: Path, seconds: float, rng: Rng, of_group: bool) -> str:
    """Start a program, signal it at a random moment, and return what became of it."""
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "XDG_DATA_HOME": str(folder)}
    program = subprocess.Popen(
        words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        text=True, env=environment, start_new_session=True,
    )  # fmt: skip
    while program.poll() is None and not _hears(program.pid):
        time.sleep(0.002)
    time.sleep(rng.uniform(0.0, seconds))
    number = signal.Signals(rng.choice([signal.SIGINT, signal.SIGTERM, signal.SIGHUP]))
    had_ended = program.poll() is not None
    told = time.perf_counter()
    with contextlib.suppress(ProcessLookupError):
        (os.killpg if of_group else os.kill)(program.pid, number)
    try:
        _, said = program.communicate(timeout=10.0)
    except subprocess.TimeoutExpired:
        os.killpg(program.pid, signal.SIGKILL)
        program.communicate()
        return f"never ended ({number.name})"
    took = time.perf_counter() - told
    lines = [line for line in said.splitlines() if _QT_OFFSCREEN not in line]
    if took > LONGEST_END_S:
        return "took more than 2 s"
    if had_ended or program.returncode == 0:  # a batch says a line of its own
        return "had ended"
    # Of photos that it can't read a batch tells as it comes to them.
    said_once = sum("interrupted" in line for line in lines) == 1 and "interrupted" in lines[-1]
    if program.returncode != 130 or not said_once or "Traceback" in said:
        return f"ended by {program.returncode} and {len(lines)} lines ({number.name}): {lines}"
    return "ended by 130 and one line"


def _hears(process: int) -> bool:
    """Return whether a process has a handler for SIGTERM yet; before, Python itself is loaded."""
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{process}/status").read_text().splitlines():
            if line.startswith("SigCgt:"):
                return bool(int(line.split()[1], 16) >> (signal.SIGTERM - 1) & 1)
    return True


def signal_programs(count: int, photos: int, seed: int, counts: Counts) -> None:
    """Signal every kind of program `count` times, and count how they ended."""
    # A shell lets what it runs in the background ignore it, and so would the programs.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rng = np.random.default_rng(seed)
    with _folders() as (folder, temporary):
        inputs = folder / "in"
        make_photos(inputs, photos, rng)
        file = str(shutil.copy(assets.sample(), folder / "photo.jpg"))
        programs = {
            "warp": [*CLI, "warp", file, "-o", str(folder / "result.jpg"), "--force"],
            "in place": [*CLI, "warp", file, "--in-place", "--temporary"],
            "detect": [*CLI, "detect", file, "--json", "-"],
            "batch": [*batch_of(inputs, folder / "out"), "--force", "--again"],
            "edit": [*EDITOR, "--edit", "--temporary", file],
        }
        for name, words in programs.items():
            start = time.perf_counter()
            if name != "edit":
                subprocess.run(words, capture_output=True, check=False)
            seconds = min(time.perf_counter() - start, 4.0) if name != "edit" else 4.0
            for number in range(count):
                of_group = name == "batch" and number % 2 == 1
                became = told_to_end(words, folder, seconds, rng, of_group)
                counts[f"{name}: {became}"] += 1
                left = [*left_aside(folder), *temporary.iterdir()]
                counts[f"{name}: left something aside"] += bool(left)
                for path in left:
                    shutil.rmtree(path, ignore_errors=True)


def main() -> None:
    """Run and print the counts; end with 1 if anything was harmed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=300, help="one in ten in a batch")
    parser.add_argument("--photos", type=int, default=60, help="in a batch")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--signals", type=int, default=0, help="of each program, instead of kills")
    options = parser.parse_args()
    counts: Counts = collections.Counter()
    if options.signals:
        signal_programs(options.signals, options.photos, options.seed, counts)
    else:
        in_batches = round(BATCH_SHARE * options.kills)
        kill_savers(options.kills - in_batches, options.seed, counts)
        kill_batches(in_batches, options.photos, options.seed, counts)
    harmed = {what: count for what, count in counts.items() if not what.endswith(EXPECTED)}
    print(json.dumps({"seed": options.seed, **counts, "harmed": sum(harmed.values())}, indent=1))
    sys.exit(any(harmed.values()))


if __name__ == "__main__":
    main()
