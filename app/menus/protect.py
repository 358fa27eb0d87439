"""The Protect menu: tools for places that must not move."""

from __future__ import annotations

from ..i18n import tr
from ..tools import Brush, ToolName, tools
from .spec import Spec


def specs() -> tuple[Spec, ...]:
    """Return the entries in their order."""
    menu = tr("Pro&tect")
    first = Brush().tool
    return (
        *(
            Spec(tool_action(t.name), menu, t.title, t.key, t.tip, checked=t.name == first)
            for t in tools()
        ),
        Spec("hard", menu, tr("&Hard edge"), "Shift+B", tr("Not a pixel of it moves"), False, True),
        Spec("smaller", menu, tr("&Smaller brush"), "[", tr("Make brush and eraser smaller")),
        Spec("larger", menu, tr("&Larger brush"), "]", tr("Make brush and eraser larger")),
        Spec(
            "unprotect",
            menu,
            tr("&Remove all protection"),
            "Shift+E",
            tr("Let every place move again"),
        ),
    )


def tool_action(tool: ToolName) -> str:
    """Return the name of the action that takes a tool in hand."""
    return f"tool-{tool}"
