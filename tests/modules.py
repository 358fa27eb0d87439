"""The modules of a package as files, and what of them no running program sees."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]


def modules(package, below):
    """Return the path of every module of a package by its name, counted from a folder on."""
    found = {}
    for path in (ROOT / package).rglob("*.py"):
        parts = path.relative_to(below).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def tree(path):
    """Return a module's syntax tree, parsed once for all tests that look at it."""
    return ast.parse(path.read_text(encoding="utf-8"))


def for_types_only(tree):
    """Return the nodes that no running program sees."""
    blocks = (n for n in ast.walk(tree) if isinstance(n, ast.If))
    return {
        node
        for block in blocks
        if ast.unparse(block.test) == "TYPE_CHECKING"
        for inner in block.body
        for node in ast.walk(inner)
    }
