"""List the constants that can be halved or doubled without a failing test.

``python tests/benchmarks/constants.py [ROOM ...]``, with rooms such as ``kogao_core/field`` or
modules such as ``kogao_core/additions/guard.py``. The core's tests run once, to record the
functions that each test calls. Each module-level number is then changed in a process of its own.
This process runs the tests that call a function with that number, until one fails.
"""

from __future__ import annotations

import ast
import importlib
import os
import pickle
import resource
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, NamedTuple

import numpy as np
import pytest

# Of each test: processor time, s, and keys of the constants in the functions that it calls.
Reach = dict[int, tuple[float, set[str]]]
ROOT = Path(__file__).resolve().parents[2]
ROOMS = (
    "kogao_core/paper",
    "kogao_core/field",
    "kogao_core/additions",
    "kogao_core/resample",
    "kogao_core/background",
    "kogao_core/faces",
)
SCENES = "test_pinned.py"  # most mutants change a stored scene
MOST_S = 240  # processor time, s, after which a mutant counts as noticed
# Constants that by nature change only time, memory or rounding, and why.
NEUTRAL = {
    "additions.brush._JOINED": "joined lattices have the same sum",
    "additions.brush._MOST_KEPT": "results that are not kept are computed again",
    "resample.canvas.BLOCK_WIDTH_PX": "smaller blocks skip more pixels that don't move",
    "resample.canvas._STRIP_ROWS": "rows are computed in more or fewer steps",
    "resample.canvas._TILE_PX": "tiles are computed one by one",
    "paper.domain._LARGEST_CELL_PX": "smaller cells skip more pixels that don't move",
    "paper.domain._STRIP_PX": "rows are computed in more or fewer steps",
    "field.field._INVERSION_STEPS": "most points need fewer steps",
    "field.field._INVERTED_PX": "an error that nobody sees; smaller ones take longer",
    "field.field._MOST_AHEAD": "bounds steps near a fold; the solution is the same",
    "additions.exact._BISECTIONS": "more steps are more exact than control points are",
    "additions.fit._FINER_PROOF": "bounds the memory of a proof",
    "additions.exact._LEAST_RIDGE": "is far below what moves a landmark",
    "additions.guard._BISECTIONS": "more steps are more exact than anybody sees",
    "additions.lens._LEAST_DEPTH": "avoids a division by zero far outside a head",
    "field.one_to_one._HALVINGS": "a tighter bound takes longer",
    "field.protection._LEAST_STEP_PX": "an eraser cuts to a quarter of a pixel",
    "resample.blocks.ROWS_PX": "products of other sizes have the same result",
    "resample.blocks.CALL_PX": "pixels are computed in more or fewer steps",
    "resample.blocks.BLOCK_HEIGHT_PX": "smaller blocks skip more pixels that don't move",
    "resample.blocks.SMALL_BLOCK_HEIGHT_PX": "smaller blocks skip more pixels that don't move",
    "resample.blocks._SMALL_IMAGE_PX": "selects one of two block heights",
    "resample.blocks._THREAD_PX": "the number of threads changes no byte",
    "resample.blocks._MARGIN_PX": "is doubled until no displacement is longer",
    "resample.blocks.KERNEL_REACH_PX": "is twice the reach of Lanczos 4; more changes nothing",
    "additions.head._DIRECTIONS": "samples a box that is larger than what moves",
    "background.holding._SMALL": "matrices are split into more or fewer parts",
    "faces.landmarks.mesh._NO_PRESENCE": "ends early for boxes that `_trust` refuses",
    "faces.landmarks.pixels._ROWS": "rows are computed in more or fewer steps",
}


class Constant(NamedTuple):
    """A name at the top of a module."""

    module: str
    name: str

    @property
    def key(self) -> str:
        """The name, with the module's if it is private."""
        return ".".join(self) if self.name.startswith("_") else self.name


def assigned(module: str) -> Iterator[tuple[str, ast.expr, set[str]]]:
    """Yield each constant of a module, its expression, and the constants in that expression."""
    for node in ast.parse(Path(str(sys.modules[module].__file__)).read_text("utf-8")).body:
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.value:
            names = {one.id for one in ast.walk(node.value) if isinstance(one, ast.Name)}
            yield node.target.id, node.value, {name for name in names if name.isupper()}


def constants(room: str) -> Iterator[Constant]:
    """Yield each constant of a room that holds numbers and isn't computed from others."""
    target = ROOT / room
    for path in [target] if target.is_file() else sorted(target.rglob("*.py")):
        module = module_of(path)
        room_of = vars(importlib.import_module(module))
        for name, _, others in assigned(module):
            if name.isupper() and not others and changed(room_of[name], 2.0):
                yield Constant(module, name)


def module_of(path: Path) -> str:
    """Return the name of a module of ours."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)


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


def modules_of(constant: Constant) -> list[str]:
    """Return the modules that can use a constant by its name."""
    if constant.key != constant.name:
        return [constant.module]
    here = [name for name, one in sys.modules.items() if is_ours(getattr(one, "__file__", None))]
    return [name for name in here if hasattr(sys.modules[name], constant.name)]


def is_ours(path: str | None) -> bool:
    """Return whether a file is the core's or a test."""
    return Path(path or "/").is_relative_to(ROOT)


def with_derived(constant: Constant) -> dict[Constant, ast.expr | None]:
    """Return a constant and those computed from it, with their expressions, in that order."""
    found: dict[Constant, ast.expr | None] = {constant: None}
    waiting = [constant]
    for one in waiting:
        for module in modules_of(one):
            for name, value, others in assigned(module):
                new = Constant(module, name)
                if one.name in others and new not in found:
                    found[new] = value
                    waiting.append(new)
    return found


def change(constant: Constant, factor: float) -> None:
    """Change a constant and those computed from it, in all modules that import them."""
    for one, value in with_derived(constant).items():
        room = vars(sys.modules[one.module])
        old = room[one.name]
        new = changed(old, factor)[0] if value is None else eval(ast.unparse(value), room)
        for module in modules_of(one):
            if getattr(sys.modules[module], one.name) is old:
                setattr(sys.modules[module], one.name, new)


def in_fork(function: Callable[..., Any], *given: Any) -> Any:
    """Return the result of a function in a process of its own; -1 if the process ends early."""
    end, start = os.pipe()
    if not (child := os.fork()):
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        with os.fdopen(start, "wb") as pipe:
            pickle.dump(function(*given), pipe)
        os._exit(0)
    os.close(start)
    with os.fdopen(end, "rb") as pipe:
        result = pipe.read()
    os.waitpid(child, 0)
    return pickle.loads(result) if result else -1


class Mutants:
    """Plugin of pytest that runs the tests of each mutant in a process of its own."""

    def __init__(self, rooms: Sequence[str]) -> None:
        self._rooms = rooms
        self._failed = False
        self._kills: dict[int, int] = {}  # the tests that noticed mutants: the latest is largest

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note a failure."""
        self._failed |= report.failed

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Print each survivor, the neutral constants, and the counts."""
        reach = in_fork(self._recorded, session.items)
        found = [one for room in self._rooms for one in constants(room)]
        survivors = 0
        for one in found:
            full = ".".join(one)
            if reason := NEUTRAL.get(full.removeprefix("kogao_core.")):
                print(f"{full}: changes no result: {reason}", flush=True)
                continue
            alive = [k for k in (0.5, 2.0) if self._survives(session.items, reach, one, k)]
            survivors += bool(alive)
            if alive:
                print(f"{full}: survives {' and '.join(f'x {k:g}' for k in alive)}", flush=True)
        print(f"{len(found)} constants, {survivors} survive halving or doubling")
        return True

    def _passes(self, item: pytest.Item) -> bool:
        self._failed = False
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
        return not self._failed

    def _recorded(self, items: Sequence[pytest.Item]) -> Reach:
        """Return processor time and reached constants of each passing test by its number."""
        codes: set[CodeType] = set()

        def note(frame: FrameType, event: str, _: object) -> None:
            if event == "call":
                codes.add(frame.f_code)

        threading.setprofile(note)
        found = {}
        for number, item in enumerate(items):
            codes.clear()
            start = time.process_time()
            sys.setprofile(note)
            passes = self._passes(item)
            sys.setprofile(None)
            if passes:
                found[number] = time.process_time() - start, keys_in(list(codes))
        return found

    def _survives(
        self, items: Sequence[pytest.Item], reach: Reach, constant: Constant, factor: float
    ) -> bool:
        """Return whether no test notices a changed constant. The likeliest tests run first."""
        keys = {one.key for one in with_derived(constant)}
        order = sorted(
            (number for number, (_, reached) in reach.items() if keys & reached),
            key=lambda one: (
                -self._kills.get(one, 0),
                items[one].path.name != SCENES,
                reach[one][0],
            ),
        )
        killer = in_fork(self._killer, [items[one] for one in order], constant, factor)
        if killer is not None and killer >= 0:
            self._kills[order[killer]] = len(self._kills) + 1
        return killer is None

    def _killer(
        self, items: Sequence[pytest.Item], constant: Constant, factor: float
    ) -> int | None:
        """Return the place of the first test that fails with a changed constant."""
        resource.setrlimit(resource.RLIMIT_CPU, (MOST_S, MOST_S))
        change(constant, factor)
        return next((place for place, one in enumerate(items) if not self._passes(one)), None)


def keys_in(codes: Sequence[CodeType]) -> set[str]:
    """Return the keys of the constants that these functions of ours use."""
    found = set()
    for code in codes:
        if is_ours(code.co_filename):
            module = module_of(Path(code.co_filename))
            found |= {Constant(module, name).key for name in code.co_names if name.isupper()}
    return found


if __name__ == "__main__":
    options = ["-qs", "-p", "no:cacheprovider", "--no-header", str(ROOT / "tests/core")]
    sys.exit(pytest.main(options, plugins=[Mutants(sys.argv[1:] or ROOMS)]))
