"""Start one of the two programs of a bundle, by the name of the executable."""

import os
import sys
import types
from pathlib import Path

# Variables for the bundle's libraries. Other programs, such as a browser, must not get these.
_OURS = ("LD_LIBRARY_PATH", "QT_PLUGIN_PATH", "QML2_IMPORT_PATH")
# multiprocessing starts this command to clean up after workers.
_TRACKER = "from multiprocessing.resource_tracker import main"


def _restore_environment() -> None:
    for name in _OURS:
        os.environ.pop(name, None)
        before = os.environ.pop(f"{name}_ORIG", None)
        if before is not None:
            os.environ[name] = before
    # Worker processes then set their own variables, as if a user had started them.
    os.environ["PYINSTALLER_RESET_ENVIRONMENT"] = "1"


def _without_opengl() -> None:
    """Add empty modules for pyqtgraph, which imports these but uses them for OpenGL only."""
    for name in ("QtOpenGL", "QtOpenGLWidgets"):
        module = types.ModuleType(f"PySide6.{name}")
        vars(module)["QOpenGLWidget"] = object
        sys.modules[module.__name__] = module


def _run_worker() -> None:
    """Run a worker process if multiprocessing has started this program.

    PyInstaller's own function would import multiprocessing at every start.
    """
    if "--multiprocessing-fork" in sys.argv[1:2]:
        from multiprocessing import spawn

        spawn.freeze_support()
    elif sys.argv[-2:-1] == ["-c"] and sys.argv[-1].startswith(_TRACKER):
        exec(sys.argv[-1])
        sys.exit()


if __name__ == "__main__":
    _run_worker()
    _restore_environment()
    if Path(sys.executable).stem == "kogao-cli":
        from kogao_core.cli import main as command_line

        command_line()
    else:
        _without_opengl()
        from kogao_app.__main__ import main as window

        sys.exit(window())
