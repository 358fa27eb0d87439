"""What menus, keys and buttons can do, and where it lies in the window."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtGui import QAction, QKeySequence

from .i18n import bare, tr

Names = tuple[str | None, ...]
FIRST_KEY = "first_key"


def layout(actions: Sequence[str]) -> dict[str, Names]:
    """Return the menus: their titles, and the names in each; None is a line."""

    def every(kind: str) -> Names:
        return tuple(name for name in actions if name.startswith(kind))

    return {
        tr("&File"): (
            *("open", "folder", "recent", "next-photo", "previous-photo", "sample", None),
            *("save", "export", "save-project", "save-options", "done", "cancel-edit", None),
            *("give-settings", "batch-chosen", "batch", None),
            *("import-landmarks", "export-landmarks", "export-figure", None),
            "quit",
        ),
        tr("&Edit"): (
            *("undo", "redo", None, "copy-settings", "paste-settings", None),
            *("stars", "presets", "keys", "preferences", None, "abort"),
        ),
        tr("&View"): (
            *("fit", "actual", "closer", "farther", None),
            *every("overlay-"),
            *("hide-overlays", None),
            *("panels", "hide-panels", "move-panels", "more-settings", None),
            *("strip-shown", "strip-order", None),
            *every("workspace-"),
            "reset-workspace",
        ),
        tr("F&ace"): (
            *("find", "place", None),
            *("only-face", "switch-face", "all-faces", "no-face", "invert-faces", "zoom-face"),
            *(None, "follow-photo", "next-point", "previous-point", "fetch-point", None),
            *("soft", "symmetric", "reach-wider", "reach-narrower", None),
            *("delete", None),
            *every("landmarks-"),
        ),
        tr("&Manual"): (
            *("mode-automatic", "mode-manual", None, "mark", "mirror", "mirror-side", "snap", None),
            *("apply", "compare-modes"),
        ),
        tr("Com&pare"): (
            *("compare-wipe", "compare-side", "compare-difference", None),
            *("wipe-left", "wipe-right", "loupe"),
        ),
        tr("&Tools"): (
            *every("tool-"),
            *("smaller", "larger", None),
            *("clear-strokes", None, "hard", "unprotect"),
            *(None, "lines-go", "lines-hold"),
        ),
        tr("E&xperiments"): (*every("experiment-"), None, *every("rate")),
        # Where keys are changed and where they are looked up.
        tr("&Help"): ("documentation", "tour", "palette", "keys", None, "copy-report", "about"),
    }


def call(action: QAction, text: str) -> None:
    """Give an action its text; on buttons Qt would leave the letter of ``開く(&O)``."""
    action.setText(text)
    action.setIconText(bare(text).rstrip("…"))


def first_key(action: QAction) -> QKeySequence:
    """Return the key that an action comes with."""
    return QKeySequence(str(action.property(FIRST_KEY)))
