"""Switching between workspaces. Changes to a workspace are stored until a reset."""

from __future__ import annotations

from collections.abc import Collection
from functools import partial
from typing import Final

from ..actions import Item
from ..canvas.overlays.listed import LISTED
from ..i18n import translated
from ..widgets.controls import Fold
from ..workspaces import WORKSPACES, Workspace
from .feature import Context, Feature

_NOW: Final = "workspaces/now"


class Workspaces(Feature):
    """Shows one workspace at a time; the document does not change."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._shown: Workspace | None = None
        for one in WORKSPACES.values():
            title, tip = translated(one.title), translated(one.help)
            show = partial(self.show, one.name)
            self.bind(Item(f"workspace-{one.name}", title, one.key, tip), show, checked=False)
        self.bind("reset-workspace", self.reset)
        self.one_of(*(f"workspace-{name}" for name in WORKSPACES))

    def begin(self, name: str | None = None) -> None:
        """Show a workspace by name, or the last used workspace."""
        left = str(self.settings.value(_NOW, ""))
        self.show(name or (left if left in WORKSPACES else next(iter(WORKSPACES))))

    def show(self, name: str) -> None:
        self._remember()
        one = WORKSPACES[name]
        docks = self.settings.value(_place(one, "docks"))
        self._arrange(
            one,
            self._kept_names(_place(one, "overlays"), one.overlays),
            self._kept_names(_place(one, "unfolded"), one.unfolded),
            docks if isinstance(docks, str) else "",
        )

    def reset(self) -> None:
        if self._shown is not None:
            self._bring_back()
            self._arrange(self._shown, self._shown.overlays, self._shown.unfolded)

    def stop(self) -> None:
        super().stop()
        self._remember()
        self.settings.sync()

    def _arrange(
        self,
        one: Workspace,
        overlays: Collection[str],
        unfolded: Collection[str],
        docks: str = "",
    ) -> None:
        self._shown = one
        self.actions[f"workspace-{one.name}"].setChecked(True)
        for overlay in LISTED:
            self.actions[f"overlay-{overlay.name}"].setChecked(overlay.name in overlays)
        for fold in self._folds():
            fold.button.setChecked(fold.objectName() in unfolded)
        self.window.arrange(one, docks)

    def _remember(self) -> None:
        one = self._shown
        if one is None:
            return
        self._bring_back()
        on = [it.name for it in LISTED if self.actions[f"overlay-{it.name}"].isChecked()]
        unfolded = [it.objectName() for it in self._folds() if it.button.isChecked()]
        self.settings.setValue(_NOW, one.name)
        self.settings.setValue(_place(one, "overlays"), ",".join(on))
        self.settings.setValue(_place(one, "unfolded"), ",".join(unfolded))
        self.settings.setValue(_place(one, "docks"), self.window.docks.state())

    def _kept_names(self, place: str, first: Collection[str]) -> Collection[str]:
        kept = self.settings.value(place)
        return first if kept is None else str(kept).split(",")

    def _folds(self) -> list[Fold]:
        """Return the groups with a stored state; other groups open automatically."""
        return [fold for fold in self.window.findChildren(Fold) if fold.objectName()]

    def _bring_back(self) -> None:
        """Show temporarily hidden overlays and panels, to store the full layout."""
        for name in ("hide-overlays", "hide-panels"):
            self.actions[name].setChecked(False)


def _place(one: Workspace, what: str) -> str:
    return f"workspaces/{one.name}/{what}"
