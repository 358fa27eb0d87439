"""The photo before and after: wipe, side by side, difference, and a loupe."""

from __future__ import annotations

from functools import partial
from typing import Final

from PySide6.QtGui import QActionGroup

from ..i18n import tr
from ..view_state import GAIN, CompareName
from .feature import Context, Feature

_WIPE_STEP: Final = 1 / 40


class Compare(Feature):
    """Chooses how before and after are seen."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._add_kind(
            "wipe", tr("Wipe"), "W", tr("Before and after, with a divider to drag; , and . move it")
        )
        self._add_kind("side", tr("Side by side"), "Y", tr("Before and after beside each other"))
        self._add_kind(
            "difference", tr("Difference"), "X", tr("What has changed, {n} times as strong", n=GAIN)
        )
        self.add_action(
            "wipe-left",
            tr("Divider to the &left"),
            ",",
            tr("See more of the result"),
            lambda: self._wipe_by(-_WIPE_STEP),
        )
        self.add_action(
            "wipe-right",
            tr("Divider to the &right"),
            ".",
            tr("See more of the original"),
            lambda: self._wipe_by(_WIPE_STEP),
        )
        self.add_action(
            "loupe", tr("Lo&upe"), "Z", tr("Before and after magnified"), toggled=self._use_loupe
        )
        kinds = self.one_of("compare-wipe", "compare-side", "compare-difference")
        kinds.setExclusionPolicy(QActionGroup.ExclusionPolicy.ExclusiveOptional)
        self.window.canvas.wiped.connect(self._wipe_to)
        self.document.opened.connect(self._open)
        self.document.recoloured.connect(self._open)

    def _add_kind(self, name: CompareName, text: str, key: str, tip: str) -> None:
        self.add_action(f"compare-{name}", text, key, tip, toggled=partial(self.toggle, name))

    def toggle(self, name: CompareName, on: bool) -> None:
        """Compare this way, or no longer."""
        if on:
            self.view.compare = name
        elif self.view.compare == name:
            self.view.compare = "off"
        self.window.original.setVisible(self.view.compare == "side")
        self.window.canvas.redraw()

    def _wipe_to(self, share: float) -> None:
        self.view.wipe = min(max(share, 0.0), 1.0)
        self.window.canvas.redraw()

    def _wipe_by(self, share: float) -> None:
        if self.view.compare == "wipe":
            self._wipe_to(self.view.wipe + share)

    def _use_loupe(self, on: bool) -> None:
        self.view.loupe = on
        self.window.canvas.redraw()

    def _open(self) -> None:
        if self.document.pyramid is not None:
            self.window.original.open(self.document.pyramid)
