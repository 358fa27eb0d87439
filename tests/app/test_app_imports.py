"""Imports and state of the editor flow one way, as ARCHITECTURE.md draws it."""

import ast
import re
from functools import cache
from graphlib import TopologicalSorter

from modules import ROOT, modules, tree

APP = ROOT / "app"


def imported(name, path, known):
    """Return which modules of the editor a module imports: at its top, later, or for types."""
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    found = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = [*package[: len(package) - node.level + 1], *(node.module or "").split(".")]
            start = ".".join(filter(None, base))
            full = (f"{start}.{alias.name}".strip(".") for alias in node.names)
            found |= {one if one in known else start for one in full}
    return found


@cache
def graph():
    known = modules("app", APP)
    return {name: imported(name, path, known) for name, path in known.items() if name}


def room(name):
    return name.split(".")[0]


def test_every_room_imports_only_from_floors_below():
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    block = re.search(r"tests/app/test_app_imports.*?```\n(.*?)```", text, re.DOTALL)[1]
    height = {one: floor for floor, line in enumerate(block.splitlines()) for one in line.split()}
    assert height.keys() == {room(name) for name in graph()}
    upwards = [
        f"{name} imports {other}"
        for name, found in graph().items()
        for other in found
        if room(other) != room(name) and height[room(other)] >= height[room(name)]
    ]
    assert upwards == []


def test_no_module_imports_itself_by_way_of_others():
    assert list(TopologicalSorter(graph()).static_order())


def test_the_window_knows_no_feature_and_the_editor_all_of_them():
    inside = graph()
    features = {
        name for name in modules("app", APP) if name.count(".") == 1 and room(name) == "features"
    }
    assert not [name for name in inside["window"] if room(name) == "features"]
    assert features <= inside["editor"] | {"features.feature"}


def at_once(made):
    """Yield the nodes below one but for lambdas, which run later."""
    for child in ast.iter_child_nodes(made):
        if not isinstance(child, ast.Lambda):
            yield child
            yield from at_once(child)


def names_bound(made):
    """Return the names, or patterns of names, of the actions that a class binds."""
    calls = (node for node in ast.walk(made) if isinstance(node, ast.Call))
    return {ast.unparse(call.args[0]) for call in calls if getattr(call.func, "attr", "") == "bind"}


def test_features_may_be_built_in_any_order_that_their_arguments_allow():
    """While it is built, a feature knows other features' actions as values, not by their names."""
    classes = [
        (path, made, built)
        for path in sorted((APP / "features").rglob("*.py"))
        for made in ast.walk(tree(path))
        if isinstance(made, ast.ClassDef)
        for built in made.body
        if getattr(built, "name", "") == "__init__"
    ]
    strangers = [
        f"{path.name}: {made.name} takes {name}"
        for path, made, built in classes
        for node in at_once(built)
        if isinstance(node, ast.Subscript) and ast.unparse(node.value) == "self.actions"
        if isinstance(node.slice, ast.Constant | ast.JoinedStr)
        if (name := ast.unparse(node.slice)) not in names_bound(made)
    ]
    assert len(classes) > 20
    assert strangers == []


VIEW = {"view", "shown", "_view", "_shown"}  # names of a `ViewState` in the editor


def test_the_state_of_the_view_is_set_in_one_way_and_nobody_orders_the_canvas_to_draw():
    strangers = []
    for path in sorted(APP.rglob("*.py")):
        for node in ast.walk(tree(path)):
            owner = getattr(node, "value", None)
            name = getattr(owner, "attr", getattr(owner, "id", ""))
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and name in VIEW:
                strangers.append(f"{path.name}:{node.lineno} writes {ast.unparse(node)}")
            if isinstance(node, ast.Attribute) and "redraw" in node.attr and name != "self":
                strangers.append(f"{path.name}:{node.lineno} calls {ast.unparse(node)}")
    assert strangers == []


def test_every_signal_says_what_it_carries_and_when():
    """In a comment above it, or in the section "Signals" of its class."""
    silent = []
    for path in sorted(APP.rglob("*.py")):
        lines = path.read_text(encoding="utf-8").splitlines()
        for made in (node for node in ast.walk(tree(path)) if isinstance(node, ast.ClassDef)):
            told = (ast.get_docstring(made) or "").partition("Signals\n---")[2]
            for node in made.body:
                call = getattr(node, "value", None)
                if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "Signal":
                    name = ast.unparse(node.targets[0])
                    if name not in told and not lines[node.lineno - 2].lstrip().startswith("# ("):
                        silent.append(f"{path.name}: {made.name}.{name}")
    assert silent == []
