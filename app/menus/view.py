"""The View menu, with a key for each overlay."""

from __future__ import annotations

from ..i18n import tr
from ..layers import ON_AT_FIRST, layers
from .spec import Spec


def specs() -> tuple[Spec, ...]:
    """Return the entries in their order."""
    menu = tr("&View")
    return (
        Spec("fit", menu, tr("&Fit"), "0", tr("Show the whole photo")),
        Spec("actual", menu, tr("&100 %"), "1", tr("One photo pixel on one screen pixel")),
        Spec("closer", menu, tr("Zoom &in"), "+", tr("Look closer")),
        Spec("farther", menu, tr("Zoom &out"), "-", tr("See more"), ends_group=True),
        *_overlays(menu),
        Spec(
            "hide-overlays",
            menu,
            tr("Hide all &overlays"),
            "O",
            tr("The photo without marks, or the same marks again"),
            checked=False,
            ends_group=True,
        ),
        Spec("panels", menu, "", "", ""),
        Spec(
            "hide-panels",
            menu,
            tr("&Hide all panels"),
            "F8",
            tr("The photo alone, or everything again"),
            checked=False,
        ),
        Spec(
            "move-panels",
            menu,
            tr("&Move panels"),
            "F9",
            tr("Give panels title bars to drag them by"),
            checked=False,
        ),
        Spec("reset-layout", menu, tr("&First layout again"), "", tr("All panels in their places")),
    )


def _overlays(menu: str) -> list[Spec]:
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
