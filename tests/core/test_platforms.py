"""Modules that use what only POSIX or Linux has are on a list, and say how they do without.

`.ci/run` also checks the types as on Windows and macOS, where a use without a guard is an error.
"""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]
# Modules that Windows lacks.
POSIX_MODULES = {"fcntl", "grp", "posix", "pty", "pwd", "resource", "termios", "tty"}
# Attributes of `os`, `signal` and `multiprocessing` that Windows lacks.
POSIX_NAMES = {
    *("fork", "forkpty", "getuid", "geteuid", "getgid", "killpg", "getpgid", "setsid", "mkfifo"),
    *("chown", "fchmod", "sched_getaffinity", "pthread_sigmask", "SIGKILL", "SIGHUP", "setitimer"),
    *(
        "O_DIRECTORY",
        "O_NOFOLLOW",
    ),
}
LINUX_PATHS = ("/proc/", "/sys/", "/dev/shm", "/tmp")
# How each module does without on other systems.
ALLOWED = {
    "kogao_core/base/atomic.py": "imports fcntl in a try; locks by msvcrt; keeps owners on POSIX",
    "kogao_core/batch/workers.py": "starts workers by spawn elsewhere; masks signals on POSIX",
    "kogao_core/cli/doctor.py": "speaks of apt-get on Linux only",
    "kogao_core/lab/reports/report.py": "names the processor by `platform` elsewhere",
    "kogao_core/photo/jpeg/coefficients.py": "reads nothing ahead elsewhere",
    "kogao_core/photo/reading.py": "assumes enough memory where there is no /proc/meminfo",
}


def uses(path):
    """Yield (line, name) of everything in a module that only some systems have."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = {alias.name for alias in node.names} & POSIX_MODULES
        elif isinstance(node, ast.ImportFrom):
            names = {node.module or ""} & POSIX_MODULES
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            names = {node.attr} & POSIX_NAMES if node.value.id in {"os", "signal"} else set()
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            names = {path for path in LINUX_PATHS if node.value.startswith(path)}
        else:
            continue
        for name in names:
            yield node.lineno, name


def test_only_listed_modules_use_what_some_systems_lack():
    found = {
        path.relative_to(ROOT).as_posix()
        for folder in ("app", "kogao_core")
        for path in (ROOT / folder).rglob("*.py")
        if any(uses(path))
    }
    assert found == set(ALLOWED)
