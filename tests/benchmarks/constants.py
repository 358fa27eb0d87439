"""List the constants that can be halved or doubled without a failing test.

``python tests/benchmarks/constants.py [ROOM ...] [TEST ...]``, with rooms such as
``kogao_core/warp`` or modules such as ``kogao_core/warp/guard.py``, and test files (default: the
stored scenes). Each module-level number is changed in a process of its own, which runs the tests.
Constants that only save time or memory survive by nature.
"""

from __future__ import annotations

import ast
import importlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("kogao_core/warp", "kogao_core/background", "kogao_core/faces")
SCENES = ("tests/core/test_pinned.py",)


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
        return (value * factor,)
    if isinstance(value, tuple) and value and all(type(one) in (int, float) for one in value):
        return (tuple(type(one)(one * factor) for one in value),)
    return ()


def survives(module: str, name: str, factor: float, tests: tuple[str, ...]) -> bool:
    """Return whether no test notices a changed constant."""
    if child := os.fork():
        return os.waitpid(child, 0)[1] == 0
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    old = getattr(sys.modules[module], name)
    (new,) = changed(old, factor)
    for other in [one for key, one in sys.modules.items() if key.startswith("kogao_core")]:
        if getattr(other, name, None) is old:
            setattr(other, name, new)
    os._exit(int(pytest.main(["-qx", "-p", "no:cacheprovider", *tests])))


def main() -> None:
    """Print each survivor, and the counts."""
    tests = tuple(one for one in sys.argv[1:] if one.startswith("tests"))
    rooms = [one for one in sys.argv[1:] if one not in tests] or ROOMS
    found = [one for room in rooms for one in constants(room)]
    survivors = 0
    for module, name in found:
        factors = [f"x {k:g}" for k in (0.5, 2.0) if survives(module, name, k, tests or SCENES)]
        survivors += bool(factors)
        if factors:
            print(f"{module}.{name}: survives {' and '.join(factors)}", flush=True)
    print(f"{len(found)} constants, {survivors} survive halving or doubling")


if __name__ == "__main__":
    main()
