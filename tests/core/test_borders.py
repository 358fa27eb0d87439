"""Rooms keep their doors shut: the core and the command line never load Qt."""

import subprocess
import sys

import pytest

PROBE = """
import sys, {module}
qt = sorted(m for m in sys.modules if m.split('.')[0] in ('PySide6', 'shiboken6', 'pyqtgraph'))
print(qt[:5]); raise SystemExit(bool(qt))
"""


@pytest.mark.parametrize(
    "module", ["kogao_core.pipeline", "kogao_core.landmarks", "kogao_core.cli"]
)
def test_core_imports_no_qt(module):
    done = subprocess.run(
        [sys.executable, "-c", PROBE.format(module=module)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
