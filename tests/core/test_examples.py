"""Docstrings tell what the house promises; examples in them and in the manual do what they show."""

import ast
import doctest
import importlib
import inspect
import pkgutil
import re
from pathlib import Path

import pytest
from modules import ROOT, modules, tree

import kogao_core

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
MODULES = sorted(
    found.name
    for found in pkgutil.walk_packages(kogao_core.__path__, "kogao_core.")
    if ">>>" in Path(importlib.util.find_spec(found.name).origin).read_text(encoding="utf-8")
)
# Made to be subclassed, or filled in by whoever adds an overlay or a panel.
FOR_OTHERS = {"Feature", "Context", "Dialog", "Overlay", "FrameOverlay", "Viewport", "SecondView"}
SECTION = re.compile(r"^ *[A-Z]\w+\n *-{3,}$", re.MULTILINE)
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PAGES = [
    page
    for page in sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
    if BLOCK.search(page.read_text(encoding="utf-8"))
]


def promised():
    """Yield the promised functions and classes, and the classes' public methods with arguments."""
    for name in kogao_core.__all__:
        found = getattr(kogao_core, name)
        if inspect.isroutine(found):
            yield pytest.param(found, id=name)
        elif inspect.isclass(found) and not issubclass(found, Exception):
            yield pytest.param(found, id=name)
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
    own = documented.__qualname__.partition(".")[0]  # the first line says what it returns
    if not inspect.isclass(documented) and signature.return_annotation not in ("None", own):
        wanted.append("Returns")
    return [name for name in wanted if f"\n{name}\n{'-' * len(name)}\n" not in text]


def unnamed(documented):
    """The parameters that the Parameters section doesn't name."""
    text = inspect.getdoc(documented)
    section = re.search(r"\nParameters\n-+\n(.*?)(\n\n\w+\n-+\n|\Z)", text, re.DOTALL)
    told = re.findall(r"^(\w+(?:, \w+)*)(?: : |$)", section[1] if section else "", re.MULTILINE)
    names = {name for line in told for name in line.split(", ")}
    return [name for name in parameters(documented) if name not in names]


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


@pytest.mark.parametrize("documented", list(promised()))
def test_what_is_promised_tells_what_it_takes_and_gives(documented):
    missing = set(lacks(documented))
    if "." in documented.__qualname__:  # examples are in the class's or the function's docstring
        missing -= {"Examples"}
    assert missing == set()
    assert unnamed(documented) == []


def documented(path):
    """Yield what stands at a module's top and in its classes, with the name of the outermost."""
    for outer in tree(path).body:
        if isinstance(outer, ast.ClassDef | ast.FunctionDef):
            for node in ast.walk(outer):
                if isinstance(node, ast.ClassDef | ast.FunctionDef):
                    yield outer.name, node


def test_what_is_not_promised_is_told_in_lines_without_sections():
    allowed = FOR_OTHERS | set(kogao_core.__all__) | {"load", "apply"}  # `load_project`
    spun_out = [
        f"{path.relative_to(ROOT)}: {node.name}"
        for folder in ("kogao_core", "app", "resources")
        for path in modules(folder, ROOT).values()
        if "integrations" not in path.parts  # they run in other programs, by those programs' rules
        if SECTION.search(path.read_text(encoding="utf-8"))
        for outer, node in documented(path)
        if outer not in allowed and SECTION.search(ast.get_docstring(node) or "")
    ]
    assert spun_out == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_blocks_of_python_in_the_manual_run_in_turn(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in BLOCK.findall(page.read_text(encoding="utf-8")):
        exec(compile(block, page.name, "exec"), names)
