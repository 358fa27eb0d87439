"""Everything the menus, keys and buttons can do, as data."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMenu, QMenuBar, QToolBar, QWidget

from kogao_core.landmarks import CHOICES

from .before_after import CompareName, comparisons
from .i18n import tr
from .layers import ON_AT_FIRST, layers
from .tools import Brush, ToolName, tools


@dataclass(frozen=True, slots=True)
class Spec:
    """One action.

    Parameters
    ----------
    name : str
        Which slot it calls.
    menu : str
        The menu it stands in; an empty one keeps it to its key.
    text, key, tip : str
        What it is called, its shortcut and what it does. Without a text it is the place of a menu
        inside the menu.
    checked : bool, optional
        Initial state of an action that toggles; None for one that doesn't.
    ends_group : bool
        Whether a line follows in the menu.
    """

    name: str
    menu: str
    text: str
    key: str
    tip: str
    checked: bool | None = None
    ends_group: bool = False


TOOLBAR = (
    *(
        "open",
        "save",
        None,
        "mode-automatic",
        "mode-manual",
        None,
        "undo",
        "redo",
        None,
        "fit",
        "actual",
        None,
    ),
    *("compare-wipe", "compare-side", "compare-difference", "loupe"),
)


def specs() -> tuple[Spec, ...]:
    """Return all actions, in the order of the menus."""
    file, edit, view = tr("&File"), tr("&Edit"), tr("&View")
    face, about = tr("F&ace"), tr("&Help")
    return (
        Spec("open", file, tr("&Open…"), "Ctrl+O", tr("Open a photo")),
        Spec("folder", file, tr("Open a &folder…"), "Ctrl+Shift+O", tr("Photos as a film strip")),
        Spec("recent", file, "", "", ""),
        Spec("next-photo", file, tr("&Next photo"), "Ctrl+Right", tr("Next on the film strip")),
        Spec(
            "previous-photo",
            file,
            tr("Pre&vious photo"),
            "Ctrl+Left",
            tr("Previous on the film strip"),
        ),
        Spec(
            "sample",
            file,
            tr("Open the sample &portrait"),
            "",
            tr("A face to try things on"),
            ends_group=True,
        ),
        Spec(
            "save",
            file,
            tr("&Save a copy…"),
            "Ctrl+S",
            tr("Save the result under another name; the original is never touched"),
            ends_group=True,
        ),
        Spec("quit", file, tr("&Quit"), "Ctrl+Q", tr("Close the window")),
        Spec("undo", edit, tr("&Undo"), "Ctrl+Z", tr("Take the last gesture back")),
        Spec("redo", edit, tr("&Redo"), "Ctrl+Shift+Z", tr("Do it again"), ends_group=True),
        Spec(
            "copy-settings",
            edit,
            tr("&Copy settings"),
            "Ctrl+Shift+C",
            tr("Copy the settings of the photo or of the selected face"),
        ),
        Spec(
            "paste-settings",
            edit,
            tr("&Paste settings"),
            "Ctrl+Shift+V",
            tr("Use the copied settings for this photo or the selected face"),
            ends_group=True,
        ),
        Spec("presets", edit, "", "", ""),
        Spec(
            "save-preset",
            "",
            tr("Save as a &preset…"),
            "Ctrl+Alt+S",
            tr("Keep these settings under a name"),
        ),
        Spec("keys", edit, tr("&Keys…"), "Ctrl+K", tr("Choose other keys"), ends_group=True),
        Spec("abort", edit, tr("&Abort the gesture"), "Escape", tr("Leave everything as it was")),
        Spec("fit", view, tr("&Fit"), "0", tr("Show the whole photo")),
        Spec("actual", view, tr("&100 %"), "1", tr("One photo pixel on one screen pixel")),
        Spec("closer", view, tr("Zoom &in"), "+", tr("Look closer")),
        Spec("farther", view, tr("Zoom &out"), "-", tr("See more"), ends_group=True),
        *_overlay_specs(view),
        Spec("panels", view, "", "", ""),
        Spec(
            "hide-panels",
            view,
            tr("&Hide all panels"),
            "F8",
            tr("The photo alone, or everything again"),
            checked=False,
        ),
        Spec(
            "move-panels",
            view,
            tr("&Move panels"),
            "F9",
            tr("Give panels title bars to drag them by"),
            checked=False,
        ),
        Spec("reset-layout", view, tr("&First layout again"), "", tr("All panels in their places")),
        Spec("find", face, tr("&Find faces again"), "Ctrl+F", tr("Undo all corrections of points")),
        Spec(
            "place",
            face,
            tr("&Place a face by hand"),
            "Ctrl+P",
            tr("A mean face to drag into place"),
            ends_group=True,
        ),
        Spec(
            "follow-photo",
            face,
            tr("&Use the photo's settings"),
            "",
            tr("Forget the settings of this face's own"),
        ),
        Spec(
            "delete",
            face,
            tr("&Delete the selected point"),
            "Delete",
            tr("Delete a landmark set by hand; put a target back on its line"),
            ends_group=True,
        ),
        *_landmark_specs(face),
        *_manual_specs(tr("&Manual")),
        *_compare_specs(tr("Com&pare")),
        *_tool_specs(tr("Pro&tect")),
        Spec(
            "palette", about, tr("&Commands…"), "Ctrl+Shift+P", tr("Find every command by its name")
        ),
        Spec("about", about, tr("&About Kogao"), "F1", tr("Version, paper and licences")),
    )


def _landmark_specs(menu: str) -> list[Spec]:
    titles = {
        "mesh": (tr("Landmarks by the m&esh"), "F5"),
        "aam": (tr("Landmarks by the &AAM"), "F6"),
    }
    return [
        *(
            Spec(
                f"landmarks-{choice.name}",
                menu,
                *titles[choice.name],
                tr(
                    "Outline within {studio:g} % of the eyes' distance on studio portraits, "
                    "{wild:g} % elsewhere; about {ms:.0f} ms",
                    studio=choice.studio_jaw,
                    wild=choice.wild_jaw,
                    ms=choice.typical_ms,
                ),
                checked=False,
            )
            for choice in CHOICES
        ),
        Spec(
            "landmarks-file",
            menu,
            tr("Landmarks by a model of &yours…"),
            "Shift+F6",
            tr("An LBF or Kazemi model of 68 points, as cv2.face reads them"),
            checked=False,
        ),
    ]


def _compare_specs(menu: str) -> list[Spec]:
    ways = comparisons()
    return [
        *(
            Spec(compare_action(c.name), menu, c.title, c.key, c.tip, False, c is ways[-1])
            for c in ways
        ),
        Spec("wipe-left", menu, tr("Divider to the &left"), ",", tr("See more of the result")),
        Spec("wipe-right", menu, tr("Divider to the &right"), ".", tr("See more of the original")),
        Spec("loupe", menu, tr("&Loupe"), "Z", tr("Before and after magnified"), False),
    ]


def compare_action(name: CompareName) -> str:
    """Return the name of the action that compares in one way."""
    return f"compare-{name}"


def _manual_specs(menu: str) -> list[Spec]:
    return [
        Spec(
            "mode-automatic", menu, tr("&Automatic"), "F2", tr("Points found by the machine"), True
        ),
        Spec(
            "mode-manual",
            menu,
            tr("&Manual"),
            "F3",
            tr("Points set by hand, the paper's conventional method (table 2)"),
            checked=False,
            ends_group=True,
        ),
        Spec(
            "mark",
            menu,
            tr("Mar&k"),
            "M",
            tr("Press to set a landmark, drag to where it goes"),
            checked=False,
        ),
        Spec("mirror", menu, tr("Mi&rror"), "Shift+M", tr("The selected point on the other side")),
        Spec(
            "mirror-side",
            menu,
            tr("Mirror s&ide"),
            "Ctrl+M",
            tr("Make the other side of the face like the selected point's"),
        ),
        Spec(
            "snap",
            menu,
            tr("S&nap"),
            "Shift+N",
            tr("Put the selected point's target on the line to the centre"),
            ends_group=True,
        ),
        Spec("apply", menu, tr("A&pply"), "Ctrl+Return", tr("Everything is set: stop the clock")),
        Spec(
            "compare-modes",
            menu,
            tr("&Compare…"),
            "F4",
            tr("Manual and automatic side by side, with their times"),
        ),
    ]


def _tool_specs(menu: str) -> list[Spec]:
    first = Brush().tool
    return [
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
    ]


def tool_action(tool: ToolName) -> str:
    """Return the name of the action that takes a tool in hand."""
    return f"tool-{tool}"


def _overlay_specs(menu: str) -> list[Spec]:
    return [
        Spec(
            overlay_action(layer.name),
            menu,
            layer.title,
            layer.key,
            tr("Show or hide: {what}", what=layer.title),
            checked=layer.name in ON_AT_FIRST,
        )
        for layer in layers()
    ]


def overlay_action(layer: str) -> str:
    """Return the name of the action that toggles an overlay."""
    return f"overlay-{layer}"


def build(owner: QWidget) -> dict[str, QAction]:
    """Return the actions by name, as children of `owner`, where their keys hold."""
    built = {}
    for spec in (spec for spec in specs() if spec.text):
        action = QAction(spec.text, owner)
        action.setShortcut(QKeySequence(spec.key))
        action.setToolTip(f"{spec.tip} ({spec.key})" if spec.key else spec.tip)
        action.setStatusTip(spec.tip)
        if spec.checked is not None:
            action.setCheckable(True)
            action.setChecked(spec.checked)
        owner.addAction(action)
        built[spec.name] = action
    return built


def fill_menus(bar: QMenuBar, actions: Mapping[str, QAction], inside: Mapping[str, QMenu]) -> None:
    """Lay the actions out in their menus, and the menus `inside` them by name."""
    shown = [spec for spec in specs() if spec.menu]
    menus = {title: bar.addMenu(title) for title in dict.fromkeys(spec.menu for spec in shown)}
    for spec in shown:
        if spec.text:
            menus[spec.menu].addAction(actions[spec.name])
        else:
            menus[spec.menu].addMenu(inside[spec.name])
        if spec.ends_group:
            menus[spec.menu].addSeparator()


def fill_toolbar(
    bar: QToolBar, actions: Mapping[str, QAction], names: Iterable[str | None] = TOOLBAR
) -> None:
    """Lay buttons out; None is a line between groups."""
    for name in names:
        if name is None:
            bar.addSeparator()
        else:
            bar.addAction(actions[name])


def connect(actions: Mapping[str, QAction], slots: Mapping[str, Callable[[], object]]) -> None:
    """Join actions to what they do."""
    for name, slot in slots.items():
        actions[name].triggered.connect(lambda _checked=False, slot=slot: slot())
