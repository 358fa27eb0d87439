"""Rooms keep their doors shut: the core loads no Qt, the program nothing that trains its models."""

import ast
import subprocess
import sys

import pytest
from modules import ROOT, tree

PROBE = """
import sys, {module}
qt = sorted(m for m in sys.modules if m.split('.')[0] in ('PySide6', 'shiboken6', 'pyqtgraph'))
print(qt[:5]); raise SystemExit(bool(qt))
"""


@pytest.mark.parametrize(
    "module", ["kogao_core.pipeline", "kogao_core.faces.landmarks", "kogao_core.cli"]
)
def test_core_imports_no_qt(module):
    done = subprocess.run(
        [sys.executable, "-c", PROBE.format(module=module)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def imports(file):
    """The modules that a file names in its import statements, lazy ones included."""
    for node in ast.walk(tree(file)):
        if isinstance(node, ast.Import):
            yield from (one.name for one in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module


@pytest.mark.parametrize("room", ["kogao_core", "app"])
def test_the_program_imports_nothing_of_what_trains_its_models(room):
    files = sorted((ROOT / room).rglob("*.py"))
    assert files
    found = [(str(file), name) for file in files for name in imports(file)]
    assert [one for one in found if "resources" in one[1].split(".")[0]] == []
