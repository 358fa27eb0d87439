"""Both programs of a bundle: which of them, the name of the file that was started says."""

import os
import sys
import types
from pathlib import Path

# Set for the bundle's own libraries, which other programs, a browser say, must not find.
_OURS = ("LD_LIBRARY_PATH", "QT_PLUGIN_PATH", "QML2_IMPORT_PATH")
# What a batch starts beside its workers, to clean up after them.
_TRACKER = "from multiprocessing.resource_tracker import main"


def _forget_where_we_lie() -> None:
    for name in _OURS:
        os.environ.pop(name, None)
        before = os.environ.pop(f"{name}_ORIG", None)
        if before is not None:
            os.environ[name] = before
    # The workers that a batch starts find them by themselves then, as if started by a user.
    os.environ["PYINSTALLER_RESET_ENVIRONMENT"] = "1"


def _without_opengl() -> None:
    """Say yes to pyqtgraph, which imports these at once, and uses them to paint by OpenGL only."""
    for name in ("QtOpenGL", "QtOpenGLWidgets"):
        module = types.ModuleType(f"PySide6.{name}")
        vars(module)["QOpenGLWidget"] = object
        sys.modules[module.__name__] = module


def _be_a_worker() -> None:
    """Do what multiprocessing has started this program for, if it has.

    PyInstaller's own code for it loads multiprocessing at every start.
    """
    if "--multiprocessing-fork" in sys.argv[1:2]:
        from multiprocessing import spawn

        spawn.freeze_support()
    elif sys.argv[-2:-1] == ["-c"] and sys.argv[-1].startswith(_TRACKER):
        exec(sys.argv[-1])
        sys.exit()


if __name__ == "__main__":
    _be_a_worker()
    _forget_where_we_lie()
    if Path(sys.executable).stem == "kogao-cli":
        from kogao_core.cli import main as command_line

        command_line()
    else:
        _without_opengl()
        from kogao_app.__main__ import main as window

        sys.exit(window())
