"""One entry of a menu, as data."""

from __future__ import annotations

from dataclasses import dataclass


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
