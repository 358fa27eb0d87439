"""The table of commands: name, text, key and tip of each, in the order of the menus.

Features connect commands to methods with `Feature.bind`. Commands that belong to other tables
(overlays, workspaces, experiments) are made by the feature that reads that table.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QWidget

from kogao_core.base.language import looked_up

from .i18n import bare

Names = tuple[str | None, ...]


@dataclass(frozen=True, slots=True)
class Item:
    """One command. `resources.catalogues` collects its text and its tip for translation."""

    name: str  # in settings, toolbars and tests
    text: str  # with & before the letter for Alt
    key: str = ""
    tip: str = ""
    photo: bool = False  # enabled only while a photo is open
    also: tuple[str, ...] = ()  # more keys, as in other programs

    def action(self, parent: QWidget) -> QAction:
        """Return a new action with the words and keys of this command."""
        action, tip = QAction(parent), looked_up(self.tip)
        call(action, looked_up(self.text))
        action.setShortcuts([QKeySequence(key) for key in (self.key, *self.also) if key])
        action.setToolTip(f"{tip} ({self.key})" if self.key else tip)
        action.setStatusTip(tip)
        return action


class Menu:
    """A menu of the menu bar.

    An entry is a command, None (a separator), the name of a submenu, or a prefix such as
    ``overlay-`` for every command of another table.
    """

    def __init__(self, title: str, *entries: Item | str | None, only: tuple[str, ...] = ()) -> None:
        self.title, self.entries = title, entries
        self.only = only  # workspaces that show the menu; empty: all

    def names(self, actions: Sequence[str]) -> Names:
        """Return the names of the entries, with those of `actions` that a prefix stands for."""
        names: list[str | None] = []
        for entry in self.entries:
            if isinstance(entry, str) and entry.endswith("-"):
                listed = [name for name in actions if name.startswith(entry) and name not in TABLE]
                names += listed
            else:
                names.append(entry.name if isinstance(entry, Item) else entry)
        return tuple(names)


MENUS: Final = (
    Menu(
        "&File",
        Item("open", "&Open…", "Ctrl+O", "Open a photo"),
        Item("folder", "Open &folder…", "Ctrl+Shift+O", "Show its photos in the film strip"),
        "recent",
        None,
        Item("save", "&Save a copy…", "Ctrl+S", "Keep the original unchanged", photo=True),
        Item("export", "E&xport…", "Ctrl+Shift+S", "Export one or more photos", photo=True),
        None,
        Item("done", "&Done", "Ctrl+Shift+Return", "Save and return to the other program"),
        Item("cancel-edit", "Cance&l", "Ctrl+Shift+Backspace", "Return without saving"),
        Item("quit", "&Quit", "Ctrl+Q", "Close the window"),
    ),
    Menu(
        "&Edit",
        Item("undo", "&Undo", "Ctrl+Z", "Undo the last step"),
        Item("redo", "&Redo", "Ctrl+Shift+Z", "Redo the next step"),
        Item(
            "reset-photo", "Reset ph&oto", "", "Discard all edits; undo restores them", photo=True
        ),
        None,
        Item("copy-result", "Copy resu&lt", "Ctrl+C", "Copy the picture", photo=True),
        Item("open-copied", "Ope&n copied photo", "Ctrl+V", "Open a file from the clipboard"),
        Item("copy-settings", "&Copy settings", "Ctrl+Shift+C", "Copy from photo or face"),
        Item(
            "paste-settings",
            "&Paste settings",
            "Ctrl+Shift+V",
            "Apply the copied settings",
            photo=True,
        ),
        Item(
            "give-settings",
            "S&ync settings to selected photos",
            "Ctrl+Alt+V",
            "Apply the open photo's settings",
            photo=True,
        ),
        Item(
            "give-person",
            "Sync settin&gs to one person",
            "Ctrl+Alt+N",
            "Apply the selected face's settings to that person in all photos of the film strip",
            photo=True,
        ),
        Item("auto-sync", "Auto &sync", "Ctrl+Alt+A", "Apply each change to selected photos"),
        "presets",
        None,
        Item("kept", "&What Kogao keeps…", "Ctrl+Alt+K", "List and delete stored data"),
        Item("preferences", "Pre&ferences…", "Ctrl+,", "Language, theme, defaults, folders"),
    ),
    Menu(
        "&View",
        Item("fit", "&Fit", "0", "Show the whole photo", True, ("Ctrl+0",)),
        Item("actual", "&100 %", "1", "Show one photo pixel per screen pixel", True, ("Ctrl+1",)),
        Item("zoom-face", "&Zoom to face", "F", "Zoom to the selected face or to all faces", True),
        None,
        Item("compare-wipe", "&Wipe", "W", "Divide original and result; , and . move it", True),
        Item("compare-side", "Side b&y side", "Y", "Show original and result side by side", True),
        Item("photos-side", "P&hotos side by side…", "Shift+Y", "Two to six selected photos"),
        None,
        Item("hide-overlays", "Hide all o&verlays", "O", "Hide or show the marks", True),
        None,
        "workspace-",
        Item("reset-workspace", "Reset wor&kspace", "", "Restore its panels and overlays"),
    ),
    Menu(
        "F&ace",
        Item("find", "&Find faces again", "Ctrl+F", "Discard all point corrections", photo=True),
        Item("place", "&Place a face by hand", "Ctrl+P", "Add a face to drag", photo=True),
        Item("import-landmarks", "&Import landmarks…", "Ctrl+Shift+I", "Read points", True),
        None,
        Item("switch-face", "&Switch this face on or off", "I", "Change or keep this face"),
        Item("all-faces", "All fa&ces on", "Ctrl+A", "Change every face"),
        None,
        Item("follow-photo", "Reset to photo se&ttings", "Ctrl+U", "Drop the face's own settings"),
        Item("soft", "Move nei&ghbours", "Q", "Nearby points follow; wheel sets the range"),
        Item("symmetric", "&Both sides", "Shift+Q", "Mirror each move on the other side"),
    ),
    Menu(
        "&Manual",
        Item("mode-automatic", "&Automatic", "F2", "Use the detected points"),
        Item("mode-manual", "&Manual", "F3", "Set points by hand, as in the paper (table 2)"),
        None,
        Item("apply", "A&pply", "Ctrl+Return", "Finish and stop the clock"),
        only=("compare", "inspect"),
    ),
    Menu(
        "&Tools",
        Item("tool-points", "Points", "A", "Drag the dots that mark the face", True),
        Item("tool-push", "Push", "Shift+W", "Drag to push", True),
        Item("tool-restore", "Restore", "Shift+R", "Restore the original under the brush", True),
        Item("tool-brush", "Protect", "B", "Paint areas to protect", True),
        Item("tool-line", "Line", "N", "Draw or move a line; Shift: level or upright", True),
        Item("tool-eraser", "Eraser", "E", "Erase protection", True),
        None,
        Item("clear-strokes", "&Clear strokes", "Shift+X", "Remove every push and restore"),
        Item(
            "protect-mask",
            "Protect from &mask…",
            "Shift+B",
            "Protect the white pixels of a picture",
            photo=True,
        ),
        Item("unprotect", "&Remove all protection", "Shift+E", "Let all places move again"),
    ),
    Menu(
        "E&xperiments",
        "landmarks-",
        None,
        Item("export-figure", "Export figure…", "Shift+F12", "Save canvas and figures", True),
        None,
        "experiment-",
        only=("compare", "inspect"),
    ),
    Menu(
        "&Help",
        Item("documentation", "&Documentation", "F1", "Read the manual offline"),
        Item("tour", "&Tour", "Ctrl+F1", "Try the sample in three steps"),
        Item("palette", "&Commands…", "Ctrl+Shift+P", "Find a command by name"),
        None,
        Item("about", "&About Kogao", "Ctrl+Shift+F1", "Version, paper and licences"),
    ),
)
# Commands with a key and a place in the palette, without one in the menus.
KEYS_ONLY: Final = (
    Item("hide-panels", "&Hide all panels", "F8", "Show the photo alone"),
    Item("copy-report", "Copy &report", "Shift+F1", "Copy versions for a bug report"),
    Item("sample", "Open sample &portrait", "", "Open a face to try"),
    Item("compare-difference", "&Difference", "X", "Show amplified differences", True),
    Item("loupe", "Lo&upe", "Z", "Magnify original and result", True),
    Item("only-face", "&Only this face", "Shift+I", "Leave all other faces unchanged"),
    Item("no-face", "All faces off", "Ctrl+Shift+A", "Leave every face unchanged"),
    Item("delete", "&Delete selected point", "Delete", "Delete a landmark, reset a target"),
    Item("mark", "Mar&k", "M", "Press to set a landmark, drag to its target"),
    Item("mirror", "Mi&rror", "Shift+M", "Copy the point to the other side"),
    Item("mirror-side", "Mirror s&ide", "Ctrl+M", "Copy this side of the face to the other"),
    Item("snap", "S&nap", "Shift+N", "Put the target on the line to the centre"),
    Item("lines-go", "Release all &lines", "Shift+S", "Let the background bend"),
    Item("lines-hold", "H&old all lines", "Shift+H", "Keep background lines straight"),
    Item("abort", "Cancel", "Escape", "Cancel the gesture, then deselect"),
    Item("next-photo", "Next photo", "Ctrl+Right", "Open the next photo of the strip"),
    Item("previous-photo", "Previous photo", "Ctrl+Left", "Open the previous photo of the strip"),
    Item("next-to-check", "Next photo to check", "Ctrl+Shift+Right", "Open it and say why"),
    Item("strip-shown", "Filter film strip", "Ctrl+Shift+F", "By stars, label or edits"),
    Item("strip-order", "Sort film strip", "Ctrl+Shift+D", "By name or stars"),
    Item("save-project", "Save project…", "Ctrl+Alt+P", "Save edits to a file", photo=True),
    Item("paper-settings", "Use the paper's settings", "", "Keep amount and centre", photo=True),
    Item("match-retouch", "Match a retouch…", "Ctrl+Alt+M", "Read a retouched copy", photo=True),
    Item("save-preset", "Save preset…", "Ctrl+Alt+S", "Save these settings as a preset"),
    Item("preset-folder", "Open preset folder", "", "Each preset is a JSON file"),
    Item("closer", "Zoom in", "+", "Magnify the view", True, ("Ctrl++", "Ctrl+=")),
    Item("farther", "Zoom out", "-", "Show more of the photo", True, ("Ctrl+-",)),
    Item("wipe-left", "Move divider left", ",", "Show more of the result"),
    Item("wipe-right", "Move divider right", ".", "Show more of the original"),
    Item("more-settings", "More settings", "Ctrl+Shift+M", "Show or hide the group “More”"),
    Item("invert-faces", "Invert faces", "Ctrl+I", "Switch each face on or off"),
    Item("next-point", "Next point", "Ctrl+.", "Select the next point"),
    Item("previous-point", "Previous point", "Ctrl+Shift+.", "Select the previous point"),
    Item("fetch-point", "Nearest point to mouse", "R", "Move the nearest landmark here"),
    Item("reach-wider", "Move more neighbours", "Ctrl+]", "Increase the range"),
    Item("reach-narrower", "Move fewer neighbours", "Ctrl+[", "Decrease the range"),
    Item("smaller", "Smaller brush", "[", "Make the brush smaller", photo=True),
    Item("larger", "Larger brush", "]", "Make the brush larger", photo=True),
)
_IN_MENUS: Final = (entry for menu in MENUS for entry in menu.entries)
TABLE: Final = {entry.name: entry for entry in (*_IN_MENUS, *KEYS_ONLY) if isinstance(entry, Item)}


def call(action: QAction, text: str) -> None:
    """Set the text of an action, and for buttons the text without the letter for Alt."""
    action.setText(text)
    # Qt would keep the letter of ``開く(&O)`` on buttons.
    action.setIconText(bare(text).rstrip("…"))
