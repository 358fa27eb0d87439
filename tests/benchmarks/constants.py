"""List the constants that can be halved or doubled without a failing test.

``python tests/benchmarks/constants.py [ROOM ...]``, with rooms such as ``kogao_core/warp`` or
modules such as ``kogao_core/warp/guard.py``. Each module-level number is changed in a process of
its own, which runs the stored scenes and then the tests that import the module.
"""

from __future__ import annotations

import ast
import importlib
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("kogao_core/warp", "kogao_core/background", "kogao_core/faces")
SCENES = ROOT / "tests/core/test_pinned.py"
# Constants that by nature change only time, memory or rounding, and why.
NEUTRAL = {
    "warp.brush._JOINED": "joined lattices have the same sum",
    "warp.brush._MOST_KEPT": "results that are not kept are computed again",
    "warp.canvas.BLOCK_WIDTH_PX": "smaller blocks skip more pixels that don't move",
    "warp.canvas._STRIP_ROWS": "rows are computed in more or fewer steps",
    "warp.canvas._TILE_PX": "tiles are computed one by one",
    "warp.domain._LARGEST_CELL_PX": "smaller cells skip more pixels that don't move",
    "warp.domain._STRIP_PX": "rows are computed in more or fewer steps",
    "warp.field._INVERSION_STEPS": "most points need fewer steps",
    "warp.field._INVERTED_PX": "an error that nobody sees; smaller ones take longer",
    "warp.field._MOST_AHEAD": "bounds steps near a fold; the solution is the same",
    "warp.fit._BISECTIONS": "more steps are more exact than control points are",
    "warp.fit._FINER_PROOF": "bounds the memory of a proof",
    "warp.fit._LEAST_RIDGE": "is far below what moves a landmark",
    "warp.guard._BISECTIONS": "more steps are more exact than anybody sees",
    "warp.lens._LEAST_DEPTH": "avoids a division by zero far outside a head",
    "warp.one_to_one._HALVINGS": "a tighter bound takes longer",
    "warp.protection._LEAST_STEP_PX": "an eraser cuts to a quarter of a pixel",
    "warp.resample.ROWS_PX": "products of other sizes have the same result",
    "warp.resample.CALL_PX": "pixels are computed in more or fewer steps",
    "warp.resample.BLOCK_HEIGHT_PX": "smaller blocks skip more pixels that don't move",
    "warp.resample.SMALL_BLOCK_HEIGHT_PX": "smaller blocks skip more pixels that don't move",
    "warp.resample._SMALL_IMAGE_PX": "selects one of two block heights",
    "warp.resample._THREAD_PX": "the number of threads changes no byte",
    "warp.resample._MARGIN_PX": "is doubled until no displacement is longer",
    "warp.resample.KERNEL_REACH_PX": "is twice the reach of Lanczos 4; more changes nothing",
    "warp.surround._DIRECTIONS": "samples a box that is larger than what moves",
    "background.holding._SMALL": "matrices are split into more or fewer parts",
    "faces.landmarks.pixels._ROWS": "rows are computed in more or fewer steps",
}


def constants(room: str) -> Iterator[tuple[str, str]]:
    """Yield module and name of each constant of a room that holds numbers."""
    target = ROOT / room
    for path in [target] if target.is_file() else sorted(target.rglob("*.py")):
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            name = getattr(getattr(node, "target", None), "id", "")
            if name.isupper() and changed(getattr(importlib.import_module(module), name), 2.0):
                yield module, name


def changed(value: Any, factor: float) -> tuple[Any, ...]:
    """Return a changed value in a tuple of one; an empty tuple if it holds no numbers."""
    if isinstance(value, int) and not isinstance(value, bool):
        return (max(1, round(value * factor)),) if value > 1 else ()
    if isinstance(value, float) or (isinstance(value, np.ndarray) and value.dtype.kind == "f"):
        return (value * factor,) if np.any(value) else ()
    # Tuples of whole numbers are labels.
    numbers = {type(one) for one in value} if isinstance(value, tuple) else set()
    if numbers in ({float}, {int, float}):
        return (tuple(type(one)(one * factor) for one in value),)
    return ()


def survives(module: str, name: str, factor: float, *tests: Path) -> bool:
    """Return whether no test notices a changed constant."""
    if child := os.fork():
        return os.waitpid(child, 0)[1] == 0
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    old = getattr(sys.modules[module], name)
    (new,) = changed(old, factor)
    for other in [one for key, one in sys.modules.items() if key.startswith("kogao_core")]:
        if getattr(other, name, None) is old:
            setattr(other, name, new)
    os._exit(int(pytest.main(["-qx", "-p", "no:cacheprovider", *map(str, tests)])))


def importing(module: str) -> list[Path]:
    """Return the test files that import a module."""
    files = sorted((ROOT / "tests/core").glob("test_*.py"))
    package, _, name = module.rpartition(".")
    imported = re.compile(rf"from {module} |from {package} import .*\b{name}\b")
    return [one for one in files if imported.search(one.read_text(encoding="utf-8"))]


def main() -> None:
    """Print each survivor, the neutral constants, and the counts."""
    found = [one for room in sys.argv[1:] or ROOMS for one in constants(room)]
    survivors = 0
    for module, name in found:
        full = f"{module}.{name}"
        if reason := NEUTRAL.get(full.removeprefix("kogao_core.")):
            print(f"{full}: changes no result: {reason}", flush=True)
            continue
        tests = SCENES, *importing(module)
        factors = [f"x {k:g}" for k in (0.5, 2.0) if survives(module, name, k, *tests)]
        survivors += bool(factors)
        if factors:
            print(f"{full}: survives {' and '.join(factors)}", flush=True)
    print(f"{len(found)} constants, {survivors} survive halving or doubling")


if __name__ == "__main__":
    main()
