"""Everything the menus, keys and buttons can do, as data."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMenuBar, QToolBar, QWidget

from .i18n import tr
from .layers import ON_AT_FIRST, layers


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
        What it is called, its shortcut and what it does.
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


TOOLBAR = ("open", "save", None, "undo", "redo", None, "fit", "actual")


def specs() -> tuple[Spec, ...]:
    """Return all actions, in the order of the menus."""
    file, edit, view = tr("&File"), tr("&Edit"), tr("&View")
    face, about = tr("F&ace"), tr("&Help")
    return (
        Spec("open", file, tr("&Open…"), "Ctrl+O", tr("Open a photo")),
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
        Spec("abort", edit, tr("&Abort the gesture"), "Escape", tr("Leave everything as it was")),
        Spec("fit", view, tr("&Fit"), "0", tr("Show the whole photo")),
        Spec("actual", view, tr("&100 %"), "1", tr("One photo pixel on one screen pixel")),
        Spec("closer", view, tr("Zoom &in"), "+", tr("Look closer")),
        Spec("farther", view, tr("Zoom &out"), "-", tr("See more"), ends_group=True),
        *_overlay_specs(view),
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
            "automatic",
            face,
            tr("Make the selected target &automatic"),
            "Delete",
            tr("Put a target that was dragged back on its line"),
        ),
        Spec("about", about, tr("&About Kogao"), "F1", tr("Version, paper and licences")),
    )


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
    for spec in specs():
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


def fill_menus(bar: QMenuBar, actions: Mapping[str, QAction]) -> None:
    """Lay the actions out in their menus."""
    menus = {title: bar.addMenu(title) for title in dict.fromkeys(spec.menu for spec in specs())}
    for spec in specs():
        menus[spec.menu].addAction(actions[spec.name])
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
