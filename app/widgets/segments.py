"""Buttons of which one is down, as one control: the switch between workspaces."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QToolButton, QWidget

from ..i18n import bare


def segmented(name: str, actions: Sequence[QAction]) -> QWidget:
    """Return the actions of an exclusive group side by side, without gaps.

    Parameters
    ----------
    name : str
        What the control is for screen readers.
    actions : sequence of QAction
        From the left; their texts are the buttons'.
    """
    whole = QWidget()
    whole.setAccessibleName(name)
    row = QHBoxLayout(whole)
    row.setContentsMargins(0, 0, 0, 0)
    row.setSpacing(0)
    for place, action in enumerate(actions):
        button = QToolButton()
        button.setDefaultAction(action)
        button.setAccessibleName(bare(action.text()))
        button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        ends = {0: "first", len(actions) - 1: "last"}
        button.setProperty("part", ends.get(place, "middle"))
        row.addWidget(button)
    return whole
