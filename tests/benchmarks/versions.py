"""Compare commits in turns: ``python tests/benchmarks/versions.py COMMIT... [--photos F...]``.

Each commit and HEAD print `warp --help` and warp each photo to JPEG, from a temporary worktree with
compiled modules, in the installed environment. The first commit is the unit. Linux or macOS.
"""

from __future__ import annotations

import argparse
import functools
import shlex
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from processes import Cost, run

from kogao_core.lab.reports.spread import in_turns

ROOT = Path(__file__).resolve().parents[2]
CALL = "import sys; sys.path.insert(0, sys.argv.pop(1)); from kogao_core.cli import main; main()"


def main() -> None:
    """Print the median wall and processor time of each version, and the ratio to the unit."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("commits", nargs="+")
    parser.add_argument("--photos", nargs="*", type=Path, default=[])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--head", default="", help="options of warp for HEAD alone")
    options = parser.parse_args()
    versions = [*options.commits, "HEAD"]
    with tempfile.TemporaryDirectory(prefix="kogao-") as folder:
        for commit in versions:
            _worktree(commit, Path(folder, commit))
        try:
            _compare("warp --help", ["warp", "--help"], versions, Path(folder), options)
            for photo in options.photos:
                words = ["warp", photo.resolve(), "-o", Path(folder, "out.jpg"), "--force"]
                _compare(photo.name, words, versions, Path(folder), options)
        finally:
            for commit in versions:
                _git("worktree", "remove", "--force", Path(folder, commit))


def _worktree(commit: str, place: Path) -> None:
    """Check out a commit with the networks of this checkout, and compile the modules."""
    _git("worktree", "add", "--detach", place, commit)
    for network in (ROOT / "resources" / "models").glob("*.tflite"):
        shutil.copy(network, place / "resources" / "models")
    (place / "kogao_resources").mkdir()  # as in an installation
    path = f"__path__ = [{str(place / 'resources')!r}]\n"
    (place / "kogao_resources" / "__init__.py").write_text(path, encoding="utf-8")
    run(sys.executable, "-m", "compileall", "-q", place / "kogao_core")


def _git(*words: object) -> None:
    subprocess.run(["git", "-C", ROOT, *map(str, words)], check=True, capture_output=True)


def _compare(
    name: str, words: list[object], versions: list[str], folder: Path, options: argparse.Namespace
) -> None:
    more = {"HEAD": shlex.split(options.head)} if len(words) > 2 else {}
    works = {
        commit: functools.partial(
            run, sys.executable, "-c", CALL, folder / commit, *words, *more.get(commit, [])
        )
        for commit in versions
    }
    found: dict[str, list[Cost]] = {commit: [] for commit in versions}
    for commit, counts in in_turns(versions, options.rounds, 1):
        cost = works[commit]()
        if counts:
            found[commit].append(cost)
    unit = found[versions[0]]
    for commit, costs in found.items():
        (wall, walls), (cpu, cpus) = (
            [statistics.median(getattr(one, kind) for one in some) for some in (costs, unit)]
            for kind in ("wall_ms", "cpu_ms")
        )
        print(
            f"{name:24.24} {commit:10.10} wall {wall:7.0f} ms ({wall / walls:.2f})   "
            f"processor {cpu:7.0f} ms ({cpu / cpus:.2f})",
            flush=True,
        )


if __name__ == "__main__":
    main()
