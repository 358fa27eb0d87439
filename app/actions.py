"""Actions from the entries of the menus, and where they lie in the window."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMenu, QMenuBar, QToolBar, QWidget

from .menus import specs

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
