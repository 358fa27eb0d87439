"""Imports point one way, as ARCHITECTURE.md draws it, and parts of one system are guarded."""

import ast
import re
from functools import cache
from graphlib import TopologicalSorter

from modules import ROOT, for_types_only, modules, tree

CORE = "kogao_core"
# Modules and attributes that Windows lacks, and paths that only Linux has.
LACKING = re.compile(
    r"\b(?:import|from) (?:fcntl|grp|posix|pty|pwd|resource|termios|tty)\b"
    r"|\bos\.(?:fork|forkpty|getuid|geteuid|getgid|killpg|getpgid|setsid|mkfifo|chown|fchmod"
    r"|sched_getaffinity|O_DIRECTORY|O_NOFOLLOW)\b"
    r"|\bsignal\.(?:pthread_sigmask|SIGKILL|SIGHUP|setitimer)\b"
    r"""|["'](?:/proc/|/sys/|/dev/shm|/tmp)"""
)
# How each module does without on other systems.
ALLOWED = {
    "kogao_core/base/atomic.py": "imports fcntl in a try; locks by msvcrt; keeps owners on POSIX",
    "kogao_core/batch/workers.py": "starts workers by spawn elsewhere; masks signals on POSIX",
    "kogao_core/cli/doctor.py": "speaks of apt-get on Linux only",
    "kogao_core/base/machine.py": "names the processor by `platform` elsewhere",
    "kogao_core/photo/filling.py": "copies decoded pixels elsewhere",
    "kogao_core/photo/jpeg/coefficients.py": "reads nothing ahead elsewhere",
    "kogao_core/photo/reading.py": "assumes enough memory where there is no /proc/meminfo",
}


def imported(path, known, types):
    """Return what a module imports, at its top or later; of the core, module by module."""
    unseen = set() if types else for_types_only(tree(path))
    found = set()
    for node in ast.walk(tree(path)):
        if node in unseen:
            continue
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: names of the core are written in full"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found |= {name if name in known else node.module for name in names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return found


@cache
def graph(types=False):
    """Return what each module imports; with `types`, also what only type checkers import."""
    known = modules(CORE, ROOT)
    return {name: imported(path, known, types) for name, path in known.items()}


def rooms():
    """Return the rooms of the core in the order in which the document names them."""
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    return re.search(r"^Imports point one way.*?```\n(.*?)```", text, re.DOTALL | re.MULTILINE)[
        1
    ].split()


def room(name):
    """Return the room of a module: what stands beneath the package, "" for the package itself."""
    return [*name.split("."), ""][1]


def test_every_room_imports_only_from_rooms_before_it():
    order = rooms()
    inner = {name: found for name, found in graph().items() if name != CORE}
    assert sorted(order) == sorted({room(name) for name in inner})
    wrong = [
        f"{name} imports {other}"
        for name, found in inner.items()
        for other in found
        if other.startswith(f"{CORE}.") and order.index(room(other)) > order.index(room(name))
    ]
    assert wrong == []


def test_measuring_needs_no_command_line():
    measuring = {
        name: found
        for name, found in graph().items()
        if room(name) == "lab" and not name.startswith(f"{CORE}.lab.commands")
    }
    assert measuring
    assert not [n for n, found in measuring.items() for one in found if room(one) == "cli"]


def test_no_module_imports_itself_by_way_of_others():
    # A package's own list of names stands for all of it, so it is no station on the way.
    lists = {name for name, path in modules(CORE, ROOT).items() if path.name == "__init__.py"}
    inner = {
        name: {other for other in found if other.startswith(CORE) and other not in lists}
        for name, found in graph(types=True).items()
        if name not in lists
    }
    assert list(TopologicalSorter(inner).static_order())


def test_the_core_knows_neither_the_editor_nor_qt_nor_how_models_are_made():
    roots = {other.split(".")[0] for found in graph().values() for other in found}
    assert not roots & {"app", "kogao_app", "PySide6", "pyqtgraph", "shiboken6"}
    ways = re.compile(r"^\s*(?:from|import) (?:\w+_)?resources\b.*", re.MULTILINE)
    texts = {path.name: path.read_text(encoding="utf-8") for path in sources(CORE, "app")}
    assert {name: ways.findall(text) for name, text in texts.items() if ways.search(text)} == {}


def sources(*folders):
    return [path for folder in folders for path in (ROOT / folder).rglob("*.py")]


def test_the_name_of_a_class_means_one_thing():
    places = {}
    for path in sources(CORE, "app", "resources"):
        for name in re.findall(r"^ *class (\w+)", path.read_text(encoding="utf-8"), re.MULTILINE):
            places.setdefault(name, []).append(path.name)
    assert {name: paths for name, paths in places.items() if len(paths) > 1} == {}


def test_the_work_is_written_out_once():
    """Command, batch and editor hand it to `retouch`, which discloses, signs and writes."""
    steps = re.compile(r"(?<!def )(?<![.\w])(?:disclose|undisclosed)\(")
    users = [path for path in sources(CORE, "app") if steps.search(path.read_text("utf-8"))]
    assert users == [ROOT / CORE / "retouch.py"]


def test_only_listed_modules_use_what_some_systems_lack():
    """`.ci/run` also checks the types as on Windows and macOS."""
    found = {
        path.relative_to(ROOT).as_posix()
        for path in sources("app", CORE)
        if LACKING.search(path.read_text(encoding="utf-8"))
    }
    assert found == set(ALLOWED)
