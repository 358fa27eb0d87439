"""Examples in docstrings and in the manual do what they show."""

import doctest
import importlib
import inspect
import pkgutil
import re
from pathlib import Path

import pytest

import kogao_core

ROOT = Path(__file__).resolve().parents[2]
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
MODULES = sorted(
    found.name
    for found in pkgutil.walk_packages(kogao_core.__path__, "kogao_core.")
    if ">>>" in Path(importlib.util.find_spec(found.name).origin).read_text(encoding="utf-8")
)
# The paper's modules: whoever reads the paper beside them finds a number to try in each function.
PAPER = (
    *(
        "base.geometry",
        "recipe.recipe",
        "faces.face",
        "faces.targets",
        "warp.lattice",
        "warp.fit",
        "warp.field",
        "warp.dose",
        "warp.samples",
    ),
    *(
        "warp.one_to_one",
        "warp.guard",
        "warp.protection",
        "warp.domain",
        "warp.counts",
        "warp.canvas",
    ),
    *("pipeline", "projects.project", "projects.sidecar"),
    *(
        "faces.naturalness",
        "warp.bezier",
        "warp.falloff",
        "background.lines",
        "warp.limits",
        "faces.differences",
    ),
    *("batch.planning", "photo.reading", "photo.writing"),
)
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PAGES = [
    page
    for page in sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
    if BLOCK.search(page.read_text(encoding="utf-8"))
]


def public_functions():
    for name in PAPER:
        module = importlib.import_module(f"kogao_core.{name}")
        for what, function in inspect.getmembers(module, inspect.isfunction):
            if not what.startswith("_") and function.__module__ == module.__name__:
                yield pytest.param(function, id=f"{name}.{what}")


def promised():
    for name in kogao_core.__all__:
        found = getattr(kogao_core, name)
        if inspect.isroutine(found) or (
            inspect.isclass(found) and not issubclass(found, Exception)
        ):
            yield pytest.param(found, id=name)


def methods():
    """The public methods with arguments of the promised classes."""
    for name in kogao_core.__all__:
        found = getattr(kogao_core, name)
        if not inspect.isclass(found) or issubclass(found, Exception):
            continue
        for what in vars(found):
            method = getattr(found, what)
            if not what.startswith("_") and inspect.isfunction(method) and parameters(method):
                yield pytest.param(method, id=f"{name}.{what}")


def parameters(documented):
    return [name for name in inspect.signature(documented).parameters if name != "self"]


def lacks(documented):
    """The numpydoc sections that a function or a class should have and hasn't."""
    text = inspect.getdoc(documented)
    signature = inspect.signature(documented)
    wanted = ["Examples"]
    if signature.parameters:
        wanted.append("Parameters")
    if not inspect.isclass(documented) and signature.return_annotation != "None":
        wanted.append("Returns")
    return [name for name in wanted if f"\n{name}\n{'-' * len(name)}\n" not in text]


def unnamed(documented):
    """The parameters that the Parameters section doesn't name."""
    text = inspect.getdoc(documented)
    section = re.search(r"\nParameters\n-+\n(.*?)(\n\n\w+\n-+\n|\Z)", text, re.DOTALL)
    told = re.findall(r"^(\w+(?:, \w+)*)(?: : |$)", section[1] if section else "", re.MULTILINE)
    names = {name for line in told for name in line.split(", ")}
    return [name for name in parameters(documented) if name not in names]


def test_there_are_examples():
    assert len(MODULES) >= len(PAPER)
    assert PAGES


@pytest.mark.parametrize("name", ["kogao_core", *MODULES])
def test_docstring_examples_hold(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = doctest.DocTestFinder().find(importlib.import_module(name))
    # Each run looks at the files of all modules; most docstrings have nothing to run.
    examples = [one for one in found if one.examples]
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    assert examples
    for one in examples:
        runner.run(one)
    assert runner.failures == 0


@pytest.mark.parametrize("documented", [*public_functions(), *promised()])
def test_what_is_public_tells_what_it_takes_and_gives(documented):
    assert lacks(documented) == []
    assert unnamed(documented) == []


@pytest.mark.parametrize("method", list(methods()))
def test_promised_methods_tell_what_they_take_and_give(method):
    assert set(lacks(method)) <= {"Examples"}  # those are in the class's or the function's
    assert unnamed(method) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_blocks_of_python_in_the_manual_run_in_turn(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in BLOCK.findall(page.read_text(encoding="utf-8")):
        exec(compile(block, page.name, "exec"), names)
