"""Three ways to work in one window: what each of them shows, declared once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from kogao_core.base.language import Text


@dataclass(frozen=True, slots=True)
class Workspace:
    """One way to work; menu, keys, ``--workspace``, settings and their tests follow from it."""

    name: str  # by which settings and the command line know it
    # What it is called, its shortcut, and what it is for.
    title: str
    key: str
    help: str
    panels: tuple[str, ...]  # features whose panels stand there, by their `Feature.name`
    overlays: tuple[str, ...]  # those that are on at first
    # The toolbar, behind the switch between workspaces, the most important first: where room is
    # short the last ones go behind ».
    tools: tuple[str | None, ...]
    # Whether panels use everyday words and fold away what a retoucher rarely sets, instead of the
    # paper's terms and figures.
    plain: bool = False
    quiet: bool = False  # whether the marks of faces step back while nobody points at them
    unfolded: tuple[str, ...] = ()  # groups of the panels that are open at first


RETOUCH: Final = Workspace(
    name="retouch",
    title=Text("Retouch"),
    key="Alt+1",
    help=Text("The photo, how much smaller its faces get, and a saved copy"),
    panels=("recipe", "faces"),
    overlays=("landmarks", "targets", "folds", "protection"),
    tools=(
        *("open", "save", None),
        *("undo", "redo", None),
        *("hold-original", "compare-wipe", "compare-side", None),
        *("tool-push", "tool-restore", "tool-brush", None, "hide-overlays", "fit"),
    ),
    plain=True,
    quiet=True,
    unfolded=("shape",),
)
COMPARE: Final = Workspace(
    name="compare",
    title=Text("Hand or machine"),
    key="Alt+2",
    help=Text("Points set by hand beside those found, against the clock"),
    panels=("recipe", "both"),
    overlays=("landmarks", "targets", "folds", "protection"),
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
    help=Text("What the machine does and why: every overlay, every figure"),
    panels=("recipe", "protect", "overlays", "faces", "readings", "history"),
    overlays=("landmarks", "targets", "centre", "folds", "protection", "legend"),
    tools=(
        *("open", "save", None),
        *("mode-automatic", "mode-manual", None),
        *("undo", "redo", None),
        *("hold-original", "compare-wipe", "compare-side", "compare-difference", "loupe", None),
        *("fit", "actual"),
    ),
)
# The first one is where a new user begins.
WORKSPACES: Final = {one.name: one for one in (RETOUCH, COMPARE, INSPECT)}
