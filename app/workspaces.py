"""The three workspaces and their panels, overlays and tools."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from kogao_core.base.language import Text


@dataclass(frozen=True, slots=True, kw_only=True)
class Workspace:
    """A workspace; menu, shortcuts, ``--workspace`` and settings use this definition."""

    name: str  # identifier in settings and on the command line
    # Visible name, shortcut and purpose.
    title: str
    key: str
    help: str
    panels: tuple[str, ...]  # features with a visible panel, by `Feature.name`
    overlays: tuple[str, ...]  # overlays enabled at first
    # Tools after the workspace switch, most important first. The last tools move to the » menu if
    # space is short.
    tools: tuple[str | None, ...]
    # Whether panels use everyday words and fold advanced settings, instead of the paper's terms
    # and units.
    plain: bool = False
    quiet: bool = False  # whether marks hide until the cursor is over a face
    unfolded: tuple[str, ...] = ()  # groups of the panels that are open at first


RETOUCH: Final = Workspace(
    name="retouch",
    title=Text("Retouch"),
    key="Alt+1",
    help=Text("The photo, how much smaller its faces get, and a saved copy"),
    panels=("recipe", "faces"),
    overlays=("landmarks", "shape", "read", "folds", "protection"),
    tools=(
        *("open", "save", None),
        *("undo", "redo", None),
        *("hold-original", "compare-wipe", "compare-side", None),
        *("tool-points", "tool-push", "tool-restore", "tool-brush", None, "fit"),
    ),
    plain=True,
    quiet=True,
    unfolded=("shape",),
)
COMPARE: Final = Workspace(
    name="compare",
    title=Text("Manual vs auto"),
    key="Alt+2",
    help=Text("Landmarks set by hand, timed, next to automatic landmarks"),
    panels=("recipe", "both"),
    overlays=("landmarks", "targets", "read", "folds", "protection"),
    tools=(
        *("open", "save", None),
        *("mode-automatic", "mode-manual", None),
        *("undo", "redo", None),
        *("hold-original", "hide-overlays", "fit"),
    ),
    plain=True,
)
INSPECT: Final = Workspace(
    name="inspect",
    title=Text("Inspect"),
    key="Alt+3",
    help=Text("All overlays and figures"),
    panels=("recipe", "overlays", "faces", "readings", "history"),
    overlays=(
        *("landmarks", "targets", "read", "centre"),
        *("domains", "folds", "protection", "legend"),
    ),
    tools=(
        *("open", "save", None),
        *("mode-automatic", "mode-manual", None),
        *("undo", "redo", None),
        *("hold-original", "compare-wipe", "compare-side", "compare-difference", "loupe", None),
        *("fit", "actual"),
    ),
)
# New users start in the first workspace.
WORKSPACES: Final = {one.name: one for one in (RETOUCH, COMPARE, INSPECT)}
