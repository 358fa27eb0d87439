"""List the tuned constants that can be halved or doubled without a change of the stored scenes.

``python tests/benchmarks/constants.py [ROOM ...]``, with rooms such as ``kogao_core/warp`` or
modules such as ``kogao_core/warp/guard.py``. For each module-level number the command changes the
number in a process of its own and renders the scenes of `tests/pinned.py`. Constants that only save
time or memory survive by nature.
"""

from __future__ import annotations

import ast
import importlib
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

import numpy as np  # noqa: E402
import pinned  # noqa: E402

ROOMS = ("kogao_core/warp", "kogao_core/background", "kogao_core/faces")
FACTORS = (0.5, 2.0)


def constants(room: str) -> Iterator[tuple[str, str]]:
    """Yield module and name of each constant of a room that holds numbers."""
    target = ROOT / room
    for path in [target] if target.is_file() else sorted(target.rglob("*.py")):
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            target = getattr(node, "target", None) or (getattr(node, "targets", None) or [None])[0]
            name = getattr(target, "id", "")
            if name.isupper() and changed(getattr(importlib.import_module(module), name), 2.0):
                yield module, name


def changed(value: Any, factor: float) -> tuple[Any, ...]:
    """Return a changed value in a tuple of one; an empty tuple if it holds no numbers."""
    if isinstance(value, bool | str | bytes | dict) or value is None:
        return ()
    if isinstance(value, int):
        return (max(1, round(value * factor)),) if value > 1 else ()
    if isinstance(value, float) or (isinstance(value, np.ndarray) and value.dtype.kind == "f"):
        return (value * factor,)
    if isinstance(value, tuple) and value and all(type(one) in (int, float) for one in value):
        return (tuple(type(one)(one * factor) for one in value),)
    return ()


def survives(module: str, name: str, factor: float, stored: dict[str, Any]) -> bool:
    """Return whether no scene notices a changed constant."""
    if child := os.fork():
        return os.waitpid(child, 0)[1] == 0
    old = getattr(sys.modules[module], name)
    (new,) = changed(old, factor)
    for other in [one for key, one in sys.modules.items() if key.startswith("kogao_core")]:
        if getattr(other, name, None) is old:
            setattr(other, name, new)
    try:
        noticed = any(pinned.difference(key, now, stored[key]) for key, now in pinned.all_results())
    except BaseException:
        noticed = True
    os._exit(1 if noticed else 0)


def main() -> None:
    """Print each survivor, and the counts."""
    stored = json.loads(pinned.FILE.read_text(encoding="utf-8"))
    found = [one for room in sys.argv[1:] or ROOMS for one in constants(room)]
    left = 0
    for module, name in found:
        factors = [factor for factor in FACTORS if survives(module, name, factor, stored)]
        if factors:
            left += 1
            print(
                f"{module}.{name}: survives {' and '.join(f'x {one:g}' for one in factors)}",
                flush=True,
            )
    print(f"{len(found)} constants, {left} survive halving or doubling")


if __name__ == "__main__":
    main()
