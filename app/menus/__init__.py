"""Everything the menus, keys and buttons can do, as data: a module for each menu."""

from . import assistance, compare, edit, experiments, face, file, manual, protect, view
from .compare import compare_action
from .protect import tool_action
from .spec import Spec
from .view import overlay_action

__all__ = ["MENUS", "Spec", "compare_action", "overlay_action", "specs", "tool_action"]

MENUS = (file, edit, view, face, manual, compare, protect, experiments, assistance)


def specs() -> tuple[Spec, ...]:
    """Return all entries, in the order of the menus."""
    return tuple(spec for menu in MENUS for spec in menu.specs())
